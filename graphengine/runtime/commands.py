"""The commands of a session, one class each: arguments with their units, code, and whether recordings contain the command.

`graphrun ctl`, the Python API and replays give a name and JSON arguments, which `parse` reads; simulation_interfaces and the
keyboard of a run create the objects directly. Replays accept only commands that recordings contain.
"""

from __future__ import annotations

import contextlib
import json
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from graphengine.devices import entity as entities
from graphengine.devices.rotation import Vector3, from_orientation
from graphengine.devices.stage import Prim
from graphengine.format import document as documents
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import StateError, UsageError
from graphengine.format.spec import Orientation, Positive, RobotUse, Spec, Vector
from graphengine.format.spec_reader import validate
from graphengine.format.wording import shown, unknown
from graphengine.messages.names import join_namespaces
from graphengine.node.mailbox import find_impulses
from graphengine.runtime.addresses import find_ports, find_variable_at
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.session_core import SessionCore
from graphengine.runtime.ticker import SCOPES, ResetScope

MAX_TICKS = 10_000_000

RATES: Mapping[object, float | None] = MappingProxyType({"realtime": 1.0, "max": None})


def _several(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


def _pace(value: Any) -> Any:
    return RATES.get(value, value) if isinstance(value, str) else value


EntityName = Annotated[str, Field(min_length=1, max_length=1000)]
Scope = Literal["time", "state", "spawned", "all"]


class Command(Spec):
    """A command that a session executes between two ticks; its fields are the arguments, named as in JSON."""

    recorded: ClassVar[bool] = False
    """Whether the command affects the simulation; only such commands are recorded and accepted by replays."""
    admitted: ClassVar[bool] = False
    """Whether the session refuses the command within a tick and after the session failed."""

    def apply(self, session: SessionCore) -> Any:
        """Execute the command between two ticks; return a result that can be written as JSON."""
        if self.admitted:
            session.admit()
        return self._apply(session)

    @abstractmethod
    def _apply(self, session: SessionCore) -> Any: ...


class _Change(Command):
    """Base class of the commands that change the world or nodes; executed ones are recorded."""

    recorded = True
    admitted = True

    def _record(self, session: SessionCore, **arguments: Any) -> None:
        """Record the executed command with arguments that do not depend on the session's state."""
        session.note(type(self).__name__.lower(), arguments)


class Play(Command):
    """Start or resume the simulation; after a stop, it starts at time 0."""

    def _apply(self, session: SessionCore) -> None:
        session.play()


class Pause(Command):
    """Pause the simulation until `play`, and cancel single ticks that have not run yet."""

    def _apply(self, session: SessionCore) -> None:
        if session.state == "stopped":
            raise StateError("a stopped session cannot pause; use play or step")
        session.pause()


class Stop(Command):
    """Return to time 0 and the initial state, and wait for `play` or `step`."""

    recorded = True

    def _apply(self, session: SessionCore) -> None:
        session.stop()


class Step(Command):
    """Run single ticks of a paused or stopped session; the command completes after the last tick."""

    ticks: int = Field(default=1, ge=1, le=MAX_TICKS)

    def _apply(self, session: SessionCore) -> None:
        session.advance(self.ticks)


class Reset(Command):
    """Reset the time, the state of the world, the spawned robots, or all three; then play or pause as before."""

    recorded = True

    scope: Annotated[tuple[Scope, ...], Field(strict=False, min_length=1), BeforeValidator(_several)] = ("all",)
    seed: int | None = None
    """New seed of all random generators; requires a reset of the time. None keeps the seed."""

    def _apply(self, session: SessionCore) -> None:
        scopes: list[ResetScope] = [scope for scope in SCOPES if scope in self.scope or "all" in self.scope]
        session.reset(*scopes, seed=self.seed)


class Rate(Command):
    """Set the speed of simulation time: a factor of real time, or as fast as possible."""

    factor: Annotated[Annotated[float, Field(ge=SLOWEST)] | None, BeforeValidator(_pace)] = Field(
        description="A factor of real time, or `realtime`, or `max`."
    )

    def _apply(self, session: SessionCore) -> None:
        session.pace = self.factor


class Spawn(_Change):
    """Add a robot to the scene; `use` has the keys of a robot in a scene file."""

    name: EntityName
    use: RobotUse

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        session.roster.add(self.name, self.use)
        self._record(session, name=self.name, use=self.use.model_dump(mode="json"))
        return _overlaps(session, self.name)


class Delete(_Change):
    """Remove a robot, its graphs and its topics."""

    name: EntityName

    def _apply(self, session: SessionCore) -> None:
        session.roster.remove(self.name)
        self._record(session, name=self.name)


class Move(_Change):
    """Move a robot or an object of the world. Joints keep their state; the velocity of the body becomes 0 unless given."""

    entity: EntityName
    position: Annotated[tuple[float, ...], Field(strict=False)] | None = None
    """Position of the robot's base link, or of the object, in the world, m; x and y alone keep the height."""
    orientation: Orientation | None = None
    linear: Vector | None = None
    """Linear velocity in the world, m/s."""
    angular: Vector | None = None
    """Angular velocity about the axes of the world, rad/s."""

    @model_validator(mode="after")
    def _something(self) -> Move:
        given = (self.position, self.orientation, self.linear, self.angular)
        if not any(value is not None for value in given):
            raise ValueError("give a position, an orientation, or a velocity")
        if self.position is not None and len(self.position) not in (2, 3):
            raise ValueError(f"a position is [x, y] or [x, y, z], not {len(self.position)} numbers")
        return self

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        position, turned = self._place(session), self.orientation
        # A quaternion as it was given, to the last bit, so that a replay does the same.
        orientation = (turned.quaternion_xyzw or from_orientation(turned)) if turned is not None else None
        to = entities.Move(position, orientation, self.linear, self.angular)
        session.services.world.entities.place(self.entity, to)
        turn = {"quaternion_xyzw": orientation} if orientation is not None else None
        where = {"position": position, "orientation": turn, "linear": self.linear, "angular": self.angular}
        self._record(session, entity=self.entity, **where)
        return _overlaps(session, self.entity)

    def _place(self, session: SessionCore) -> Vector3 | None:
        if self.position is None:
            return None
        x, y, *height = self.position
        return x, y, height[0] if height else session.services.world.entities.state(self.entity).position[2]


def _overlaps(session: SessionCore, name: str) -> dict[str, Any]:
    """Return the result of placing an entity: a warning if it overlaps others, which is also logged."""
    text = entities.warning(name, session.services.world.entities.overlaps(name))
    if text:
        session.services.log("warning", "", text)
    return {"warnings": [text] if text else []}


class Push(_Change):
    """Apply a force, or an impulse spread over a duration, to a robot or an object, starting with the next physics step."""

    entity: EntityName
    force: Vector | None = None
    """Force in the world, N."""
    impulse: Vector | None = None
    """Impulse in the world, N s."""
    duration: Positive | None = None
    """Duration of the force or impulse in simulation time, s; required for a force, by default one tick for an impulse."""
    at: Vector | None = None
    """Point of application in the world, m; by default the centre of mass."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Push:
        if (self.force is None) == (self.impulse is None):
            raise ValueError("give either a force (N) or an impulse (N s)")
        if self.force is not None and self.duration is None:
            raise ValueError("a force needs a duration (s)")
        return self

    def _apply(self, session: SessionCore) -> None:
        duration = self.duration or session.clock.delta
        x, y, z = self.force or self.impulse or (0.0, 0.0, 0.0)
        force = (x, y, z) if self.force is not None else (x / duration, y / duration, z / duration)
        session.services.world.entities.push(self.entity, force, duration, self.at)
        self._record(session, entity=self.entity, force=force, duration=duration, at=self.at)


class Set(_Change):
    """Set unwired inputs to a value, which they keep after `stop` and `reset`. If an error occurs, no input changes."""

    address: EntityName
    """`[robot/][graph/]Node.port`, globs allowed."""
    value: Any
    """The value, written as in a graph file."""

    def _apply(self, session: SessionCore) -> None:
        ports = find_ports(session.graphs, self.address, ("inputs",))
        changes = [(port, port.convert(self.value)) for port in ports]
        with contextlib.ExitStack() as undoing:
            for port, converted in changes:
                undo = partial(port.put, port.value)
                port.put(converted)
                undoing.callback(undo)
            undoing.pop_all()
        self._record(session, address=self.address, value=self.value)


class Assign(_Change):
    """Set a variable of a graph, as WriteVariable does; a reset of the time returns it to its initial value."""

    graph: EntityName
    """`graph`, or `robot/graph`."""
    variable: EntityName
    """Name of the variable; `subgraph/name` in subgraphs."""
    value: Any
    """The value, written as in a graph file."""

    def _apply(self, session: SessionCore) -> None:
        find_variable_at(session.graphs, self.graph, self.variable).put(self.value)
        self._record(session, graph=self.graph, variable=self.variable, value=self.value)


class Impulse(_Change):
    """Fire an OnImpulseEvent in the next tick; several impulses before a tick count as one."""

    node: EntityName
    """Prim path of the node, or an end of it that no other OnImpulseEvent has."""

    def _apply(self, session: SessionCore) -> None:
        path, queue = find_impulses(session.services.queues, self.node)
        if not queue.waiting:
            queue.post()
        self._record(session, node=path)


class _Keys(_Change):
    keys: Annotated[
        tuple[EntityName, ...], Field(strict=False, min_length=1, max_length=100), BeforeValidator(_several)
    ]
    """Names of keys, as in OmniGraph."""


class Press(_Keys):
    """Press keys and hold them down, starting with the next tick."""

    def _apply(self, session: SessionCore) -> None:
        session.services.keys.press(self.keys)
        self._record(session, keys=list(self.keys))


class Release(_Keys):
    """Release keys; a key that was pressed since the last tick stays down for one tick."""

    def _apply(self, session: SessionCore) -> None:
        session.services.keys.release(self.keys)
        self._record(session, keys=list(self.keys))


class Reload(Command):
    """Read the files of the scene again and run the changed scene; after an error, nothing changes.

    Changed graphs are replaced, and nodes with the same name and type keep their state. A change of the world or of a robot
    restarts the session at time 0. The command reads only files of the scene. Recordings contain the changed files, and replays
    use them.
    """

    recorded = True

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        done = session.reload()
        return {"text": str(done), **asdict(done), "files": [str(path) for path in done.files]}


class Checkpoint(Command):
    """Save the whole state of the session, so that `restore` can return to it."""

    recorded = True

    name: Annotated[str, Field(max_length=1000)] = ""
    """Name of the checkpoint; by default a numbered one."""

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        made = session.checkpoint(self.name)
        session.hold(made)
        return {"name": made.name}


class Restore(Command):
    """Return to a checkpoint; messages that were already sent cannot be recalled."""

    recorded = True

    name: EntityName

    def _apply(self, session: SessionCore) -> None:
        kept = session.held.get(self.name)
        if kept is None:
            raise UsageError(unknown("checkpoint", self.name, session.held))
        session.hold(kept)
        session.restore(kept)


class State(Command):
    """Return the state of the session: its time, its rate, its robots and objects."""

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        robots = list(session.services.stage.prims("robot"))
        paths = {robot.path for robot in robots}
        dropped = session.services.dropped
        counts = {
            "dropped_values": dict(dropped.ticks) if dropped is not None else {},
            "clamped_commands": dict(session.services.world.clamped_commands),
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
            **{name: count for name, count in counts.items() if count},
            **({"findings": list(session.findings)} if session.findings else {}),
        }


def _robot(session: SessionCore, prim: Prim) -> dict[str, Any]:
    """Return name, namespace, position and orientation of a robot, and whether it was spawned."""
    state = session.services.world.entities.state(prim.entity_name)
    return {
        "name": prim.entity_name,
        "namespace": join_namespaces(session.services.stage.namespaces(prim.facts["base_link"])),
        "position": state.position,
        "orientation": state.orientation,
        "spawned": prim.entity_name in session.roster.spawned,
    }


class Topics(Command):
    """Return the message type of each topic that the session publishes or reads, by topic name."""

    def _apply(self, session: SessionCore) -> dict[str, dict[str, str]]:
        claims = sorted(session.services.claims, key=lambda claim: claim.topic)
        return {"topics": {claim.topic: claim.message_type for claim in claims if not claim.is_service}}


class View(Command):
    """Return the address of the session's web page; start the page again if its process has ended."""

    def _apply(self, session: SessionCore) -> dict[str, str]:
        if session.open_page is None:
            raise StateError("the run has no page; start it with --view")
        return {"page": session.open_page()}


class Quit(Command):
    """End the run, as Ctrl-C does."""

    def _apply(self, session: SessionCore) -> None:
        session.interrupt()


_KINDS: tuple[type[Command], ...] = (Play, Pause, Step, Stop, Reset, Rate, Spawn, Delete, Move, Push, Set, Assign)
_KINDS += (Impulse, Press, Release, Reload, Checkpoint, Restore, State, Topics, View, Quit)

COMMANDS: Mapping[str, type[Command]] = MappingProxyType({kind.__name__.lower(): kind for kind in _KINDS})


def parse(name: str, arguments: Any = None) -> Command:
    """Create a command from its name and arguments.

    Raises:
        UsageError: the name is unknown, or the arguments are invalid.
    """
    if name not in COMMANDS:
        raise UsageError(unknown("command", str(name)[:40], COMMANDS))
    given = {} if arguments is None else arguments
    if not isinstance(given, dict):
        raise UsageError(f"{name}: the arguments must be a mapping, not {shown(given)}")
    findings = Findings()
    document = documents.parse(json.dumps(given, default=str), name, findings)
    command = validate(COMMANDS[name], document, given, findings) if document is not None else None
    if command is None:
        wrong = findings.errors[0]
        raise UsageError("\n  ".join([f"{name}: {wrong.message.removeprefix('file: ')}", *wrong.help]))
    return command
