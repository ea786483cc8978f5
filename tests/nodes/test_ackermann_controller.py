"""AckermannController."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.wheeled_robots.ackermann import AckermannController
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, fed

GEOMETRY: dict[str, Any] = {"wheel_base": 1.6, "track_width": 1.2, "front_wheel_radius": 0.3, "back_wheel_radius": 0.4}
sizes = st.floats(0.05, 3.0)
angles = st.floats(-1.3, 1.3)


def controller(**inputs: Any) -> AckermannController:
    return fed(AckermannController, **{**GEOMETRY, **inputs})


def driven(node: AckermannController) -> tuple[list[float], list[float]]:
    """Steering angles and wheel speeds of one more compute."""
    node.compute()
    return node.wheel_angles.tolist(), node.wheel_rotation_velocity.tolist()


def close(value: Any, expected: Any) -> bool:
    return bool(value == pytest.approx(expected, rel=1e-9, abs=1e-9))


def test_before_the_first_compute_there_is_no_command() -> None:
    assert controller().wheel_angles.tolist() == []
    assert controller().wheel_rotation_velocity.tolist() == []


def test_straight_ahead_every_wheel_rolls_at_speed_over_radius() -> None:
    steering, rolling = driven(controller(speed=1.2))
    assert steering == [0.0, 0.0]
    assert close(rolling, [4.0, 4.0, 3.0, 3.0])


@given(base=sizes, track=sizes, angle=angles, speed=st.floats(-5.0, 5.0), rear=st.booleans())
def test_all_wheels_roll_about_one_turning_centre(
    base: float, track: float, angle: float, speed: float, rear: bool
) -> None:
    # The middle of the axle that does not steer moves ahead at `speed` while the base turns at w = speed tan(angle) / base. A
    # wheel at p then moves with v + w x p; it has to point and roll that way.
    node = controller(
        wheel_base=base,
        track_width=track,
        steering_angle=angle,
        speed=speed,
        invert_steering=rear,
        max_wheel_rotation=0.0,
    )
    steering, rolling = driven(node)
    turning, ahead = speed * math.tan(angle) / base, -base if rear else base
    left, right = track / 2, -track / 2
    front, back = ((0.0, 0.0), (ahead, ahead)) if rear else ((ahead, ahead), (0.0, 0.0))
    pointed = [*([0.0, 0.0] if rear else steering), *(steering if rear else [0.0, 0.0])]
    for x, y, toward, rate, radius in zip(
        (*front, *back), (left, right) * 2, pointed, rolling, (0.3, 0.3, 0.4, 0.4), strict=True
    ):
        moves = np.array([speed - turning * y, turning * x])
        rolls = rate * radius * np.array([math.cos(toward), math.sin(toward)])
        np.testing.assert_allclose(rolls, moves, atol=1e-9 * (1 + abs(speed) + abs(turning) * (base + track)))


def test_a_turn_to_the_left_steers_the_left_wheel_more_and_rolls_it_slower() -> None:
    (left, right), (front_left, front_right, back_left, back_right) = driven(controller(speed=1.0, steering_angle=0.3))
    assert left > right > 0.0
    assert 0.0 < front_left < front_right
    assert 0.0 < back_left < back_right


def test_a_small_steering_angle_steers_although_isaac_sim_drives_straight() -> None:
    steering, _ = driven(controller(speed=1.0, steering_angle=0.01, track_width=0.0))
    assert close(steering, [0.01, 0.01])


def test_a_missing_radius_is_taken_from_the_other_axle() -> None:
    for given_radius in ({"back_wheel_radius": 0.0}, {"front_wheel_radius": 0.0, "back_wheel_radius": 0.3}):
        assert close(driven(controller(speed=1.2, **given_radius))[1], [4.0] * 4)


def test_the_signs_of_wheel_base_track_and_radii_are_ignored() -> None:
    negative = {name: -value for name, value in GEOMETRY.items()}
    turn = {"speed": 1.0, "steering_angle": 0.3}
    assert driven(controller(**turn, **negative)) == driven(controller(**turn))


@pytest.mark.parametrize(
    ("missing", "told"),
    [
        ({"wheel_base": 0.0}, "wheelBase must be other than 0"),
        (
            {"front_wheel_radius": 0.0, "back_wheel_radius": 0.0},
            "frontWheelRadius, backWheelRadius must be two numbers, at least one of them not 0",
        ),
    ],
)
def test_a_missing_size_is_an_error_that_names_the_input(missing: dict[str, float], told: str) -> None:
    with pytest.raises(ValueError, match=f"^{told}"):
        controller(**missing).compute()


def test_in_a_graph_missing_sizes_are_errors_of_the_file(play: Player) -> None:
    with pytest.raises(CheckError, match="wheelBase") as caught:
        play.graph("nodes: {Tick: OnPlaybackTick, A: AckermannController}\nconnections: [Tick.tick -> A.execIn]")
    assert all(name in str(caught.value) for name in ("trackWidth", "frontWheelRadius", "backWheelRadius"))


def test_with_a_track_width_of_0_both_wheels_move_like_a_bicycles(play: Player) -> None:
    steering, rolling = driven(controller(track_width=0.0, steering_angle=0.3, speed=1.0))
    assert close(steering, [0.3, 0.3])
    assert close(rolling, [1 / (0.3 * math.cos(0.3))] * 2 + [1 / 0.4] * 2)
    sizes = "{wheelBase: 1, trackWidth: 0, frontWheelRadius: 0.1}"
    nodes = f"nodes: {{Tick: OnPlaybackTick, A: {{type: AckermannController, inputs: {sizes}}}}}"
    play.graph(f"{nodes}\nconnections: [Tick.tick -> A.execIn]")


# Limits and ramps


def test_the_wheel_limit_bounds_the_speed_of_the_base_and_of_each_wheel() -> None:
    assert close(driven(controller(speed=100.0, max_wheel_velocity=5.0))[1], [5.0, 5.0, 5.0, 5.0])
    assert close(driven(controller(speed=-100.0, max_wheel_velocity=5.0))[1], [-5.0, -5.0, -5.0, -5.0])


def test_steering_is_limited_for_the_bicycle_and_for_each_wheel() -> None:
    steering, _ = driven(controller(speed=1.0, steering_angle=1.0, max_wheel_rotation=0.3))
    centre = 1.6 / math.tan(0.3)
    assert close(steering, [0.3, math.atan(1.6 / (centre + 0.6))])


def test_speed_changes_by_acceleration_times_dt_until_the_exact_target() -> None:
    node = controller(speed=0.25, acceleration=-1.0, dt=0.1, back_wheel_radius=1.0)
    assert close([driven(node)[1][2] for _ in range(4)], [0.1, 0.2, 0.25, 0.25])
    node.speed = 0.0
    assert close([driven(node)[1][2] for _ in range(4)], [0.15, 0.05, 0.0, 0.0])


def test_steering_changes_by_its_velocity_times_dt_until_the_exact_target() -> None:
    node = controller(steering_angle=-0.05, steering_angle_velocity=0.2, dt=0.1, track_width=0.0)
    assert close([driven(node)[0][0] for _ in range(4)], [-0.02, -0.04, -0.05, -0.05])


def test_maximum_acceleration_and_steering_velocity_limit_the_ramps() -> None:
    node = controller(speed=1.0, acceleration=5.0, max_acceleration=2.0, dt=0.1, back_wheel_radius=1.0)
    assert close(driven(node)[1][2], 0.2)
    limits = {"steering_angle_velocity": 5.0, "max_steering_angle_velocity": 1.0, "dt": 0.1}
    assert close(driven(controller(steering_angle=1.0, track_width=0.0, **limits))[0][0], 0.1)


@pytest.mark.parametrize("ramp", ["acceleration", "steering_angle_velocity"])
def test_a_ramp_needs_dt(ramp: str) -> None:
    with pytest.raises(ValueError, match=r"dt, .* must be above 0 for ramps \(wire deltaSeconds"):
        controller(speed=1.0, **{ramp: 1.0}).compute()


def test_parameters_take_effect_when_they_are_set() -> None:
    node = controller(speed=1.2)
    driven(node)
    node.front_wheel_radius, node.invert_steering, node.steering_angle = 0.6, True, 0.2
    assert driven(node) == driven(
        controller(speed=1.2, front_wheel_radius=0.6, invert_steering=True, steering_angle=0.2)
    )


def test_after_a_stop_the_ramp_starts_from_rest() -> None:
    node = controller(speed=1.0, acceleration=1.0, dt=0.1, back_wheel_radius=1.0)
    first = [driven(node) for _ in range(3)]
    RecordingContext().stop(node)
    assert node.wheel_angles.tolist() == []
    assert [driven(node) for _ in range(3)] == first
