"""The joints of a robot (`isaacsim.core.nodes`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from graphengine.compiler.lint_registry import lint
from graphengine.devices.motion import Articulation, JointSelection
from graphengine.format.errors import BadValueError, GraphError, JointError
from graphengine.format.wording import listing
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out
from graphengine.node.types import Double3s, Doubles, Ints, String, Target, Tokens
from graphengine.nodes.touched import drives_of

if TYPE_CHECKING:
    from graphengine.compiler.graph import Graph, Instance
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.devices.stage import Prim


class RobotNode(Node):
    """Base of nodes that need a robot, given as a target or by its path."""

    exec_in = ExecIn()
    target_prim: Target = In(required="robot", setup=True, doc="the robot's prim, base link or articulation root")
    robot_path: String = In(
        default="", required="robot", setup=True, doc="path of the robot's prim; overrides `targetPrim`"
    )

    articulation: Articulation = Bound()

    def prim(self) -> str:
        """Return the path of the prim that the inputs give for the robot.

        Raises:
            BadValueError: `targetPrim` and `robotPath` are empty.
        """
        if not (self.robot_path or self.target_prim):
            raise BadValueError(
                "targetPrim, robotPath", self.target_prim, "the prim, base link or articulation root of a robot"
            )
        return self.robot_path or self.target_prim[0]


class SelectedJointsNode(RobotNode):
    """Base of nodes that read or command selected joints of a robot."""

    joint_names: Tokens = In(doc="names of the joints to use, in order; if empty, `jointIndices` selects them")
    joint_indices: Ints = In(doc="indices of the joints to use if `jointNames` is empty; if both are empty, all joints")

    selection: JointSelection = Bound()
    selected: tuple[object, object] = Bound()

    def setup(self, context: Context) -> None:
        """Bind the robot and the joints that the inputs select now."""
        self.articulation = context.articulation(self.prim())
        self.select()

    def select(self) -> JointSelection:
        """Look up the joints that the inputs select, and keep the result for `joints`."""
        self.selection = self.articulation.select(self.joint_names, self.joint_indices.tolist())
        self.selected = (self.joint_names, self.joint_indices)
        return self.selection

    def joints(self) -> JointSelection:
        """Return the joints that the inputs select; they are looked up again after a change of an input.

        Raises:
            BadValueError: the robot has no joint with a name or index.
        """
        names, indices = self.selected
        if names is self.joint_names and indices is self.joint_indices:
            return self.selection
        try:
            return self.select()
        except JointError as error:
            given: object = self.joint_names or self.joint_indices
            raise BadValueError("jointNames" if self.joint_names else "jointIndices", given) from error


class IsaacArticulationController(SelectedJointsNode, type="isaacsim.core.nodes.IsaacArticulationController"):
    """Sets targets of joints, which act from the next physics step until the next command.

    A command to a mimic joint logs a warning: without a drive, the command has no effect; with one, the drive works against the
    joint that it mimics.
    """

    position_command: Doubles = In(
        unit="rad, m", doc="target of each joint; NaN keeps a joint's target, an empty array keeps all targets"
    )
    velocity_command: Doubles = In(
        unit="rad/s, m/s", doc="target of each joint; NaN keeps a joint's target, an empty array keeps all targets"
    )
    effort_command: Doubles = In(
        unit="N m, N", doc="target of each joint; NaN keeps a joint's target, an empty array keeps all targets"
    )

    logger: Context = Bound()

    def setup(self, context: Context) -> None:
        """Bind the robot and the joints that the inputs select now."""
        self.logger = context
        super().setup(context)

    def select(self) -> JointSelection:
        """Look up the joints that the inputs select, and warn of those that mimic other joints."""
        selection, robot = super().select(), self.articulation
        chosen = set(selection.names) if self.joint_names or len(self.joint_indices) else ()
        for name, leader in zip(robot.joint_names, robot.leaders, strict=True):
            if leader and name in chosen:
                text = f"joint {name} of {robot.prim_path} follows {leader}: command {leader} instead"
                self.logger.log("warning", text)
        return selection

    def compute(self) -> None:
        """Apply all commands, or none on an error.

        Raises:
            BadValueError: a joint is unknown, a command does not have one number per joint, or a number is too large.
        """
        selection = self.joints()
        commands = self.position_command.tolist(), self.velocity_command.tolist(), self.effort_command.tolist()
        joints = len(selection.names)
        for name, command in zip(("positionCommand", "velocityCommand", "effortCommand"), commands, strict=True):
            if len(command) not in (0, joints):
                raise BadValueError(
                    f"{name}, jointNames, jointIndices",
                    command,
                    f"one per joint, for {joints} joints of {self.articulation.prim_path}",
                )
        position, velocity, effort = commands
        selection.command(position or None, velocity or None, effort or None)

    def writes(self) -> Iterable[str]:
        """Return the resource keys of the robot's drive targets."""
        return (drives_of(self.prim()),) if self.robot_path or self.target_prim else ()


class IsaacArticulationState(SelectedJointsNode, type="isaacsim.core.nodes.IsaacArticulationState"):
    """Reads positions, velocities and efforts of selected joints; all outputs have the same order.

    `measuredJointForces` and `measuredJointTorques` take longer than a physics step, so they are computed only if one of them
    is wired.
    """

    joint_positions: Doubles = Out(unit="rad, m")
    joint_velocities: Doubles = Out(unit="rad/s, m/s")
    measured_joint_efforts: Doubles = Out(unit="N m, N", doc="effort of the drive plus commanded effort, per joint")
    measured_joint_forces: Double3s = Out(
        unit="N", doc="force of each joint's parent link on its child link, in the child link's frame"
    )
    measured_joint_torques: Double3s = Out(
        unit="N m",
        doc="torque of each joint's parent link on its child link, about the child link's origin and in its frame",
    )
    joint_names_out: Tokens = Out(name="jointNames", doc="names of the joints, in the order of the other outputs")

    has_wrenches: bool = Bound()

    def setup(self, context: Context) -> None:
        """Bind the robot and find out which outputs are wired."""
        super().setup(context)
        self.has_wrenches = context.wired("measured_joint_forces") or context.wired("measured_joint_torques")

    def compute(self) -> None:
        """Read the joints.

        Raises:
            BadValueError: a joint is unknown.
        """
        robot = self.articulation
        self.joint_names_out = names = self.joints().names
        if not set(names) <= set(robot.joint_names):
            legal = "joints, as an actuator of anything else has no state"
            raise BadValueError("jointNames", self.joint_names, legal)
        chosen = [robot.joint_names.index(name) for name in names]
        self.joint_positions, self.joint_velocities = robot.positions()[chosen], robot.velocities()[chosen]
        self.measured_joint_efforts = robot.efforts()[chosen]
        if self.has_wrenches:
            forces, torques = robot.wrenches()
            self.measured_joint_forces, self.measured_joint_torques = forces[chosen], torques[chosen]


class IsaacJointNameResolver(RobotNode, type="isaacsim.core.nodes.IsaacJointNameResolver"):
    """Translates joint names given by `isaac:nameOverride`, as in ROS messages, to those of the robot description.

    Names that are no override are output unchanged.
    """

    joint_names: Tokens = In(doc="names to translate, such as `jointNames` of ROS2SubscribeJointState")
    exec_out = ExecOut()
    joint_names_out: Tokens = Out(
        name="jointNames", doc="names in the robot description, for IsaacArticulationController"
    )
    robot_path_out: String = Out(name="robotPath", doc="path of the robot's prim")

    own_names: dict[str, str] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the names and output them before the first tick."""
        self.articulation = context.articulation(self.prim())
        published = context.joint_names(self.prim())
        self.own_names = dict(zip(published, self.articulation.joint_names, strict=True))
        self.compute()

    def compute(self) -> None:
        """Translate the names."""
        self.joint_names_out = tuple(self.own_names.get(name, name) for name in self.joint_names)
        self.robot_path_out = self.articulation.prim_path


_KINDS = {"position_command": "stiffness", "velocity_command": "damping", "effort_command": ""}
"""For each kind of command, the drive gain without which it has no effect."""
_EXAMPLES = {"stiffness": 1000, "damping": 50}
"""Example gains for a new drive."""
NO_JOINTS = "look for `enabled: false`, `keep_only_joints` and fixed joints in the robot file and its description"
"""Advice for a robot none of whose joints can move."""


@dataclass(frozen=True, slots=True)
class _Command:
    """The joints that one controller commands."""

    graph: Graph
    instance: Instance
    robot: Prim
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    chosen: bool
    """Whether the controller chooses joints, by name or index, rather than commanding all."""


@lint("W207")
def lint_joints_commanded_twice(context: LintContext) -> None:
    """Warn of joints that two graphs command; the graph that runs last wins."""
    first: dict[tuple[str, str, str], _Command] = {}
    for command in _commands(context):
        others: dict[int, tuple[_Command, dict[str, None]]] = {}
        for joint, kind in ((joint, kind) for joint in command.joints for kind in command.kinds):
            other = first.setdefault((command.robot.path, joint, kind), command)
            if other.graph is not command.graph:
                others.setdefault(id(other), (other, {}))[1][joint] = None
        for other, joints in others.values():
            context.findings.add(
                "W207",
                f"{command.graph.name}/{command.instance.id} and {other.graph.name}/{other.instance.id} "
                f"command the same joints of {command.robot.path}",
                command.instance.span,
                listing(joints, "joints"),
                "the later command of a tick wins; remove one, or give each its own jointNames",
                related=[(other.instance.span, "the other one")],
            )


@lint("W209")
def lint_commands_without_drive(context: LintContext) -> None:
    """Report commands that have no effect because the drives of their joints have no stiffness or damping.

    The report is an error if the inputs select one of these joints by name or index, and this joint has no drive at all and
    mimics no other joint; otherwise it is a warning.
    """
    for command in _commands(context):
        joints = {prim.facts["joint"]: prim.facts for prim in command.robot.descendants() if prim.kind == "joint"}
        drives = {joint: facts["drive"] for joint, facts in joints.items()}
        gains = [_KINDS[kind] for kind in command.kinds]
        actuators = command.robot.facts.get("actuators", {})
        named = [actuators.get(name) or name for name in command.joints]
        known = [joint for joint in named if joint in joints]  # others are reported by the dry setup
        idle = [j for j in known if not any(not gain or getattr(drives[j], gain, 0.0) for gain in gains)]
        if not (idle and gains):
            continue
        node, robot = command.instance, command.robot.path
        passive = {joint for joint, facts in joints.items() if facts["drive"] is None and not facts["leader"]}
        free = [joint for joint in idle if command.chosen and joint in passive]
        if free:
            message = f"{node.id} sets targets of joints of {robot} that move freely: they have no drive"
            drive = ", ".join(f"{gain}: {_EXAMPLES[gain]}" for gain in _EXAMPLES if gain in gains or gain == "damping")
            way = f"write `{free[0]}: {{drive: {{{drive}}}}}` below `joints:` of the robot file, or command efforts"
            context.findings.add("G310", message, node.span, listing(free, "joints"), way, related=node.entry.via)
        else:
            message = f"{node.id} commands joints of {robot} that have no drive for it: nothing moves"
            way = f"give them a drive with {' or '.join(gains)} below `joints:` of the robot file, or command efforts"
            context.findings.add("W209", message, node.span, listing(idle, "joints"), way, related=node.entry.via)


@lint("W211")
def lint_robots_without_joints(context: LintContext) -> None:
    """Warn of nodes that command a robot none of whose joints can move."""
    for command in _commands(context):
        if not command.joints:
            message = f"{command.instance.id} commands the joints of {command.robot.path}, none of which moves"
            context.findings.add("W211", message, command.instance.span, NO_JOINTS, related=command.instance.entry.via)


def _commands(context: LintContext) -> Iterator[_Command]:
    """Yield the wired controllers whose robot and joints are known before the run."""
    for graph, instance, node in context.nodes(IsaacArticulationController):
        index, wires = instance.index, graph.data_wires
        wired = {wire.target_field for wire in wires if wire.target == index}
        if index not in graph.plan.order or ({"joint_names", "joint_indices"} & wired and not node.joint_names):
            continue
        robot = robot_of(context, node)
        if robot is None:
            continue
        joints: tuple[str, ...] = robot.facts.get("joints", ())
        try:
            chosen = node.joint_names or tuple(joints[number] for number in node.joint_indices) or joints
        except IndexError:  # reported by the dry setup
            continue
        kinds = tuple(kind for kind in _KINDS if kind in wired or len(getattr(node, kind)))
        by_choice = bool(node.joint_names or len(node.joint_indices))
        yield _Command(graph, instance, robot, tuple(chosen), kinds, by_choice)


def robot_of(context: LintContext, node: RobotNode) -> Prim | None:
    """Return the robot of a node; None if the node's inputs name no robot, which `check` reports when it sets up the node."""
    try:
        return context.stage.stands_for_robot(context.stage.find(node.prim()))
    except GraphError:
        return None
