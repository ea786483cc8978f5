"""Published names of TF frames: unchanged, or prefixed with a namespace if all robots share /tf and /tf_static.

The key `tf` of a scene selects the mode. With `tf: global`, the frame `base_link` of a robot's node is published as
`dd100_0000/base_link`, as with the parameter `frame_prefix` of robot_state_publisher. The prefix is the outermost namespace of
the ancestor prims, or else the node's `nodeNamespace`; with `tf: namespaced`, the topic `tf` gets this namespace instead. For
the frame of a prim, the ancestors are those of this prim, whichever node publishes the frame.
"""

from __future__ import annotations

from graphengine.devices.stage import Prim, Stage
from graphengine.messages.names import join_namespaces, strip

SHARED_FRAMES = frozenset(("map", "world", "earth"))
"""Frames that all robots share; they are never prefixed."""


class PublishedFrame(str):
    """The published name of a frame, with its prefix. Wires keep the type, so that a publishing node adds no second prefix."""

    __slots__ = ()


def frame_prefix(stage: Stage, prim_path: str, node_namespace: str = "") -> str:
    """Return the frame prefix at and below a prim, with its trailing slash; empty if frames are not prefixed."""
    if not stage.global_tf:
        return ""
    namespace = strip(join_namespaces(stage.namespaces(prim_path), outermost=True) or node_namespace)
    return f"{namespace}/" if namespace else ""


def prim_prefix(stage: Stage, prim: Prim) -> str:
    """Return the prefix of a prim's frame: that of its ancestors, or else that of its robot's base link."""
    robot = stage.robot_of(prim)
    base = robot.facts.get("base_link") if robot is not None else None
    return frame_prefix(stage, prim.path) or (frame_prefix(stage, base) if base else "")


def full_frame(stage: Stage, frame: str, prefix: str) -> PublishedFrame:
    """Return the published name of a frame; a PublishedFrame is returned unchanged.

    Under `tf: global`, a leading slash makes a name absolute: it is published without the slash and without a prefix. A name that
    already has the prefix, a shared frame and an empty name stay as they are.
    """
    if isinstance(frame, PublishedFrame):
        return frame
    if not stage.global_tf or not frame or frame in SHARED_FRAMES:
        return PublishedFrame(frame)
    if frame.startswith("/"):
        return PublishedFrame(frame.lstrip("/"))
    return PublishedFrame(frame if frame.startswith(prefix) else f"{prefix}{frame}")
