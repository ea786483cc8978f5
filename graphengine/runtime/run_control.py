"""Decides when the ticks of a session run: continuously, at a pace, or one by one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol, Self

from graphengine.format.errors import StateError, UsageError
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.pacer import Pacer
from graphengine.runtime.ticker import Ticker

SessionState = Literal["stopped", "playing", "paused", "failed"]

IDLE = 0.25
"""Maximum wall time that a paused run sleeps before the next check whether to end, s; a command ends the sleep."""
POLL = 0.001
"""Wall time between two calls of a gate that holds back a tick, s."""


class WaitingCommands(Protocol):
    """Commands from other threads that wait for the session, such as a `CommandQueue`."""

    def serve(self, session: Any) -> None:
        """Execute waiting commands between two ticks."""

    def wait(self, seconds: float) -> None:
        """Sleep until a command arrives or `wake` is called, but at most for `seconds`."""

    def wake(self) -> None:
        """End the current or next `wait`. Safe in other threads and in signal handlers."""

    def close(self, reason: str) -> None:
        """Reject all waiting and all later commands."""


Gate = Callable[[int, tuple[int, int]], bool]
"""Returns whether the next tick may begin; the arguments are the last tick's number and the tick period. Errors end the run."""


class RunControl:
    """Runs ticks while the session plays, and single ticks while it is paused.

    Args:
        ticker: runs the ticks of the session.
    """

    def __init__(self, ticker: Ticker) -> None:
        self._ticker = ticker
        self.services = ticker.services
        self.services.started = True
        self.clock = ticker.clock
        self.step_clock = ticker.step_clock
        self.state: SessionState = "stopped"
        self.inbox = ExternalInputs()
        """Gives the wall clock to nodes and receives the executed commands; a recorder or a replay replaces this object."""
        self.queue: WaitingCommands | None = None
        """Queue for commands from other threads; None: no queue, and `run` returns when the session is paused or stopped."""
        self.gate: Gate | None = None
        """Delays ticks, as `Lockstep.opens` does; commands are executed meanwhile. A replay has no gate."""
        self.listeners: list[Callable[[], None]] = []
        """Functions that the session calls in its thread after each executed command and each change between two ticks."""
        self.late_ticks = 0
        """Number of ticks that ended after the next tick was due; only runs with a pace count them."""
        self._until = 0
        self.last = math.inf
        """Number of the tick after which `run` ends."""
        self._pace: float | None = None
        self._pacer: Pacer | None = None
        self.interrupted = False
        self.failure = ""
        """Message of the error that made the session fail; empty if no error has occurred since the last reset of the time."""

    @property
    def graphs(self) -> Sequence[GraphRun]:
        """Graphs in execution order: the scene's, then each robot's."""
        return self._ticker.graphs

    @property
    def ticks(self) -> int:
        """Number of ticks that have run since the session was created; a stop does not reset this number."""
        return self._ticker.count

    @property
    def time(self) -> float:
        """Simulation time since play, s."""
        return self.clock.time

    def play(self) -> None:
        """Let `run` execute ticks continuously; after a stop, the simulation starts at time 0."""
        self.admit()
        self._set("playing")

    def pause(self) -> None:
        """Pause the session if it is playing, and cancel single ticks that have not run yet.

        A stopped session stays stopped. `step` still runs single ticks.
        """
        self.admit()
        self._set("paused" if self.state == "playing" else self.state)

    def advance(self, ticks: int) -> None:
        """Let `run` execute a number of single ticks while the session is paused; a stopped session becomes paused.

        Raises:
            StateError: the session is playing, or earlier single ticks have not run yet.
        """
        self.admit()
        if self.state == "playing":
            raise StateError("the session is playing; pause it before running single ticks")
        if self.advancing:
            remedy = "wait until they have run, or cancel them with `pause`"
            raise StateError(f"{self.advancing} ticks of an earlier `step` have not run yet; {remedy}")
        self._set("paused")
        self._until = self.ticks + ticks

    @property
    def advancing(self) -> int:
        """Number of ticks requested by `advance` that have not run yet."""
        return max(self._until - self.ticks, 0)

    def _set(self, state: SessionState) -> None:
        """Enter a state, restart the schedule of ticks, and cancel single ticks that have not run yet."""
        self.state, self._until = state, self.ticks
        if self._pacer is not None:
            self._pacer.begin()

    @property
    def pace(self) -> float | None:
        """Target real-time factor of `run`, seconds of simulation per second of wall time; None: as fast as possible."""
        return self._pace

    @pace.setter
    def pace(self, pace: float | None) -> None:
        self._pace = pace
        self._pacer = Pacer(self.clock.delta / pace) if pace else None
        self._tell_listeners()

    def step(self, ticks: int = 1) -> None:
        """Run a number of ticks as fast as possible; a stopped session becomes paused.

        After an error, the session is in the state `failed`, and the joint commands are zero.

        Raises:
            NodeError: a node raised an exception.
            PhysicsError: the simulation diverged.
        """
        self.admit()
        if self.state == "stopped":
            self.state = "paused"
        for _ in range(ticks):
            while not self._may_tick():
                self._sleep(POLL)
                if self.queue is not None:
                    self.queue.serve(self)
                if self.interrupted:
                    return
            self._tick()

    def run(
        self,
        seconds: float | None = None,
        pace: float | None = None,
        on_tick: Callable[[Self], bool] | None = None,
        *,
        paused: bool = False,
    ) -> None:
        """Play the session for a given simulation time, and return afterwards.

        If the session is paused or stopped, the method returns; with a queue, it instead sleeps until the command `play`. After
        an error, the session is in the state `failed`, with zero joint commands.

        Args:
            seconds: total simulation time to run, s, also across stops of the session; None: no limit.
            pace: target real-time factor, seconds of simulation per second of wall time; None: as fast as possible.
            on_tick: function that is called after each tick, and several times per second while the session is paused or
                stopped; the result False ends the run.
            paused: whether the session is paused until the command `play` arrives in the queue.

        Raises:
            NodeError: a node raised an exception.
            PhysicsError: the simulation diverged.
        """
        self.admit()
        self.pace = pace
        self._set("paused" if paused else "playing")
        self.last = math.inf if seconds is None else self.ticks + round(seconds / self.clock.delta)
        try:
            self._run(on_tick)
        finally:
            self.interrupted = False

    def _run(self, on_tick: Callable[[Self], bool] | None) -> None:
        """Run ticks until the tick `last`, an interrupt, or, without a queue, a pause or stop."""
        while self._serve() and self.ticks < self.last:
            paced = self._pacer if self.state == "playing" else None
            self.services.world.realtime = paced is not None and not self.inbox.exact
            if self.state != "playing" and not self.advancing:
                self._sleep(IDLE)
            elif paced is not None and (early := paced.early()) > 0:
                self._sleep(early)
                continue
            elif not self._may_tick():
                if paced is not None:
                    paced.begin()
                self._sleep(POLL)
                continue
            else:
                self._tick()
                if paced is not None and paced.count():
                    self.late_ticks += 1
            if on_tick is not None and not on_tick(self):
                self.interrupted = True

    def _may_tick(self) -> bool:
        return self.gate is None or self.gate(self.clock.frame, self.services.world.tick_period)

    def _serve(self) -> bool:
        """Execute the commands in the queue; return whether the run continues."""
        if self.queue is not None:
            self.queue.serve(self)
        return not self.interrupted and (self.queue is not None or self.state == "playing")

    def interrupt(self) -> None:
        """End `run` after the current tick, or a sleep of `run` immediately. Safe in other threads and in signal handlers."""
        self.interrupted = True
        if self.queue is not None:
            self.queue.wake()

    def _sleep(self, seconds: float) -> None:
        if self.queue is not None:
            self.queue.wait(seconds)
        else:
            time.sleep(seconds)

    def _refuse_within_tick(self) -> None:
        if self._ticker.running:
            remedy = "do it between two ticks, as in `on_tick`"
            raise UsageError(f"a session cannot be changed or saved within a tick; {remedy}")

    def admit(self) -> None:
        """Check that the session can be changed now.

        Raises:
            StateError: the session failed, and the time was not reset since then.
            UsageError: the method was called within a tick.
        """
        self._refuse_within_tick()
        if self.state == "failed":
            raise StateError(f"the session failed; reset it first\n  {self.failure.partition(chr(10))[0]}")

    def note(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Report an executed command to `inbox`, which records it, and call the listeners.

        Args:
            name: name of the command.
            arguments: arguments as JSON values.
        """
        self.inbox.command(name, arguments)
        self._tell_listeners()

    def _tell_listeners(self) -> None:
        for listener in self.listeners:
            listener()

    def _tick(self) -> None:
        try:
            self._ticker.run(self.inbox)
        except BaseException as error:  # an interrupted tick leaves graphs half computed, too
            self._set("failed")
            self.failure = str(error) or type(error).__name__
            raise
