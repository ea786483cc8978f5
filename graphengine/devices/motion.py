"""The interfaces of bodies and joints: poses, velocities and drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import Quaternion, Vector3


class Frame(Protocol):
    """The pose of any prim, also of prims without physics."""

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Return position (m) and orientation of the prim in the world frame."""


class Body(Frame, Protocol):
    """The rigid body of a prim, or the rigid body that carries the prim."""

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Return linear (m/s) and angular (rad/s) velocity of the prim's origin, in the world frame."""


class Placement(Protocol):
    """A body that can be placed and held at a pose."""

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Place the body's prim at rest and hold it against all forces until the simulation stops.

        A link moves only within its joint's range.

        Args:
            position: position in the world frame, m.
            orientation: unit quaternion in the world frame.

        Raises:
            PhysicsError: the position is too far away for the physics; nothing has changed.
        """


class Surface(Protocol):
    """The moving surface of a body that stays in place, like a conveyor belt: it carries along objects that touch it."""

    def move(self, linear: Vector3, angular: Vector3) -> None:
        """Set the velocity of the surface from the next physics step on; a reset stops it.

        Args:
            linear: velocity in the body's frame, m/s.
            angular: angular velocity about the origin of the body, in its frame, rad/s.

        Raises:
            PhysicsError: a number is too large for the physics; the velocity stays as before.
        """


@dataclass(frozen=True, slots=True)
class FrameLink:
    """One edge of a transform tree: a named child frame below a named parent frame."""

    parent_name: str
    child_name: str
    parent: Frame | None
    """Parent frame; None is the world frame."""
    child: Frame
    optical: bool = False
    """Whether to rotate a camera by 180 degrees about x, from its view along -z to the ROS optical frame."""
    fixed: tuple[Vector3, Quaternion] | None = None
    """Constant pose of the child in the parent's frame if one body carries both; else None."""


class JointSelection(Protocol):
    """Selected joints of an articulation, in the order of the selection."""

    @property
    def names(self) -> tuple[str, ...]:
        """Joint names in order."""

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Set targets from the next physics step on, clamped to the joints' limits.

        Each sequence has one value per joint (rad or m, rad/s or m/s, N m or N). None instead of a sequence keeps the targets
        of this kind, NaN keeps the target of its joint.

        Raises:
            BadValueError: a number is infinite or too large for the physics; nothing was set. The error names the port
                `positionCommand`, `velocityCommand` or `effortCommand`.
        """


class Articulation(Protocol):
    """The movable joints of a robot."""

    @property
    def prim_path(self) -> str:
        """Path of the robot's prim."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all movable joints, in the articulation's order."""

    @property
    def actuators(self) -> Mapping[str, str]:
        """Joint that each actuator moves, by the actuator's name; empty for an actuator that does not move exactly one joint."""

    @property
    def prismatic(self) -> tuple[bool, ...]:
        """Whether each joint is prismatic."""

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest position of each joint from the robot description, rad or m; infinite without limits."""

    @property
    def max_velocities(self) -> tuple[float, ...]:
        """Velocity limit of each joint from the robot description, rad/s or m/s; infinite without one."""

    @property
    def leaders(self) -> tuple[str, ...]:
        """Name of the joint that each joint mimics; empty for joints that are not mimic joints."""

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness of each joint's drive, N m/rad or N/m; 0 without a position drive."""

    @property
    def resets(self) -> int:
        """Number of resets so far. Joint positions jump at a reset, so their difference across one is not a motion."""

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> JointSelection:
        """Select the joints with these names, else those with these indices, else all.

        Raises:
            JointError: the articulation has no joint with a name or index.
        """

    def positions(self) -> NDArray[np.float64]:
        """Return the joint positions, rad or m, as a new array."""

    def velocities(self) -> NDArray[np.float64]:
        """Return the joint velocities, rad/s or m/s, as a new array."""

    def set_points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return target position (rad or m) and target velocity (rad/s or m/s) of each joint's drive as new arrays.

        NaN for a drive without such a target.
        """

    def efforts(self) -> NDArray[np.float64]:
        """Return the torque or force of each joint's drive after the last step, N m or N, as a new array."""

    def wrenches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the forces (N) and torques (N m) with which each joint's parent link holds the child link.

        Both are new arrays of shape (joints, 3) in the child link's frame; torques are about the child link's origin.
        """
