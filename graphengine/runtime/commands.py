"""The commands of a session, one class for each command; the fields of a class are the arguments of the command.

`graphrun ctl`, the Python API and replays give `parse` the name of a command and the arguments as JSON types. The services of
simulation_interfaces and the keyboard of a run create objects of the classes directly.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from graphengine.devices.stage import Prim
from graphengine.format.errors import StateError, UsageError
from graphengine.format.spec_reader import read_given
from graphengine.format.wording import shown, unknown
from graphengine.messages.names import join_namespaces
from graphengine.node.mailbox import find_impulses
from graphengine.runtime.addresses import find_ports, find_variable_at
from graphengine.runtime.command import ChangeCommand, Command, EntityName, find_robot
from graphengine.runtime.edit_commands import Place, Redo, Save, Undo
from graphengine.runtime.entity_commands import Clearance, Delete, Move, Push, ResetRobot, Spawn
from graphengine.runtime.fault_commands import Fault, Mend
from graphengine.runtime.joint_command import JointCommand
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.session_core import SessionCore
from graphengine.runtime.ticker import SCOPES, ResetScope
from graphengine.runtime.why.explanation import explain

MAX_TICKS = 10_000_000
"""Maximum number of ticks of one `step`."""

RATES: Mapping[object, float | None] = MappingProxyType({"realtime": 1.0, "max": None})


def _several(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


def _pace(value: Any) -> Any:
    return RATES.get(value, value) if isinstance(value, str) else value


Scope = Literal["time", "state", "spawned", "all"]


class Play(Command):
    """Start or resume the simulation; after a stop, it starts at time 0."""

    def _apply(self, session: SessionCore) -> None:
        session.play()


class Pause(Command):
    """Pause the simulation until `play`, and cancel the single ticks of `step` that have not run yet."""

    def _apply(self, session: SessionCore) -> None:
        if session.state == "stopped":
            raise StateError("a stopped session cannot pause; use play or step")
        session.pause()


class Stop(Command):
    """Reset the simulation to time 0 and its initial state, and wait for `play` or `step`."""

    recorded = True

    def _apply(self, session: SessionCore) -> None:
        session.stop()


class Step(Command):
    """Run a number of single ticks in a paused or stopped session; the command is complete after the last tick."""

    ticks: int = Field(default=1, ge=1, le=MAX_TICKS)

    def _apply(self, session: SessionCore) -> None:
        session.advance(self.ticks)


class Reset(Command):
    """Reset the time, the state of the world, the spawned robots, or all three; the session then plays or pauses as before."""

    recorded = True

    scope: Annotated[tuple[Scope, ...], Field(strict=False, min_length=1), BeforeValidator(_several)] = ("all",)
    seed: int | None = None
    """New seed of all random generators, which requires the scope `time` or `all`; None: the seed stays."""

    def _apply(self, session: SessionCore) -> None:
        scopes: list[ResetScope] = [scope for scope in SCOPES if scope in self.scope or "all" in self.scope]
        session.reset(*scopes, seed=self.seed)


class Rate(Command):
    """Set the real-time factor of the simulation, or let it run as fast as possible."""

    factor: Annotated[Annotated[float, Field(ge=SLOWEST)] | None, BeforeValidator(_pace)] = Field(
        description="Real-time factor, or `realtime` (1), or `max` (as fast as possible)."
    )

    def _apply(self, session: SessionCore) -> None:
        session.pace = self.factor


class Set(ChangeCommand):
    """Set unwired inputs of nodes to a value; `stop` and `reset` keep the value. After an error, no input has changed."""

    address: EntityName
    """Address of the inputs, `[robot/][graph/]Node.port`; its parts may be globs."""
    value: Any
    """The value, written as in a graph file."""

    def _apply(self, session: SessionCore) -> None:
        ports = find_ports(session.graphs, self.address, ("inputs",))
        recorded = session.inbox.replays
        changes = [(port, port.convert(self.value, recorded=recorded)) for port in ports]
        with contextlib.ExitStack() as undoing:
            for port, converted in changes:
                undo = partial(port.put, port.value)
                port.put(converted)
                undoing.callback(undo)
            undoing.pop_all()
        self._record(session, address=self.address, value=self.value)


class Assign(ChangeCommand):
    """Set a variable of a graph, as a WriteVariable node does; `stop` and a reset of the time restore its initial value."""

    graph: EntityName
    """Name of the graph; `robot/graph` for a graph of a robot."""
    variable: EntityName
    """Name of the variable; `subgraph/name` for a variable in a subgraph."""
    value: Any
    """The value, written as in a graph file."""

    def _apply(self, session: SessionCore) -> None:
        find_variable_at(session.graphs, self.graph, self.variable).put(self.value)
        self._record(session, graph=self.graph, variable=self.variable, value=self.value)


class Impulse(ChangeCommand):
    """Fire an OnImpulseEvent node in the next tick; several impulses before the tick count as one."""

    node: EntityName
    """Prim path of the OnImpulseEvent node, or its last parts if they identify the node."""

    def _apply(self, session: SessionCore) -> None:
        path, queue = find_impulses(session.services.queues, self.node)
        if not queue.waiting:
            queue.post()
        self._record(session, node=path)


class _Keys(ChangeCommand):
    keys: Annotated[
        tuple[EntityName, ...], Field(strict=False, min_length=1, max_length=100), BeforeValidator(_several)
    ]
    """Names of the keys as in OmniGraph, such as `W` or `LeftShift`."""


class Press(_Keys):
    """Press keys from the next tick on, and hold them down until `release`."""

    def _apply(self, session: SessionCore) -> None:
        session.services.keys.press(self.keys)
        self._record(session, keys=list(self.keys))


class Release(_Keys):
    """Release keys; a key pressed since the last tick still counts as down in the next tick."""

    def _apply(self, session: SessionCore) -> None:
        session.services.keys.release(self.keys)
        self._record(session, keys=list(self.keys))


class Reload(Command):
    """Read the files of the scene again and run the changed scene; after an error, the session continues unchanged.

    Changed graphs are replaced, and nodes with the same name and type keep their state. A change of the world or of a robot
    restarts the session at time 0. Recordings contain the changed files, and replays use these.
    """

    recorded = True

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        done = session.reload()
        return {"text": str(done), **asdict(done), "files": [str(path) for path in done.files]}


class Checkpoint(Command):
    """Save the whole state of the session, so that `restore` can return to it."""

    recorded = True

    name: Annotated[str, Field(max_length=1000)] = ""
    """Name of the checkpoint; default: a numbered name such as `checkpoint_1`."""

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        made = session.checkpoint(self.name)
        session.hold(made)
        return {"name": made.name}


class Restore(Command):
    """Restore the state of a checkpoint; messages that were already sent cannot be recalled."""

    recorded = True

    name: EntityName
    seed: int | None = None
    """New seed of all random generators; None restores their state too."""

    def _apply(self, session: SessionCore) -> None:
        kept = session.held.get(self.name)
        if kept is None:
            raise UsageError(unknown("checkpoint", self.name, session.held))
        session.hold(kept)
        session.restore(kept, self.seed)


class State(Command):
    """Return the state of the session: state, time, rate, robots, objects and problems."""

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        robots = list(session.services.stage.prims("robot"))
        paths = {robot.path for robot in robots}
        dropped = session.services.dropped
        problems = {
            "dropped_values": dict(dropped.ticks) if dropped is not None else {},
            "clamped_commands": dict(session.services.world.clamped_commands),
            "faults": [*session.services.world.faults.acting, *session.services.network.faults.acting],
            "findings": list(session.findings),
        }
        return {
            "state": session.state,
            "time": session.time,
            "tick": session.clock.frame,
            "tick_period": session.clock.delta,
            "rate": "max" if session.pace is None else session.pace,
            "robots": [_robot(session, robot) for robot in robots],
            "objects": [
                entity.name
                for entity in session.services.world.entities.all()
                if entity.kind == "object" and entity.prim_path not in paths
            ],
            **{name: found for name, found in problems.items() if found},
        }


def _robot(session: SessionCore, prim: Prim) -> dict[str, Any]:
    """Return name, namespace and pose in the world of a robot, and whether the robot was spawned, as JSON types."""
    state = session.services.world.entities.state(prim.entity_name)
    return {
        "name": prim.entity_name,
        "namespace": join_namespaces(session.services.stage.namespaces(prim.facts["base_link"])),
        "position": state.position,
        "orientation": state.orientation,
        "spawned": prim.entity_name in session.roster.spawned,
    }


class Topics(Command):
    """Return the message type of each topic that the session publishes or subscribes to, by topic name."""

    def _apply(self, session: SessionCore) -> dict[str, dict[str, str]]:
        claims = sorted(session.services.claims, key=lambda claim: claim.topic)
        return {"topics": {claim.topic: claim.message_type for claim in claims if not claim.is_service}}


class Why(Command):
    """Explain why a robot stands still: `sentence`, and `evidence` as a list of texts."""

    robot: EntityName
    paused_counts: bool = True
    """Whether a paused session is a cause; false for programs that run single ticks themselves."""

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        return asdict(explain(session, find_robot(session, self.robot), paused_counts=self.paused_counts))


class View(Command):
    """Return the URL of the session's web page, empty while the page starts; if the page's process has ended, start a new one.

    Attributes:
        waiting: whether an earlier command started the page; if its process has ended, the command then raises an error.
    """

    waiting: bool = False

    def _apply(self, session: SessionCore) -> dict[str, str]:
        if session.open_page is None:
            raise StateError("the run does not serve a web page; start the run with --view")
        return {"page": session.open_page(self.waiting)}


class Quit(Command):
    """End the run, as Ctrl-C in its terminal does."""

    def _apply(self, session: SessionCore) -> None:
        session.interrupt()


_KINDS: tuple[type[Command], ...] = (Play, Pause, Step, Stop, Reset, Rate, Spawn, Delete, Move, ResetRobot, Push)
_KINDS += (JointCommand, Set, Assign, Impulse, Press, Release, Reload, Checkpoint, Restore, State, Clearance)
_KINDS += (Save, Place, Undo, Redo, Fault, Mend, Topics, Why, View, Quit)

COMMANDS: Mapping[str, type[Command]] = MappingProxyType({kind.command_name(): kind for kind in _KINDS})


def parse(name: str, arguments: Any = None) -> Command:
    """Return the command with this name and these arguments.

    Args:
        name: name of the command in `COMMANDS`.
        arguments: a dict from argument names to JSON values; None: no arguments.

    Raises:
        UsageError: the name is unknown, or the arguments are invalid.
    """
    if name not in COMMANDS:
        raise UsageError(unknown("command", str(name)[:40], COMMANDS))
    given = {} if arguments is None else arguments
    if not isinstance(given, dict):
        raise UsageError(f"{name}: the arguments must be a mapping, not {shown(given)}")
    return read_given(COMMANDS[name], name, given)
