"""A live display on a terminal, a status line or a progress bar, below all other output."""

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
    """Return whether the standard error is a terminal on which a line can be overwritten."""
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")


def width(stream: TextIO) -> int:
    """Return the width of a stream's terminal in columns, without reading environment variables; 80 without a terminal."""
    try:
        return os.get_terminal_size(stream.fileno()).columns or 80
    except OSError:
        return 80


def shows_stdout() -> bool:
    """Return whether the standard output is a terminal too, so that its output must be printed above the display."""
    return sys.stdout is not None and sys.stdout.isatty()


def make_console() -> Console:
    """Return a rich console on the standard error; requires `can_overwrite`. The terminal wraps long lines."""
    from rich.console import Console

    return Console(
        stderr=True, force_terminal=True, force_interactive=True, highlight=False, markup=False, soft_wrap=True
    )


def start(display: Live | Progress) -> None:
    """Start a display. The cursor stays visible, so that a killed process does not leave it hidden."""
    display.start()
    display.console.show_cursor(True)


def start_live_line() -> Live:
    """Start an empty line that stays below all output of Python to the terminal until it is stopped."""
    from rich.live import Live

    line = Live(console=make_console(), auto_refresh=False, transient=True, redirect_stdout=shows_stdout())
    start(line)
    return line


def overwrite(line: Live, parts: Iterable[tuple[str, str]], gap: str) -> None:
    """Show the parts, each with its style, that fit in the width of the terminal."""
    from rich.text import Text

    shown, most = Text(no_wrap=True, overflow="crop"), width(sys.stderr) - 1
    for part, style in parts:
        before = gap if shown else ""
        if shown and len(shown) + len(before) + len(part) > most:
            break
        shown.append(before).append(part, style)
    shown.truncate(most)
    line.update(shown, refresh=True)
