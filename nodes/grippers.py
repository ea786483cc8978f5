"""Nodes that control suction grippers (`isaacsim.robot.surface_gripper`) and fingers (`isaacsim.robot.manipulators`)."""

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

    While the gripper holds a body, the body keeps the pose relative to the gripper that it had when the grip began. The gripper
    does not pull the body closer. To read the status of the gripper, read the attribute `isaac:status` of the gripper's prim with
    ReadPrimAttribute. The robot file defines the gripper as a device of type `surface_gripper`; the device has the attributes of
    Isaac Sim's prim.
    """

    toggle = ExecIn(name="Toggle", doc="closes the gripper if it is open; opens it otherwise")
    open_in = ExecIn(name="Open", doc="opens the gripper and releases the held bodies")
    close_in = ExecIn(name="Close", doc="closes the gripper, which then grips bodies in front of it")
    enabled: bool = In(default=True, doc="false: executions do nothing")
    surface_gripper: Target = In(name="SurfaceGripper", required=True, setup=True, doc="prim of the surface gripper")

    gripper: SurfaceGripperDevice = Bound()

    def setup(self, context: Context) -> None:
        """Look up the surface gripper at `SurfaceGripper` and keep its handle."""
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
        """Return the resource key of the gripper's status attribute."""
        return [attribute_of(path, "isaac:status") for path in self.surface_gripper]


class IsaacGripperController(Node, type="isaacsim.robot.manipulators.IsaacGripperController"):
    """Opens and closes the fingers of a gripper step by step: each execution moves them by `gripperSpeed`.

    If several inputs fire together, `stop` takes precedence over `close`, and `close` over `open`. Each joint moves towards its
    own goal; in Isaac Sim, all joints move in the direction of the first joint. A changed input takes effect at the next
    execution; Isaac Sim keeps the values of the first execution. The joints need position drives.
    """

    exec_in = ExecIn(doc="moves the fingers one step further if they are opening or closing")
    open_in = ExecIn(name="open", doc="starts to open the gripper and moves the fingers by the first step")
    close_in = ExecIn(name="close", doc="starts to close the gripper and moves the fingers by the first step")
    stop = ExecIn(doc="stops the fingers where they are")
    articulation_root_prim: Target = In(required=True, setup=True, doc="robot's prim, base link or articulation root")
    gripper_prim: Target = In(doc="no effect: `jointNames` selects the joints")
    joint_names_in: Tokens = In(name="jointNames", required=True, doc="names of the fingers' joints")
    open_position: Doubles = In(
        unit="rad, m",
        doc="joint positions of the open gripper: one per joint, or one for all joints; if `openPosition` and `closePosition` "
        "are empty or all 0, the upper limits of the joints are used",
    )
    close_position: Doubles = In(
        unit="rad, m",
        doc="joint positions of the closed gripper: one per joint, or one for all joints; if `openPosition` and `closePosition` "
        "are empty or all 0, the lower limits of the joints are used",
    )
    gripper_speed: Doubles = In(
        gt=0.0,
        required=True,
        unit="rad, m",
        doc="motion of the joints per execution: one number per joint, or one for all joints; greater than 0",
    )
    joint_names_out: Tokens = Out(name="jointNames", doc="names of the joints, in the order of `positionCommands`")
    position_commands: Doubles = Out(
        unit="rad, m", doc="position target of each joint; if wired, the node itself does not set targets"
    )

    articulation: Articulation = Bound()
    commands_joints: bool = Bound()
    motion: str = State(default="")
    """Direction in which the fingers move: `open` or `close`. Empty while they do not move."""
    commanded: tuple[float, ...] = State(default=())
    """Last position target of each joint, rad or m; empty before the first execution."""

    def setup(self, context: Context) -> None:
        """Look up the robot at `articulationRootPrim`, and check whether `positionCommands` is wired."""
        self.articulation = context.articulation(self.articulation_root_prim[0])
        self.commands_joints = not context.wired("position_commands")

    def compute(self) -> None:
        """Move the fingers one step further if they are opening or closing.

        If the first execution does not open or close the fingers, it sets the measured positions as targets.

        Raises:
            BadValueError: a joint is unknown, has no position drive, or lacks the limits that replace missing positions; an array
                has the wrong length; a number is not finite; or a speed is not above 0.
        """
        selection, measured = self.joints()
        goals = self.goals(selection.names)
        speed = self.one_per_joint("gripperSpeed", self.gripper_speed, selection.names)
        if not (speed > 0.0).all():
            raise BadValueError("gripperSpeed", speed.tolist(), "greater than 0")
        is_first = len(self.commanded) != len(measured)
        positions = measured if is_first or self.stop else np.array(self.commanded)
        motion = "close" if self.close_in else "open" if self.open_in else self.motion
        motion = "" if self.stop else motion
        moves = is_first or self.stop or motion
        if motion:
            positions = np.clip(goals[motion], positions - speed, positions + speed)
            motion = "" if np.array_equal(positions, goals[motion]) else motion
        if moves and self.commands_joints:
            selection.command(positions=positions.tolist())
        self.motion, self.commanded = motion, tuple(positions.tolist())
        self.joint_names_out, self.position_commands = selection.names, positions

    def joints(self) -> tuple[JointSelection, NDArray[np.float64]]:
        """Return the joints of the fingers and their measured positions, rad or m.

        Raises:
            BadValueError: `jointNames` is empty, or a named joint does not exist or has no position drive.
        """
        names, robot = self.joint_names_in, self.articulation
        if not names:
            raise BadValueError("jointNames", names, "the names of the fingers' joints")
        try:
            selection, chosen = robot.select(names), joint_numbers(robot, names)
        except JointError as error:
            raise BadValueError("jointNames", names, "names of joints of the robot") from error
        if np.isnan(robot.set_points()[0][chosen]).any():
            raise BadValueError("jointNames", names, "joints with a position drive (stiffness in the robot file)")
        return selection, robot.positions()[chosen]

    def goals(self, names: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """Return a dict with the joint positions of the open gripper (key `open`) and of the closed gripper (key `close`).

        Raises:
            BadValueError: an array has the wrong length or a number is not finite; or the inputs give no positions, and a joint
                has no limits to use instead.
        """
        opened = self.one_per_joint("openPosition", self.open_position, names)
        closed = self.one_per_joint("closePosition", self.close_position, names)
        if not opened.any() and not closed.any():
            robot = self.articulation
            closed, opened = np.array([robot.ranges[robot.joint_names.index(name)] for name in names], float).T
            if not np.isfinite([closed, opened]).all():
                legal = f"positions that are not all 0 (not all of {', '.join(names)} have limits to use instead)"
                raise BadValueError("openPosition, closePosition", [], legal)
        return {"open": opened, "close": closed}

    def one_per_joint(self, port: str, values: NDArray[np.float64], names: Sequence[str]) -> NDArray[np.float64]:
        """Return an array with one value per joint from the values of an input.

        A single value is repeated for all joints. An empty array gives zeros.

        Args:
            port: OmniGraph name of the input, for the error message.
            values: values of the input.
            names: names of the joints.

        Raises:
            BadValueError: the number of values is not 0, 1 or the number of joints, or a number is not finite.
        """
        if len(values) not in (0, 1, len(names)) or not np.isfinite(values).all():
            raise BadValueError(port, values.tolist(), f"one finite number, or one for each of {len(names)} joints")
        return np.broadcast_to(values if len(values) else np.zeros(1), len(names))

    def writes(self) -> Iterable[str]:
        """Return the resource key of the robot's drive targets."""
        return [drives_of(path) for path in self.articulation_root_prim]
