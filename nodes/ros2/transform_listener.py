"""A node that subscribes to TF and moves prims to the received poses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from graphengine.devices.motion import Frame, Placement
from graphengine.devices.rotation import Quaternion, Vector3, compose
from graphengine.messages.endpoints import Subscription
from graphengine.node import Bound, Context, ContextError, ExecOut, Fire, In, String, Tokens
from graphengine.nodes.ros2.publisher import TopicNode
from graphengine.nodes.touched import writing_poses

_FARTHEST = 1e9
"""Maximum absolute coordinate of a pose, m; the physics accepts up to 1e10."""
_UNIT = 0.01
"""Maximum deviation of the squared length of a quaternion from 1; tf2 uses the same value."""


class ROS2SubscribeTransformTree(TopicNode, type="isaacsim.ros2.bridge.ROS2SubscribeTransformTree", gated=True):
    """Moves prims to the poses in tf2_msgs/TFMessage and fires when a message arrives.

    A transform is used if both of its frames are in `frameNamesMap`. If several transforms of a child frame arrive in one tick,
    the newest is used. The prim of the child frame moves to the transform's pose, relative to the current pose of the parent
    frame's prim. From then on until the simulation stops, physics does not move this prim: it is an immovable obstacle. If the
    prim is that of a robot, the whole robot moves. A link below a joint moves only within the joint's range. A prim that is fixed
    to another prim, such as a sensor, cannot move: its transform is ignored and logged. A transform from a frame to itself is
    dropped and logged, and so is a transform with NaN, a coordinate above 1e9 m or a quaternion that is not a unit quaternion.
    """

    topic_name: String = In(default="tf", setup=True)
    frame_names_map: Tokens = In(
        required=True, setup=True, doc="alternating prim paths and frame names; each prim and frame occurs once"
    )
    articulation_roots: Tokens = In(setup=True, doc="paths of robots; they are checked, but have no other effect")
    exec_out = ExecOut(doc="fires once in each tick in which messages arrived")

    subscription: Subscription = Bound()
    frames: dict[str, tuple[str, Frame, Placement | None]] = Bound()
    logger: Context = Bound()

    def setup(self, context: Context) -> None:
        """Look up the prims and create the subscription on `topicName`."""
        self.logger = context
        prims, names = self.frame_names_map[::2], self.frame_names_map[1::2]
        if len(prims) != len(names):
            odd = f"frameNamesMap has {len(self.frame_names_map)} strings, but it must be pairs of a prim path and a frame name"
            raise ContextError(odd, prims[-1])
        for given in (prims, names):
            twice = [text for text in dict.fromkeys(given) if given.count(text) > 1]
            if twice:
                text = f"{twice[0]!r} is in frameNamesMap twice"
                raise ContextError(text, twice[0], "list each prim and each frame once")
        for root in self.articulation_roots:
            context.articulation(root)
        published = [context.frame_name(name, namespace=self.node_namespace) for name in names]
        handles = [(prim, context.frame(prim), context.placement(prim)) for prim in prims]
        self.frames = dict(zip(published, handles, strict=True))
        topic = self.topic_name
        self.subscription = self.listen(context, "tf2_msgs/msg/TFMessage", topic, outermost_namespace=True)

    def writes(self) -> Iterable[str]:
        """Return the resource keys of the poses of the prims in `frameNamesMap`."""
        return writing_poses(self.frame_names_map[::2])

    def compute(self) -> Fire:
        """Move the prim of each child frame to the pose in the newest transform of this frame, and fire."""
        arrived, frames = self.subscription.take(), self.frames
        edges = (edge for message in arrived for edge in message.transforms)
        newest = {e.child_frame_id: e for e in edges if e.child_frame_id in frames and e.header.frame_id in frames}
        for edge in newest.values():
            fault = self.follow(edge)
            if fault:
                self.logger.log_dropped(f"{self.subscription.topic}: {fault}")
        return self.exec_out if arrived else None

    def follow(self, edge: Any) -> str:
        """Move the prim of a transform's child frame. Return the reason if it cannot move, otherwise an empty string."""
        (_, parent, _), (prim, child, placement) = self.frames[edge.header.frame_id], self.frames[edge.child_frame_id]
        if placement is None:
            return f"{edge.child_frame_id} is the frame of {prim}, which cannot be moved by itself"
        pose = _pose(edge.transform)
        place = compose(parent.pose(), pose) if pose is not None and parent is not child else None
        if place is None or max(map(abs, place[0])) > _FARTHEST:
            return f"an invalid transform from {edge.header.frame_id} to {edge.child_frame_id} was dropped"
        placement.place(*place)
        return ""


def _pose(transform: Any) -> tuple[Vector3, Quaternion] | None:
    """Return a transform as a pose; None if a coordinate is too large or the length of the quaternion is not 1."""
    t, r = transform.translation, transform.rotation
    square = r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w
    if not all(abs(value) <= _FARTHEST for value in (t.x, t.y, t.z)) or not abs(square - 1.0) <= _UNIT:
        return None  # NaN fails both comparisons
    length = math.sqrt(square)
    return (t.x, t.y, t.z), (r.x / length, r.y / length, r.z / length, r.w / length)
