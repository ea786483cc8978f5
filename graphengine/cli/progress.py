"""Shows a progress bar on a terminal while a block of code runs, if it takes longer than `DELAY`."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from graphengine.cli import terminal

DELAY = 2.0
"""Wall time before the bar appears, s."""
PERIOD = 0.1
"""Wall time between two updates of the bar, s."""


@contextmanager
def progress(what: str, done: Callable[[], float] = lambda: 0.0, total: float | None = None) -> Iterator[None]:
    """Show a bar while a block runs.

    Args:
        what: label of the bar.
        done: returns the completed amount of work; called from another thread.
        total: total amount of work; None: it is unknown, and the bar shows activity only.
    """
    if not terminal.can_overwrite():
        yield
        return
    over = threading.Event()
    thread = threading.Thread(target=_show, args=(what, done, total, over), name="progress", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _show(what: str, done: Callable[[], float], total: float | None, over: threading.Event) -> None:
    """Draw the bar until `over` is set; runs in its own thread."""
    if over.wait(DELAY):
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    bar = BarColumn(max(min(40, terminal.width(sys.stderr) - len(what) - 15), 4))
    percent, left = TextColumn("{task.percentage:>3.0f} %"), TimeRemainingColumn(compact=True)
    columns = (bar, TimeElapsedColumn()) if total is None else (bar, percent, left)
    display = Progress(
        TextColumn("{task.description}", markup=False),
        *columns,
        console=terminal.make_console(),
        auto_refresh=False,
        transient=True,
        redirect_stdout=terminal.shows_stdout(),
    )
    with suppress(OSError):  # a closed terminal does not end the work
        try:
            terminal.start(display)
            task = display.add_task(what, total=total)
            while not over.wait(PERIOD):
                display.update(task, completed=done(), refresh=True)
        finally:
            display.stop()
