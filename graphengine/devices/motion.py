"""The Protocols of the handles to bodies and joints: poses, velocities, conveyor surfaces and drives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.devices.stage import Prim

CommandKind = Literal["position", "velocity", "effort"]
"""Kinds of joint commands."""


class Frame(Protocol):
    """A handle to the pose of any prim, including prims without physics."""

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Return position (m) and orientation of the prim in the world frame."""

    @property
    def released(self) -> bool:
        """Whether the handle is no longer valid, because its prim was removed or its world was closed."""


class Body(Frame, Protocol):
    """A handle to the pose and velocity of a prim that is a rigid body or is fixed to one."""

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Return linear (m/s) and angular (rad/s) velocity of the prim's origin, in the world frame."""


class Placement(Protocol):
    """A handle that moves a prim to a pose and holds it there."""

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Move the prim to a pose, with zero velocity, and hold it there against all forces until the simulation is reset.

        A link moves only along or about its joint, within the joint's limits.

        Args:
            position: position in the world frame, m.
            orientation: unit quaternion in the world frame.

        Raises:
            PhysicsError: the position is too far from the world's origin. The prim then keeps its pose.
        """


class Surface(Protocol):
    """A handle to the surface velocity of a fixed body. Like a conveyor belt, the surface carries along objects that touch it."""

    def move(self, linear: Vector3, angular: Vector3) -> None:
        """Set the velocity of the surface from the next physics step on; a reset sets it to zero.

        Args:
            linear: linear velocity in the body's frame, m/s.
            angular: angular velocity about the body's origin in the body's frame, rad/s.

        Raises:
            PhysicsError: a number is not finite or too large for the physics. The surface then keeps its velocity.
        """


@dataclass(frozen=True, slots=True)
class FrameLink:
    """One edge of a TF tree, from a parent frame to a child frame, with handles to the poses of both."""

    parent_name: str
    child_name: str
    parent: Frame | None
    """Pose of the parent frame; None stands for the world frame."""
    child: Frame
    optical: bool = False
    """Whether the child frame is the optical frame of a camera: the pose of `child`, rotated by 180 degrees about the x axis."""
    fixed: tuple[Vector3, Quaternion] | None = None
    """Constant pose of the child in the parent's frame if the same body carries both; otherwise None."""


class JointSelection(Protocol):
    """A handle to selected joints of an articulation, in the order of the selection."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the selected joints, in the order of the selection."""

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Set the targets of the selected joints from the next physics step on. Targets are clamped to the joints' limits.

        Each sequence has one value per selected joint. NaN keeps the target of this joint; None in place of a sequence keeps the
        targets of this kind for all joints.

        Args:
            positions: target positions, rad or m.
            velocities: target velocities, rad/s or m/s.
            efforts: torques or forces, N m or N.

        Raises:
            BadValueError: a number is infinite or too large for the physics. No target has changed then. The error names the port
                `positionCommand`, `velocityCommand` or `effortCommand`.
        """

    def undriven(self, kind: CommandKind) -> Sequence[str]:
        """Return the names of the selected joints without a drive for this kind of command; such commands have no effect."""


class Articulation(Protocol):
    """A handle to the movable joints of a robot."""

    @property
    def prim_path(self) -> str:
        """Path of the robot's prim."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all movable joints. All other sequences of the articulation have the same order."""

    @property
    def actuators(self) -> Mapping[str, str]:
        """A dict from the name of each actuator to the name of the joint that it moves.

        The joint's name is empty for an actuator that moves several joints or none.
        """

    @property
    def prismatic(self) -> tuple[bool, ...]:
        """Whether each joint is prismatic; all other joints are revolute or continuous."""

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper position limit of each joint from the robot description, rad or m; infinite without limits."""

    @property
    def target_ranges(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest position target of each joint, rad or m: its range, extended by the `overtravel` of its drive."""

    @property
    def max_velocities(self) -> tuple[float, ...]:
        """Velocity limit of each joint from the robot description, rad/s or m/s; infinite without a limit."""

    @property
    def leaders(self) -> tuple[str, ...]:
        """For each mimic joint, the name of the joint that it mimics; empty for other joints."""

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness of each joint's drive, N m/rad or N/m; 0 for a joint without a position drive."""

    @property
    def resets(self) -> int:
        """Number of resets since the session began. Joint positions jump at a reset: compute no velocity from before to after."""

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> JointSelection:
        """Return the joints with these names; without names, those with these indices; with neither, all joints.

        Raises:
            JointError: the articulation has no joint with a given name, or an index is out of range.
        """

    def positions(self) -> NDArray[np.float64]:
        """Return the joint positions, rad or m, as a new array."""

    def velocities(self) -> NDArray[np.float64]:
        """Return the joint velocities, rad/s or m/s, as a new array."""

    def set_points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the target positions (rad or m) and target velocities (rad/s or m/s) of the joints' drives as new arrays.

        An element is NaN if the joint's drive does not have this target.
        """

    def efforts(self) -> NDArray[np.float64]:
        """Return the torque or force on each joint from its drive and commands after the last step, N m or N, as a new array."""

    def wrenches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the forces (N) and torques (N m) with which each joint's parent link holds the child link.

        Both are new arrays of shape (joints, 3) in the child link's frame; torques are about the child link's origin.
        """


class JointFacts:
    """Base class of implementations of `Articulation`. It sets the attributes that the facts of the robot's prim give."""

    def __init__(self, robot: Prim) -> None:
        facts = robot.facts
        self.joint_names: tuple[str, ...] = tuple(facts.get("joints", ()))
        joints = len(self.joint_names)
        self.prismatic: tuple[bool, ...] = tuple(facts.get("prismatic", (False,) * joints))
        self.ranges: tuple[tuple[float, float], ...] = facts.get("ranges", ((-math.inf, math.inf),) * joints)
        self.max_velocities: tuple[float, ...] = facts.get("max_velocities", (math.inf,) * joints)
        self.leaders: tuple[str, ...] = facts.get("leaders", ("",) * joints)
        self.actuators: Mapping[str, str] = facts.get("actuators", {})
        self.commanded_names: tuple[str, ...] = (*self.joint_names, *facts.get("other_actuators", {}))
        """Names of the joints, then of the actuators that do not move exactly one joint."""
