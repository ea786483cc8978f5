"""A node that publishes the transform map -> odom. It corrects odometry to the true pose of a robot."""

from __future__ import annotations

from collections.abc import Mapping

from graphengine.compiler.lint_registry import LintContext, lint
from graphengine.devices.motion import Frame
from graphengine.devices.rotation import IDENTITY, ORIGIN, compose, relative
from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Clock, Context, In, String, Target
from graphengine.node.context.published_transform import PublishedTransform
from graphengine.nodes.ros2.publisher import TopicNode, stamp
from graphengine.nodes.touched import reading_poses

_MESSAGE = "tf2_msgs/msg/TFMessage"
_LATE = (
    "{parent} -> {child} is not published: the odometry of this tick must be published first, stamped with simulation time; "
    "list the graph that publishes the odometry before this one"
)


class ROS2PublishGroundTruthTransform(TopicNode, type="graphengine.ros2.ROS2PublishGroundTruthTransform"):
    """Publishes the transform map -> odom with which map -> odom -> base link is the true pose of a robot in the scene's world.

    The node replaces localization, such as AMCL. Another node of the session must publish odom -> base link on the same topic
    earlier in the tick. Each execution publishes map -> odom with the stamp of the newest odom -> base link.
    """

    target_prim: Target = In(required=True, setup=True, doc="the robot: its prim, base link or articulation root")
    parent_frame_id: String = In(default="map", setup=True, doc="frame of the world; parent of the published transform")
    child_frame_id: String = In(
        default="odom", setup=True, doc="parent frame of the odometry; child of the published transform"
    )
    topic_name: String = In(default="tf", setup=True, doc="topic of both the odometry and the published transform")

    publisher: Publisher = Bound()
    links: Mapping[str, Frame] = Bound()
    odometry: PublishedTransform = Bound()
    clock: Clock = Bound()
    logger: Context = Bound()

    def setup(self, context: Context) -> None:
        """Look up the links of the robot, create the publisher, and find the odometry transform on the same topic."""
        self.logger, self.clock = context, context.clock
        self.links = {edge.child_name: edge.child for edge in context.transform_tree(self.target_prim, loops=False)}
        edge = (self.parent_frame_id, self.child_frame_id)
        self.publisher = self.open_topic(
            context, _MESSAGE, self.topic_name, outermost_namespace=True, frame_id=edge[0], transforms=[edge]
        )
        odom = self.publisher.claim.transforms[0][1]
        self.odometry = context.published_transform(self.publisher.claim, odom, self.links)

    def compute(self) -> None:
        """Publish the transform, if the topic has subscribers and the odometry of this tick has been published.

        Raises:
            BadValueError: the simulation time is out of the range of a message.
        """
        if not self.publisher.wanted:
            return
        odometry = self.odometry.newest()
        if odometry is None:
            return
        parent, child = self.publisher.claim.transforms[0]
        if odometry.header.stamp != stamp(self.clock.time):
            self.logger.log("warning", _LATE.format(parent=parent, child=child))
            return
        t, r = odometry.transform.translation, odometry.transform.rotation
        back = relative(((t.x, t.y, t.z), (r.x, r.y, r.z, r.w)), (ORIGIN, IDENTITY))
        position, orientation = compose(self.links[odometry.child_frame_id].pose(), back)
        pose = messages.Transform(messages.Vector3(*position), messages.Quaternion(*orientation))
        head = messages.Header(odometry.header.stamp, parent)
        self.publisher.publish(messages.TFMessage([messages.TransformStamped(head, child, pose)]))

    def reads(self) -> tuple[str, ...]:
        """Return the resource key of the pose of the robot."""
        return tuple(reading_poses(self.target_prim))


@lint("W203")
def lint_missing_odometry(context: LintContext) -> None:
    """Warn about a ROS2PublishGroundTruthTransform if no other node publishes the odometry of its robot on its topic."""
    for graph, instance, node in context.nodes(ROS2PublishGroundTruthTransform):
        path = f"{graph.prim_path}/{instance.id}"
        claim = next((claim for claim in context.claims if claim.node == path), None)
        if claim is None or not claim.transforms:
            continue
        parent, child = claim.transforms[0]
        others = [other for other in context.claims if other.topic == claim.topic and other is not claim]
        if any(above == child for other in others for above, _ in other.transforms):
            continue
        robot = node.target_prim[0] if node.target_prim else "the robot"
        edges = sorted({f"{above} -> {below}" for other in others for above, below in other.transforms})
        context.findings.add(
            "W203",
            f"no node publishes odometry of {robot} on {claim.topic}, a transform from {child} to the base link, so "
            f"{parent} -> {child} will not be published",
            instance.span,
            "publish the odometry, as graphs/wheel_odometry.yaml and graphs/base/state.yaml do",
            "if the odometry has another parent frame, set childFrameId; "
            f"transforms on the topic: {', '.join(edges[:5]) or 'none'}",
            related=instance.entry.via,
        )
