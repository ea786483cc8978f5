"""The part of a session that controls time: ticks, resets, checkpoints, reloads and commands from other threads."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Self

from graphengine.api.after_tick import AfterTick
from graphengine.api.guards import acting, reading
from graphengine.api.runner import Runner
from graphengine.api.values import plain
from graphengine.format.closing import Closing
from graphengine.format.errors import UsageError
from graphengine.format.spec import Spec
from graphengine.runtime.commands import COMMANDS

if TYPE_CHECKING:
    from graphengine.runtime.reloading import Reloaded
    from graphengine.runtime.run_control import SessionState
    from graphengine.runtime.session_core import SavedSession as InnerCheckpoint
    from graphengine.runtime.session_core import SessionCore as InnerSession
    from graphengine.runtime.ticker import ResetScope


RECORDED_COMMANDS: Mapping[str, type[Spec]] = {
    name: kind for name, kind in COMMANDS.items() if kind.recorded and name not in ("stop", "restore", "checkpoint")
}
"""Specs of the arguments of the commands for `Session.submit` that change the simulation, by name."""


class Checkpoint:
    """The complete state of a session, made by `Session.checkpoint` for `Session.restore`."""

    def __init__(self, inner: InnerCheckpoint, after_ticks: Sequence[tuple[AfterTick, Any]]) -> None:
        self._inner = inner
        self._after_ticks = after_ticks

    def __repr__(self) -> str:
        return f"<Checkpoint {self._inner.name}>"


class SessionControl(Closing):
    """Runs the ticks of a session, and resets, saves, restores, reloads and closes it."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

    @property
    @reading
    def time(self) -> float:
        """Simulation time, s; 0 at the start and after a reset of the time."""
        return self._runner.session.time

    @property
    @reading
    def tick(self) -> int:
        """Number of ticks since the start or since the last reset of the time."""
        return self._runner.session.clock.frame

    @property
    @reading
    def state(self) -> SessionState:
        """`stopped` (at time 0), `playing` (during `run`), `paused` (after `run` or `step`) or `failed` (after an error)."""
        return self._runner.session.state

    @acting
    def step(self, ticks: int = 1) -> None:
        """Run a number of ticks, as fast as possible.

        >>> sim.step(3)

        Raises:
            NodeError: a node raised an exception; joint commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        count = operator.index(ticks)
        if count < 0:
            raise UsageError(f"ticks: expected 0 or more, got {count}")
        self._runner.step(count)

    @acting
    def run(
        self,
        seconds: float | None = None,
        rate: float | None = None,
        until: Callable[[Self], bool] | None = None,
    ) -> bool:
        """Run for a duration in simulation time, or until a condition holds.

        Ctrl-C ends the run between two ticks and raises KeyboardInterrupt; the session stays usable.

        >>> sim.run(1.0)
        True
        >>> sim.run(10.0, until=lambda s: s.time > 1.2)
        True

        Args:
            seconds: duration in simulation time, s; None runs without end.
            rate: seconds of simulation per second of wall time; infinity runs as fast as possible. None runs as fast as
                possible with the transport `memory`, and in real time with other transports.
            until: condition, called before the first tick and after each tick; if it returns True, the run ends.

        Returns:
            With `until`, whether the condition held; without `until`, whether the whole duration passed without `interrupt`.

        Raises:
            NodeError: a node raised an exception; joint commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        held = False

        def goes_on(_: InnerSession) -> bool:
            nonlocal held
            held = until is not None and until(self)
            return not held

        passed = self._runner.run(seconds, rate, goes_on, first=goes_on)
        return held if until is not None else passed

    def interrupt(self) -> None:
        """End the current `run` after the present tick; without a current `run`, end the next `run` before its first tick.

        Any thread may call this method.
        """
        self._runner.session.interrupt()

    @reading
    def reset(self, *scopes: ResetScope, seed: int | None = None) -> None:
        """Reset the whole session or a part of it. Inputs changed by `set` keep their values.

        >>> sim.reset("state")

        Args:
            scopes: parts to reset: `time` resets the clock and the graphs, `state` resets bodies and joints, `spawned`
                removes spawned robots. Without scopes, everything is reset.
            seed: new seed of all random generators, used if the time is reset; None keeps the seed.

        Raises:
            UsageError: a spawned robot cannot be removed because a graph outside this robot reads from this robot.
        """
        self._runner.command("reset", scope=list(scopes) or "all", seed=seed)

    @acting
    def checkpoint(self) -> Checkpoint:
        """Save the complete state; `restore` can return to it any number of times. A recording stores the call.

        The call waits until all images that are being rendered are finished.

        >>> sim.checkpoint()
        <Checkpoint checkpoint_1>

        Raises:
            NodeError: the state of a node cannot be copied.
        """
        inner = self._runner.session.checkpoint()
        return Checkpoint(inner, [(action, action.save()) for action in self._runner.after_ticks.values()])

    @reading
    def restore(self, checkpoint: Checkpoint, *, seed: int | None = None) -> None:
        """Return to a checkpoint of this session. A recording stores the call.

        With the transport `memory`, repeating the calls that followed the checkpoint sends the same bytes again. `restore` does
        not withdraw messages that were already sent, and does not remove messages that a `Subscription` keeps. It does not
        rewind the sequence numbers of DDS or the times in a recording.

        >>> mark = sim.checkpoint()
        >>> sim.run(1.0)
        True
        >>> sim.restore(mark)
        >>> sim.time
        0.0

        Args:
            checkpoint: checkpoint of this session.
            seed: new seed of all random generators, for other noise from here on; None restores their state too.

        Raises:
            GraphError: a removed robot or a node cannot be restored.
            UsageError: the checkpoint belongs to another session.
        """
        self._runner.session.restore(checkpoint._inner, seed)
        for action, state in checkpoint._after_ticks:
            action.restore(state)

    @acting
    def reload(self) -> Reloaded:
        """Read the files of the scene again and run the changed scene. A recording stores the call, with the changed files.

        Changed graphs are replaced, and the world continues. A node whose name, type and ports are unchanged keeps its
        state. A wired input keeps its value if its wire is unchanged; an unwired input keeps its value if the file gives it the
        same value as before. Unchanged topics keep their endpoints. A change of the world or of a robot restarts the session at
        time 0, without spawned robots. `restore` with a checkpoint from before the reload returns to the scene as it was before
        the reload. Python modules with node types are not imported again.

        >>> print(sim.reload())
        no file changed: graphs and world are unchanged

        Raises:
            CheckError: the files have errors; nothing has changed.
            GraphError: the changed scene cannot start; nothing has changed.
        """
        return self._runner.act(lambda session: session.reload())

    def submit(self, command: str, arguments: Mapping[str, Any] | None = None) -> Future[Any]:
        """Queue a command of `graphrun ctl` for execution before the next tick; any thread may call this method.

        >>> done = sim.submit("push", {"entity": "dd100", "force": [0, 80, 0], "duration": 0.5})
        >>> sim.step()
        >>> done.result(timeout=0)

        Args:
            command: name of the command. `pause` and `stop` suspend a `run`, `play` and `step` resume it, and `quit` ends it. The
                other commands are `reset`, `rate`, `spawn`, `delete`, `move`, `reset-robot`, `push`, `fault`, `mend`,
                `command`, `set`, `impulse`, `press`, `release`, `reload` and `state`.
            arguments: arguments of the command, as JSON values.

        Returns:
            A future, which the session's thread completes with the result or with an exception: the exception of the
            command, UsageError for invalid arguments, or StateError if the session is closed before the
            command is executed.

        Raises:
            UsageError: an argument cannot be converted to JSON.
        """
        return self._runner.queue.submit(command, plain(arguments))

    def close(self) -> None:
        """End the session: run the graphs' closing events, then close the recording and the network.

        Safe to call twice.

        Raises:
            RecordingError: the recording cannot be written.
        """
        self._runner.close()

    def __repr__(self) -> str:
        inner = self._runner.session
        state = "closed" if self._runner.closed else inner.state
        return f"<Session of {self._runner.scene.path.stem}: {state}, t = {inner.time:.3f} s>"
