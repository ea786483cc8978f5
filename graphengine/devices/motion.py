"""What nodes see of bodies and joints: their poses, their velocities, their drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.sensor import Quaternion, Vector3


class Frame(Protocol):
    """The pose of any prim, whether or not physics knows it."""

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Position (m) and orientation of the prim in the world frame."""


class Body(Frame, Protocol):
    """A rigid body, or the rigid body that carries a prim."""

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Linear (m/s) and angular (rad/s) velocity of the prim's origin, in the world frame."""


class Placement(Protocol):
    """A body that is put somewhere and stays there."""

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Put the body's prim there, at rest, and hold it against all that acts on it until the simulation stops.

        A link goes as far as its joint lets it.

        Args:
            position: in the world frame, m.
            orientation: in the world frame, of length 1.

        Raises:
            PhysicsError: it is too far away to be counted with; nothing has changed.
        """


@dataclass(frozen=True, slots=True)
class FrameLink:
    """One edge of a transform tree: a named child frame below a named parent frame."""

    parent_name: str
    child_name: str
    parent: Frame | None
    """None stands for the world frame."""
    child: Frame
    optical: bool = False
    """Cameras turn by 180 degrees about x: from looking along -z to the ROS optical frame."""
    fixed: tuple[Vector3, Quaternion] | None = None
    """Pose of the child in the parent's frame where it never changes, because one body carries both."""


class JointSelection(Protocol):
    """Some joints of an articulation, in the order they were asked for."""

    @property
    def names(self) -> tuple[str, ...]:
        """Joint names in order."""

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Set targets from the next physics step on; what is beyond a joint's limits is set to them.

        Each sequence has one value a joint (rad or m, rad/s or m/s, N m or N); None leaves that kind as it is, and so does
        NaN for a single joint.

        Raises:
            BadValueError: a number that physics cannot count with; nothing was set. Its port is `positionCommand`,
                `velocityCommand` or `effortCommand`.
        """


class Articulation(Protocol):
    """A robot's moving joints."""

    @property
    def prim_path(self) -> str:
        """Path of the robot's prim."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """All moving joints, in the articulation's order."""

    @property
    def prismatic(self) -> tuple[bool, ...]:
        """For each joint, whether it slides."""

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> JointSelection:
        """Joints by name, else by index, else all.

        Raises:
            JointError: a name or index that the articulation does not have.
        """

    def positions(self) -> NDArray[np.float64]:
        """Joint positions, rad or m; a fresh array."""

    def velocities(self) -> NDArray[np.float64]:
        """Joint velocities, rad/s or m/s; a fresh array."""

    def set_points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Targets of position (rad or m) and velocity (rad/s or m/s) of each joint's drive; NaN where it has no such target.

        Fresh arrays.
        """

    def efforts(self) -> NDArray[np.float64]:
        """Torque or force of each joint's drive after the last step, N m or N; a fresh array."""

    def wrenches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Forces (N) and torques (N m) with which each joint's parent link holds its child link, in the child's frame.

        Each has the shape (joints, 3); torques are about the child link's origin. Fresh arrays.
        """
