"""ComputeWheelOdometry against closed forms of lines, arcs and turns, and the laws of its noise and covariances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.devices.dry_world import ArticulationStub
from graphengine.format.errors import ContextError, JointError
from graphengine.node import BadValueError
from graphengine.nodes.wheeled_robots.dead_reckoning import Planar, Propagation, moved
from graphengine.nodes.wheeled_robots.holonomic import HolonomicController
from graphengine.nodes.wheeled_robots.wheel_odometry import ComputeWheelOdometry
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, dd100, ready, vector
from tests.other_process import in_another_process

RADIUS, TRACK, BASE = 0.1, 0.5, 0.8
DT = 1 / 60


class Car:
    """A robot whose wheels a test turns, and its odometry."""

    def __init__(self, joints: Sequence[str], *, seed: int = 0, **inputs: Any) -> None:
        self.context = RecordingContext()
        self.context.services.seed = seed
        self.joints: ArticulationStub = self.context.world.add_robot("/robot", joints)
        self.angles = dict.fromkeys(joints, 0.0)
        geometry = {"wheel_radius": RADIUS, "wheel_distance": TRACK, "velocity_window": 1}
        self.node = ready(ComputeWheelOdometry, self.context, **{"target_prim": "/robot", **geometry, **inputs})
        self.tick()

    def tick(self) -> None:
        self.context.tick()
        self.joints.state["position"] = list(self.angles.values())
        self.node.compute()

    def roll(self, travel: Mapping[str, float], ticks: int = 1) -> None:
        """Roll wheels by distances (m), spread evenly over ticks."""
        for _ in range(ticks):
            for name, distance in travel.items():
                self.angles[name] += distance / ticks / RADIUS
            self.tick()

    @property
    def pose(self) -> tuple[float, float, float]:
        """x, y and yaw, as they are output."""
        x, y, _ = self.node.position
        _, _, sine, cosine = self.node.orientation
        return x, y, 2.0 * math.atan2(sine, cosine)

    @property
    def twist(self) -> tuple[float, float, float]:
        """Speeds forward and to the left, and the turn rate."""
        return (*self.node.linear_velocity[:2], self.node.angular_velocity[2])

    def covariance(self, of: str = "pose") -> Any:
        """The covariance of x, y and yaw."""
        return getattr(self.node, f"{of}_covariance").reshape(6, 6)[np.ix_([0, 1, 5], [0, 1, 5])]


def two_wheels(**inputs: Any) -> Car:
    return Car(["left", "right"], **{"left_joints": ["left"], "right_joints": ["right"], **inputs})


def sides(ahead: float, turn: float, distance: float = TRACK) -> dict[str, float]:
    """How far two wheels roll for a motion."""
    return {"left": ahead - turn * distance / 2, "right": ahead + turn * distance / 2}


MECANUM = ["front_left", "back_left", "front_right", "back_right"]


def mecanum(**inputs: Any) -> Car:
    joints: dict[str, Any] = {"left_joints": MECANUM[:2], "right_joints": MECANUM[2:]}
    return Car(MECANUM, kinematics="mecanum", wheel_base=BASE, **joints, **inputs)


def ackermann(steering: Sequence[str], **inputs: Any) -> Car:
    joints: dict[str, Any] = {"left_joints": ["left"], "right_joints": ["right"], "steering_joints": steering}
    return Car(["left", "right", *steering], kinematics="ackermann", wheel_base=BASE, **joints, **inputs)


def on_arc(length: float, turn: float) -> Any:
    """Where an arc that begins along x ends."""
    if abs(turn) < 1e-5:  # too little for the closed form; the series is off by less than 1e-10 m
        return pytest.approx((length, length * turn / 2.0, turn), abs=1e-9)
    radius = length / turn
    return pytest.approx((radius * math.sin(turn), radius * (1.0 - math.cos(turn)), turn), abs=1e-9)


# Wheels that do not steer


def test_before_the_first_motion_the_odometry_is_at_the_origin_at_rest() -> None:
    car = two_wheels()
    assert (car.pose, car.twist) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert car.node.pose_covariance.tolist() == car.node.twist_covariance.tolist() == [0.0] * 36


@given(length=st.floats(-5.0, 5.0), turn=st.floats(-3.0, 3.0), ticks=st.integers(1, 20))
def test_lines_arcs_and_turns_on_the_spot_are_exact_however_few_ticks_they_take(
    length: float, turn: float, ticks: int
) -> None:
    car = two_wheels()
    car.roll(sides(length, turn), ticks)
    assert car.pose == on_arc(length, turn)
    assert car.twist == pytest.approx((length / ticks / DT, 0.0, turn / ticks / DT), abs=1e-6)


def test_a_circle_closes() -> None:
    car = two_wheels()
    car.roll(sides(math.tau, math.tau), 7)
    assert car.node.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_square_of_lines_and_turns_closes() -> None:
    car = two_wheels()
    for _ in range(4):
        car.roll(sides(2.0, 0.0), 3)
        car.roll(sides(0.0, math.pi / 2), 3)
    assert car.node.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_skid_steered_base_uses_the_mean_of_the_wheels_on_each_side() -> None:
    car = Car("abcde", wheel_distance_multiplier=1.5, left_joints=["a", "b", "c"], right_joints=["d", "e"])
    car.roll({"a": 0.1, "b": 0.2, "c": 0.3, "d": 0.3, "e": 0.5})
    assert car.pose == on_arc(0.3, 0.2 / (1.5 * TRACK))


def test_calibrated_radii_and_joints_that_turn_backwards_are_multipliers_of_the_radius() -> None:
    car = two_wheels(left_wheel_radius_multiplier=1.02, right_wheel_radius_multiplier=-0.98)
    car.roll({"left": 1.0 / 1.02, "right": -1.5 / 0.98})
    assert car.pose == on_arc(1.25, 0.5 / TRACK)


@given(center=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), length=st.floats(-2.0, 2.0), turn=st.floats(-3, 3))
def test_the_origin_of_the_base_may_lie_beside_the_middle_of_the_wheels(
    center: tuple[float, float], length: float, turn: float
) -> None:
    """The middle goes from `center` along the arc; the origin is at -center of it, turned."""
    car = two_wheels(center_position=center)
    car.roll(sides(length, turn))
    middle = two_wheels()
    middle.roll(sides(length, turn))
    x, y, yaw = middle.pose
    expected = np.array([x, y]) + center
    expected -= [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]] @ np.array(center)
    assert car.pose == pytest.approx((*expected.tolist(), yaw), abs=1e-9)


# Mecanum wheels


def test_mecanum_wheels_that_turn_crosswise_move_the_base_sideways() -> None:
    car = mecanum()
    car.roll({"front_left": -0.3, "back_left": 0.3, "front_right": 0.3, "back_right": -0.3})
    assert car.pose == pytest.approx((0.0, 0.3, 0.0), abs=1e-12)


@given(twist=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-2, 2)))
def test_mecanum_odometry_undoes_the_controller_of_rolling_wheels(twist: tuple[float, float, float]) -> None:
    x, y, half = BASE / 2, TRACK / 2, math.sqrt(0.5)
    controller = HolonomicController(
        wheel_radius=np.array([RADIUS]),
        wheel_positions=np.array([[x, y, 0.0], [-x, y, 0.0], [x, -y, 0.0], [-x, -y, 0.0]]),
        wheel_orientations=np.array([[half, 0.0, 0.0, half]] * 4),  # the axle, x of each wheel, is y of the base
        mecanum_angles=np.array([45.0, -45.0, -45.0, 45.0]),
        rolling=True,
        input_velocity=twist,
    )
    controller.compute()
    car = mecanum()
    speeds = controller.joint_velocity_command * RADIUS
    car.roll({name: speed * DT for name, speed in zip(MECANUM, speeds.tolist(), strict=True)})
    assert car.twist == pytest.approx(twist, abs=1e-9)


def test_sideways_motion_with_a_turn_is_integrated_as_an_arc() -> None:
    fine, coarse = mecanum(), mecanum()
    k = (TRACK + BASE) / 2
    travel = {"front_left": -0.4 - k, "back_left": 0.4 - k, "front_right": 0.4 + k, "back_right": -0.4 + k}
    fine.roll(travel, 1000)
    coarse.roll(travel)
    assert coarse.pose == pytest.approx(fine.pose, abs=1e-9)


# Steered wheels


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_four_wheels_turn_about_the_point_that_their_steering_angles_give(sign: float) -> None:
    radius = sign * 2.5
    car = ackermann(["steer_left", "steer_right"])
    car.angles["steer_left"] = math.atan(BASE / (radius - TRACK / 2))
    car.angles["steer_right"] = math.atan(BASE / (radius + TRACK / 2))
    car.roll(sides(1.5, 1.5 / radius))
    assert car.pose == on_arc(1.5, 1.5 / radius)


def test_a_steered_wheel_in_the_middle_bends_the_path_by_its_tangent() -> None:
    car = ackermann(["steer"], steering_multiplier=-1.0)
    car.angles["steer"] = -0.4
    turn = math.tan(0.4) / BASE
    car.roll(sides(1.0, turn))
    assert car.pose == on_arc(1.0, turn)


def test_a_driven_wheel_in_the_middle_replaces_both_sides() -> None:
    joints: dict[str, Any] = {"left_joints": ["back"], "right_joints": ["back"], "steering_joints": ["front"]}
    car = Car(["back", "front"], kinematics="ackermann", wheel_base=BASE, wheel_distance=0.0, **joints)
    car.angles["front"] = 0.4
    car.roll({"back": 1.0}, 5)
    assert car.pose == on_arc(1.0, math.tan(0.4) / BASE)


def test_steered_wheels_behind_turn_the_base_the_other_way() -> None:
    car = ackermann(["steer"])
    car.node.wheel_base, car.angles["steer"] = -BASE, 0.4
    turn = -math.tan(0.4) / BASE
    car.roll(sides(1.0, turn))
    assert car.pose == on_arc(1.0, turn)


# Encoders


@given(distance=st.floats(-3.0, 3.0), resolution=st.integers(4, 4096))
def test_the_error_of_encoders_stays_below_a_tick_over_any_distance(distance: float, resolution: int) -> None:
    car = two_wheels(ticks_per_revolution=float(resolution))
    car.roll(sides(distance, 0.0), 50)
    assert abs(car.pose[0] - distance) <= math.tau * RADIUS / resolution + 1e-9
    assert car.pose[2] == 0.0


def test_velocity_is_the_mean_of_the_window() -> None:
    car = two_wheels(velocity_window=4)
    for speed in (0.0, 1.0, 2.0, 3.0, 6.0):
        car.roll(sides(speed * DT, 0.0))
    assert car.twist[0] == pytest.approx(3.0)


def final_yaw_and_x(seed: int, ticks: int, slip: float = 0.02) -> tuple[float, float]:
    car = two_wheels(slip=slip, seed=seed)
    car.roll(sides(1.0, 0.0), ticks)
    return car.pose[2], car.pose[0]


@pytest.mark.parametrize("ticks", [1, 25])
def test_slip_spreads_the_travel_of_a_metre_by_its_value_in_any_number_of_ticks(ticks: int) -> None:
    runs = 400
    yaw, x = np.transpose([final_yaw_and_x(seed, ticks) for seed in range(runs)])
    # Two independent wheels: the mean has half the variance of one, the difference twice it.
    assert np.std(yaw) == pytest.approx(0.02 * math.sqrt(2.0) / TRACK, rel=5 / math.sqrt(2 * runs))
    assert np.std(x) == pytest.approx(0.02 / math.sqrt(2.0), rel=5 / math.sqrt(2 * runs))
    assert abs(np.mean(yaw)) < 5 * np.std(yaw) / math.sqrt(runs)


def test_slip_depends_on_the_seed_and_repeats_after_a_stop() -> None:
    assert in_another_process(final_yaw_and_x, 1, 9) == final_yaw_and_x(1, 9) != final_yaw_and_x(2, 9)
    car = two_wheels(slip=0.02)
    poses = []
    for _ in range(2):
        car.roll(sides(1.0, 0.0), 5)
        poses.append(car.pose)
        car.context.stop(car.node)
        assert (car.pose, car.twist) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        car.tick()
    assert poses[0] == poses[1]


# Covariances

VARIANCES: dict[str, Any] = {
    "distance_variance": 2e-4,
    "heading_variance_by_distance": 5e-4,
    "heading_variance_by_turn": 3e-4,
}


def test_variances_grow_in_proportion_to_the_distance_at_any_tick_rate() -> None:
    for ticks in (1, 10, 1000):
        car = two_wheels(**VARIANCES)
        car.roll(sides(4.0, 0.0), ticks)
        covariance = car.covariance()
        assert covariance[0, 0] == pytest.approx(4.0 * 2e-4)
        assert covariance[2, 2] == pytest.approx(4.0 * 5e-4)
    # A heading that walks randomly moves the end sideways by the integral of its walk: variance k L^3 / 3, covariance k L^2 / 2.
    assert covariance[1, 1] == pytest.approx(5e-4 * 4.0**3 / 3.0, rel=1e-3)
    assert covariance[1, 2] == pytest.approx(5e-4 * 4.0**2 / 2.0, rel=1e-3)


def test_a_turn_on_the_spot_increases_only_the_variance_of_the_heading() -> None:
    car = two_wheels(**VARIANCES)
    car.roll(sides(0.0, -2.0), 10)
    np.testing.assert_allclose(car.covariance(), np.diag([0.0, 0.0, 2.0 * 3e-4]), atol=1e-15)


def test_the_covariance_agrees_with_many_runs_with_slip() -> None:
    """On an arc, with the variances that `slip` of two wheels amounts to."""
    slip, runs = 0.02, 400
    model: dict[str, Any] = {"distance_variance": slip**2 / 2, "heading_variance_by_distance": 2 * slip**2 / TRACK**2}
    cars = [two_wheels(slip=slip, seed=seed, **model) for seed in range(runs)]
    for car in cars:
        car.roll(sides(2.0, 1.0), 20)
    predicted, spread = cars[0].covariance(), np.cov(np.transpose([car.pose for car in cars]))
    scale = np.sqrt(np.diag(predicted))
    # The standard error of a correlation over n runs is at most 1 / sqrt(n), of a variance sqrt(2 / n).
    np.testing.assert_allclose(spread / np.outer(scale, scale), predicted / np.outer(scale, scale), atol=5 * 0.0707)


PARTS = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def test_a_turn_whose_half_underflows_to_0_is_a_straight_line() -> None:
    assert moved((1.0, 2.0, 0.0), (3.0, 4.0, 5e-324)) == (4.0, 6.0, 5e-324)


@settings(max_examples=1000)
@given(st.lists(st.floats(-3.0, 3.0), min_size=9, max_size=9), PARTS, PARTS, PARTS)
def test_the_propagated_covariance_equals_matrix_products_to_the_last_bit(
    numbers: list[float], pose: Planar, motion: Planar, noise: Planar
) -> None:
    root = np.array(numbers).reshape(3, 3)
    before = root @ root.T
    (x, y, yaw), (after_x, after_y, _) = pose, moved(pose, motion)
    east, north, turned = after_x - x, after_y - y, yaw + motion[2] / 2.0
    cosine, sine = math.cos(turned), math.sin(turned)
    by_pose = np.array([[1.0, 0.0, -north], [0.0, 1.0, east], [0.0, 0.0, 1.0]])
    by_motion = np.array([[cosine, -sine, -north / 2.0], [sine, cosine, east / 2.0], [0.0, 0.0, 1.0]])
    after = by_pose @ before @ by_pose.T + by_motion @ np.diag(noise) @ by_motion.T
    found = Propagation().propagate(before.ravel().tolist(), pose, moved(pose, motion), motion[2], noise)
    assert np.array(found).tobytes() == ((after + after.T) / 2.0).tobytes()


def test_an_input_that_changes_during_a_run_takes_effect_at_once() -> None:
    car = two_wheels(ticks_per_revolution=0.0)
    car.roll(sides(1.0, 0.0))
    car.node.wheel_radius *= 2.0
    car.roll(sides(1.0, 0.0))
    assert car.pose == on_arc(3.0, 0.0)
    car.node.center_position = (0.0, 0.1)
    car.roll(sides(0.0, 1.0))
    assert car.pose[0] == pytest.approx(3.0 + 0.1 * math.sin(2.0), abs=1e-9)


def test_directions_that_wheels_do_not_measure_have_a_large_variance() -> None:
    car = two_wheels(**VARIANCES)
    car.roll(sides(1.0, 0.5))
    for of in ("pose", "twist"):
        full = getattr(car.node, f"{of}_covariance").reshape(6, 6)
        assert np.diag(full)[2:5].tolist() == [1e6, 1e6, 1e6]
        np.testing.assert_array_equal(full, full.T)
        assert np.linalg.eigvalsh(car.covariance(of)).min() >= -1e-15


def test_the_twist_is_as_uncertain_as_the_motions_of_its_window_and_the_encoders() -> None:
    car = two_wheels(velocity_window=5, ticks_per_revolution=1000.0, **VARIANCES)
    car.roll(sides(1.0, 0.0), 5)
    tick = math.tau * RADIUS / 1000.0
    expected_v = (2e-4 * car.twist[0] * 5 * DT + tick**2 / 6 / 2) / (5 * DT) ** 2
    expected_w = (5e-4 * car.twist[0] * 5 * DT + tick**2 / 6 * 2 / TRACK**2) / (5 * DT) ** 2
    assert np.diag(car.covariance("twist")) == pytest.approx([expected_v, 0.0, expected_w])


# Mistakes


def test_the_error_of_missing_joints_names_the_needed_joints() -> None:
    with pytest.raises(ContextError, match="the joints do not fit mecanum kinematics") as caught:
        two_wheels(kinematics="mecanum")
    assert caught.value.help == ("set leftJoints and rightJoints, with [front, back] in each",)
    with pytest.raises(ContextError, match="the joints do not fit ackermann kinematics"):
        two_wheels(kinematics="ackermann")
    with pytest.raises(JointError, match="no joint 'rigth'"):
        two_wheels(right_joints=["rigth"])


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"wheel_radius": 0.0}, "wheelRadius must be other than 0"),
        ({"wheel_distance": 0.0}, "must be values that determine the motion of a base with differential kinematics"),
        ({"wheel_distance": math.nan}, "wheelDistance must be finite"),
        ({"slip": -0.1}, "slip must be 0.0 or more"),
        ({"velocity_window": 0}, "velocityWindow must be 1 or more"),
    ],
)
def test_a_wire_with_an_illegal_value_changes_nothing(inputs: dict[str, Any], message: str) -> None:
    car = two_wheels()
    car.roll(sides(1.0, 0.0))
    good = {field: getattr(car.node, field) for field in inputs}
    for field, value in inputs.items():
        setattr(car.node, field, value)
    with pytest.raises(BadValueError, match=message):
        car.roll(sides(1.0, 0.0))
    assert car.pose == on_arc(1.0, 0.0)
    for field, value in good.items():
        setattr(car.node, field, value)
    car.tick()
    assert car.pose == on_arc(2.0, 0.0)  # encoders went on counting


# The shipped graph


def test_the_shipped_graph_publishes_wheel_odometry_with_covariances_and_the_truth_beside_it(play: Player) -> None:
    world = dd100()
    joints: ArticulationStub = world.articulation(world.stage.find("/dd100"))
    playing = play.shipped("wheel_odometry", world).tick()
    for tick in range(1, 4):
        joints.state["position"] = [tick * 1.0, tick * 1.0]
        playing.tick()
    odometry = playing.published("/dd100_0000/odom")[-1]
    assert vector(odometry.pose.pose.position)[0] == pytest.approx(3 * 0.049, abs=0.02)
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_link")
    assert odometry.pose.covariance[0] > 0.0 < odometry.twist.covariance[0]
    transform = playing.published("/dd100_0000/tf")[-1].transforms[0]
    assert vector(transform.transform.translation) == vector(odometry.pose.pose.position)
    assert vector(playing.published("/dd100_0000/ground_truth/odom")[-1].pose.pose.position) == (0.0, 0.0, 0.0)


def test_a_reset_of_the_joints_is_no_motion() -> None:
    car = two_wheels()
    car.roll(sides(1.0, 0.5), 10)
    before = car.pose
    car.angles = dict.fromkeys(car.angles, 0.0)
    car.joints.resets += 1
    car.tick()
    assert car.pose == before
    car.roll(sides(0.5, 0.0))
    assert car.twist == pytest.approx((0.5 / DT, 0.0, 0.0))
    assert math.dist(car.pose[:2], before[:2]) == pytest.approx(0.5)
