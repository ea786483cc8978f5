"""Nodes that read poses of prims, singly or as a transform tree (`isaacsim.core.nodes`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from graphengine.devices import rotation
from graphengine.devices.motion import Frame, FrameLink
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out
from graphengine.node.types import Double3s, Double4s, Quaterniond, Target, Tokens, Vector3d
from graphengine.nodes.touched import reading_poses

_HALF_TURN_ABOUT_X = (1.0, 0.0, 0.0, 0.0)


class IsaacReadWorldPose(Node, type="isaacsim.core.nodes.IsaacReadWorldPose", volatile=True):
    """Reads the pose of a prim in the world frame."""

    prim: Target = In(required=True, setup=True, doc="prim whose pose is read")
    translation: Vector3d = Out(unit="m")
    orientation: Quaterniond = Out(default=(0.0, 0.0, 0.0, 1.0), doc="orientation (x, y, z, w) in the world frame")
    scale: Vector3d = Out(doc="always (1, 1, 1), because poses have no scale")

    frame: Frame = Bound()

    def setup(self, context: Context) -> None:
        """Look up the prim and keep a handle to its pose."""
        self.frame = context.frame(self.prim[0])

    def compute(self) -> None:
        """Output the current pose of the prim."""
        self.translation, self.orientation = self.frame.pose()
        self.scale = (1.0, 1.0, 1.0)

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the prim's pose."""
        return reading_poses(self.prim)


class IsaacComputeTransformTree(Node, type="isaacsim.core.nodes.IsaacComputeTransformTree"):
    """Computes the poses of prims relative to a parent prim. For a robot, it computes the transform tree of the links."""

    exec_in = ExecIn()
    parent_prim: Target = In(setup=True, doc="prim of the parent frame; if empty, the world frame is the parent")
    target_prims: Target = In(required=True, setup=True, doc="prims to compute: robots, links, sensors, frames")
    exec_out = ExecOut()
    parent_frames: Tokens = Out(doc="name of the parent frame of each pose")
    child_frames: Tokens = Out(doc="name of the child frame of each pose")
    translations: Double3s = Out(unit="m", doc="position of each child frame in its parent frame")
    orientations: Double4s = Out(doc="orientation (x, y, z, w) of each child frame in its parent frame")

    links: Sequence[FrameLink] = Bound()
    names: tuple[tuple[str, ...], tuple[str, ...]] = Bound()
    constant: tuple[Double3s, Double4s] | None = Bound()

    def setup(self, context: Context) -> None:
        """Look up the frames of the targets, and output the frame names before the first tick."""
        self.links = context.transform_tree(self.target_prims, self.parent_prim[0] if self.parent_prim else "")
        self.names = tuple(link.parent_name for link in self.links), tuple(link.child_name for link in self.links)
        self.parent_frames, self.child_frames = self.names
        self.constant = self.read_poses() if all(link.fixed is not None for link in self.links) else None

    def compute(self) -> None:
        """Output the frame names and the current poses."""
        self.parent_frames, self.child_frames = self.names
        self.translations, self.orientations = self.constant or self.read_poses()

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the poses of the targets and the parent."""
        return reading_poses((*self.target_prims, *self.parent_prim))

    def read_poses(self) -> tuple[Double3s, Double4s]:
        """Return the current positions, m, shape (n, 3), and orientations, shape (n, 4), of the child frames in their parents."""
        poses = [pose_of(link) for link in self.links]
        translations = np.array([position for position, _ in poses]).reshape(-1, 3)
        return translations, np.array([orientation for _, orientation in poses]).reshape(-1, 4)


def pose_of(link: FrameLink) -> rotation.Pose:
    """Return the current pose of the child frame of an edge of the transform tree, in the parent frame of the edge."""
    if link.fixed is not None:
        position, orientation = link.fixed
    else:
        position, orientation = link.child.pose()
        if link.parent is not None:
            position, orientation = rotation.relative(link.parent.pose(), (position, orientation))
    return position, rotation.multiply(orientation, _HALF_TURN_ABOUT_X) if link.optical else orientation
