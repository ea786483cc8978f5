"""Nodes that publish TF: a single transform, a tree of transforms, or the topics of robot_state_publisher."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from graphengine.compiler.lint_registry import lint
from graphengine.devices.motion import FrameLink
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher
from graphengine.node import BadValueError, Bound, Context, ContextError, In, RobotDescription, State
from graphengine.node.types import Double3s, Double4s, Quaterniond, String, Target, Tokens, Vector3d
from graphengine.nodes.checked import same_length
from graphengine.nodes.core.transforms import pose_of
from graphengine.nodes.known_inputs import known_inputs
from graphengine.nodes.ros2.publisher import NetworkNode, PublisherNode, header, send, stamp
from graphengine.nodes.touched import reading_poses

if TYPE_CHECKING:
    from graphengine.compiler.lint_registry import LintContext

_TF = "tf2_msgs/msg/TFMessage"


def transform(time: float, parent: str, child: str, position: Vector3, turn: Quaternion) -> messages.TransformStamped:
    """Return the transform from a parent frame to a child frame; time in s, position in m, quaternion (x, y, z, w)."""
    pose = messages.Transform(messages.Vector3(*position), messages.Quaternion(*turn))
    return messages.TransformStamped(header(time, parent), child, pose)


class TransformPublisher(PublisherNode):
    """Base of nodes that publish tf2_msgs/TFMessage; the topic has the namespace of the outermost ancestor prim."""

    message_type: ClassVar[str] = _TF

    static_publisher: bool = In(
        default=False, setup=True, doc="true: publish only once after play, latched, even without subscribers"
    )

    sent: bool = State(default=False)

    def open(self, context: Context, **facts: Any) -> Publisher:
        """Create the publisher on `topicName`, latched if `staticPublisher` is true."""
        self.sent = False
        return super().open(context, outermost_namespace=True, latched=self.static_publisher, **facts)

    def compute(self) -> None:
        """Publish the transforms in each execution, or only once if `staticPublisher` is true."""
        if not self.static_publisher:
            super().compute()
        elif not self.sent:
            send(self.publisher, self.message())
            self.sent = True


class ROS2PublishRawTransformTree(TransformPublisher, type="isaacsim.ros2.bridge.ROS2PublishRawTransformTree"):
    """Publishes one transform, taken from the inputs, as tf2_msgs/TFMessage."""

    parent_frame_id: String = In(default="odom", setup=True)
    child_frame_id: String = In(default="base_link", setup=True)
    topic_name: String = In(default="tf", setup=True)
    translation: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m")
    rotation_in: Quaterniond = In(default=(0.0, 0.0, 0.0, 1.0), name="rotation", doc="quaternion (x, y, z, w)")

    def setup(self, context: Context) -> None:
        """Create the publisher on `topicName`."""
        edge = (self.parent_frame_id, self.child_frame_id)
        self.publisher = self.open(context, frame_id=self.parent_frame_id, transforms=[edge])

    def message(self) -> messages.TFMessage:
        """Return the message with the transform."""
        [(parent, child)] = self.publisher.claim.transforms
        return messages.TFMessage([transform(self.time_stamp, parent, child, self.translation, self.rotation_in)])


class ROS2PublishTransformTree(TransformPublisher, type="isaacsim.ros2.bridge.ROS2PublishTransformTree"):
    """Publishes the transforms of target prims, or transforms given by arrays, as one tf2_msgs/TFMessage per execution."""

    parent_prim: Target = In(setup=True, doc="prim that is the parent frame of `targetPrims`; if empty, the world")
    target_prims: Target = In(required="frames", setup=True, doc="prims to publish if `parentFrames` is empty")
    topic_name: String = In(default="tf", setup=True)
    parent_frames: Tokens = In(
        required="frames", setup=True, doc="parent frame of each transform, from IsaacComputeTransformTree"
    )
    child_frames: Tokens = In(setup=True, doc="child frame of each transform, from IsaacComputeTransformTree")
    translations: Double3s = In(unit="m", doc="translation of each transform")
    orientations: Double4s = In(doc="quaternion (x, y, z, w) of each transform")

    links: Sequence[FrameLink] = Bound()

    def setup(self, context: Context) -> None:
        """Create the publisher on `topicName`, which announces the parent and child frame of each transform.

        Raises:
            ContextError: there are neither frames nor target prims.
        """
        self.links = ()
        edges = list(zip(self.parent_frames, self.child_frames, strict=False))
        if not edges and self.target_prims:
            parent = self.parent_prim[0] if self.parent_prim else ""
            self.links = context.transform_tree(self.target_prims, parent, loops=False)
            edges = [(link.parent_name, link.child_name) for link in self.links]
        elif not edges:
            empty = "parentFrames, childFrames and targetPrims are empty"
            raise ContextError(f"{empty}: set targetPrims, or wire the frames")
        self.publisher = self.open(context, frame_id=edges[0][0] if edges else "", transforms=edges)

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the poses of `targetPrims`."""
        return reading_poses(self.target_prims) if self.target_prims else ()

    def message(self) -> messages.TFMessage:
        """Return the message with all transforms."""
        if not self.parent_frames:
            return linked(self.time_stamp, self.publisher, self.links)
        same_length(
            parentFrames=self.parent_frames,
            childFrames=self.child_frames,
            translations=self.translations,
            orientations=self.orientations,
        )
        rows = zip(self.publisher.claim.transforms, self.translations.tolist(), self.orientations.tolist(), strict=True)
        return messages.TFMessage([transform(self.time_stamp, *edge, *pose) for edge, *pose in rows])


@lint("W215")
def lint_lengths_of_transforms(context: LintContext) -> None:
    """Warn about transforms in arrays of different lengths."""
    for inputs, _ in known_inputs(context, ROS2PublishTransformTree):
        if inputs.length("parent_frames"):
            inputs.warn_of_unequal("parent_frames", "child_frames", "translations", "orientations")


def linked(time: float, publisher: Publisher, links: Iterable[FrameLink]) -> messages.TFMessage:
    """Return a TFMessage with the current transform of each link.

    Args:
        time: simulation time, s.
        publisher: publisher that announced the parent and child frame of each link, in the same order as `links`.
        links: parent and child of each transform.
    """
    edges = zip(publisher.claim.transforms, links, strict=True)
    return messages.TFMessage([transform(time, *edge, *pose_of(link)) for edge, link in edges])


class RobotStatePublisher(NetworkNode, type="graphengine.ros2.RobotStatePublisher"):
    """Publishes robot_description and tf_static, both latched, and tf at a fixed rate, like the node robot_state_publisher."""

    target_prim: Target = In(required=True, setup=True, doc="the robot: its prim, base link or articulation root")
    time_stamp: float = In(default=0.0, unit="s")
    publish_frequency: float = In(
        default=20.0, le=1e9, gt=0.0, setup=True, unit="Hz", doc="rate of the transforms of movable links on `tf`"
    )

    description: RobotDescription = Bound()
    description_publisher: Publisher = Bound()
    static_publisher: Publisher = Bound()
    publisher: Publisher = Bound()
    last: float = State(default=-1.0)
    sent: bool = State(default=False)

    def setup(self, context: Context) -> None:
        """Create the publishers of the three topics.

        Raises:
            BadValueError: `publishFrequency` is not above 0, or is above 1e9 Hz.
        """
        if not 0.0 < self.publish_frequency <= 1e9:
            raise BadValueError("publishFrequency", self.publish_frequency, "above 0 and at most 1e9 Hz")
        self.sent, self.last = False, -1.0
        self.description = context.robot_description(self.target_prim[0])
        common = self.endpoint()
        tf: dict[str, Any] = {**common, "outermost_namespace": True}
        fixed = [(parent, child) for parent, child, _, _ in self.description.fixed]
        moving = [(link.parent_name, link.child_name) for link in self.description.moving]
        publisher, text, rate = context.publisher, "std_msgs/msg/String", self.publish_frequency
        self.description_publisher = publisher(text, "robot_description", latched=True, **common)
        self.static_publisher = publisher(_TF, "tf_static", latched=True, transforms=fixed, **tf)
        self.publisher = publisher(_TF, "tf", rate=rate, transforms=moving, **tf)

    def compute(self) -> None:
        """Publish the latched topics once, and `tf` when it is due.

        Raises:
            BadValueError: `timeStamp` is out of the range of builtin_interfaces/Time.
        """
        stamp(self.time_stamp)
        if not self.sent:
            self.description_publisher.publish(messages.String(self.description.urdf))
            edges = zip(self.static_publisher.claim.transforms, self.description.fixed, strict=True)
            fixed = [transform(self.time_stamp, *edge, *joint[2:]) for edge, joint in edges]
            self.static_publisher.publish(messages.TFMessage(fixed))
            self.sent = True
        turn = int(self.time_stamp * self.publish_frequency + 1e-9)
        if turn > self.last:
            self.last = turn
            if self.publisher.wanted:
                self.publisher.publish(linked(self.time_stamp, self.publisher, self.description.moving))
