"""IsaacComputeOdometry and ROS2PublishOdometry, against rotation matrices of numpy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.dry_world import BodyStub
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.errors import PrimError
from graphengine.nodes.core.odometry import IsaacComputeOdometry
from graphengine.nodes.ros2.state import ROS2PublishOdometry
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, dd100, matrix, quaternion, ready, vector, yaw

numbers = st.floats(-100.0, 100.0)
vectors = st.tuples(numbers, numbers, numbers)


def unit(parts: Quaternion) -> Quaternion:
    a, b, c, d = (np.array(parts) / np.linalg.norm(parts)).tolist()
    return a, b, c, d


parts = st.floats(-1.0, 1.0)
rotations = st.tuples(parts, parts, parts, parts).filter(lambda q: np.linalg.norm(q) > 1e-3).map(unit)
poses = st.tuples(vectors, rotations)


def computing(position: Vector3 = (0.0, 0.0, 0.0), orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)) -> Any:
    """A context with a body, the body, and a node that watches it."""
    context = RecordingContext()
    body = context.world.add_body("/cube", position, orientation)
    return context, body, ready(IsaacComputeOdometry, context, chassis_prim="/cube")


def compute(context: RecordingContext, node: IsaacComputeOdometry, ticks: int = 1) -> None:
    context.tick(ticks)
    node.compute()


def close(value: Any, expected: Any) -> bool:
    return np.allclose(value, expected, rtol=0.0, atol=1e-9)


# IsaacComputeOdometry


def test_before_the_first_compute_all_is_0_and_upright() -> None:
    _, _, node = computing((5.0, 3.0, 10.0))
    vectors = (node.position, node.linear_velocity, node.angular_velocity, node.linear_acceleration)
    assert (*vectors, node.angular_acceleration, node.global_linear_velocity) == ((0.0, 0.0, 0.0),) * 6
    assert (node.global_linear_acceleration, node.orientation) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


@given(start=poses)
def test_the_first_compute_is_the_origin(start: tuple[Vector3, Quaternion]) -> None:
    context, _, node = computing(*start)
    compute(context, node)
    assert close(node.position, (0.0, 0.0, 0.0))
    assert close(matrix(node.orientation), np.eye(3))


@given(start=poses, now=poses)
def test_the_pose_is_relative_to_the_start_pose_of_the_body(
    start: tuple[Vector3, Quaternion], now: tuple[Vector3, Quaternion]
) -> None:
    context, body, node = computing(*start)
    compute(context, node)
    body.position, body.orientation = now
    compute(context, node)
    back = matrix(start[1]).T
    assert close(node.position, back @ np.subtract(now[0], start[0]))
    assert close(matrix(node.orientation), back @ matrix(now[1]))


@given(orientation=rotations, linear=vectors, angular=vectors)
def test_linear_velocity_is_in_the_body_frame_and_angular_velocity_in_the_world_frame(
    orientation: Quaternion, linear: Vector3, angular: Vector3
) -> None:
    context, body, node = computing()
    body.orientation, body.linear, body.angular = orientation, linear, angular
    compute(context, node)
    assert close(node.linear_velocity, matrix(orientation).T @ linear)
    assert node.angular_velocity == angular
    assert node.global_linear_velocity == linear


motions = st.tuples(rotations, vectors, vectors)


@given(before=motions, now=motions, ticks=st.integers(1, 9))
def test_accelerations_are_differences_of_the_velocities_over_simulation_time(
    before: tuple[Quaternion, Vector3, Vector3], now: tuple[Quaternion, Vector3, Vector3], ticks: int
) -> None:
    context, body, node = computing()
    body.orientation, body.linear, body.angular = before
    compute(context, node)
    assert node.linear_acceleration == node.global_linear_acceleration == node.angular_acceleration == (0.0, 0.0, 0.0)
    body.orientation, body.linear, body.angular = now
    compute(context, node, ticks)

    def slope(one: Any, other: Any) -> Any:
        return np.subtract(other, one) * 60.0 / ticks

    local = slope(matrix(before[0]).T @ before[1], matrix(now[0]).T @ now[1])
    assert np.allclose(node.linear_acceleration, local, rtol=1e-9, atol=1e-6)
    assert np.allclose(node.global_linear_acceleration, slope(before[1], now[1]), rtol=1e-9, atol=1e-6)
    assert np.allclose(node.angular_acceleration, slope(before[2], now[2]), rtol=1e-9, atol=1e-6)


def test_accelerations_stay_unchanged_while_time_stands_still() -> None:
    context, body, node = computing()
    compute(context, node)
    body.linear = (1.0, 0.0, 0.0)
    compute(context, node)
    node.compute()
    assert close(node.linear_acceleration, (60.0, 0.0, 0.0))


def test_after_a_stop_the_origin_is_the_new_start_pose() -> None:
    context, body, node = computing()
    compute(context, node)
    body.position, body.linear = (4.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    compute(context, node)
    assert node.position == (4.0, 0.0, 0.0)
    context.stop(node)
    assert (node.position, node.linear_velocity) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    compute(context, node)
    assert node.position == node.linear_acceleration == (0.0, 0.0, 0.0)


def test_another_body_has_its_own_origin_and_its_own_accelerations() -> None:
    context, body, node = computing((5.0, 0.0, 0.0))
    other = context.world.add_body("/other", (0.0, 7.0, 0.0))
    body.linear, other.linear = (1.0, 0.0, 0.0), (0.0, 9.0, 0.0)
    compute(context, node)
    node.chassis_prim = ("/other",)
    node.setup(context)
    for _ in range(2):
        compute(context, node)
        assert (node.position, node.linear_velocity) == ((0.0, 0.0, 0.0), (0.0, 9.0, 0.0))
        assert node.linear_acceleration == (0.0, 0.0, 0.0)


def test_a_prim_without_a_body_has_the_motion_of_the_body_that_carries_it(context: RecordingContext) -> None:
    body = context.world.add_body("/cube", orientation=yaw(math.pi / 2))
    context.world.stage.add("/cube/sensor", "frame", position=(1.0, 0.0, 0.0))
    node = ready(IsaacComputeOdometry, context, chassis_prim="/cube/sensor")
    compute(context, node)
    body.linear, body.angular = (0.5, 0.0, 0.0), (0.0, 0.0, 2.0)
    compute(context, node)
    # The sensor is at (0, 1, 0) of the body in the world: w x r = (-2, 0, 0).
    assert close(node.global_linear_velocity, (0.5 - 2.0, 0.0, 0.0))
    assert close(node.linear_velocity, (0.0, 1.5, 0.0))


def test_the_prim_of_a_robot_has_the_motion_of_its_base(context: RecordingContext) -> None:
    context.world.add_robot("/robot")
    robot = context.world.body(context.world.stage.find("/robot"))
    node = ready(IsaacComputeOdometry, context, chassis_prim="/robot")
    compute(context, node)
    robot.position = (1.0, 2.0, 3.0)
    compute(context, node)
    assert node.position == (1.0, 2.0, 3.0)


def test_a_prim_that_no_body_carries_is_refused_with_the_bodies_below_it(context: RecordingContext) -> None:
    context.world.add_body("/World/crate/box")
    with pytest.raises(PrimError, match="neither it nor a prim above it has a rigid body") as caught:
        ready(IsaacComputeOdometry, context, chassis_prim="/World/crate")
    assert "/World/crate/box" in "".join(caught.value.help)


# ROS2PublishOdometry


def published(**inputs: Any) -> Any:
    """The message of a node with those inputs."""
    return ready(ROS2PublishOdometry, RecordingContext(), **inputs).message()


def test_the_defaults_publish_the_origin_of_odom_and_base_link() -> None:
    message = published()
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    assert quaternion(message.pose.pose.orientation) == (0.0, 0.0, 0.0, 1.0)
    assert vector(message.pose.pose.position) == vector(message.twist.twist.linear) == (0.0, 0.0, 0.0)


@given(pose=poses)
def test_the_pose_is_copied_and_covariances_are_0_unless_given(pose: tuple[Vector3, Quaternion]) -> None:
    message = published(position=pose[0], orientation=pose[1])
    assert vector(message.pose.pose.position) == pose[0]
    assert quaternion(message.pose.pose.orientation) == pose[1]
    assert message.pose.covariance.tolist() == message.twist.covariance.tolist() == [0.0] * 36


def test_given_covariances_are_published_unchanged() -> None:
    pose, twist = np.arange(36.0), np.arange(36.0, 72.0)
    message = published(pose_covariance=pose, twist_covariance=twist)
    assert message.pose.covariance.tolist() == pose.tolist()
    assert message.twist.covariance.tolist() == twist.tolist()


def test_a_covariance_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="twistCovariance must be 36 numbers, or empty"):
        published(twist_covariance=np.zeros(9))


@given(linear=vectors, angular=vectors)
def test_velocities_in_the_bodys_frame_are_the_twist(linear: Vector3, angular: Vector3) -> None:
    message = published(linear_velocity=linear, angular_velocity=angular)
    assert vector(message.twist.twist.linear) == linear
    assert vector(message.twist.twist.angular) == angular


@given(linear=vectors, angular=vectors, heading=st.floats(-3.2, 3.2), length=st.floats(0.1, 10.0), z=numbers)
def test_velocities_are_projected_onto_front_side_and_up(
    linear: Vector3, angular: Vector3, heading: float, length: float, z: float
) -> None:
    front = np.array([math.cos(heading), math.sin(heading), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    axes = np.stack([front, np.cross(up, front), up])
    given_front = (length * front[0], length * front[1], z)
    message = published(linear_velocity=linear, angular_velocity=angular, robot_front=given_front)
    assert close(vector(message.twist.twist.linear), axes @ linear)
    assert close(vector(message.twist.twist.angular), axes @ angular)


@given(linear=vectors, angular=vectors)
def test_raw_velocities_are_copied_for_any_front(linear: Vector3, angular: Vector3) -> None:
    inputs = {"linear_velocity": linear, "angular_velocity": angular, "robot_front": (0.0, 1.0, 0.0)}
    message = published(publish_raw_velocities=True, **inputs)
    assert vector(message.twist.twist.linear) == linear
    assert vector(message.twist.twist.angular) == angular


def test_a_front_along_the_up_axis_is_refused() -> None:
    with pytest.raises(ValueError, match="robotFront must be finite, and not along the up axis"):
        published(robot_front=(0.0, 0.0, 1.0))


# Both, in the tutorial's graph


@pytest.mark.parametrize("name", ["tutorial/joint_states", "dd100/joint_states"])
def test_odometry_and_tf_hold_the_same_pose_in_every_tick_from_the_first_on(play: Player, name: str) -> None:
    world = dd100()
    playing = play.shipped(name, world)
    robot: BodyStub = world.body(world.stage.find("/dd100"))
    for tick in range(4):
        robot.position, robot.orientation = (0.1 * tick, 0.0, 0.0), yaw(0.2 * tick)
        playing.tick()
    odometry, tf = playing.published("/dd100_0000/odom"), playing.published("/dd100_0000/tf")
    assert len(odometry) == len(tf) == 4
    for tick, (pose, transform) in enumerate(zip(odometry, (m.transforms[0] for m in tf), strict=True)):
        assert close(vector(pose.pose.pose.position), (0.1 * tick, 0.0, 0.0))
        assert vector(transform.transform.translation) == vector(pose.pose.pose.position)
        assert quaternion(transform.transform.rotation) == quaternion(pose.pose.pose.orientation)
        assert transform.header.stamp == pose.header.stamp
        assert pose.header.stamp.nanosec == int((tick + 1) / 60 * 1e9)


def test_in_a_graph_odometry_restarts_at_the_origin_after_a_stop(play: Player) -> None:
    world = dd100()
    playing = play.shipped("tutorial/joint_states", world)
    robot = world.body(world.stage.find("/dd100"))
    playing.tick()
    robot.position = (1.0, 0.0, 0.0)
    playing.tick()
    playing.session.stop()
    playing.tick()
    assert [vector(m.pose.pose.position)[0] for m in playing.published("/dd100_0000/odom")] == [0.0, 1.0, 0.0]
