"""Prints the output of a run on standard error: a status line, messages of nodes, and a summary."""

from __future__ import annotations

import contextlib
import math
import re
import sys
import time
from typing import TYPE_CHECKING, Any

from graphengine.cli import terminal
from graphengine.cli.common import clean, counted, explain
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import NodeError, StateError
from graphengine.runtime.run_status import RunStatus, StatusMeter

if TYPE_CHECKING:
    from concurrent.futures import Future

    from rich.live import Live

    from graphengine.ros.network import LiveNetwork
    from graphengine.runtime.session_core import SessionCore

LATE_PICTURE = """an image came too late and was dropped
  rendering does not keep up: make images smaller or fewer, or run slower, as with --rate 0.5"""
GAP = "  "
"""Separator between two values of the status line."""


class Console:
    """Prints the status of a run, the messages of its nodes, and a summary at the end.

    On a terminal, each status overwrites the previous one; elsewhere each status is a new line. Errors of the output, such as a
    closed terminal or a full disk, do not end the run.

    Args:
        quiet: print only warnings, errors and losses, such as dropped messages.
    """

    LIVE, PLAIN = 0.25, 10.0  # seconds of wall time between two lines

    network: LiveNetwork
    """Network of the session; the caller must set it before the first tick."""

    def __init__(self, *, quiet: bool = False) -> None:
        self.quiet = quiet
        self.said: set[tuple[str, str, str]] = set()
        self.faults = 0
        self.last_line = ""
        self._overwrites = terminal.can_overwrite()
        self._period = self.LIVE if self._overwrites else self.PLAIN
        self._live: Live | None = None

    def begin(self, session: SessionCore) -> None:
        """Start the status line and the measurement of wall and CPU time, which thus exclude the setup of the run."""
        if self._overwrites and not self.quiet:
            with contextlib.suppress(OSError):
                self._live = terminal.start_live_line()
        self.start = self.last = time.perf_counter()
        self.cpu_start = time.thread_time()
        self._meter = StatusMeter(session)

    def tell(self, text: str) -> None:
        """Print a text to standard error and flush it; errors of the output are ignored."""
        with contextlib.suppress(OSError):
            print(text, file=sys.stderr, flush=True)

    def inform(self, text: str) -> None:
        """Print a text to standard error, unless the console is quiet; errors of the output are ignored."""
        if not self.quiet:
            self.tell(text)

    def say(self, severity: str, node: str, message: str) -> None:
        """Print the message of a node, unless the node has sent a message with the same severity and first line before."""
        key = (severity, node, message.partition("\n")[0])
        if key not in self.said and not (self.quiet and severity == "info"):
            self.said.add(key)
            # Further lines are indented, so that a text of the network cannot pass for a message of the run.
            self.tell(clean(re.sub(r"\n(?! )", "\n  ", f"{severity}: {node + ': ' if node else ''}{message}")))

    def fault(self, error: NodeError) -> None:
        """Count and print an exception of a node that does not end the run."""
        self.faults += 1
        self.say("error", "", explain(error))

    def reloaded(self, reload: Future[Any]) -> None:
        """Print the result of a completed reload: the changes, or the errors in the changed files."""
        if (error := reload.exception()) is None:
            done = reload.result()
            lines = [*done["warnings"], *([done["text"]] if done["files"] or done["mended"] else [])]
        elif isinstance(error, CheckError):
            errors = counted(len(error.findings), "error")
            lines = [str(error), f"{errors} in changed files; the run continues with the previous version"]
        elif isinstance(error, StateError):  # the run ends
            return
        else:
            lines = [f"error: {error}", "the run continues with the previous version of the files"]
        for line in lines:
            self.tell(clean(line))

    def on_tick(self, session: SessionCore) -> bool:
        """Update the status line, and return True; called after each tick, and repeatedly while the run is paused."""
        if session.state != "playing":
            self.network.look()
        for camera in session.services.world.dropped_pictures:
            self.say("warning", camera, LATE_PICTURE)
        now = time.perf_counter()
        if now - self.last >= self._period and not self.quiet:
            self.last = now
            self._show(_facts(self._meter.read()))
        return True

    def _show(self, facts: list[tuple[str, str]]) -> None:
        """Overwrite the status line on a terminal; elsewhere print the values, unless they equal those of the last line."""
        if self._live is not None:
            try:
                terminal.overwrite(self._live, facts, GAP)
            except OSError:  # the terminal was closed, and pending output would accumulate
                self._clear_line()
                self._period = math.inf
            return
        line = GAP.join(fact for fact, _ in facts)
        if line != self.last_line:
            self.tell(line)
        self.last_line = line

    def _clear_line(self) -> None:
        """Stop and clear the status line on a terminal."""
        if self._live is not None:
            with contextlib.suppress(OSError):
                self._live.stop()
            self._live = None

    def summarize(self, session: SessionCore) -> None:
        """Print all losses, such as dropped messages; then the number of ticks, the simulated time, speed and messages."""
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
            self.tell(f"came too late and dropped: {counted(number, 'image')} of {camera}")
        for fate, messages in (
            ("malformed and dropped", self.network.malformed),
            ("overwritten before a tick read them", self.network.overwritten),
            ("given up on a reader that did not keep up", self.network.given_up),
        ):
            for topic, number in sorted(messages.items()):
                self.tell(f"{fate}: {counted(number, 'message')} of {topic}")
        if self.network.sent < ticks and self.network.publishers and not self.network.subscribers:
            self.inform("few messages: topics without subscribers send only what late subscribers get")
        self.inform(
            f"{counted(ticks, 'tick')}, {simulated:.3f} s of simulation in {wall:.3f} s (x{simulated / wall:.2f}), "
            f"{tick * 1e3:.3f} ms a tick, {counted(self.network.sent, 'message')}{faults}"
        )


def _facts(status: RunStatus) -> list[tuple[str, str]]:
    """Return the texts of the status line in order of importance, each with its style for rich."""
    late, dropped, size = status.late_ticks, status.dropped_values, status.recorded_bytes
    facts = [
        (f"t {status.time:.2f} s", "bold"),
        (f"x{status.real_time_factor:.2f}", "") if status.state == "playing" else (status.state, "cyan"),
        (f"{late} late", "yellow" if late else ""),
        (f"{status.message_rate:.0f} messages/s", ""),
        (counted(status.subscribers, "subscriber"), ""),
        (f"{dropped} dropped", "yellow" if dropped else ""),
    ]
    if status.file_errors:
        facts.insert(1, (f"{counted(status.file_errors, 'error')} in changed files", "red"))
    facts += [(f"REC {size / 1e6:.1f} MB", "red")] if size is not None else []
    return facts + ([(f"{status.tick_cpu * 1e3:.2f} ms a tick", "")] if status.tick_cpu else [])
