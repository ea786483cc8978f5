"""Shows the progress of a slow block of code: a bar on a terminal, elsewhere a line every `PLAIN` seconds."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from graphengine.cli import terminal
from graphengine.format.wording import printable

DELAY = 2.0
"""Wall time before the bar appears, s."""
PERIOD = 0.1
"""Wall time between two updates of the bar, s."""
PLAIN = 10.0
"""Wall time between two lines where there is no terminal, s."""


@contextmanager
def progress(what: str, done: Callable[[], float] = lambda: 0.0, total: float | None = None) -> Iterator[None]:
    """Show a bar while a block runs.

    Args:
        what: label of the bar.
        done: returns the completed amount of work; called from another thread.
        total: total amount of work; with None, the bar shows activity only, and no lines are printed.
    """
    what, overwrites = printable(what), terminal.can_overwrite()
    if not overwrites and (total is None or sys.stderr is None):
        yield
        return
    over = threading.Event()
    show = _show if overwrites else _print
    thread = threading.Thread(target=show, args=(what, done, total, over), name="progress", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def share_of(what: str) -> Iterator[Callable[[float], None]]:
    """Show a bar while a block runs, and yield a function that the block calls with the completed share, 0 to 1.

    Args:
        what: label of the bar.
    """
    share = 0.0

    def advance(completed: float) -> None:
        nonlocal share
        share = completed

    with progress(what, lambda: share, 1.0):
        yield advance


def _print(what: str, done: Callable[[], float], total: float | None, over: threading.Event) -> None:
    """Print a line with the completed share every `PLAIN` seconds until `over` is set; runs in its own thread."""
    with suppress(OSError):
        while not over.wait(PLAIN):
            print(f"{what}: {100.0 * min(done() / total, 1.0) if total else 0.0:.0f} %", file=sys.stderr, flush=True)


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
