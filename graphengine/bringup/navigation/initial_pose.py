"""Initializes a robot's localization with its true pose, as a user does with "2D Pose Estimate" in RViz."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from graphengine.bringup.navigation.true_poses import MAP, PlanarPose, TruePoses
from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.ros.transport import Transport, Writer

MESSAGE = "geometry_msgs/msg/PoseWithCovarianceStamped"
SPREAD = 0.05
"""Standard deviation that the pose message states for position (m) and yaw (rad)."""
NEAR = 0.3
"""Maximum distance (m) and angle (rad) between the true pose and the pose on `amcl_pose` after the initial pose is accepted."""
AGAIN = 2.0
"""Wall time between two messages with the pose, s."""
PATIENCE = 30.0
"""Maximum wall time to wait until the localization has accepted the pose, s."""


def has_listener(transport: Transport, namespace: str) -> bool:
    """Return whether a node subscribes to the topic `initialpose` in a namespace."""
    return bool(transport.graph().subscribers(f"{namespace}/initialpose"))


def may_belong(frame: str, namespace: str) -> bool:
    """Return whether a frame on a shared `/tf` can belong to the robot with a namespace: its prefix is the namespace or empty."""
    return frame.strip("/").rpartition("/")[0] in ("", namespace.strip("/"))


def give_initial_pose(transport: Transport, namespace: str, truth: TruePoses, clock: Callable[[], float]) -> bool:
    """Publish the true pose on `initialpose` until the localization node accepts it; return whether the node accepted it.

    The function returns False after `PATIENCE` s of wall time, or when the run behind `truth` has ended. The node has accepted
    the pose when `amcl_pose` is near the true pose or, if no node publishes `amcl_pose`, when a node broadcasts the transform
    map -> odom of this robot.
    """
    near = broadcasts = False
    writer = transport.writer(f"{namespace}/initialpose", MESSAGE, QoS())

    def take_pose(data: bytes) -> None:
        nonlocal near
        with suppress(TransportError):
            found = PlanarPose.of(messages.decode(data, MESSAGE).pose.pose)
            near = found.distance(truth.newest) < NEAR and found.turn(truth.newest) < NEAR

    def take_transforms(data: bytes, *, shared: bool) -> None:
        nonlocal broadcasts
        with suppress(TransportError):
            edges = messages.decode(data, "tf2_msgs/msg/TFMessage").transforms
            children = [edge.child_frame_id for edge in edges if edge.header.frame_id == MAP]
            broadcasts |= any(not shared or may_belong(child, namespace) for child in children)

    readers = [transport.reader(f"{namespace}/amcl_pose", MESSAGE, QoS(depth=1), take_pose)]
    for name, shared in {f"{namespace}/tf": False, "/tf": bool(namespace)}.items():
        take = partial(take_transforms, shared=shared)
        readers.append(transport.reader(name, "tf2_msgs/msg/TFMessage", QoS(depth=100), take))
    deadline, due = time.monotonic() + PATIENCE, 0.0
    try:
        while time.monotonic() < deadline and not truth.ended:
            if time.monotonic() >= due and writer.matched:
                due = time.monotonic() + AGAIN
                _send(writer, truth.newest, clock())
            time.sleep(0.05)
            reports = bool(transport.graph().publishers(f"{namespace}/amcl_pose"))
            if due and (near or (broadcasts and not reports)):
                return True
        return False
    finally:
        for end in (writer, *readers):
            end.close()


def _send(writer: Writer, pose: PlanarPose, now: float) -> None:
    message = DEFINITIONS.initial(MESSAGE)
    message.header = messages.header(now, MAP)
    pose.put_into(message.pose.pose)
    message.pose.covariance[[0, 7, 35]] = SPREAD * SPREAD
    writer.write(messages.encode(message))
