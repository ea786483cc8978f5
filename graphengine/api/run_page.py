"""Samples a running session, and writes one HTML file with its 3D picture, plots, marks and log."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.api.after_tick import AfterTick
from graphengine.api.recording_page import MAX_ENTRIES, log_entry
from graphengine.recording.marks import LONGEST
from graphengine.view.html.html_file import LogEntry, Plot, robot_plots, write_html
from graphengine.view.html.trace import SceneTrace

if TYPE_CHECKING:
    from graphengine.api.session import Session


class RunPage(AfterTick):
    """The samples and the log of a session from its start; `write` writes the HTML file.

    Pass `log` to `Scene.session`, and the session to `watch`, before the first tick.
    """

    def __init__(self) -> None:
        self._trace: SceneTrace | None = None
        self._log: list[LogEntry] = []
        self._plots: list[Plot] = []
        self._tick = 0

    def log(self, severity: str, node: str, text: str) -> None:
        """Add a message of a node."""
        if len(self._log) < MAX_ENTRIES:
            self._log.append(log_entry(self._tick, severity, node, text))

    def watch(self, session: Session) -> None:
        """Begin to sample a session."""
        self._trace = SceneTrace(session._runner.session)
        self._trace.sample(0)
        session._runner.after_ticks[self] = self

    def after_tick(self, frame: int) -> None:
        """Take a sample of the session."""
        assert self._trace is not None
        self._tick += 1
        self._trace.sample(self._tick)

    def plot(self, name: str, times: Sequence[float], values: Sequence[float], least: float | None = None) -> None:
        """Add a plot of values over time to the page.

        Args:
            name: name of the values.
            times: times of the values, s, in ascending order.
            values: one value for each time.
            least: smallest legal value, which the plot shows as a line; None: no line.
        """
        self._plots.append(Plot(name, times, values, limits=(least, None)))

    def write(self, path: Path, *, title: str, marks: Sequence[tuple[float, str]] = ()) -> None:
        """Write the file, unless no session has been watched; an older file is replaced when the new one is complete.

        Args:
            path: file to write.
            title: title of the page.
            marks: simulation time, s, and text of each mark on the time bar.

        Raises:
            OSError: the file cannot be written.
        """
        trace = self._trace
        if trace is None:
            return
        placed = [LogEntry(max(round(time / trace.period), 1), "verdict", text[:LONGEST]) for time, text in marks]
        plots = [*self._plots, *robot_plots(trace)]
        write_html(trace, path, title=title, plots=plots, marks=placed, log=self._log)
