"""Finds the first cause on the way from a robot's commands to its motion for which the robot stands still."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from graphengine.devices.motion import CommandKind
from graphengine.devices.stage import Prim
from graphengine.format.errors import JointError
from graphengine.format.wording import listing
from graphengine.messages.endpoints import EndpointClaim, Supply
from graphengine.runtime.session_core import SessionCore
from graphengine.runtime.why.command_route import COMMANDS, CommandRoute, is_nonzero, routes_to
from graphengine.runtime.why.joint_motion import CLOSE, JointMotion, RobotMotion, read_motion

SILENT = 1.0
"""Simulation time without messages after which a publisher counts as silent, s."""
GAINS: Mapping[CommandKind, str] = {"position": "stiffness", "velocity": "damping"}
"""Gain of a drive that commands of each kind need."""
SLOW = 0.05
"""Share of a velocity target below which a joint counts as standing."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why a robot stands still, or that it moves.

    Attributes:
        sentence: the first cause on the way from the commands to the wheels.
        evidence: what each stage of this way does: topics, values in graphs, joints, contacts.
    """

    sentence: str
    evidence: tuple[str, ...]

    def __str__(self) -> str:
        return "\n  ".join((self.sentence, *self.evidence))


def explain(session: SessionCore, robot: Prim, *, paused_counts: bool = True) -> Explanation:
    """Explain why a robot stands still; the state of the session does not change.

    Args:
        session: session of the robot.
        robot: prim of the robot.
        paused_counts: whether a paused session is the cause; false for a program that runs single ticks itself.
    """
    case = _Case(session, robot, paused_counts)
    causes: Sequence[Callable[[_Case], str]] = (
        _session_rests,
        _robot_moves,
        _no_joints,
        _no_commands,
        _setup_failed,
        _commands_missing,
        _commands_lost_in_graph,
        _no_drive,
        _held_by_stiffness,
        _command_limited,
        _blocked,
        _wheels_free,
        _joints_stand,
    )
    sentence = next(filter(None, (cause(case) for cause in causes)), "")
    return Explanation(sentence or f"{case.name} stands where its commands put it", tuple(_evidence(case)))


@dataclass(frozen=True)
class _Case:
    session: SessionCore
    robot: Prim
    paused_counts: bool

    @property
    def name(self) -> str:
        return self.robot.entity_name

    @cached_property
    def motion(self) -> RobotMotion:
        return read_motion(self.session.services.world, self.robot)

    @cached_property
    def routes(self) -> list[CommandRoute]:
        return routes_to(self.session.graphs, self.robot)

    @cached_property
    def commanded(self) -> list[JointMotion]:
        return [joint for joint in self.motion.joints if joint.is_commanded]

    @cached_property
    def supplies(self) -> list[tuple[CommandRoute, EndpointClaim, Supply]]:
        services = self.session.services
        pairs = [(route, claim) for route in self.routes for claim in route.endpoints(services.claims)]
        return [(route, claim, services.network.supply(claim)) for route, claim in pairs]

    @cached_property
    def clamped(self) -> list[tuple[str, int]]:
        counts = self.session.services.world.clamped_commands.items()
        return [(text, times) for text, times in counts if f" of {self.robot.path}/" in text]

    def seconds(self, ticks: int) -> float:
        return ticks * self.session.clock.delta


def _session_rests(case: _Case) -> str:
    session = case.session
    if session.state == "failed":
        return "the session failed: reset it to continue"
    if session.clock.frame == 0:
        return f"no tick has run yet: the simulation is {session.state}"
    if session.state != "playing" and case.paused_counts:
        return f"the simulation is {session.state}: `play` or `step` continues it"
    return ""


def _robot_moves(case: _Case) -> str:
    motion = case.motion
    if motion.stands:
        return ""
    joints = [joint.name for joint in motion.joints if joint.moves and joint.name not in motion.wheels]
    parts = [f"its base at {motion.speed:.2g} m/s, turning at {motion.turn:.2g} rad/s"] if motion.base_moves else []
    return f"{case.name} moves: {'; '.join([*parts, *([listing(joints, 'joints')] if joints else [])])}"


def _no_joints(case: _Case) -> str:
    return "" if case.motion.joints else f"{case.name} has no movable joints"


def _no_commands(case: _Case) -> str:
    if case.routes or case.commanded:
        return ""
    return f"nothing commands the joints of {case.name}: no node that commands joints has it as target"


def _setup_failed(case: _Case) -> str:
    for route in case.routes:
        for instance in route.nodes:
            if route.run.executor.has_failed(instance.index):
                return f"{route.name(instance)} does not run: its setup failed, see the log"
    return ""


def _commands_missing(case: _Case) -> str:
    """Return the cause if no route has a command that moves joints and a subscription got nothing but silence or zeros."""
    if case.commanded or any(route.commands_motion() for route in case.routes):
        return ""
    texts = [text for route, claim, supply in case.supplies if (text := _missing(case, route, claim, supply))]
    return texts[0] if texts else ""


def _missing(case: _Case, route: CommandRoute, claim: EndpointClaim, supply: Supply) -> str:
    network = case.session.services.network
    source = next(instance for instance in route.nodes if route.path(instance) == claim.node)
    reader = route.name(source)
    if claim.topic in network.faults.acting:
        return f"a fault of {claim.topic} withholds its messages: `mend` ends it"
    if claim.direction == "serve":
        return f"no call of {claim.topic} is being executed"
    if supply.misfits and supply.silence is None:
        return supply.misfits[0].partition("\n")[0]
    if not supply.publishers and supply.silence is None:
        near = f"; {listing(supply.strays, 'but there is a publisher of')}" if supply.strays else ""
        return f"nobody publishes on {claim.topic}, from which {reader} takes its commands{near}"
    who = " and ".join(supply.publishers) or "its publisher, which has left,"
    if supply.silence is None:
        return f"{who} has not sent any message on {claim.topic} yet"
    since, timeout = case.seconds(supply.silence), route.value(source, "timeout") or math.inf
    if since > min(SILENT, timeout):
        ends = f", and {reader} stops after {timeout:g} s without messages" if timeout < since else ""
        return f"{who} has sent nothing on {claim.topic} for {since:.1f} s{ends}"
    outputs = {wire.source_field for wire in route.wires if wire.source == source.index}
    if not any(is_nonzero(route.value(source, field)) for field in outputs):
        return f"{who} commands to stand: the messages on {claim.topic} are zero"
    return ""


def _commands_lost_in_graph(case: _Case) -> str:
    if case.commanded:
        return ""
    for route in case.routes:
        stale = route.first_stale()
        if stale is not None:
            wire, idle = stale
            graph = route.run.executor.graph
            fires = [graph.source(firing) for firing in graph.exec_wires if firing.target == idle.index]
            ways = " or ".join(f"{node.id}.{port.name}" for node, port in fires)
            reason = f": {ways} does not fire" if ways else ""
            return f"{route.name(idle)} has not run since {route.port_text(*graph.source(wire))}{reason}"
        zero = None if route.commands_motion() else route.first_zero()
        if zero is not None:
            dropped = case.session.services.dropped
            if dropped is not None and route.path(zero) in dropped.ticks:
                return f"{route.name(zero)} drops bad values, in {dropped.ticks[route.path(zero)]} ticks so far"
            return f"{route.name(zero)} turns its command into zeros"
    return ""


def _no_drive(case: _Case) -> str:
    """Return the cause if a node commands joints without a drive for this kind of command."""
    articulation = case.session.services.world.articulation(case.robot)
    for route in case.routes:
        for port in route.commands():
            names = route.value(route.target, "joint_names") or ()
            kind = next(kind for kind, name in COMMANDS.items() if name == port.name)
            try:
                idle = articulation.select(names).undriven(kind) if kind in GAINS else ()
            except JointError as error:
                return f"{route.name(route.target)} drops its commands: {error}"
            if idle and len(idle) == len(names or articulation.joint_names):
                what = f"have no drive with {GAINS[kind]}, so {kind} commands have no effect; {listing(idle, 'joints')}"
                return f"the joints of {case.name} {what}"
    return ""


def _held_by_stiffness(case: _Case) -> str:
    held = [joint for joint in case.commanded if joint.stiffness and _falls_short(joint)]
    if not held:
        return ""
    joint = held[0]
    return (
        f"the drives of {case.name} hold their positions: {joint.name} has a stiffness of {joint.stiffness:.4g}, against which "
        "its velocity target has no effect; set the stiffness to 0"
    )


def _command_limited(case: _Case) -> str:
    """Return the cause if the joints follow their targets, and a limit has made these targets small."""
    turning = [joint for joint in case.commanded if joint.target_velocity]
    if any(_falls_short(joint) for joint in turning):
        return ""
    for route in case.routes:
        for instance, limit, port in route.limits():
            given = route.port_text(instance, port)
            return f"{route.port_text(instance, limit)} limits the command to almost nothing: {given}"
    if case.commanded or any(joint.at_limit for joint in case.motion.joints):
        return next((f"a limit of {case.name} clamps its commands: {text}" for text, _ in case.clamped), "")
    return ""


def _falls_short(joint: JointMotion) -> bool:
    return bool(joint.target_velocity) and abs(joint.velocity) < SLOW * abs(joint.target_velocity or 0.0)


def _blocked(case: _Case) -> str:
    if not case.commanded:
        return ""
    if case.motion.obstacles:
        name, force = max(case.motion.obstacles.items(), key=lambda item: item[1])
        return f"{case.name} is stuck: it pushes against {name} with {force:.3g} N"
    entities = case.session.services.world.entities
    x, y, _ = entities.state(case.name).position
    near = entities.clearance(case.name, (x, y), CLOSE) if case.motion.wheels else {}
    return f"{case.name} is stuck: it bounces off {next(iter(near))}" if near else ""


def _wheels_free(case: _Case) -> str:
    turning = [joint for joint in case.motion.joints if joint.name in case.motion.wheels and joint.moves]
    if not turning:
        return ""
    names = listing([joint.name for joint in turning], "wheels")
    if not case.motion.supports:
        return f"the wheels of {case.name} turn in the air: none of them touches anything; {names}"
    return f"the wheels of {case.name} slip: they turn, but the base stands; {names}"


def _joints_stand(case: _Case) -> str:
    for joint in case.commanded:
        if math.isfinite(joint.max_effort) and abs(joint.effort) > 0.95 * joint.max_effort:
            return f"the drive of {joint.name} is too weak: it gives its largest effort of {joint.max_effort:.4g}"
        if joint.at_limit:
            return f"{joint.name} is at the end of its range, {joint.position:.4g}"
    return ""


def _evidence(case: _Case) -> Iterator[str]:
    session = case.session
    for _, claim, supply in case.supplies:
        silence = "never" if supply.silence is None else f"{case.seconds(supply.silence):.2f} s ago"
        who = ", ".join(supply.publishers) or "nobody"
        yield f"{claim.topic}: published by {who}; messages received: {supply.messages}, the last one {silence}"
        yield from supply.misfits
    for route in case.routes:
        yield from route.values()
    dropped = session.services.dropped.ticks if session.services.dropped is not None else {}
    for path, ticks in dropped.items():
        if any(path == route.path(instance) for route in case.routes for instance in route.nodes):
            yield f"{path} dropped bad values in {ticks} ticks"
    yield from (f"clamped {times} times: {text}" for text, times in case.clamped)
    yield from map(str, case.motion.joints[:12])
    for name, force in case.motion.obstacles.items():
        yield f"pushes against {name} with {force:.3g} N"
    if case.motion.wheels:
        yield f"contact points of the wheels: {case.motion.supports}"
    if session.late_ticks:
        yield f"ticks that ended late: {session.late_ticks}"
