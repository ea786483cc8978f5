"""Grippers: suction cups (`isaacsim.robot.surface_gripper`) and fingers (`isaacsim.robot.manipulators`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.backend import joint_numbers
from graphengine.devices.motion import Articulation, JointSelection
from graphengine.devices.surface_gripper import SurfaceGripperDevice
from graphengine.format.errors import JointError
from graphengine.node import BadValueError, Bound, Context, ExecIn, In, Node, Out, State
from graphengine.node.types import Doubles, Target, Tokens
from graphengine.nodes.touched import attribute_of, drives_of


class SurfaceGripper(Node, type="isaacsim.robot.surface_gripper.SurfaceGripper"):
    """Closes and opens a surface gripper. If several inputs fire together, `Close` takes precedence over `Open` and `Toggle`.

    A gripped body keeps its pose relative to the gripper, even at a distance from it. ReadPrimAttribute reads the gripper's
    status from the attribute `isaac:status`. The gripper is a device of type `surface_gripper` in the robot file, with the
    attributes of Isaac Sim's prim.
    """

    toggle = ExecIn(name="Toggle", doc="closes the gripper if it is open; opens it otherwise")
    open_in = ExecIn(name="Open", doc="opens the gripper, which releases the bodies that it holds")
    close_in = ExecIn(name="Close", doc="closes the gripper, which grips bodies in front of it")
    enabled: bool = In(default=True, doc="false: executions do nothing")
    surface_gripper: Target = In(name="SurfaceGripper", required=True, setup=True, doc="prim of the surface gripper")

    gripper: SurfaceGripperDevice = Bound()

    def setup(self, context: Context) -> None:
        """Bind the gripper."""
        self.gripper = context.device(SurfaceGripperDevice, self.surface_gripper[0])

    def compute(self) -> None:
        """Close or open the gripper, depending on the execution inputs that fired."""
        if not self.enabled:
            return
        if self.close_in or (self.toggle and not self.open_in and self.gripper.status == "Open"):
            self.gripper.close()
        else:
            self.gripper.open()

    def writes(self) -> Iterable[str]:
        """Return the resource keys of the gripper's status."""
        return [attribute_of(path, "isaac:status") for path in self.surface_gripper]


class IsaacGripperController(Node, type="isaacsim.robot.manipulators.IsaacGripperController"):
    """Opens and closes the fingers of a gripper step by step: each execution moves them by `gripperSpeed`.

    If several inputs fire together, `stop` takes precedence over `close`, and `close` over `open`. Each joint moves towards its
    own goal; in Isaac Sim, all joints move in the direction of the first. Changes of inputs take effect at any time; Isaac Sim
    uses the values of the first execution. The joints need position drives.
    """

    exec_in = ExecIn(doc="moves the fingers one step further if they are opening or closing")
    open_in = ExecIn(name="open", doc="begins to open the gripper, with the first step at once")
    close_in = ExecIn(name="close", doc="begins to close the gripper, with the first step at once")
    stop = ExecIn(doc="stops the fingers where they are")
    articulation_root_prim: Target = In(
        required=True, setup=True, doc="the robot's prim, base link or articulation root"
    )
    gripper_prim: Target = In(doc="no effect: `jointNames` selects the joints")
    joint_names_in: Tokens = In(name="jointNames", required=True, doc="names of the fingers' joints")
    open_position: Doubles = In(
        unit="rad, m",
        doc="position of each joint when open, or one for all; if this and `closePosition` are empty or all 0: the joints' upper "
        "limits",
    )
    close_position: Doubles = In(
        unit="rad, m",
        doc="position of each joint when closed, or one for all; if this and `openPosition` are empty or all 0: the joints' "
        "lower limits",
    )
    gripper_speed: Doubles = In(
        required=True, unit="rad, m", doc="distance that each joint moves per execution, or one for all; greater than 0"
    )
    joint_names_out: Tokens = Out(name="jointNames", doc="names of the joints, in the order of `positionCommands`")
    position_commands: Doubles = Out(
        unit="rad, m",
        doc="position set point of each joint; if this output is wired, the node does not command the joints itself",
    )

    articulation: Articulation = Bound()
    commands_joints: bool = Bound()
    motion: str = State(default="")
    """Direction in which the fingers move: `open` or `close`; empty while they rest."""
    commanded: tuple[float, ...] = State(default=())
    """Commanded position of each joint; empty before the first execution."""

    def setup(self, context: Context) -> None:
        """Bind the robot, and check whether `positionCommands` is wired to another node."""
        self.articulation = context.articulation(self.articulation_root_prim[0])
        self.commands_joints = not context.wired("position_commands")

    def compute(self) -> None:
        """Move the fingers one step further; the first execution makes them hold their position unless it opens or closes them.

        Raises:
            BadValueError: a joint is unknown or has no limits, or an array has the wrong length.
        """
        selection, measured = self.joints()
        goals, speed = (
            self.goals(selection.names),
            self.one_per_joint("gripperSpeed", self.gripper_speed, selection.names),
        )
        if not (speed > 0.0).all():
            raise BadValueError("gripperSpeed", speed.tolist(), "greater than 0")
        is_first = len(self.commanded) != len(measured)
        positions = measured if is_first or self.stop else np.array(self.commanded)
        motion = "close" if self.close_in else "open" if self.open_in else self.motion
        motion = "" if self.stop else motion
        moves = bool(is_first or self.stop or motion)
        if motion:
            positions = np.clip(goals[motion], positions - speed, positions + speed)
            motion = "" if np.array_equal(positions, goals[motion]) else motion
        if moves and self.commands_joints:
            selection.command(positions=positions.tolist())
        self.motion, self.commanded = motion, tuple(positions.tolist())
        self.joint_names_out, self.position_commands = selection.names, positions

    def joints(self) -> tuple[JointSelection, NDArray[np.float64]]:
        """Return the fingers' joints and their positions, rad or m.

        Raises:
            BadValueError: a joint is unknown or has no position drive, or no joint is given.
        """
        names, robot = self.joint_names_in, self.articulation
        if not names:
            raise BadValueError("jointNames", names, "the names of the fingers' joints")
        try:
            selection, chosen = robot.select(names), joint_numbers(robot, names)
        except JointError as error:
            raise BadValueError("jointNames", names) from error
        if np.isnan(robot.set_points()[0][chosen]).any():
            raise BadValueError("jointNames", names, "joints with a position drive (stiffness in the robot file)")
        return selection, robot.positions()[chosen]

    def goals(self, names: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """Return the joint positions of the open and the closed gripper, by `open` and `close`.

        Raises:
            BadValueError: an array has the wrong length, or no positions are given and a joint has no limits.
        """
        opened = self.one_per_joint("openPosition", self.open_position, names)
        closed = self.one_per_joint("closePosition", self.close_position, names)
        if not opened.any() and not closed.any():
            robot = self.articulation
            closed, opened = np.array([robot.ranges[robot.joint_names.index(name)] for name in names], float).T
            if not np.isfinite([closed, opened]).all():
                raise BadValueError(
                    "openPosition, closePosition", [], f"given, as not all of {', '.join(names)} have limits"
                )
        return {"open": opened, "close": closed}

    def one_per_joint(self, port: str, values: NDArray[np.float64], names: Sequence[str]) -> NDArray[np.float64]:
        """Return the values of an input, one for each joint; zeros for an empty array.

        Raises:
            BadValueError: the array has another length, or a number is not finite.
        """
        if len(values) not in (0, 1, len(names)) or not np.isfinite(values).all():
            raise BadValueError(port, values.tolist(), f"one finite number, or one for each of {len(names)} joints")
        return np.broadcast_to(values if len(values) else np.zeros(1), len(names))

    def writes(self) -> Iterable[str]:
        """Return the resource keys of the robot's drive targets."""
        return [drives_of(path) for path in self.articulation_root_prim]
