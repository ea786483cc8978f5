"""A running simulation: the tick, its pace, and what can be done between two ticks."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from graphengine.devices.entity import Move, warning
from graphengine.devices.sensor import Quaternion, Vector3
from graphengine.format.errors import StateError, TransportError, UnknownEntityError, UsageError
from graphengine.format.spec import RobotUse
from graphengine.node.clock import Clock
from graphengine.node.context.services import Services
from graphengine.node.mailbox import find_impulses
from graphengine.runtime.addresses import find_ports
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.inbox import Inbox, LiveInbox
from graphengine.runtime.pacer import Pacer
from graphengine.runtime.ticker import SCOPES, ResetScope, Ticker

if TYPE_CHECKING:
    from graphengine.runtime.desk import Desk

SessionState = Literal["stopped", "playing", "paused", "failed"]

IDLE = 0.25
"""Seconds between two looks at whether a run that is paused is to end, where no desk wakes it."""


class Roster:
    """The robots of a session, which a scene adds and removes; without a scene there are none."""

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the robots that came and are still there, oldest first."""
        return ()

    def add(self, name: str, use: RobotUse, running: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Put a robot into the scene; its graphs, set up.

        Raises:
            CheckError: with all that is wrong with it.
            GraphError: physics, rays or one of its nodes cannot begin. After an error of any kind all is as it was.
        """
        raise UsageError("a session without a scene has no place for robots")

    def own(self, name: str, graphs: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Which of the session's graphs are a robot's, which can be removed.

        Raises:
            UnknownEntityError: there is no such robot.
            UsageError: a graph that is not its own reads something of it.
        """
        raise UnknownEntityError("a session without a scene has no robots")

    def remove(self, name: str, own: Sequence[GraphRun]) -> None:
        """Take a robot away, with its graphs and topics."""
        raise NotImplementedError

    def save(self) -> Any:
        """Which robots are there."""

    def restore(self, saved: Any, running: Sequence[GraphRun]) -> Sequence[GraphRun]:
        """Put back the robots that were there, and take away the others; the graphs that run then, in their order.

        Raises:
            GraphError: a robot cannot be put back.
        """
        return running


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The whole state of a session."""

    name: str
    of: Ticker
    """Of the session."""
    robots: Any
    state: Any
    play: tuple[SessionState, str, bool]


class Session:
    """Owns world, network and graphs.

    One thread runs all of it, and no method is for any other but `interrupt`: who is in another leaves word at a desk. Within
    a tick a session refuses to step, to stop, and whatever else changes what there is.

    Args:
        services: what the nodes' contexts share.
        clock: of the ticks.
        step_clock: of the physics steps inside of a tick.
        graphs: in the order they run: the scene's, then each robot's.
        roster: who adds and removes robots; None where there is no scene.
    """

    def __init__(
        self,
        services: Services,
        clock: Clock,
        step_clock: Clock,
        graphs: Sequence[GraphRun],
        roster: Roster | None = None,
    ) -> None:
        self.services = services
        self.clock = clock
        self.step_clock = step_clock
        self.state: SessionState = "stopped"
        self.inbox: Inbox = LiveInbox()
        """Where what comes from outside is read, or was; to be exchanged before the first tick."""
        self.desk: Desk | None = None
        """Where others ask for what can be done; with one, a run goes on while it is paused or stopped."""
        self._roster = roster or Roster()
        self._until = 0
        self._pace: float | None = None
        self._pacer: Pacer | None = None
        self.interrupted = self._ended = False
        self._failure = ""
        self._checkpoints = 0
        self.held: dict[str, Checkpoint] = {}
        """Checkpoints that commands asked for, by name."""
        self._ticker = Ticker(services, clock, step_clock, graphs)

    @property
    def graphs(self) -> Sequence[GraphRun]:
        """In the order they run: the scene's, then each robot's."""
        return self._ticker.graphs

    @property
    def ticks(self) -> int:
        """Ticks that ran; those before a stop count too."""
        return self._ticker.count

    @property
    def time(self) -> float:
        """Seconds of simulation since play."""
        return self.clock.time

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the robots that came while the session ran and are still there, oldest first."""
        return self._roster.spawned

    def spawn(self, name: str, use: RobotUse) -> str:
        """Put a robot into the scene, between two ticks: time goes on, what others do and publish stays as it is.

        Its graphs run after those that are there. On `stop` it goes back to where it was put.

        Args:
            name: in the scene, as a scene file's key would be.
            use: as in a scene file; one robot.

        Returns:
            A warning, where it is in what stands there; else nothing.

        Raises:
            CheckError: with all that is wrong with it.
            GraphError: physics, rays or one of its nodes cannot begin. After an error of any kind all is as it was.
            UsageError: the session has no scene, or is within a tick.
        """
        self.admit()
        self._ticker.take([*self.graphs, *self._roster.add(name, use, self.graphs)])
        self.inbox.command("spawn", {"name": name, "use": use.model_dump(mode="json")})
        return self._warn_of_overlaps(name)

    def remove(self, name: str) -> None:
        """Take a robot, its graphs and its topics away, between two ticks; time and the others' state stay.

        Raises:
            UnknownEntityError: there is no such robot.
            UsageError: a graph that is not its own reads something of it, or within a tick.
        """
        self.admit()
        own = self._roster.own(name, self.graphs)
        self._ticker.tell("at_close", own)
        self._roster.remove(name, own)
        gone = {id(run) for run in own}
        self._ticker.take([run for run in self.graphs if id(run) not in gone])
        self.inbox.command("delete", {"name": name})

    def place(
        self,
        name: str,
        position: Vector3 | None = None,
        orientation: Quaternion | None = None,
        linear: Vector3 | None = None,
        angular: Vector3 | None = None,
    ) -> str:
        """Put an entity somewhere else, between two ticks; its joints go on as they are.

        Args:
            name: of a robot, or of an object of the world.
            position: of a robot's base link, or of the object, in the world, m; the present one if not given.
            orientation: likewise, (x, y, z, w).
            linear: velocity in the world, m/s; at rest if not given.
            angular: velocity about the axes of the world, rad/s; likewise.

        Returns:
            A warning, where it is in what stands there; else nothing.

        Raises:
            UnknownEntityError: there is none of that name.
            UsageError: it cannot be moved, or within a tick.
        """
        self.admit()
        self.services.world.entities.place(name, Move(position, orientation, linear, angular))
        turned = {"quaternion_xyzw": orientation} if orientation is not None else None
        told = {"entity": name, "position": position, "orientation": turned, "linear": linear, "angular": angular}
        self.inbox.command("move", told)
        return self._warn_of_overlaps(name)

    def _warn_of_overlaps(self, name: str) -> str:
        text = warning(name, self.services.world.entities.overlaps(name))
        if text:
            self.services.log("warning", "", text)
        return text

    def push(self, name: str, force: Vector3, duration: float, point: Vector3 | None = None) -> None:
        """Let a force act on an entity from the next physics step on, beside others that do.

        Args:
            name: of a robot, or of an object of the world.
            force: in the world, N.
            duration: in simulation time, s.
            point: where it acts, in the world, m; at the centre of mass if not given.

        Raises:
            UnknownEntityError: there is none of that name.
            UsageError: it cannot be moved, or within a tick.
        """
        self.admit()
        self.services.world.entities.push(name, force, duration, point)
        self.inbox.command("push", {"entity": name, "force": force, "duration": duration, "at": point})

    def set_inputs(self, address: str, value: Any) -> None:
        """Give inputs that no wire feeds another value, between two ticks; they keep it through `stop` and `reset`.

        Args:
            address: `[robot/][graph/]Node.port`, globs allowed.
            value: as a file would have it.

        Raises:
            UsageError: no such input, a wired one, a value that a port does not take, or within a tick. Nothing has changed.
            GraphError: a node cannot be set up with the value. The old values are back.
        """
        self.admit()
        ports = find_ports(self.graphs, address, ("inputs",))
        changes = [(port, port.convert(value)) for port in ports]
        with contextlib.ExitStack() as undoing:
            for port, converted in changes:
                undo = partial(port.put, port.value)
                port.put(converted)
                undoing.callback(undo)
            undoing.pop_all()
        self.inbox.command("set", {"address": address, "value": value})

    def impulse(self, node: str) -> None:
        """Let an OnImpulseEvent fire in the next tick; several before one tick are one.

        Args:
            node: its prim path, or as much of the end as no other has: `graph/Node`, `Node`.

        Raises:
            UsageError: there is no such node, there are several, or within a tick.
        """
        self.admit()
        path, queue = find_impulses(self.services.queues, node)
        if not queue.waiting:
            queue.post()
        self.inbox.command("impulse", {"node": path})

    def press(self, *keys: str) -> None:
        """Hold keys down from the next tick on, by OmniGraph's names.

        Raises:
            UsageError: there is no such key, or within a tick.
        """
        self.admit()
        self.services.keys.press(keys)
        self.inbox.command("press", {"keys": list(keys)})

    def release(self, *keys: str) -> None:
        """Let go of keys; one that was pressed since the last tick is down for one tick.

        Raises:
            UsageError: there is no such key, or within a tick.
        """
        self.admit()
        self.services.keys.release(keys)
        self.inbox.command("release", {"keys": list(keys)})

    def checkpoint(self, name: str = "") -> Checkpoint:
        """Keep a copy of the whole state, between two ticks; a picture that is being drawn is waited for.

        Args:
            name: by which a recording knows it; numbered if not given.

        Raises:
            UsageError: within a tick.
            NodeError: a node holds what cannot be copied.
        """
        self._refuse_within_tick()
        self._checkpoints += 1
        name = name or f"checkpoint_{self._checkpoints}"
        play = self.state, self._failure, self._ended
        made = Checkpoint(name, self._ticker, self._roster.save(), self._ticker.save(), play)
        self.inbox.command("checkpoint", {"name": name})
        return made

    def restore(self, kept: Checkpoint) -> None:
        """Go back to a checkpoint, between two ticks; what follows is the same, byte by byte, over memory.

        Ticks and recordings go on counting, and messages that have left the process are not taken back.

        Args:
            kept: a checkpoint of this session.

        Raises:
            UsageError: it is another session's, or within a tick.
            GraphError: a robot that has gone, or a node, cannot be what it was.
        """
        self._refuse_within_tick()
        if kept.of is not self._ticker:
            raise UsageError(f"{kept.name} is a checkpoint of another session")
        self._ticker.take(self._roster.restore(kept.robots, self.graphs))
        self._ticker.restore(kept.state)
        state, self._failure, self._ended = kept.play
        self._set(state)
        self.inbox.command("restore", {"name": kept.name})

    def play(self) -> None:
        """Let ticks run."""
        self.admit()
        self._set("playing")

    def pause(self) -> None:
        """Hold; `step` still runs single ticks."""
        self.admit()
        self._set("paused" if self.state == "playing" else self.state)

    def advance(self, ticks: int) -> None:
        """Let `run` do so many ticks more although the session does not play; a stopped one is paused first.

        Raises:
            StateError: it plays, or does such ticks already.
        """
        self.admit()
        if self.state == "playing":
            raise StateError("the session is playing; pause it to run single ticks")
        if self.advancing:
            raise StateError(f"{self.advancing} single ticks are under way")
        self._set("paused")
        self._until = self.ticks + ticks

    @property
    def advancing(self) -> int:
        """How many ticks of `advance` are to come."""
        return max(self._until - self.ticks, 0)

    def _set(self, state: SessionState) -> None:
        """Enter a state, at once; the pace begins anew, and single ticks that were to come do not."""
        self.state, self._until = state, self.ticks
        if self._pacer is not None:
            self._pacer.begin()

    @property
    def pace(self) -> float | None:
        """Seconds of simulation in a second of wall time while `run` plays; None for as fast as possible."""
        return self._pace

    @pace.setter
    def pace(self, pace: float | None) -> None:
        self._pace = pace
        self._pacer = Pacer(self.clock.delta / pace) if pace else None

    def step(self, ticks: int = 1) -> None:
        """Run single ticks, here and now; a stopped session is paused first.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        self.admit()
        if self.state == "stopped":
            self.state = "paused"
        for _ in range(ticks):
            self._tick()

    def run(
        self,
        seconds: float | None = None,
        pace: float | None = None,
        on_tick: Callable[[Session], bool] | None = None,
        *,
        paused: bool = False,
    ) -> None:
        """Play for some time of simulation.

        With a desk this goes on through pauses and stops, asleep meanwhile.

        Args:
            seconds: how long, all plays together; None for ever.
            pace: seconds of simulation in a second of wall time; None for as fast as possible.
            on_tick: called after each tick, and while there are none now and then; returning False ends the run.
            paused: begin with a pause, which the desk ends.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        self.admit()
        self.pace = pace
        self._set("paused" if paused else "playing")
        last = math.inf if seconds is None else self.ticks + round(seconds / self.clock.delta)
        try:
            self._run(last, on_tick)
        finally:
            self.interrupted = False

    def _run(self, last: float, on_tick: Callable[[Session], bool] | None) -> None:
        """Ticks until a number of them ran, the run is interrupted, or it ends because nobody can let it go on."""
        while self._serve() and self.ticks < last:
            paced = self._pacer if self.state == "playing" else None
            self.services.world.realtime = paced is not None and not self.inbox.exact
            if self.state != "playing" and not self.advancing:
                self._sleep(IDLE)
            elif paced is not None and (early := paced.early()) > 0:
                self._sleep(early)
                continue
            else:
                self._tick()
                if paced is not None:
                    paced.count()
            if on_tick is not None and not on_tick(self):
                self.interrupted = True

    def _serve(self) -> bool:
        """Do what was asked for, and tell who waits for ticks that they ran; whether the run goes on."""
        if self.desk is not None:
            self.desk.serve(self)
        return not self.interrupted and (self.desk is not None or self.state == "playing")

    def interrupt(self) -> None:
        """End `run`, at once while it waits, else after the tick; for other threads and signal handlers."""
        self.interrupted = True
        if self.desk is not None:
            self.desk.wake()

    def _sleep(self, seconds: float) -> None:
        if self.desk is not None:
            self.desk.wait(seconds)
        else:
            time.sleep(seconds)

    def _refuse_within_tick(self) -> None:
        if self._ticker.running:
            raise UsageError("a session can be asked for this between two ticks only, as from `on_tick`")

    def admit(self) -> None:
        """Refuse a change within a tick, or of a session that failed.

        Raises:
            StateError: the session failed, and its time was not reset.
            UsageError: within a tick.
        """
        self._refuse_within_tick()
        if self.state == "failed":
            raise StateError(f"the session failed; reset it first\n  {self._failure.partition(chr(10))[0]}")

    def _tick(self) -> None:
        try:
            self._ticker.run(self.inbox)
        except BaseException as error:  # an interrupted tick leaves graphs half computed, too
            self._set("failed")
            self._failure = str(error) or type(error).__name__
            raise

    def stop(self) -> None:
        """Back to time 0: commands zero, world at its start, outputs and state at their defaults."""
        self._refuse_within_tick()
        self._begin_anew("state", "time")
        self._set("stopped")
        self.inbox.command("stop", {})

    def reset(self, *scopes: ResetScope) -> None:
        """Begin anew, wholly or in part, and go on as before: playing, paused or stopped. A session that failed is paused.

        Args:
            scopes: all if none is given.
                `time`: the clock goes to 0, and with it begin graphs and sensors, as after `stop`; commands are zero. Bodies
                stay where they are, and keep their velocities.
                `state`: bodies and joints go to where they were at the start, robots that came to where they were put, with
                the commands that they had then. Time, and what graphs know, goes on.
                `spawned`: robots that came while the session ran are removed.

        Raises:
            StateError: the session failed, and its time is to go on.
            UsageError: a graph that is not its own reads something of a robot that is to go, or within a tick.
        """
        self._refuse_within_tick()
        wanted = [scope for scope in SCOPES if scope in scopes or not scopes]
        if self.state == "failed":
            if "time" not in wanted:
                raise StateError("the session failed; only a reset of its time lets it go on")
            self._set("paused")
        if "spawned" in wanted:
            for name in reversed(list(self.spawned)):
                self.remove(name)
            wanted.remove("spawned")
        if wanted:
            self._begin_anew(*wanted)
            self.inbox.command("reset", {"scope": wanted})
        self._set(self.state)

    def _begin_anew(self, *scopes: ResetScope) -> None:
        """Parts of the session as before the first tick; a play ends before its time does."""
        if "time" in scopes:
            self._end_play()
            self._failure = ""
        self._ticker.begin_anew(*scopes)

    def _end_play(self) -> None:
        """Tell graphs that a play ends, if there was one."""
        if self.clock.frame:
            self._ticker.tell("at_stop", self.graphs)

    def end(self) -> None:
        """Let graphs do what they have for the end of a play and for their own, once; nothing is to run after it.

        After an error they do nothing: what they know may be half of a tick.
        """
        if self._ended or self._failure:
            return
        self._ended = True
        self._end_play()
        self._ticker.tell("at_close", self.graphs)

    def close(self) -> None:
        """End, leave the network and release the world; safe to call twice."""
        with contextlib.suppress(TransportError):
            self.end()
        if self.desk is not None:
            self.desk.close(self._failure or "the run has ended")
        self.held.clear()
        for run in self.graphs:
            run.close()
        self.services.network.close()
        self.services.world.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
