"""QuinticPathPlanner, CheckGoal2D and StanleyControlPID: alone, in a loop around an ideal base, and in a graph."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.node.port import camel_case
from graphengine.nodes.wheeled_robots.check_goal import CheckGoal2D
from graphengine.nodes.wheeled_robots.planar import yaw_of
from graphengine.nodes.wheeled_robots.quintic import DURATIONS, QuinticPathPlanner, derivative, quintic
from graphengine.nodes.wheeled_robots.stanley import StanleyControlPID
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, computed, fed, matrix, ready, yaw

Floats = NDArray[np.float64]
Heading = tuple[float, float, float]

angles = st.floats(-math.pi, math.pi)
metres = st.floats(-20.0, 20.0)
places = st.tuples(metres, metres, angles)


def here(place: Heading) -> dict[str, Any]:
    return {"current_position": (*place[:2], 0.0), "current_orientation": yaw(place[2])}


# Headings


@given(st.tuples(*[st.floats(-2.0, 2.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_yaw_is_the_horizontal_direction_of_the_rotated_x_axis(q: tuple[float, float, float, float]) -> None:
    a, b, c, d = (np.array(q) / np.linalg.norm(q)).tolist()
    x, y, _ = matrix((a, b, c, d))[:, 0]
    length = math.hypot(x, y)
    if length > 1e-6:
        assert (math.cos(yaw_of(q)), math.sin(yaw_of(q))) == pytest.approx((x / length, y / length), abs=1e-6)


@pytest.mark.parametrize("place", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0, math.nan)])
@pytest.mark.parametrize("cls", [QuinticPathPlanner, CheckGoal2D, StanleyControlPID])
def test_a_base_with_a_pose_that_is_not_finite_is_refused(cls: Any, place: Heading) -> None:
    node = ready(cls, RecordingContext(), **here(place))
    with pytest.raises(ValueError, match="must be finite"):
        node.compute()


# CheckGoal2D


def reached(place: Heading, target: Heading, thresholds: tuple[float, float]) -> list[bool]:
    node = fed(CheckGoal2D, **here(place), target=target, thresholds=thresholds)
    node.compute()
    found: list[bool] = node.reached_goal.tolist()
    return found


@given(target=places, away=st.floats(0.0, 1.0), bearing=angles, turn=angles, turns=st.integers(-2, 2))
def test_a_goal_is_reached_within_the_thresholds_and_no_farther(
    target: Heading, away: float, bearing: float, turn: float, turns: int
) -> None:
    x, y, looking = target
    place = x + away * math.cos(bearing), y + away * math.sin(bearing), looking + turn + turns * math.tau
    assert reached(place, target, (away + 1e-6, abs(turn) + 1e-6)) == [True, True]
    assert reached(place, target, (away - 1e-6, abs(turn) - 1e-6)) == [False, False]


def test_a_base_exactly_at_a_threshold_has_reached_the_goal() -> None:
    assert reached((3.0, 4.0, 0.5), (0.0, 0.0, 0.0), (5.0, yaw_of(yaw(0.5)))) == [True, True]


@pytest.mark.parametrize(
    ("target", "current", "arrived"), [(0.8, 0.8, True), (0.8, -1.0, False), (math.pi - 0.01, 0.01 - math.pi, True)]
)
def test_yaws_are_compared_with_the_targets(target: float, current: float, arrived: bool) -> None:
    assert reached((0.0, 0.0, current), (0.0, 0.0, target), (0.1, 0.05)) == [True, arrived]


def test_a_target_with_nan_is_never_reached() -> None:
    assert reached((0.0, 0.0, 0.0), (math.nan, 0.0, math.nan), (1.0, 1.0)) == [False, False]


# QuinticPathPlanner


def planner(start: Heading, target: Heading, **inputs: Any) -> QuinticPathPlanner:
    goal = {"target_position": (*target[:2], 0.0), "target_orientation": yaw(target[2])}
    return ready(QuinticPathPlanner, RecordingContext(), **{**here(start), **goal, **inputs})


def arrays(node: QuinticPathPlanner) -> Floats:
    """Rows of one more compute: speeds, x, y, yaws."""
    node.compute()
    return node.path_arrays.reshape(4, -1)


numbers = st.floats(-10.0, 10.0)


@given(ends=st.lists(numbers, min_size=6, max_size=6), duration=st.sampled_from(DURATIONS))
def test_a_quintic_meets_position_velocity_and_acceleration_at_both_ends(ends: list[float], duration: int) -> None:
    coefficients = quintic(np.array(ends)[:, None], duration)
    found = [derivative(coefficients, order, duration, 1)[0] for order in range(3)]
    assert [at[0] for at in found] + [at[-1] for at in found] == pytest.approx(ends, abs=1e-9)


def test_a_quintic_from_rest_to_rest_is_the_minimum_jerk_curve() -> None:
    """10 s^3 - 15 s^4 + 6 s^5 (T. Flash and N. Hogan, The coordination of arm movements, 1985)."""
    coefficients = quintic(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])[:, None], 7.0)
    assert coefficients[:, 0] == pytest.approx([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])


@given(start=places, target=places, v=st.floats(0.1, 2.0), w=st.floats(0.1, 2.0))
def test_a_path_leads_from_the_base_to_the_target_along_both_yaws(
    start: Heading, target: Heading, v: float, w: float
) -> None:
    node = planner(start, target, initial_velocity=v, goal_velocity=w, max_accel=100.0, max_jerk=100.0)
    speeds, x, y, yaws = arrays(node)
    assert (x[0], y[0], yaws[0], speeds[0]) == pytest.approx((*start, v), abs=1e-6)
    assert (x[-1], y[-1], yaws[-1], speeds[-1]) == pytest.approx((*target, w), abs=1e-6)
    assert node.target == pytest.approx(target)
    assert node.target_changed


@settings(max_examples=30)
@given(target=places.filter(lambda place: math.hypot(*place[:2]) > 1.0))
def test_a_path_respects_its_limits_and_its_points_are_at_most_a_step_apart(target: Heading) -> None:
    node = planner((0.0, 0.0, 0.0), target, step=0.01)
    speeds, x, y, _ = arrays(node)
    duration = next(T for T in DURATIONS if math.ceil(T / 0.01) + 1 == len(x))
    dt = duration / (len(x) - 1)
    assert dt <= 0.01
    velocity = np.gradient(x, dt), np.gradient(y, dt)
    assert np.hypot(*velocity)[1:-1] == pytest.approx(speeds[1:-1], abs=1e-3)
    acceleration = np.gradient(velocity[0], dt), np.gradient(velocity[1], dt)
    assert np.hypot(*acceleration)[2:-2].max() <= 1.5 + 1e-2
    jerk = np.gradient(acceleration[0], dt), np.gradient(acceleration[1], dt)
    assert np.hypot(*jerk)[3:-3].max() <= 0.3 + 1e-2


def test_the_path_has_the_shortest_duration_that_respects_the_limits() -> None:
    """From rest to rest the greatest acceleration is 10 / sqrt(3) D / T^2 and the greatest jerk 60 D / T^3."""
    rest = {"initial_velocity": 0.0, "goal_velocity": 0.0, "initial_accel": 0.0, "goal_accel": 0.0, "step": 1.0}
    for distance in (1.0, 10.0, 100.0):
        fits = [T for T in DURATIONS if 10 / math.sqrt(3) * distance / T**2 <= 1.5 and 60 * distance / T**3 <= 0.3]
        assert arrays(planner((0.0, 0.0, 0.0), (distance, 0.0, 0.0), **rest)).shape == (4, fits[0] + 1)


def test_where_nothing_moves_a_path_keeps_the_yaw() -> None:
    rest = {"initial_velocity": 0.0, "goal_velocity": 0.0, "initial_accel": 0.0, "goal_accel": 0.0}
    speeds, x, y, yaws = arrays(planner((1.0, 2.0, 0.7), (1.0, 2.0, 0.7), **rest))
    assert speeds == pytest.approx(0.0, abs=1e-12)
    assert (set(x), set(y)) == ({1.0}, {2.0})
    assert yaws == pytest.approx(0.7)


def test_a_target_that_hardly_moves_keeps_its_path() -> None:
    node = planner((0.0, 0.0, 0.0), (5.0, 0.0, math.pi - 0.01))
    node.compute()
    path = node.path_arrays
    node.target_position, node.target_orientation = (5.09, -0.09, 0.0), yaw(0.01 - math.pi)
    node.compute()
    assert node.path_arrays is path
    assert not node.target_changed
    assert node.target == pytest.approx((5.0, 0.0, math.pi - 0.01))


@pytest.mark.parametrize("target", [(5.11, 0.0, 0.0), (5.0, -0.11, 0.0), (5.0, 0.0, 0.06)])
def test_a_target_that_moves_or_turns_gets_another_path(target: Heading) -> None:
    node = planner((0.0, 0.0, 0.0), (5.0, 0.0, 0.0))
    node.compute()
    node.target_position, node.target_orientation = (*target[:2], 0.0), yaw(target[2])
    node.compute()
    assert node.target_changed
    assert node.target == pytest.approx(target)


def test_after_a_stop_a_new_path_is_planned(context: RecordingContext) -> None:
    node = computed(QuinticPathPlanner, context, **here((0.0, 0.0, 0.0)), target_position=(5.0, 0.0, 0.0))
    context.stop(node)
    assert (len(node.path_arrays), node.target_changed) == (0, False)
    node.compute()
    assert node.target_changed


@pytest.mark.parametrize("turn", [0.5, -0.5])
def test_a_prim_can_be_the_target_and_its_yaw_has_a_sign(turn: float, context: RecordingContext) -> None:
    context.world.add_body("/Goal", (4.0, 1.0, 0.3), yaw(turn))
    node = computed(QuinticPathPlanner, context, **here((0.0, 0.0, 0.0)), target_prim="/Goal")
    assert node.target == pytest.approx((4.0, 1.0, turn))


@pytest.mark.parametrize(
    ("inputs", "complaint"),
    [
        (
            {"max_jerk": 0.0},
            "a path of 95 s or less that respects maxAccel 1.5 m/s2 and maxJerk 0 m/s3; the path of 95 s needs",
        ),
        ({"max_accel": math.inf, "target_position": (1e6, 0.0, 0.0)}, "the path of 95 s needs"),
        ({"target_position": (math.nan, 0.0, 0.0)}, "targetPosition must be finite"),
        ({"goal_velocity": math.inf}, "goalVelocity must be finite"),
        ({"initial_accel": -math.inf}, "initialAccel must be finite"),
    ],
)
def test_a_path_that_cannot_be_planned_is_an_error(inputs: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        planner((0.0, 0.0, 0.0), (5.0, 0.0, 0.0), **inputs).compute()


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, 1e-9])
def test_a_step_from_a_wire_is_checked(step: float) -> None:
    node = planner((0.0, 0.0, 0.0), (5.0, 0.0, 0.0))
    node.step = step
    with pytest.raises(ValueError, match=r"step must be 0\.001 s or more"):
        node.compute()


# StanleyControlPID


class Base:
    """A base that does at once what it is told, at 100 Hz."""

    def __init__(self, place: Heading, speed: float, **inputs: Any) -> None:
        self.place, self.speed = place, speed
        self.node = StanleyControlPID(**here(place), **inputs)

    def move(self, seconds: float) -> None:
        dt = 0.01
        for _ in range(round(seconds / dt)):
            self.node.current_position, self.node.current_orientation = (*self.place[:2], 0.0), yaw(self.place[2])
            self.node.current_speed = (self.speed, 0.0, 0.0)
            self.node.compute()
            x, y, looking = self.place
            self.speed, turn = self.node.linear_velocity, self.node.angular_velocity * dt
            middle = looking + turn / 2
            step = self.speed * dt
            self.place = x + step * math.cos(middle), y + step * math.sin(middle), looking + turn


def line(length: float, at: Heading = (0.0, 0.0, 0.0)) -> Floats:
    """A straight path with a point every 5 cm."""
    along = np.arange(0.0, length + 0.01, 0.05)
    x, y = at[0] + along * math.cos(at[2]), at[1] + along * math.sin(at[2])
    return np.concatenate((np.ones_like(along), x, y, np.full_like(along, at[2])))


@settings(max_examples=20)
@given(side=st.floats(-2.0, 2.0), turned=st.floats(-1.5, 1.5), heading=angles)
def test_a_base_comes_to_a_straight_path_and_stays(side: float, turned: float, heading: float) -> None:
    start = -side * math.sin(heading), side * math.cos(heading), heading + turned
    base = Base(start, 0.5, path_arrays=line(40.0, (0.0, 0.0, heading)), target=(99.0, 99.0, 0.0), max_velocity=1.0)
    base.move(20.0)
    x, y, looking = base.place
    assert -x * math.sin(heading) + y * math.cos(heading) == pytest.approx(0.0, abs=0.02)
    assert math.remainder(looking - heading, math.tau) == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("gain", [0.25, 0.5, 1.0])
def test_a_small_error_of_the_front_axle_decays_with_the_control_gain(gain: float) -> None:
    """On the law's own manifold, heading = -asin(k e / v), the error of the front axle obeys de/dt = -k e."""
    ahead, error = 0.1 * 0.4132, 0.05
    looking = -math.asin(gain * error)
    start = 0.0, error - ahead * math.sin(looking), looking
    inputs = {"path_arrays": line(40.0), "target": (99.0, 99.0, 0.0), "max_velocity": 1.0}
    base = Base(start, 1.0, **inputs, gains=(gain, 0.1, 1.5))
    base.move(2.0)
    front = base.place[1] + ahead * math.sin(base.place[2])
    assert front == pytest.approx(error * math.exp(-gain * 2.0), rel=0.03)


def test_the_steering_limit_is_a_limit_of_curvature() -> None:
    base = Base((0.0, 5.0, math.pi / 2), 1.0, path_arrays=line(40.0), target=(99.0, 99.0, 0.0), max_velocity=1.0)
    base.node.current_speed = (1.0, 0.0, 0.0)
    base.node.compute()
    assert base.node.angular_velocity / base.node.linear_velocity == pytest.approx(-math.tan(0.0872665) / 0.04132)


def test_the_speed_is_scaled_to_the_greatest_and_falls_evenly_over_the_last_third() -> None:
    base = Base((0.0, 0.0, 0.0), 2.0, path_arrays=line(9.0), target=(9.0, 0.0, 0.0), max_velocity=2.0)
    for x, expected in [(1.0, 2.0), (5.9, 2.0), (7.5, 2.0 * math.sqrt(0.5)), (8.85, 2.0 * math.sqrt(0.05))]:
        base.place, base.node.gains = (x, 0.0, 0.0), (0.5, 1.0, 0.1)
        base.node.wheel_base = 1e-6
        base.move(0.01)
        assert base.node.linear_velocity == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("turned", [3.0, -3.0, 0.05])
def test_at_the_target_a_base_turns_on_the_spot_in_the_shorter_direction(turned: float) -> None:
    target = (5.0, 0.0, 2.0)
    base = Base((5.05, 0.0, 2.0 + turned), 0.0, path_arrays=line(5.0), target=target)
    base.move(0.01)
    assert base.node.linear_velocity == 0.0
    assert base.node.angular_velocity == pytest.approx(-math.copysign(min(1.0, 0.6 * abs(turned)), turned))
    base.move(15.0)
    assert base.place == pytest.approx((5.05, 0.0, 2.0), abs=1e-2)


def test_a_base_that_reached_the_goal_stops() -> None:
    base = Base((0.0, 0.0, 0.0), 1.0, path_arrays=line(5.0), target=(5.0, 0.0, 0.0), reached_goal=[True, True])
    base.move(0.01)
    assert (base.node.linear_velocity, base.node.angular_velocity) == (0.0, 0.0)


def test_a_base_that_missed_the_target_drives_back_to_it() -> None:
    base = Base((5.0, 0.4, 0.0), 0.5, path_arrays=line(5.0), target=(5.0, 0.0, 0.0))
    base.node.nearest = 99
    base.move(60.0)
    assert math.dist(base.place[:2], (5.0, 0.0)) <= 0.1


def test_a_path_restarts_if_its_values_change_or_target_changed_is_true() -> None:
    node = StanleyControlPID(**here((4.0, 0.0, 0.0)), path_arrays=line(5.0), target=(99.0, 0.0, 0.0))
    node.compute()
    assert node.nearest == 81
    node.current_position, node.path_arrays = (0.0, 0.0, 0.0), node.path_arrays.copy()
    node.compute()
    assert node.nearest == 81
    node.target_changed = True
    node.compute()
    assert node.nearest == 1
    node.target_changed, node.path_arrays = False, line(3.0)
    node.compute()
    assert node.nearest == 1


@pytest.mark.parametrize(
    ("inputs", "complaint"),
    [
        ({"path_arrays": []}, r"pathArrays must be a path \(wire pathArrays of QuinticPathPlanner"),
        ({"path_arrays": [1.0] * 5}, "four arrays of the same length, all finite, not 5 numbers"),
        ({"path_arrays": [1.0, math.nan, 0.0, 0.0]}, "four arrays of the same length, all finite"),
        ({"gains": (0.5, 0.0, 0.1)}, "gains must be three numbers, the second above 0"),
        ({"gains": (0.5, 0.1, 0.0)}, "between 0 and pi/2"),
        ({"gains": (0.5, 0.1, 1.6)}, "between 0 and pi/2"),
        ({"current_speed": (math.nan, 0.0, 0.0)}, "currentSpeed"),
    ],
)
def test_numbers_out_of_range_are_refused(inputs: dict[str, Any], complaint: str) -> None:
    values: dict[str, Any] = {"path_arrays": line(5.0), "target": (5.0, 0.0, 0.0), **inputs}
    with pytest.raises(ValueError, match=complaint):
        StanleyControlPID(**here((0.0, 0.0, 0.0)), **values).compute()


@pytest.mark.parametrize("field", ["wheel_base", "step"])
def test_a_size_of_0_from_a_wire_is_refused(field: str) -> None:
    node = StanleyControlPID(**here((0.0, 0.0, 0.0)), path_arrays=line(5.0), target=(5.0, 0.0, 0.0))
    setattr(node, field, 0.0)
    with pytest.raises(ValueError, match=f"{camel_case(field)} must be above 0"):
        node.compute()


# In a graph


GRAPH = """
nodes:
  Tick: OnPlaybackTick
  Position: {{type: ConstantVector3d, inputs: {{value: [0.0, 0.0, 0.0]}}}}
  Orientation: {{type: ConstantQuatd, inputs: {{value: [0.0, 0.0, 0.0, 1.0]}}}}
  Plan: {{type: QuinticPathPlanner, inputs: {{targetPosition: {target}}}}}
  Check: CheckGoal2D
  Steer: StanleyControlPID
connections:
  - Tick.tick -> Plan.execIn
  - Plan.execOut -> Check.execIn
  - Check.execOut -> Steer.execIn
  - Position.inputs:value -> Plan.currentPosition
  - Position.inputs:value -> Check.currentPosition
  - Position.inputs:value -> Steer.currentPosition
  - Orientation.inputs:value -> Plan.currentOrientation
  - Orientation.inputs:value -> Check.currentOrientation
  - Orientation.inputs:value -> Steer.currentOrientation
  - Plan.pathArrays -> Steer.pathArrays
  - Plan.target -> Check.target
  - Plan.target -> Steer.target
  - Plan.targetChanged -> Steer.targetChanged
  - Check.reachedGoal -> Steer.reachedGoal
"""


def test_in_a_graph_planner_goal_check_and_follower_drive_a_base_to_its_target(play: Player) -> None:
    playing = play.graph(GRAPH.format(target="[5, 0, 0]")).tick()
    plan, check, steer = (playing.node(name) for name in ("Plan", "Check", "Steer"))
    assert (plan.target, plan.target_changed) == ((5.0, 0.0, 0.0), True)
    assert check.reached_goal.tolist() == [False, True]
    assert steer.linear_velocity > 0.0
    assert steer.angular_velocity == pytest.approx(0.0)
    playing.tick()
    assert not plan.target_changed
    playing.set("Plan", "target_position", (0.0, 0.05, 0.0))
    playing.tick()
    assert check.reached_goal.tolist() == [True, True]
    assert (steer.linear_velocity, steer.angular_velocity) == (0.0, 0.0)


def test_a_target_out_of_reach_ends_the_branch_of_the_planner(play: Player) -> None:
    playing = play.graph(GRAPH.format(target="[1e6, 0, 0]")).tick()
    assert playing.dropped == {"/World/graph/Plan": 1}
    assert not playing.node("Plan").target_changed
