"""DifferentialController."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import NodeError
from graphengine.node.port import camel_case
from graphengine.nodes.wheeled_robots.differential import DifferentialController
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, dd100, fed, twist

GEOMETRY: dict[str, Any] = {"wheel_radius": 0.1, "wheel_distance": 0.5}
speeds = st.floats(-10.0, 10.0)
sizes = st.floats(0.01, 2.0)


def controller(**inputs: Any) -> DifferentialController:
    return fed(DifferentialController, **{**GEOMETRY, **inputs})


def wheels(node: DifferentialController) -> list[float]:
    """What one more compute commands: left, right."""
    node.compute()
    command: list[float] = node.velocity_command.tolist()
    return command


def twist_of(node: DifferentialController) -> tuple[float, float]:
    """Forward and turning speed that one more compute asks of the wheels: v = r (R + L) / 2, w = r (R - L) / d."""
    left, right = wheels(node)
    return node.wheel_radius * (right + left) / 2, node.wheel_radius * (right - left) / node.wheel_distance


def close(value: Any, expected: Any) -> bool:
    return bool(value == pytest.approx(expected, rel=1e-9, abs=1e-9))


def test_the_default_command_is_two_wheels_at_rest() -> None:
    assert controller().velocity_command.tolist() == [0.0, 0.0]


@given(v=speeds, w=speeds, radius=sizes, distance=sizes)
def test_left_is_slower_than_right_by_w_d_over_r(v: float, w: float, radius: float, distance: float) -> None:
    node = DifferentialController(wheel_radius=radius, wheel_distance=distance, linear_velocity=v, angular_velocity=w)
    left, right = wheels(node)
    assert close(left, (2 * v - w * distance) / (2 * radius))
    assert close(right, (2 * v + w * distance) / (2 * radius))


def test_a_turn_to_the_left_is_positive_and_drives_the_right_wheel_forward() -> None:
    assert wheels(controller(angular_velocity=1.0)) == [-2.5, 2.5]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_signs_of_radius_and_distance_are_ignored(sign: float) -> None:
    node = controller(wheel_radius=0.1 * sign, wheel_distance=-0.5 * sign, angular_velocity=1.0)
    assert wheels(node) == [-2.5, 2.5]


@given(v=speeds, w=speeds, v_max=sizes, w_max=sizes)
def test_the_twist_is_limited_before_the_wheel_speeds_are_computed(
    v: float, w: float, v_max: float, w_max: float
) -> None:
    node = controller(linear_velocity=v, angular_velocity=w, max_linear_speed=v_max, max_angular_speed=w_max)
    assert close(twist_of(node), (math.copysign(min(abs(v), v_max), v), math.copysign(min(abs(w), w_max), w)))


def test_each_wheel_is_limited_separately() -> None:
    node = controller(linear_velocity=1.0, angular_velocity=1.0, max_wheel_speed=10.0)
    assert wheels(node) == [7.5, 10.0]
    node.linear_velocity, node.angular_velocity = -1.0, -1.0
    assert wheels(node) == [-7.5, -10.0]


@pytest.mark.parametrize(("v", "w"), [(1.0, 1.0), (-1.0, 1.0), (0.3, -6.0), (0.0, 5.0), (0.3, 0.1)])
def test_a_twist_beyond_the_wheel_limit_is_scaled_with_a_constant_radius_of_turn(v: float, w: float) -> None:
    inputs = {"linear_velocity": v, "angular_velocity": w, "max_wheel_speed": 5.0, "scale_wheel_speeds": True}
    speeds = wheels(controller(**inputs))
    asked = [(v - w * 0.25) / 0.1, (v + w * 0.25) / 0.1]
    share = min(1.0, 5.0 / max(map(abs, asked)))
    assert speeds == pytest.approx([each * share for each in asked])


def test_a_base_whose_twist_was_scaled_slows_down_from_the_speed_of_its_wheels() -> None:
    limits = {"dt": 0.1, "max_acceleration": 1.0, "max_deceleration": 1.0, "max_wheel_speed": 2.0}
    node = controller(**limits, linear_velocity=5.0, scale_wheel_speeds=True)
    for _ in range(30):
        node.compute()
    assert wheels(node) == pytest.approx([2.0, 2.0])  # 0.2 m/s
    node.linear_velocity = 0.0
    assert wheels(node) == pytest.approx([1.0, 1.0])


def test_a_limit_of_0_means_no_limit_and_the_sign_of_a_limit_is_ignored() -> None:
    assert close(twist_of(controller(linear_velocity=1e6)), (1e6, 0.0))
    assert close(twist_of(controller(linear_velocity=5.0, max_linear_speed=-2.0)), (2.0, 0.0))


# Ramps


def ramping(**inputs: Any) -> DifferentialController:
    limits = {"dt": 0.1, "max_acceleration": 1.0, "max_deceleration": 2.0, "max_angular_acceleration": 3.0}
    return controller(**{**limits, **inputs})


@pytest.mark.parametrize(
    ("first", "computes", "then", "speeds"),
    [
        pytest.param(0.25, 0, 0.25, [0.1, 0.2, 0.25, 0.25], id="up by acceleration times dt"),
        pytest.param(0.3, 3, 0.0, [0.1, 0.0, 0.0], id="down by deceleration times dt"),
        pytest.param(
            0.2, 2, -0.2, [0.0, -0.1, -0.2, -0.2], id="on the way through 0, first braking, then accelerating"
        ),
        pytest.param(0.2, 2, -5.0, [0.0, -0.1, -0.2], id="first braking also on the way to a higher speed backwards"),
    ],
)
def test_forward_speed_ramps(first: float, computes: int, then: float, speeds: list[float]) -> None:
    node = ramping(linear_velocity=first)
    for _ in range(computes):
        node.compute()
    node.linear_velocity = then
    assert close([twist_of(node)[0] for _ in speeds], speeds)


def test_ramps_are_the_same_backwards_and_forwards() -> None:
    forward, backward = ramping(linear_velocity=0.25), ramping(linear_velocity=-0.25)
    assert all(close(twist_of(forward)[0], -twist_of(backward)[0]) for _ in range(4))


def test_ramps_of_the_turn_rate_are_the_same_in_both_directions() -> None:
    node = ramping(angular_velocity=0.7)
    assert close([twist_of(node)[1] for _ in range(3)], [0.3, 0.6, 0.7])
    node.angular_velocity = -0.7
    assert close([twist_of(node)[1] for _ in range(6)], [0.4, 0.1, -0.2, -0.5, -0.7, -0.7])


@pytest.mark.parametrize("missing", ["max_acceleration", "max_deceleration"])
def test_the_forward_ramp_acts_only_if_both_of_its_limits_are_set(missing: str) -> None:
    node = ramping(linear_velocity=5.0, angular_velocity=5.0, **{missing: 0.0})
    assert close(twist_of(node), (5.0, 0.3))


@given(target=speeds, ticks=st.integers(1, 60))
def test_a_ramp_never_goes_beyond_its_target_and_never_faster_than_its_limit(target: float, ticks: int) -> None:
    node, before = ramping(linear_velocity=target), 0.0
    for _ in range(ticks):
        now = twist_of(node)[0]
        assert abs(now) <= abs(target) + 1e-9
        assert abs(now - before) <= 0.1 + 1e-9
        before = now
    assert close(before, math.copysign(min(abs(target), 0.1 * ticks), target))


@pytest.mark.parametrize("name", ["linear_velocity", "angular_velocity", "dt"])
def test_a_ramp_continues_after_a_nan_command(name: str) -> None:
    node, spared = (ramping(linear_velocity=0.5, angular_velocity=0.7) for _ in range(2))
    assert close(wheels(node), wheels(spared))
    good = getattr(node, name)
    setattr(node, name, math.nan)
    with contextlib.suppress(ValueError):
        node.compute()
    setattr(node, name, good)
    assert all(close(wheels(node), wheels(spared)) for _ in range(5))


def test_the_limit_of_speed_comes_before_the_ramp() -> None:
    node = ramping(linear_velocity=5.0, max_linear_speed=0.15)
    assert close([twist_of(node)[0] for _ in range(3)], [0.1, 0.15, 0.15])


# When inputs are not legal, and when they change


@pytest.mark.parametrize("name", ["wheel_radius", "wheel_distance"])
def test_a_wheel_without_size_is_an_error_that_names_it(name: str) -> None:
    with pytest.raises(ValueError, match=f"{camel_case(name)} must be other than 0"):
        controller(**{name: 0.0}).compute()


@pytest.mark.parametrize("limit", ["max_acceleration", "max_deceleration", "max_angular_acceleration"])
@pytest.mark.parametrize("dt", [0.0, -0.1])
def test_a_ramp_without_dt_is_an_error_and_the_command_stays(limit: str, dt: float) -> None:
    node = controller(linear_velocity=1.0)
    node.compute()
    node.dt, before = dt, node.velocity_command
    setattr(node, limit, 1.0)
    node.linear_velocity = 2.0
    with pytest.raises(ValueError, match="must be above 0 for acceleration limits"):
        node.compute()
    assert node.velocity_command is before


def test_changed_parameters_take_effect_although_isaac_sim_keeps_the_first_values() -> None:
    node = controller(linear_velocity=1.0)
    assert wheels(node) == [10.0, 10.0]
    node.wheel_radius = 0.2
    assert wheels(node) == [5.0, 5.0]
    node.max_linear_speed = 0.5
    assert wheels(node) == [2.5, 2.5]


def test_every_compute_makes_a_new_array() -> None:
    node = controller(linear_velocity=1.0)
    node.compute()
    before = node.velocity_command
    node.linear_velocity = 2.0
    node.compute()
    assert before.tolist() == [10.0, 10.0]


def test_a_stop_resets_ramp_and_command_and_keeps_the_inputs() -> None:
    node = ramping(linear_velocity=0.25)
    first = [twist_of(node) for _ in range(3)]
    RecordingContext().stop(node)
    assert node.velocity_command.tolist() == [0.0, 0.0]
    assert node.linear_velocity == 0.25
    assert [twist_of(node) for _ in range(3)] == first


# In graphs


def test_in_the_tutorials_graph_a_twist_drives_the_wheels_in_the_tick_of_its_arrival(play: Player) -> None:
    world = dd100()
    playing = play.shipped("tutorial/cmd_vel", world)
    robot = world.articulation(world.stage.find("/dd100"))
    playing.tick()
    assert robot.targets["velocity"] == [0.0, 0.0]
    playing.transport.inject("/dd100_0000/cmd_vel", twist(1.0, 1.0))
    playing.tick()
    # wheelRadius 0.1, wheelDistance 0.45
    assert robot.targets["velocity"] == pytest.approx([7.75, 12.25])
    playing.tick(100)
    assert robot.targets["velocity"] == pytest.approx([7.75, 12.25])


def test_in_the_dd100s_graph_silence_brakes_it_along_the_ramp(play: Player) -> None:
    world = dd100()
    playing = play.shipped("dd100/cmd_vel", world)
    robot = world.articulation(world.stage.find("/dd100"))
    radius, acceleration, timeout = 0.049, 1.0, 0.5
    playing.transport.inject("/dd100_0000/cmd_vel", twist(0.4, 0.0))
    driven = playing.each_tick(90, lambda: robot.targets["velocity"][0] * radius)
    up = [min(0.4, acceleration * tick / 60) for tick in range(1, 31)]
    # The message came at tick 1; half a second of silence ends at tick 31.
    down = [max(0.0, 0.4 - acceleration * (tick - 30) / 60) for tick in range(31, 91)]
    assert timeout * 60 == 30
    assert driven == pytest.approx(up + down, abs=1e-9)


@pytest.mark.parametrize("name", ["tutorial/cmd_vel", "dd100/cmd_vel"])
def test_in_the_shipped_graphs_a_second_play_begins_at_rest(play: Player, name: str) -> None:
    world = dd100()
    playing = play.shipped(name, world)
    robot = world.articulation(world.stage.find("/dd100"))
    playing.transport.inject("/dd100_0000/cmd_vel", twist(0.4, 0.4))
    playing.tick(10)
    assert robot.targets["velocity"] != [0.0, 0.0]
    playing.session.stop()
    playing.tick()
    assert robot.targets["velocity"] == [0.0, 0.0]


def test_in_a_graph_a_wheel_radius_of_0_stops_the_run_with_an_error_that_names_the_node(play: Player) -> None:
    playing = play.shipped("tutorial/cmd_vel", dd100())
    playing.transport.inject("/dd100_0000/cmd_vel", twist(1.0, 0.0))
    playing.set("DiffController", "wheel_radius", 0.0)
    with pytest.raises(NodeError, match=r"node DiffController .*wheelRadius must be other than 0"):
        playing.tick()
