"""Published names of TF frames. They have a prefix if all robots share the topics /tf and /tf_static.

The key `tf` of a scene selects the mode. With `tf: global`, a robot's frame `base_link` is published as `dd100_0000/base_link`,
as with the parameter `frame_prefix` of robot_state_publisher. With `tf: namespaced`, frame names have no prefix, and the
namespace is part of the topic name instead, as in `/dd100_0000/tf`.

The prefix is the namespace of the outermost ancestor prim that has one; if no ancestor has a namespace, it is the
`nodeNamespace` of the publishing node. For a frame that is a prim, the ancestors of this prim count; for other frames, the
ancestors of the publishing node.
"""

from __future__ import annotations

from graphengine.devices.stage import Prim, Stage
from graphengine.messages.names import join_namespaces, strip

SHARED_FRAMES = frozenset(("map", "world", "earth"))
"""Frames that all robots share; they are never prefixed."""


class PublishedFrame(str):
    """The published name of a frame, including its prefix.

    The value keeps this type when a wire passes it to another node, so that a publishing node does not add a second prefix.
    """

    __slots__ = ()


def frame_prefix(stage: Stage, prim_path: str, node_namespace: str = "") -> str:
    """Return the prefix of frames at a prim, including the trailing slash; empty if frames have no prefix.

    Args:
        stage: stage of the prim.
        prim_path: path of the prim, which need not exist.
        node_namespace: namespace to use if neither the prim nor an ancestor of it has one.
    """
    if not stage.global_tf:
        return ""
    namespace = strip(join_namespaces(stage.namespaces(prim_path), outermost=True) or node_namespace)
    return f"{namespace}/" if namespace else ""


def prim_prefix(stage: Stage, prim: Prim) -> str:
    """Return the prefix of a prim's frame, from the namespaces of the prim and its ancestors.

    If these have no namespace, return the prefix of the base link of the robot to which the prim belongs.
    """
    robot = stage.robot_of(prim)
    base = robot.facts.get("base_link") if robot is not None else None
    return frame_prefix(stage, prim.path) or (frame_prefix(stage, base) if base else "")


def full_frame(stage: Stage, frame: str, prefix: str) -> PublishedFrame:
    """Return the published name of a frame.

    The prefix is added only with `tf: global`. It is not added to a PublishedFrame, to a shared frame such as `map`, to an empty
    name or to a name that already begins with the prefix. A name with a leading slash is published without slash and prefix.
    """
    if isinstance(frame, PublishedFrame):
        return frame
    if not stage.global_tf or not frame or frame in SHARED_FRAMES:
        return PublishedFrame(frame)
    if frame.startswith("/"):
        return PublishedFrame(frame.lstrip("/"))
    return PublishedFrame(frame if frame.startswith(prefix) else f"{prefix}{frame}")
