"""What an inertial unit measures: against gravity, circles, and the motion that its samples add up to."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.devices.imu import ImuSample
from graphengine.devices.rotation import IDENTITY, ORIGIN, Quaternion, Vector3, from_rpy, rotate, unrotate
from graphengine.devices.stage import Stage
from graphengine.physics.sensors.imu import InertialUnit
from graphengine.physics.simulation import Simulation
from tests.physics.conftest import Ship
from tests.physics.harness import ticks

G = 9.81
FREE = '<body name="it" pos="0 0 {height}"><freejoint/><geom type="{shape}" size=".1 .2 .3" mass="2"/></body>'
TURNTABLE = '<body name="it"><joint axis="0 0 1"/><geom size=".1" mass="1"/></body>'
FACTS: dict[str, Any] = {
    "rate": 60.0,
    "acceleration_noise": 0.0,
    "angular_velocity_noise": 0.0,
    "acceleration_bias": (0.0, 0.0, 0.0),
    "angular_velocity_bias": (0.0, 0.0, 0.0),
}


def world(bodies: str) -> str:
    """A model whose step is the fourth part of a 60th of a second."""
    option = '<option integrator="discrete" timestep="0.00416666666666666667"/>'
    return f"<mujoco>{option}<worldbody>{bodies}</worldbody></mujoco>"


def carried(
    body: str,
    position: Vector3 = ORIGIN,
    orientation: Quaternion = IDENTITY,
    floor: bool = False,
    seed: int = 0,
    **facts: object,
) -> InertialUnit:
    """A unit on the body `it`; 60 ticks a second of 4 physics steps each."""
    ground = '<geom type="plane" size="0 0 1"/>' if floor else ""
    model = mujoco.MjModel.from_xml_string(world(f"{ground}{body}"))
    stage = Stage()
    stage.add("/it", "body", body="it")
    stage.add("/it/Imu", "imu", position=position, orientation=orientation, facts=FACTS | facts)
    simulation = Simulation(model, stage, Fraction(60), 4, seed=seed)
    return simulation.device(InertialUnit, stage.find("/it/Imu"))


def moving(imu: InertialUnit, *velocity: float) -> InertialUnit:
    """The unit after a start with these generalised velocities."""
    simulation = imu._simulation
    simulation.data.qvel[:] = velocity
    mujoco.mj_step1(simulation.model, simulation.data)
    imu.reset()
    return imu


def tick(imu: InertialUnit, count: int = 1, each: Callable[[], object] = lambda: None) -> None:
    ticks(imu._simulation, count, each)


def accelerometer(sample: ImuSample) -> list[float]:
    return [a + g for a, g in zip(sample.linear_acceleration, sample.gravity, strict=True)]


def test_at_rest_an_accelerometer_reads_9_81_upwards() -> None:
    turn = from_rpy(0.3, -0.5, 1.1)
    imu = carried(FREE.format(height=0.3, shape="box"), orientation=turn, floor=True)
    tick(imu, 60)
    sample = imu.sample()
    assert accelerometer(sample) == pytest.approx(unrotate(turn, (0.0, 0.0, G)), abs=1e-6)
    assert sample.gravity == pytest.approx(unrotate(turn, (0.0, 0.0, G)), abs=1e-6)
    assert sample.angular_velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert sample.orientation == pytest.approx(turn, abs=1e-6)


def test_an_imu_in_free_fall_reads_0_on_a_tumbling_body() -> None:
    imu = moving(carried(FREE.format(height=100, shape="ellipsoid")), 1.0, -2.0, 3.0, 0.5, 4.0, -0.3)
    tick(imu, 30, lambda: np.testing.assert_allclose(accelerometer(imu.sample()), 0.0, atol=1e-9))


def test_an_imu_reads_the_present_gravity_and_after_a_reset_the_initial_gravity() -> None:
    imu = carried(FREE.format(height=100, shape="ellipsoid"))
    tick(imu)
    assert isinstance(imu._simulation, Simulation)
    imu._simulation.set_gravity((0.5, 0.0, -1.62))
    tick(imu, 3, lambda: np.testing.assert_allclose(accelerometer(imu.sample()), 0.0, atol=1e-9))
    assert imu.sample().gravity == pytest.approx((-0.5, 0.0, 1.62))
    imu._simulation.reset()
    assert imu.sample().gravity == pytest.approx((0.0, 0.0, G))
    tick(imu, 3, lambda: np.testing.assert_allclose(accelerometer(imu.sample()), 0.0, atol=1e-9))


@pytest.mark.parametrize("w", [0.5, -2.0, 10.0])
def test_an_imu_on_a_turntable_reads_w_squared_r_towards_the_axis(w: float) -> None:
    imu = moving(carried(TURNTABLE, position=(0.0, 0.4, 0.0), orientation=from_rpy(0.0, 0.0, 0.7)), w)
    tick(imu, 3)
    sample = imu.sample()
    inwards = unrotate(from_rpy(0.0, 0.0, 0.7), (0.0, -w * w * 0.4, 0.0))
    angle_of_a_step = w / 240
    assert sample.linear_acceleration == pytest.approx(inwards, abs=w * w * 0.4 * angle_of_a_step**2)
    assert sample.gravity == pytest.approx((0.0, 0.0, G))
    assert sample.angular_velocity == pytest.approx((0.0, 0.0, w))


@settings(max_examples=20)
@given(rate=st.sampled_from([7.0, 20.0, 59.0, 60.0, 100.0, 1000.0]), height=st.floats(0.15, 0.5))
def test_samples_add_up_to_the_change_of_velocity_shocks_included(rate: float, height: float) -> None:
    imu = carried(FREE.format(height=height, shape="sphere"), floor=True, rate=rate)
    velocity, last, upwards = np.zeros(3), 0.0, list[float]()

    def add() -> None:
        nonlocal velocity, last
        if imu.due:
            sample = imu.sample()
            velocity = velocity + np.array(sample.linear_acceleration) * (sample.time - last)
            last = sample.time
            np.testing.assert_allclose(velocity, imu._simulation.data.qvel[:3], atol=1e-9)
            upwards.append(sample.linear_acceleration[2])

    tick(imu, 60, add)
    assert max(upwards) > 0.0  # it did hit the floor


def test_graphs_that_run_in_physics_steps_get_the_imu_samples_between_ticks() -> None:
    imu = carried(FREE.format(height=100, shape="sphere"), rate=120.0)
    simulation = imu._simulation
    seen = []
    for number in range(1, 9):
        simulation.step()
        if imu.due:
            seen.append((imu.sample().index, imu.sample().time))
        if number % 4 == 0:
            simulation.begin_tick(number // 4)
            assert imu.due
            assert imu.sample().time == number / 240
    assert seen == [(0, 1 / 240), (1, 2 / 240), (2, 4 / 240), (3, 6 / 240), (4, 8 / 240)]


def test_a_sample_requested_late_has_the_values_of_its_own_tick() -> None:
    asked, late = (carried(TURNTABLE, rate=20.0, acceleration_noise=0.1) for _ in range(2))
    tick(asked, 3)
    then = asked.sample()
    tick(late, 4)
    assert (then.index, then.time) == (1, 0.05)
    assert late.sample() == then
    assert not late.due


def test_noise_depends_on_seed_prim_and_sample_only() -> None:
    often, once, other = (carried(TURNTABLE, acceleration_noise=0.1, seed=seed) for seed in (0, 0, 1))
    tick(often, 5, often.sample)
    tick(once, 5)
    tick(other, 5)
    assert often.sample() == once.sample()
    assert once.sample() != other.sample()
    assert once.sample() is once.sample()


def test_noise_and_bias_come_from_the_profile() -> None:
    noise: dict[str, Any] = {"acceleration_noise": 0.02, "angular_velocity_noise": 0.3}
    bias: dict[str, Any] = {"acceleration_bias": (1.0, 2.0, 3.0), "angular_velocity_bias": (0.0, 5.0, 0.0)}
    imu = carried(TURNTABLE, **noise, **bias)
    samples: list[ImuSample] = []
    tick(imu, 1000, lambda: samples.append(imu.sample()))
    acceleration = np.array([sample.linear_acceleration for sample in samples])
    turning = np.array([sample.angular_velocity for sample in samples])
    # The standard errors of a mean and of a deviation over n samples are s / sqrt(n) and s / sqrt(2 n).
    np.testing.assert_allclose(acceleration.mean(axis=0), [1.0, 2.0, 3.0], atol=5 * 0.02 / math.sqrt(1000))
    np.testing.assert_allclose(turning.mean(axis=0), [0.0, 5.0, 0.0], atol=5 * 0.3 / math.sqrt(1000))
    np.testing.assert_allclose(acceleration.std(axis=0), 0.02, rtol=5 / math.sqrt(2000))
    np.testing.assert_allclose(turning.std(axis=0), 0.3, rtol=5 / math.sqrt(2000))
    assert all(sample.gravity == (0.0, 0.0, G) for sample in samples)


def test_an_imu_repeats_its_samples_after_a_reset() -> None:
    imu = carried(FREE.format(height=0.3, shape="box"), position=(0.1, 0.0, 0.0), floor=True, acceleration_noise=0.1)
    plays: list[list[ImuSample]] = [[], []]
    for play in plays:
        tick(imu, 20, lambda play=play: play.append(imu.sample()))  # type: ignore[misc]
        imu._simulation.reset()
    assert plays[0] == plays[1]
    assert [sample.index for sample in plays[0]] == list(range(1, 21))


def test_its_samples_go_on_over_a_model_that_is_compiled_anew() -> None:
    imu, same = (moving(carried(TURNTABLE, position=(0.0, 0.4, 0.0), rate=20.0), 3.0) for _ in range(2))
    tick(imu, 4)
    tick(same, 4)
    more = mujoco.MjModel.from_xml_string(world(f'<body name="more" pos="9 0 0"><geom size=".1"/></body>{TURNTABLE}'))
    imu._simulation.continue_with(more)
    tick(imu, 2)
    tick(same, 2)
    assert imu.sample().index == 2
    assert accelerometer(imu.sample()) == pytest.approx(accelerometer(same.sample()))


def test_an_imu_reads_gravity_only_before_the_first_step() -> None:
    turn = from_rpy(0.0, 1.0, 0.0)
    sample = carried(TURNTABLE, orientation=turn, acceleration_noise=1.0).sample()
    assert rotate(turn, sample.gravity) == pytest.approx((0.0, 0.0, G))
    assert sample.linear_acceleration == (0.0, 0.0, 0.0)  # no noise: that belongs to samples
    assert (sample.time, sample.index) == (0.0, -1)


def test_the_unit_of_a_camera_on_a_robot_that_stands_feels_gravity_in_its_own_frame(ship: Ship) -> None:
    simulation = ship("dd100_flat.yaml").simulation
    prim = simulation.stage.find("/dd100/base_link/chassis_link/sim_camera/RSD455/Imu_Sensor")
    imu = simulation.device(InertialUnit, prim)
    tick(imu, 2)
    sample = imu.sample()
    assert imu.rate == 200.0
    assert sample.index == 6  # the newest at 2/60 s
    assert rotate(sample.orientation, sample.gravity) == pytest.approx((0.0, 0.0, G), abs=1e-6)
    assert accelerometer(sample) == pytest.approx((0.0, 0.0, G), abs=0.02)
