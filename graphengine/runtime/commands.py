"""What a session can be asked for between two ticks, by name and with arguments that JSON can say.

Those that change the simulation's course are what recordings hold, under the same names; the others only decide when ticks run.
"""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from graphengine.devices.poses import from_orientation
from graphengine.devices.sensor import Quaternion, Vector3
from graphengine.devices.stage import Prim
from graphengine.format import document as documents
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import StateError, UsageError
from graphengine.format.spec import Orientation, Positive, RobotUse, Spec, Vector
from graphengine.format.spec_reader import validate
from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages.names import join_namespaces
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.session import Session
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
    """One thing to do; its fields are its arguments."""

    def apply(self, session: Session) -> Any:
        """Do it, between two ticks; what JSON can say about what came of it."""
        return self._apply(session)

    @abstractmethod
    def _apply(self, session: Session) -> Any: ...


class Play(Command):
    """Let ticks run, from time 0 after a stop."""

    def _apply(self, session: Session) -> None:
        session.play()


class Pause(Command):
    """Hold the time where it is; single ticks that are under way end."""

    def _apply(self, session: Session) -> None:
        if session.state == "stopped":
            raise StateError("the session is stopped, at time 0; it can play, or do single ticks")
        session.pause()


class Stop(Command):
    """Everything as before the first tick, and no ticks until it plays again."""

    def _apply(self, session: Session) -> None:
        session.stop()


class Step(Command):
    """Run some ticks of a session that does not play; it is done when they ran."""

    ticks: int = Field(default=1, ge=1, le=MAX_TICKS)

    def _apply(self, session: Session) -> None:
        session.advance(self.ticks)


class Reset(Command):
    """Begin anew and go on as before: the time, the state of the world, without the robots that came, or all of it."""

    scope: Annotated[tuple[Scope, ...], Field(strict=False, min_length=1), BeforeValidator(_several)] = ("all",)

    def _apply(self, session: Session) -> None:
        scopes: list[ResetScope] = [scope for scope in SCOPES if scope in self.scope or "all" in self.scope]
        session.reset(*scopes)


class Rate(Command):
    """How fast simulation time passes: a factor of real time, or as fast as possible."""

    factor: Annotated[Annotated[float, Field(ge=SLOWEST)] | None, BeforeValidator(_pace)] = Field(
        description="A factor of real time, or `realtime`, or `max`."
    )

    def _apply(self, session: Session) -> None:
        session.pace = self.factor


class Spawn(Command):
    """Put a robot into the scene; `use` is what a scene file would say about it."""

    name: EntityName
    use: RobotUse

    def _apply(self, session: Session) -> dict[str, Any]:
        return _warned(session.spawn(self.name, self.use))


class Delete(Command):
    """Take a robot out of the scene, with its graphs and its topics."""

    name: EntityName

    def _apply(self, session: Session) -> None:
        session.remove(self.name)


class Move(Command):
    """Put a robot or an object of the world somewhere else; without a velocity it rests there."""

    entity: EntityName
    position: Annotated[tuple[float, ...], Field(strict=False)] | None = None
    """In the world, m; of two numbers, the height stays as it is."""
    orientation: Orientation | None = None
    linear: Vector | None = None
    angular: Vector | None = None

    @model_validator(mode="after")
    def _something(self) -> Move:
        given = (self.position, self.orientation, self.linear, self.angular)
        if not any(value is not None for value in given):
            raise ValueError("give a position, an orientation, or a velocity")
        if self.position is not None and len(self.position) not in (2, 3):
            raise ValueError(f"a position is x, y, and z if the height is another, not {len(self.position)} numbers")
        return self

    def _apply(self, session: Session) -> dict[str, Any]:
        orientation = _quaternion(self.orientation) if self.orientation is not None else None
        return _warned(session.place(self.entity, self._place(session), orientation, self.linear, self.angular))

    def _place(self, session: Session) -> Vector3 | None:
        if self.position is None:
            return None
        x, y, *height = self.position
        return x, y, height[0] if height else session.services.world.entities.state(self.entity).position[2]


def _warned(warning: str) -> dict[str, Any]:
    """What came of putting something somewhere, with what is to be known of it."""
    return {"warnings": [warning] if warning else []}


def _quaternion(orientation: Orientation) -> Quaternion:
    """A quaternion as it was given, to the last bit, so that what is recorded is what was done."""
    return orientation.quaternion_xyzw or from_orientation(orientation)


class Push(Command):
    """Let a force act on a robot or an object for a while: a force, N, or an impulse, N s, that is spread over the time."""

    entity: EntityName
    force: Vector | None = None
    impulse: Vector | None = None
    duration: Positive | None = None
    """In simulation time, s; one tick for an impulse without it."""
    at: Vector | None = None
    """Where in the world, m; at the centre of mass if not given."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Push:
        if (self.force is None) == (self.impulse is None):
            raise ValueError("give one of force, N, and impulse, N s")
        if self.force is not None and self.duration is None:
            raise ValueError("a force needs a duration, s")
        return self

    def _apply(self, session: Session) -> None:
        duration = self.duration or session.clock.delta
        x, y, z = self.force or self.impulse or (0.0, 0.0, 0.0)
        force = (x, y, z) if self.force is not None else (x / duration, y / duration, z / duration)
        session.push(self.entity, force, duration, self.at)


class Set(Command):
    """Give inputs that no wire feeds another value."""

    address: EntityName
    """`[robot/][graph/]Node.port`, globs allowed."""
    value: Any

    def _apply(self, session: Session) -> None:
        session.set_inputs(self.address, self.value)


class Impulse(Command):
    """Let an OnImpulseEvent fire in the next tick."""

    node: EntityName
    """Its prim path, or as much of the end as no other has."""

    def _apply(self, session: Session) -> None:
        session.impulse(self.node)


class _Keys(Command):
    keys: Annotated[
        tuple[EntityName, ...], Field(strict=False, min_length=1, max_length=100), BeforeValidator(_several)
    ]
    """By OmniGraph's names."""


class Press(_Keys):
    """Hold keys down from the next tick on."""

    def _apply(self, session: Session) -> None:
        session.press(*self.keys)


class Release(_Keys):
    """Let go of keys; one that was pressed since the last tick is down for one tick."""

    def _apply(self, session: Session) -> None:
        session.release(*self.keys)


class Checkpoint(Command):
    """Keep a copy of the whole state of the session, to which `restore` goes back."""

    name: Annotated[str, Field(max_length=1000)] = ""
    """By which it is known; numbered if not given."""

    def _apply(self, session: Session) -> dict[str, Any]:
        made = session.checkpoint(self.name)
        session.held[made.name] = made
        return {"name": made.name}


class Restore(Command):
    """Go back to a checkpoint; messages that have left the process are not taken back."""

    name: EntityName

    def _apply(self, session: Session) -> None:
        kept = session.held.get(self.name)
        if kept is None:
            hint = did_you_mean(self.name, session.held) or listing(session.held, "checkpoints")
            raise UsageError(f"no checkpoint {self.name!r}\n  {hint}")
        session.restore(kept)


class State(Command):
    """Tell how the session is."""

    def _apply(self, session: Session) -> dict[str, Any]:
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
        }


def _robot(session: Session, prim: Prim) -> dict[str, Any]:
    """A robot, the namespace that its topics are in, and where it is."""
    state = session.services.world.entities.state(prim.entity_name)
    return {
        "name": prim.entity_name,
        "namespace": join_namespaces(session.services.stage.namespaces(prim.facts["base_link"])),
        "position": state.position,
        "orientation": state.orientation,
        "spawned": prim.entity_name in session.spawned,
    }


class Quit(Command):
    """End the run, as Ctrl-C does."""

    def _apply(self, session: Session) -> None:
        session.interrupt()


_KINDS: tuple[type[Command], ...] = (Play, Pause, Step, Stop, Reset, Rate, Spawn, Delete, Move, Push, Set, Impulse)
_KINDS += (Press, Release, Checkpoint, Restore, State, Quit)

COMMANDS: Mapping[str, type[Command]] = MappingProxyType({kind.__name__.lower(): kind for kind in _KINDS})

RECORDED = frozenset({"stop", "reset", "spawn", "delete", "move", "push", "set", "impulse", "press", "release"})
RECORDED |= {"checkpoint", "restore"}
"""Those that change the simulation's course: another run that is asked for them before the same ticks is the same."""


def parse(name: str, arguments: Any = None) -> Command:
    """A command of its name and its arguments.

    Raises:
        UsageError: there is none of that name, or its arguments make no sense.
    """
    if name not in COMMANDS:
        hint = did_you_mean(str(name)[:40], COMMANDS) or listing(COMMANDS, "commands")
        raise UsageError(f"no command {str(name)[:40]!r}\n  {hint}")
    given = {} if arguments is None else arguments
    if not isinstance(given, dict):
        raise UsageError(f"{name}: its arguments are a mapping, not {shown(given)}")
    findings = Findings()
    document = documents.parse(json.dumps(given, default=str), name, findings)
    command = validate(COMMANDS[name], document, given, findings) if document is not None else None
    if command is None:
        wrong = findings.errors[0]
        raise UsageError("\n  ".join([f"{name}: {wrong.message.removeprefix('file: ')}", *wrong.help]))
    return command
