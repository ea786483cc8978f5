"""The part of a terminal that is overwritten: a status line or a progress bar, below everything else that is printed."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.console import Console
    from rich.live import Live
    from rich.progress import Progress


def can_overwrite() -> bool:
    """Whether the standard error is a terminal on which a line can be overwritten."""
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")


def width(stream: TextIO) -> int:
    """Columns of the terminal that a stream goes to, whatever the environment says; 80 without a terminal."""
    try:
        return os.get_terminal_size(stream.fileno()).columns or 80
    except OSError:
        return 80


def shows_stdout() -> bool:
    """Whether the standard output is a terminal too, so that what is printed there has to go above the display."""
    return sys.stdout is not None and sys.stdout.isatty()


def make_console() -> Console:
    """A console of rich on the standard error, which `can_overwrite`. Long lines are left to the terminal to wrap."""
    from rich.console import Console

    return Console(
        stderr=True, force_terminal=True, force_interactive=True, highlight=False, markup=False, soft_wrap=True
    )


def start(display: Live | Progress) -> None:
    """Start a display. The cursor stays visible, so that a process that is killed leaves the terminal as it was."""
    display.start()
    display.console.show_cursor(True)


def start_live_line() -> Live:
    """A line below everything that Python prints to the terminal until it is stopped; empty until it is overwritten."""
    from rich.live import Live

    line = Live(console=make_console(), auto_refresh=False, transient=True, redirect_stdout=shows_stdout())
    start(line)
    return line


def overwrite(line: Live, parts: Iterable[tuple[str, str]], gap: str) -> None:
    """Show as many parts, each with its style, as fit in the width of the terminal."""
    from rich.text import Text

    shown, most = Text(no_wrap=True, overflow="crop"), width(sys.stderr) - 1
    for part, style in parts:
        before = gap if shown else ""
        if shown and len(shown) + len(before) + len(part) > most:
            break
        shown.append(before).append(part, style)
    shown.truncate(most)
    line.update(shown, refresh=True)
