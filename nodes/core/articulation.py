"""The joints of a robot (`isaacsim.core.nodes`)."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.devices.motion import Articulation, JointSelection
from graphengine.format.errors import BadValueError, JointError
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, State
from graphengine.node.types import Double3s, Doubles, Ints, String, Target, Tokens
from graphengine.nodes.touched import drives_of


class RobotNode(Node):
    """A node that is executed on the joints of a robot."""

    exec_in = ExecIn()
    target_prim: Target = In(required="robot", setup=True, doc="prim that stands for the robot")
    robot_path: String = In(default="", required="robot", setup=True, doc="the same as text; wins over targetPrim")

    articulation: Articulation = Bound()

    def prim(self) -> str:
        """The path that names the robot."""
        return self.robot_path or self.target_prim[0]


class SelectedJointsNode(RobotNode):
    """A node that is executed on some joints of a robot."""

    joint_names: Tokens = In(doc="joints that the arrays are for; empty for all, or by index")
    joint_indices: Ints = In(doc="joints by number, where no names are given")

    selection: JointSelection | None = State(default=None)
    selected: tuple[object, object] = State(default=((), ()))

    def setup(self, context: Context) -> None:
        """Bind the robot, and the joints that are known by now."""
        self.articulation = context.articulation(self.prim())
        self.select()

    def select(self) -> JointSelection:
        """Bind the joints."""
        self.selection = self.articulation.select(self.joint_names, self.joint_indices.tolist())
        self.selected = (self.joint_names, self.joint_indices)
        return self.selection

    def joints(self) -> JointSelection:
        """The joints that the inputs name, bound anew if they changed.

        Raises:
            BadValueError: the robot does not have one of them.
        """
        names, indices = self.selected
        if self.selection is not None and names is self.joint_names and indices is self.joint_indices:
            return self.selection
        try:
            return self.select()
        except JointError as error:
            given: object = self.joint_names or self.joint_indices
            raise BadValueError("jointNames" if self.joint_names else "jointIndices", given) from error


class IsaacArticulationController(SelectedJointsNode, type="isaacsim.core.nodes.IsaacArticulationController"):
    """Joint targets from arrays; they act from the next physics step on, and hold until the next command."""

    position_command: Doubles = In(unit="rad, m", doc="one a joint; NaN leaves a joint alone")
    velocity_command: Doubles = In(unit="rad/s, m/s", doc="one a joint; NaN leaves a joint alone")
    effort_command: Doubles = In(unit="N m, N", doc="one a joint; NaN leaves a joint alone")

    def compute(self) -> None:
        """Apply the commands, all or none.

        Raises:
            BadValueError: a joint is unknown, or a command has another length than the joints or too large a number.
        """
        selection = self.joints()
        commands = self.position_command.tolist(), self.velocity_command.tolist(), self.effort_command.tolist()
        joints = len(selection.names)
        for name, command in zip(("positionCommand", "velocityCommand", "effortCommand"), commands, strict=True):
            if len(command) not in (0, joints):
                raise BadValueError(
                    f"{name}, jointNames, jointIndices",
                    command,
                    f"one a joint, for {joints} joints of {self.articulation.prim_path}",
                )
        position, velocity, effort = commands
        selection.command(position or None, velocity or None, effort or None)

    def writes(self) -> Iterable[str]:
        """What the robot's drives are told."""
        return (drives_of(self.prim()),) if self.robot_path or self.target_prim else ()


class IsaacArticulationState(SelectedJointsNode, type="isaacsim.core.nodes.IsaacArticulationState"):
    """Positions, velocities and forces of joints, in the order they are asked for.

    measuredJointForces and measuredJointTorques cost more than a physics step; they are computed where a wire takes them.
    """

    joint_positions: Doubles = Out(unit="rad, m")
    joint_velocities: Doubles = Out(unit="rad/s, m/s")
    measured_joint_efforts: Doubles = Out(unit="N m, N", doc="what drives and commanded efforts exert")
    measured_joint_forces: Double3s = Out(
        unit="N", doc="with which parent links hold child links, in the child's frame"
    )
    measured_joint_torques: Double3s = Out(unit="N m", doc="the same, about the child link's origin")
    joint_names_out: Tokens = Out(name="jointNames", doc="the joints of the arrays")

    has_wrenches: bool = Bound()

    def setup(self, context: Context) -> None:
        """Bind the robot, and see what is asked for."""
        super().setup(context)
        self.has_wrenches = context.wired("measured_joint_forces") or context.wired("measured_joint_torques")

    def compute(self) -> None:
        """Read the joints.

        Raises:
            BadValueError: a joint is unknown.
        """
        robot = self.articulation
        self.joint_names_out = names = self.joints().names
        chosen = [robot.joint_names.index(name) for name in names]
        self.joint_positions, self.joint_velocities = robot.positions()[chosen], robot.velocities()[chosen]
        self.measured_joint_efforts = robot.efforts()[chosen]
        if self.has_wrenches:
            forces, torques = robot.wrenches()
            self.measured_joint_forces, self.measured_joint_torques = forces[chosen], torques[chosen]


class IsaacJointNameResolver(RobotNode, type="isaacsim.core.nodes.IsaacJointNameResolver"):
    """Own names of joints that are called by their published names.

    Published are values of `isaac:nameOverride`. Other names are handed on as they are.
    """

    joint_names: Tokens = In(doc="published names")
    exec_out = ExecOut()
    joint_names_out: Tokens = Out(name="jointNames", doc="the joints' own names, for IsaacArticulationController")
    robot_path_out: String = Out(name="robotPath", doc="path of the robot's prim")

    own_names: dict[str, str] = Bound()

    def setup(self, context: Context) -> None:
        """Learn the names; what is known of them by now is put out before the first tick."""
        self.articulation = context.articulation(self.prim())
        published = context.joint_names(self.prim())
        self.own_names = dict(zip(published, self.articulation.joint_names, strict=True))
        self.compute()

    def compute(self) -> None:
        """Replace the names."""
        self.joint_names_out = tuple(self.own_names.get(name, name) for name in self.joint_names)
        self.robot_path_out = self.articulation.prim_path
