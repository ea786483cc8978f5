"""Output of a run on the standard error: a status line, messages of nodes, and a summary."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import time
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import clean, counted, explain
from graphengine.format.errors import CheckError, NodeError, StateError

if TYPE_CHECKING:
    from concurrent.futures import Future

    from graphengine.ros.network import LiveNetwork
    from graphengine.runtime.session_core import SessionCore

LATE_PICTURE = """a picture came too late and was dropped
  drawing does not keep up: make pictures smaller or fewer, or run slower, as with --rate 0.5"""


class Console:
    """Prints a run's status (a live line on a terminal, else plain lines), messages of nodes, and a summary at the end.

    A closed terminal or a full disk does not end the run.
    """

    LIVE, PLAIN = 0.25, 10.0  # seconds of wall time between two lines

    network: LiveNetwork
    """Of the session, to be set before the first tick."""

    def __init__(self) -> None:
        self.terminal = sys.stderr is not None and sys.stderr.isatty()
        self.said: set[tuple[str, str, str]] = set()
        self.faults = 0
        self.last_sent = 0
        self.last_ticks = 0
        self.last_line = ""
        self.begin()

    def begin(self) -> None:
        """Start measuring time and work of the run, without its setup."""
        self.start = self.last = time.perf_counter()
        self.cpu_start = self.last_cpu = time.thread_time()

    def tell(self, text: str, end: str = "\n") -> None:
        """Print and flush; output errors are ignored."""
        with contextlib.suppress(OSError):
            print(text, end=end, file=sys.stderr, flush=True)

    def say(self, severity: str, node: str, message: str) -> None:
        """Print a node's message; a repeated first line is printed once."""
        key = (severity, node, message.partition("\n")[0])
        if key not in self.said:
            self.said.add(key)
            self._clear_line()
            # Further lines are indented, so that a text of the network cannot pass for a message of the run.
            self.tell(clean(re.sub(r"\n(?! )", "\n  ", f"{severity}: {node + ': ' if node else ''}{message}")))

    def fault(self, error: NodeError) -> None:
        """Print the error of a node in a run that continues."""
        self.faults += 1
        self.say("error", "", explain(error))

    def reloaded(self, reload: Future[Any]) -> None:
        """Print what a reload did, or what is wrong with the files."""
        if (error := reload.exception()) is None:
            done = reload.result()
            lines = [*done["warnings"], *([done["text"]] if done["files"] or done["mended"] else [])]
        elif isinstance(error, CheckError):
            errors = counted(len(error.findings), "error")
            lines = [str(error), f"{errors} in changed files; the run goes on with the files before"]
        elif isinstance(error, StateError):  # the run ends
            return
        else:
            lines = [f"error: {error}", "the run goes on with the files before"]
        self._clear_line()
        for line in lines:
            self.tell(clean(line))

    def on_tick(self, session: SessionCore) -> bool:
        """Update the status line; called after each tick and while paused. Always returns True."""
        if session.state != "playing":
            self.network.look()
        for camera in session.services.world.dropped_pictures:
            self.say("warning", camera, LATE_PICTURE)
        now = time.perf_counter()
        if now - self.last >= (self.LIVE if self.terminal else self.PLAIN):
            errors = f"   {counted(len(session.findings), 'error')} in changed files" if session.findings else ""
            self._show(self._line(session, now - self.last) + errors)
            self.last, self.last_cpu = now, time.thread_time()
            self.last_sent, self.last_ticks = self.network.sent, session.ticks
        return True

    def _line(self, session: SessionCore, elapsed: float) -> str:
        """The status line: time, state and the speed since the last line."""
        ticks = session.ticks - self.last_ticks
        if not ticks and session.state != "playing":
            return f"t {session.time:9.2f} s   {session.state}"
        factor = ticks * session.clock.delta / elapsed
        tick = (time.thread_time() - self.last_cpu) / ticks if ticks else 0.0
        out = (self.network.sent - self.last_sent) / elapsed
        return (
            f"t {session.time:9.2f} s   real time x{factor:<6.2f} tick {tick * 1e3:6.2f} ms   out {out:6.0f} messages/s"
        )

    def _show(self, line: str) -> None:
        """Overwrite the live line on a terminal; elsewhere print the line unless it is unchanged."""
        if self.terminal:
            self.tell(f"\r{line[: self._columns()]}\x1b[K", end="")
        elif line != self.last_line:
            self.tell(line)
        self.last_line = line

    def _columns(self) -> int | None:
        """Longest line that can be overwritten, as it does not wrap; None if the output is not a terminal."""
        try:
            columns = os.get_terminal_size(sys.stderr.fileno()).columns
        except OSError:
            columns = 0
        return columns - 1 if columns else None

    def _clear_line(self) -> None:
        if self.terminal:
            self.tell("\r\x1b[K", end="")

    def summarize(self, session: SessionCore) -> None:
        """Print the summary: what was done and how fast."""
        self._clear_line()
        wall = time.perf_counter() - self.start
        ticks, simulated = session.ticks, session.ticks * session.clock.delta
        tick = (time.thread_time() - self.cpu_start) / ticks if ticks else 0.0
        faults = f", {counted(self.faults, 'fault')}" if self.faults else ""
        dropped = session.services.dropped
        for node, number in sorted(dropped.ticks.items()) if dropped is not None else ():
            self.tell(clean(f"dropped bad values: in {counted(number, 'tick')} at {node}"))
        for command, number in sorted(session.services.world.clamped_commands.items()):
            self.tell(clean(f"clamped: {counted(number, 'command')}, {command}"))
        for camera, number in session.services.world.dropped_pictures.items():
            self.tell(f"came too late and dropped: {counted(number, 'picture')} of {camera}")
        for fate, messages in (
            ("malformed and dropped", self.network.malformed),
            ("overwritten before a tick took them", self.network.overwritten),
            ("given up on a reader that did not keep up", self.network.given_up),
        ):
            for topic, number in sorted(messages.items()):
                self.tell(f"{fate}: {counted(number, 'message')} of {topic}")
        self.tell(
            f"{counted(ticks, 'tick')}, {simulated:.3f} s of simulation in {wall:.3f} s (x{simulated / wall:.2f}), "
            f"{tick * 1e3:.3f} ms a tick, {counted(self.network.sent, 'message')}{faults}"
        )
