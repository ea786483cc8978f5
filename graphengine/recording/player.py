"""Plays a recording: replays the ticks once and makes checkpoints, and seeks to any replayed tick."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from graphengine.format.errors import GraphError
from graphengine.recording.marks import Marks
from graphengine.recording.reader import Recording, Tick
from graphengine.recording.replay import Difference, Replay
from graphengine.recording.tick_inputs import TickInputs
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import Complain
from graphengine.runtime.session_core import SavedSession, SessionCore

SPACING = 2.5
"""Simulation time between two checkpoints, s."""
MAX_CHECKPOINTS = 1000
"""Maximum number of checkpoints.

Beyond this number, every second checkpoint is dropped and the spacing doubles: to 5 s after 42 minutes, to 20 s after 3 hours.
"""
STRIDE = 20
"""Longest distance, in ticks, for which a seek runs ticks instead of restoring a checkpoint.

A seek also makes temporary checkpoints at this distance, and keeps the last of them, so that single steps back are fast.
"""


@dataclass(frozen=True, slots=True)
class _Kept:
    """A checkpoint after a tick: the session, the checkpoints of recorded commands until then, and the exchanged files."""

    tick: int
    session: SavedSession
    held: Mapping[str, SavedSession]
    files: Mapping[str, str | None]


class RecordingPlayer:
    """Replays a recording in a session, and can restore the state after each replayed tick.

    Ticks have the numbers of the recording, which continue after a reset of the simulation time. Not thread-safe.

    Args:
        session: session of the recorded scene, before its first tick.
        network: network of the session, over a `SilentTransport`.
        recording: recording to play.
        marks: collects the events of the replay, including errors that the session logs.
        warn: receives warnings about recorded inputs that no node reads.

    Raises:
        GraphError: a node holds state that cannot be copied.
    """

    def __init__(
        self, session: SessionCore, network: LiveNetwork, recording: Recording, marks: Marks, warn: Complain
    ) -> None:
        self.session = session
        self.recording = recording
        self.marks = marks
        self.replay = Replay(session, network, recording, warn=warn)
        self.length = recording.length()
        """Number of ticks of the recording, including a failed tick; after the end of the replay, number of replayed ticks."""
        self._verdicts = recording.verdicts()
        self.built = 0
        """Number of ticks that have been replayed and compared."""
        self.position = 0
        """Number of the shown tick; the web page shows the state after this tick."""
        self.complete = False
        """Whether the replay has ended."""
        self.difference: Difference | None = None
        """The first difference between replay and recording; later ticks are not compared."""
        self.failure = ""
        """The error that ended the run or the replay; empty if there was no error."""
        self._ticks = recording.ticks()
        self._inputs = TickInputs()
        self._spacing = max(round(SPACING / session.clock.delta), 1)
        self._at: int | None = 0
        """Number of the last tick that the session has run; None if the session is in the middle of a tick."""
        self._head = self._shown = self._visited = self._keep(0)
        """Checkpoints: `_head` is after the last replayed tick, `_shown` at or shortly before the shown tick, `_visited` is after
        the last tick of `visit`."""
        self._checkpoints = [self._head]

    def build(self, seconds: float = math.inf, interrupted: Callable[[], bool] = lambda: False) -> None:
        """Continue the replay: run and compare the next ticks, and make checkpoints. `position` does not change.

        Args:
            seconds: wall time after which no further tick begins, s. It starts after the seek to the last replayed tick. At
                least one tick runs.
            interrupted: function that returns True to end `build`. It is called after each tick.
        """
        if self.complete:
            return
        if self._at == self.position != self._shown.tick:
            self._shown = self._keep(self.position)
        self._go(self.built, math.inf)
        ends = time.monotonic() + seconds
        while not self.complete:
            self._build_tick()
            if time.monotonic() >= ends or interrupted():
                break

    def show(self, tick: int, seconds: float = math.inf) -> None:
        """Seek to the state after a replayed tick.

        Args:
            tick: number of the tick; 0 is the start.
            seconds: wall time after which the seek ends, s, possibly at an earlier tick.
        """
        self._go(min(max(tick, 0), self.built), time.monotonic() + seconds)
        assert self._at is not None
        self.position = self._at

    def visit(self, first: int, seconds: float, seen: Callable[[int], None], interrupted: Callable[[], bool]) -> int:
        """Run replayed ticks again, in order, and return the number of the next tick to visit. `position` does not change.

        Args:
            first: number of the first tick to visit.
            seconds: wall time after which no new tick begins, s.
            seen: called with the number of each tick after it has run.
            interrupted: called after each tick; the result True makes `visit` return.
        """
        if self._at == self.position != self._shown.tick:
            self._shown = self._keep(self.position)
        ends = time.monotonic() + seconds
        for tick in range(first, self.built + 1):
            self._go(tick, math.inf)
            seen(tick)
            if time.monotonic() >= ends or interrupted():
                self._visited = self._keep(tick)
                return tick + 1
        return self.built + 1

    def close(self) -> None:
        """Delete the temporary files of the player; the caller closes the session."""
        self._inputs.close()

    def _keep(self, tick: int) -> _Kept:
        made, files = self.session.checkpoint(f"tick {tick} of the recording"), self.recording.workspace.exchanged
        return _Kept(tick, made, dict(self.session.held), files)

    def _go(self, tick: int, ends: float) -> None:
        """Bring the session to the state after a tick, from its current state or from the nearest earlier checkpoint."""
        if self._at == tick:
            return
        if self._at == self.built != self._head.tick and tick < self.built and self.session.state != "failed":
            self._head = self._keep(self.built)
        earlier = [kept for kept in (*self._checkpoints, self._head, self._shown, self._visited) if kept.tick <= tick]
        nearest = max(earlier, key=lambda kept: kept.tick)
        if self._at is None or self._at > tick or nearest.tick - self._at > STRIDE:
            if self.recording.workspace.exchanged != nearest.files:
                self.recording.workspace.exchange(nearest.files)
            self.session.restore(nearest.session)
            self.session.held.clear()
            self.session.held.update(nearest.held)
            self._at = nearest.tick
        while self._at < tick:
            self._at += 1
            self.replay.repeat(self._inputs[self._at])
            if self._at % STRIDE == 0 and self._at < tick:
                self._shown = self._keep(self._at)
            if time.monotonic() >= ends:
                break

    def _build_tick(self) -> None:
        """Replay the next tick of the recording, or finish at its end."""
        try:
            tick = next(self._ticks, None)
            if tick is None:
                self._finish("")
            elif tick.whole or self.recording.failure:
                self._replay_tick(tick)
            else:
                self._replay_end(tick)
        except GraphError as error:  # a damaged file, or a command that fails
            self._at = None
            self.marks.tick = self.built + 1
            self._finish(str(error))

    def _replay_tick(self, tick: Tick) -> None:
        self.marks.tick = tick.number
        self._inputs.append(tick)
        self.marks.add_commands(tick.commands)
        error = self._run(tick)
        self._at = self.built = tick.number
        self.length = max(self.length, self.built)
        touching = self.session.services.world.entities.touching()
        robots = self.session.services.stage.robots
        self.marks.add_contacts({name: contact.other for name, contact in touching.items()}, robots)
        for text in self._verdicts.get(tick.number, ()):
            self.marks.add("verdict", text)
        if error is not None:
            self._finish(str(error))
        elif self.built % self._spacing == 0:
            self._add_checkpoint()
        self.marks.tick = 0

    def _replay_end(self, tick: Tick) -> None:
        """Replay the end of the session, and compare the messages that it sends; the last tick before the end stays shown."""
        self._head = self._keep(self.built)
        self._run(tick)
        self._at = None
        self._finish("")

    def _run(self, tick: Tick) -> GraphError | None:
        error = self.replay.repeat(tick)
        if self.difference is None:
            self.difference = self.replay.compare(tick, error)
            if self.difference is not None:
                self.marks.tick = self.difference.tick
                self.marks.add("error", str(self.difference))
        return error

    def _add_checkpoint(self) -> None:
        self._checkpoints.append(self._keep(self.built))
        if len(self._checkpoints) > MAX_CHECKPOINTS:
            self._spacing *= 2
            self._checkpoints = self._checkpoints[::2]

    def _finish(self, failure: str) -> None:
        self.complete = True
        self.length = self.built
        self.failure = failure
        if failure:
            self.marks.add("error", failure)
        self.marks.tick = 0
