"""Nodes that read and command the joints of a robot (`isaacsim.core.nodes`), and lints of their commands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from graphengine.compiler.lint_registry import lint
from graphengine.devices.backend import follower_warnings
from graphengine.devices.motion import Articulation, JointSelection
from graphengine.format.errors import BadValueError, GraphError, JointError
from graphengine.format.wording import listing
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out
from graphengine.node.types import Double3s, Doubles, Ints, String, Target, Tokens
from graphengine.nodes.known_inputs import known_inputs
from graphengine.nodes.touched import drives_of

if TYPE_CHECKING:
    from graphengine.compiler.graph import Graph, Instance
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.devices.stage import Prim


class RobotNode(Node):
    """Base of nodes that need a robot, selected by the target `targetPrim` or by the path in `robotPath`."""

    exec_in = ExecIn()
    target_prim: Target = In(required="robot", setup=True, doc="the robot's prim, base link or articulation root")
    robot_path: String = In(default="", required="robot", setup=True, doc="path of the robot; overrides `targetPrim`")

    articulation: Articulation = Bound()

    def prim(self) -> str:
        """Return `robotPath`, or the path of `targetPrim` if `robotPath` is empty.

        Raises:
            BadValueError: both inputs are empty.
        """
        if not (self.robot_path or self.target_prim):
            legal = "the prim, base link or articulation root of a robot"
            raise BadValueError("targetPrim, robotPath", self.target_prim, legal)
        return self.robot_path or self.target_prim[0]


class SelectedJointsNode(RobotNode):
    """Base of nodes that read or command joints of a robot; `jointNames` or `jointIndices` selects the joints."""

    joint_names: Tokens = In(doc="names of the joints to use, in this order; if empty, `jointIndices` selects them")
    joint_indices: Ints = In(
        ge=0, doc="indices of the joints to use, if `jointNames` is empty; if both are empty, all joints"
    )

    selection: JointSelection = Bound()
    selected: tuple[object, object] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the robot and the joints that the inputs select at the start."""
        self.articulation = context.articulation(self.prim())
        self.select()

    def select(self) -> JointSelection:
        """Look up the joints that the inputs select, store the selection for `joints`, and return it."""
        self.selection = self.articulation.select(self.joint_names, self.joint_indices.tolist())
        self.selected = (self.joint_names, self.joint_indices)
        return self.selection

    def joints(self) -> JointSelection:
        """Return the joints that the inputs select; look them up only if an input has changed.

        Raises:
            BadValueError: a name in `jointNames` is unknown, or an index in `jointIndices` is out of range.
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
    """Sets the position, velocity and effort targets of joints. A target acts from the next physics step until it is set again.

    A command to a mimic joint logs a warning. If the mimic joint has no drive, the command has no effect. If it has a drive, the
    drive works against the joint that is mimicked.
    """

    position_command: Doubles = In(
        unit="rad, m", doc="position targets, one per selected joint; NaN keeps a target, an empty array all targets"
    )
    velocity_command: Doubles = In(
        unit="rad/s, m/s",
        doc="velocity targets, one per selected joint; NaN keeps a target, an empty array all targets",
    )
    effort_command: Doubles = In(
        unit="N m, N", doc="effort targets, one per selected joint; NaN keeps a target, an empty array all targets"
    )

    logger: Context = Bound()

    def setup(self, context: Context) -> None:
        """Look up the robot and the joints that the inputs select at the start."""
        self.logger = context
        super().setup(context)

    def select(self) -> JointSelection:
        """Look up the joints that the inputs select, and warn of joints selected by name or index that mimic other joints."""
        selection = super().select()
        chosen = set(selection.names) if self.joint_names or len(self.joint_indices) else ()
        for text in follower_warnings(self.articulation, chosen):
            self.logger.log("warning", text)
        return selection

    def compute(self) -> None:
        """Set the targets of the selected joints. On an error, no target changes.

        Raises:
            BadValueError: a joint is unknown, a command does not have one number per joint, or a number is infinite or too large.
        """
        selection = self.joints()
        commands = self.position_command.tolist(), self.velocity_command.tolist(), self.effort_command.tolist()
        joints = len(selection.names)
        for name, command in zip(("positionCommand", "velocityCommand", "effortCommand"), commands, strict=True):
            if len(command) not in (0, joints):
                robot = self.articulation.prim_path
                legal = f"such that {name} has one number for each of {joints} joints of {robot}"
                raise BadValueError(f"{name}, jointNames, jointIndices", command, legal)
        position, velocity, effort = commands
        selection.command(position or None, velocity or None, effort or None)

    def writes(self) -> Iterable[str]:
        """Return the resource key of the robot's drive targets."""
        return (drives_of(self.prim()),) if self.robot_path or self.target_prim else ()


class IsaacArticulationState(SelectedJointsNode, type="isaacsim.core.nodes.IsaacArticulationState"):
    """Reads the positions, velocities and efforts of the selected joints. All outputs list the joints in the same order.

    The computation of `measuredJointForces` and `measuredJointTorques` takes longer than a physics step, so the node computes
    them only if one of the two is wired.
    """

    joint_positions: Doubles = Out(unit="rad, m")
    joint_velocities: Doubles = Out(unit="rad/s, m/s")
    measured_joint_efforts: Doubles = Out(unit="N m, N", doc="effort of each joint's drive plus commanded effort")
    measured_joint_forces: Double3s = Out(
        unit="N", doc="for each joint, force of the parent link on the child link, in the frame of the child link"
    )
    measured_joint_torques: Double3s = Out(
        unit="N m",
        doc="for each joint, torque of the parent link on the child link about the origin of the child link, in the frame of "
        "the child link",
    )
    joint_names_out: Tokens = Out(name="jointNames", doc="names of the joints, in the order of the other outputs")

    has_wrenches: bool = Bound()

    def setup(self, context: Context) -> None:
        """Look up the robot and the selected joints, and check whether the output of forces or torques is wired."""
        super().setup(context)
        self.has_wrenches = context.wired("measured_joint_forces") or context.wired("measured_joint_torques")

    def compute(self) -> None:
        """Output the current state of the selected joints.

        Raises:
            BadValueError: a joint is unknown, or `jointNames` contains an actuator that moves several joints or none.
        """
        robot = self.articulation
        self.joint_names_out = names = self.joints().names
        if not set(names) <= set(robot.joint_names):
            legal = "names of joints, because only joints have a state"
            raise BadValueError("jointNames", self.joint_names, legal)
        chosen = [robot.joint_names.index(name) for name in names]
        self.joint_positions, self.joint_velocities = robot.positions()[chosen], robot.velocities()[chosen]
        self.measured_joint_efforts = robot.efforts()[chosen]
        if self.has_wrenches:
            forces, torques = robot.wrenches()
            self.measured_joint_forces, self.measured_joint_torques = forces[chosen], torques[chosen]


class IsaacJointNameResolver(RobotNode, type="isaacsim.core.nodes.IsaacJointNameResolver"):
    """Translates published joint names to the joint names in the robot description.

    The published name of a joint, used in ROS messages, is its `isaac:nameOverride`. A name that is not an override of any joint
    is output unchanged.
    """

    joint_names: Tokens = In(doc="names to translate, such as `jointNames` of ROS2SubscribeJointState")
    exec_out = ExecOut()
    joint_names_out: Tokens = Out(name="jointNames", doc="joint names for IsaacArticulationController")
    robot_path_out: String = Out(name="robotPath", doc="path of the robot's prim")

    own_names: dict[str, str] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the names of the robot's joints, and set the outputs before the first tick."""
        self.articulation = context.articulation(self.prim())
        published = context.joint_names(self.prim())
        self.own_names = dict(zip(published, self.articulation.joint_names, strict=True))
        self.compute()

    def compute(self) -> None:
        """Translate the input names, and output them with the path of the robot's prim."""
        self.joint_names_out = tuple(self.own_names.get(name, name) for name in self.joint_names)
        self.robot_path_out = self.articulation.prim_path


_KINDS = {"position_command": "stiffness", "velocity_command": "damping", "effort_command": ""}
"""A dict from each command input to the drive gain without which the command has no effect; empty if no drive is needed."""
_EXAMPLES = {"stiffness": 1000, "damping": 50}
"""Example values of drive gains, for messages that advise to add a drive."""
NO_JOINTS = "look for `enabled: false`, `keep_only_joints` and fixed joints in the robot file and its description"
"""Message text: the remedy for a robot that has no movable joints."""


@dataclass(frozen=True, slots=True)
class _Command:
    """One IsaacArticulationController of a graph, with the joints that it commands."""

    graph: Graph
    instance: Instance
    robot: Prim
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    chosen: bool
    """Whether the inputs of the controller select joints by name or index; false if it commands all joints."""


@lint("W207")
def lint_joints_commanded_twice(context: LintContext) -> None:
    """Warn about joints that get the same kind of command from two graphs. The command of the graph that runs last wins."""
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
                "the later command of a tick wins; remove one node, or give each node its own jointNames",
                related=[(other.instance.span, "the other one")],
            )


@lint("W209")
def lint_commands_without_drive(context: LintContext) -> None:
    """Report controllers whose commands have no effect on some joints, because the drives of these joints lack the needed gain.

    Position commands need a drive with stiffness, velocity commands a drive with damping. The finding is an error if the inputs
    select a joint by name or index that has no drive and mimics no other joint. Otherwise the finding is a warning.
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
            message = f"{node.id} sets targets of joints of {robot}, but these joints have no drive and move freely"
            drive = ", ".join(f"{gain}: {_EXAMPLES[gain]}" for gain in _EXAMPLES if gain in gains or gain == "damping")
            way = f"write `{free[0]}: {{drive: {{{drive}}}}}` below `joints:` of the robot file, or command efforts"
            context.findings.add("G310", message, node.span, listing(free, "joints"), way, related=node.entry.via)
        else:
            message = f"{node.id} commands joints of {robot} that have no drive for this kind of command: nothing moves"
            way = f"give these joints a drive with {' or '.join(gains)} below `joints:` of the robot file, or command efforts"
            context.findings.add("W209", message, node.span, listing(idle, "joints"), way, related=node.entry.via)


@lint("W214")
def lint_velocities_held_by_stiffness(context: LintContext) -> None:
    """Warn about velocity commands to joints whose drives have stiffness, unless a controller also commands their positions.

    In equilibrium, stiffness x deviation = damping x velocity: the joint stops damping / stiffness x velocity from its position
    set point.
    """
    commands = list(_commands(context))
    placed = {(c.robot.path, joint) for c in commands if "position_command" in c.kinds for joint in c.joints}
    for command in commands:
        node, robot, rests = command.instance, command.robot, dict[str, float]()
        actuators = robot.facts.get("actuators", {})
        chosen = {actuators.get(name) or name for name in command.joints if (robot.path, name) not in placed}
        for prim in robot.descendants() if "velocity_command" in command.kinds else ():
            drive = prim.facts["drive"] if prim.kind == "joint" and prim.facts["joint"] in chosen else None
            if drive is not None and drive.stiffness and drive.damping:  # W209 reports a drive without damping
                rests[prim.facts["joint"]] = drive.damping / drive.stiffness
        if not rests:
            continue
        joint, rest = next(iter(rests.items()))
        context.findings.add(
            "W214",
            f"{node.id} commands velocities of joints of {robot.path} whose drives have stiffness: the joints hold still",
            node.span,
            listing(rests, "joints"),
            f"at a command of 1, {joint} stops {rest:.3g} from its position set point (damping / stiffness, SI units)",
            "remove `stiffness` of their drives in the robot file, or set it to 0 in a robot file that `extends:` another",
            related=node.entry.via,
        )


@lint("W215")
def lint_lengths_of_commands(context: LintContext) -> None:
    """Warn about commands that do not have one number for each selected joint, if their length is known before the run."""
    for inputs, node in known_inputs(context, IsaacArticulationController):
        robot, names, indices = robot_of(context, node), inputs.length("joint_names"), inputs.length("joint_indices")
        if inputs.instance.index not in inputs.graph.plan.order or names is None or indices is None:
            continue
        joints: tuple[str, ...] | None = robot.facts.get("joints") if robot is not None else None
        selected = names or indices or (len(joints) if joints is not None else 0)
        by = "jointNames" if names else "jointIndices" if indices else f"joints of {robot.path if robot else ''}"
        for kind in _KINDS if selected else ():
            reason = f"one number for each joint is needed ({by}); otherwise the node sets no target"
            inputs.warn_of_length(kind, selected, reason, may_be_empty=True)


@lint("W211")
def lint_robots_without_joints(context: LintContext) -> None:
    """Warn about controllers that command a robot without movable joints."""
    for command in _commands(context):
        if not command.joints:
            node, robot = command.instance, command.robot.path
            message = f"{node.id} commands the joints of {robot}, but no joint of the robot can move"
            context.findings.add("W211", message, node.span, NO_JOINTS, related=node.entry.via)


def _commands(context: LintContext) -> Iterator[_Command]:
    """Yield all controllers that can be executed and whose robot and joints are known before the run."""
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
    """Return the robot that the inputs of a node select, or None if they select no robot; setting up the node then fails."""
    try:
        return context.stage.stands_for_robot(context.stage.find(node.prim()))
    except GraphError:
        return None
