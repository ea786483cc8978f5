"""The core of a session: stops, resets, reloads and checkpoints the simulation between two ticks."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from graphengine.compiler.graph import Graph
from graphengine.format.closing import Closing
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import GraphError, StateError, TransportError, UsageError
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.reloading import Reloaded, Reloader
from graphengine.runtime.roster import Roster
from graphengine.runtime.run_control import RunControl, SessionState
from graphengine.runtime.ticker import SCOPES, ResetScope, Ticker

MAX_HELD = 1000
"""Maximum number of checkpoints that a session keeps for the command `restore`."""


@dataclass(frozen=True, eq=False)
class SavedSession:
    """A checkpoint: a copy of the whole state of a session, made by `SessionCore.checkpoint`."""

    name: str
    of: SessionCore
    version: int
    """Version number of the files that the session ran; `files` is the saved version for `Reloader.restore`."""
    files: Any
    robots: Any
    state: Any
    play: tuple[SessionState, str, bool]


class SessionCore(RunControl, Closing):
    """Changes the state of the simulation between two ticks; `RunControl` decides when ticks run.

    Not thread-safe: another thread may only call `interrupt`, and must submit all other calls to `queue`. Methods that run ticks
    or change the simulation raise an error if a node calls them within a tick.

    Args:
        ticker: runs the ticks of the session.
        roster: adds and removes the robots of the session.
    """

    def __init__(self, ticker: Ticker, roster: Roster) -> None:
        super().__init__(ticker)
        self.roster = roster
        self.reloader = Reloader()
        self._versions = itertools.count()
        self.version = next(self._versions)
        """Number of the version of the files that the session runs."""
        self.edits = False
        """Whether commands may change the files of the session."""
        self.findings: tuple[str, ...] = ()
        """Errors that the last reload found in changed files, as text; empty if the session runs the current files. The web page
        and the terminal of the run show them."""
        self.open_page: Callable[[bool], str] | None = None
        """Function that returns the URL of the session's web page, empty while the page starts; None: no page. If the page's
        process has ended, the function raises UsageError for the argument True, and starts a new process for False."""
        self._ended = False
        self._checkpoints = 0
        self.held: dict[str, SavedSession] = {}
        """Checkpoints of the command `checkpoint`, by name; the least recently used checkpoint is first."""

    def checkpoint(self, name: str = "") -> SavedSession:
        """Return a copy of the whole state of the session, after a wait for camera images that are being rendered.

        Args:
            name: name of the checkpoint in recordings; default: a numbered name such as `checkpoint_1`.

        Raises:
            UsageError: the method was called within a tick.
            NodeError: a node has state that cannot be copied.
        """
        self._refuse_within_tick()
        self._checkpoints += 1
        name = name or f"checkpoint_{self._checkpoints}"
        play = self.state, self.failure, self._ended
        version, files = self.version, self.reloader.save()
        made = SavedSession(name, self, version, files, self.roster.save(), self._ticker.save(), play)
        self.note("checkpoint", {"name": name})
        return made

    def hold(self, checkpoint: SavedSession) -> None:
        """Keep a checkpoint for the command `restore`; discard the least recently used one of more than `MAX_HELD`."""
        self.held.pop(checkpoint.name, None)
        self.held[checkpoint.name] = checkpoint
        if len(self.held) > MAX_HELD:
            del self.held[next(iter(self.held))]

    def restore(self, kept: SavedSession, seed: int | None = None) -> None:
        """Restore the state of a checkpoint; on the transport `memory`, equal inputs then give byte-identical messages.

        The tick count `ticks` and the recording continue. Messages that were already sent cannot be recalled.

        Args:
            kept: checkpoint of this session.
            seed: new seed of all random generators; None restores the state of the generators too.

        Raises:
            UsageError: the checkpoint is of another session, or the method was called within a tick.
            GraphError: a robot that was removed cannot be added again, or a node cannot be restored.
        """
        self._refuse_within_tick()
        if kept.of is not self:
            raise UsageError(f"{kept.name} is a checkpoint of another session")
        before = self.clock.frame
        if kept.version != self.version:
            self.reloader.restore(kept.files)
            self.version = kept.version
        self.roster.restore(kept.robots)
        self._ticker.restore(kept.state)
        if seed is not None:
            self._ticker.reseed(seed)
        state, self.failure, self._ended = kept.play
        self._set(state)
        self.note("restore", {"name": kept.name, **({"seed": seed} if seed is not None else {})})
        self._announce_jump(before, restored=True)

    def stop(self) -> None:
        """Stop the simulation and reset it to time 0.

        Joint commands become zero. The world, and the outputs, states and variables of graphs, get their initial values.
        """
        self._refuse_within_tick()
        before = self.clock.frame
        self._begin_anew("state", "time")
        self._set("stopped")
        self.note("stop", {})
        self._announce_jump(before)

    def reset(self, *scopes: ResetScope, seed: int | None = None) -> None:
        """Reset all or parts of the session, which stays playing, paused or stopped; a failed session becomes paused.

        Args:
            scopes: parts to reset; if none is given, all parts.
                `time`: set the clock to 0 and restart graphs and sensors, as after `stop`; joint commands become zero. Bodies
                keep their poses and velocities.
                `state`: return bodies and joints to their initial state, and spawned robots to the poses and commands with
                which they were spawned. Time and the state of graphs continue.
                `spawned`: remove the robots that were spawned while the session ran.
            seed: new seed of all random generators, which requires the scope `time`; None: the seed stays.

        Raises:
            StateError: the session failed, and `scopes` does not include `time`.
            UsageError: a graph of another robot or of the scene uses a spawned robot, a seed was given without the scope `time`,
                or the method was called within a tick.
        """
        self._refuse_within_tick()
        wanted = [scope for scope in SCOPES if scope in scopes or not scopes]
        if seed is not None and "time" not in wanted:
            raise UsageError("a new seed takes effect when the time is reset: add the scope `time`")
        if self.state == "failed":
            if "time" not in wanted:
                raise StateError("the session failed; reset it with the scope `time` to continue")
            self._set("paused")
        if "spawned" in wanted:
            for name in reversed(list(self.roster.spawned)):
                self.roster.remove(name)
                self.note("delete", {"name": name})
            wanted.remove("spawned")
        if wanted:
            before = self.clock.frame
            self._begin_anew(*wanted, seed=seed)
            self.note("reset", {"scope": wanted, **({"seed": seed} if seed is not None else {})})
            self._announce_jump(before)
        self._set(self.state)

    def reload(self) -> Reloaded:
        """Read the files of the scene again, and run the changed scene.

        Changed graphs are replaced: nodes with the same name and type keep their state, and the world continues. A change of the
        world or of a robot restarts the session at time 0, without spawned robots. After an error, the session continues
        unchanged, and `findings` has the errors until a reload succeeds.

        Raises:
            CheckError: the files have errors.
            GraphError: the changed scene cannot start.
            StateError: the session failed.
        """
        self.admit()
        before, frame = self.version, self.clock.frame
        try:
            done = self.reloader.reload()
        except CheckError as error:
            errors = [finding for finding in error.findings if finding.severity == "error"]
            self.findings = tuple(finding.render() for finding in errors)
            raise CheckError(errors) from None
        except GraphError as error:
            self.findings = (str(error),)
            raise
        mended, self.findings = bool(self.findings), ()
        self.note("reload", {"effective": self.version != before})
        self._announce_jump(frame)
        return replace(done, mended=mended)

    def exchange(self, graphs: Sequence[Graph]) -> Reloaded:
        """Replace all running graphs with `graphs`; nodes with the same name and type keep their state.

        Raises:
            GraphError: a node could not be set up; the old graphs continue unchanged.
        """
        done = self._ticker.exchange(graphs)
        if done.changed or done.added or done.removed:
            self.version = next(self._versions)
        return done

    def begin_with(self, ticker: Ticker, roster: Roster) -> None:
        """Replace the world and all graphs, and restart at time 0. The session stays playing, paused or stopped.

        Args:
            ticker: ticker of the new world, whose graphs are already set up.
            roster: adds and removes the robots of the new world.
        """
        before = self._ticker
        if math.isfinite(self.last):
            left = (self.last - before.count) * before.clock.delta
            self.last = before.count + round(left / ticker.clock.delta)
        ticker.count = before.count
        self._ticker, self.services, self.roster = ticker, ticker.services, roster
        self.clock, self.step_clock = ticker.clock, ticker.step_clock
        self.version = next(self._versions)
        ticker.close(before.graphs)
        ticker.services.forget_calls()
        before.services.world.close()
        self.pace = self._pace
        self._set(self.state)

    def _begin_anew(self, *scopes: ResetScope, seed: int | None = None) -> None:
        """Reset parts of the session; before the time is reset, run the events for the end of play."""
        if "time" in scopes:
            self.end_play()
            self.failure = ""
        self._ticker.begin_anew(*scopes, seed=seed)

    def _announce_jump(self, before: int, *, restored: bool = False) -> None:
        """Let nodes announce the simulation time if it has jumped.

        Args:
            before: number of the tick before the jump.
            restored: whether a checkpoint was restored.
        """
        if self.clock.frame != before:
            self._ticker.announce_time(restored=restored)

    def end_play(self, closing: Sequence[GraphRun] = ()) -> None:
        """Run the events for the end of play if a tick has run since play, then the events for the end of the given graphs.

        Args:
            closing: graphs that will be closed.
        """
        if self.clock.frame:
            self._ticker.tell("at_stop", self.graphs)
        if closing:
            self._ticker.tell("at_close", closing)

    def end(self) -> None:
        """Run the events for the end of play and of all graphs; a second call has no effect. No tick may run afterwards.

        In a failed session these events do not run, because an unfinished tick may have left inconsistent values.
        """
        if self._ended or self.failure:
            return
        self._ended = True
        self.end_play()
        self._ticker.tell("at_close", self.graphs)

    def close(self) -> None:
        """End the session: run the events for its end, close the queue, the graphs, the network and the world.

        Safe to call twice.
        """
        with contextlib.suppress(TransportError):
            self.end()
        if self.queue is not None:
            self.queue.close(self.failure or "the run has ended")
        self.held.clear()
        for run in self.graphs:
            run.contexts.close()
        self.services.network.close()
        self.services.world.close()
