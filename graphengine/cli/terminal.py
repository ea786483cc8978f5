"""Helpers for a live display on a terminal, such as a status line or progress bar, which stays below all other output."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich.console import Console
    from rich.live import Live
    from rich.progress import Progress


def can_overwrite() -> bool:
    """Return whether standard error is a terminal on which a line can be overwritten."""
    return _takes_sequences(sys.stderr)


def _takes_sequences(stream: TextIO | None) -> bool:
    """Return whether a stream is a terminal that understands escape sequences."""
    return stream is not None and stream.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")


def width(stream: TextIO) -> int:
    """Return the width of a stream's terminal in columns, or 80 if the stream is not a terminal.

    Unlike `shutil.get_terminal_size`, it does not read the environment variable COLUMNS.
    """
    try:
        return os.get_terminal_size(stream.fileno()).columns or 80
    except OSError:
        return 80


def uses_colours(stream: TextIO | None) -> bool:
    """Return whether to write colours to a stream: only to a terminal, unless NO_COLOR or FORCE_COLOR are set."""
    if os.environ.get("NO_COLOR"):
        return False
    return os.environ.get("FORCE_COLOR", "0") not in ("", "0") or _takes_sequences(stream)


_WHOLE = re.compile(r"^ *\d* +\| |.graphrun |.cd |--allow |pip install")
"""Matches a line that is not wrapped, because the line shows a file or because users copy a command from it."""
_TOGETHER = re.compile(r"--[\w-]+ |'[^']*/[^']*'")
"""Matches a part of a line that is not split at its spaces: an option with its value, or a quoted path."""


def wrapped(text: str, stream: TextIO | None) -> str:
    """Return a message, for a terminal with its long lines wrapped between words, except lines with commands."""
    if stream is None or not stream.isatty():
        return text
    most, lines = width(stream), list[str]()
    for line in text.split("\n"):
        below = " " * (len(line) - len(line.lstrip()) + 2)
        wraps = len(line) > most and not _WHOLE.search(line)
        options: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
        line = _TOGETHER.sub(lambda part: part[0].replace(" ", "\0"), line) if wraps else line
        lines += textwrap.wrap(line, most, subsequent_indent=below, **options) if wraps else [line]
    return "\n".join(lines).replace("\0", " ")


def shows_stdout() -> bool:
    """Return whether standard output is a terminal; its text must then be printed above the live display."""
    return sys.stdout is not None and sys.stdout.isatty()


def make_console() -> Console:
    """Return a rich console on standard error that leaves the wrapping of long lines to the terminal.

    Call it only if `can_overwrite` returns true.
    """
    from rich.console import Console

    return Console(
        stderr=True, force_terminal=True, force_interactive=True, highlight=False, markup=False, soft_wrap=True
    )


def start(display: Live | Progress) -> None:
    """Start a display and show the cursor, which rich hides; after a kill of the process, the cursor would stay hidden."""
    display.start()
    display.console.show_cursor(True)


def start_live_line() -> Live:
    """Start and return an empty line that stays below all output of this program until the caller stops it."""
    from rich.live import Live

    line = Live(console=make_console(), auto_refresh=False, transient=True, redirect_stdout=shows_stdout())
    start(line)
    return line


def overwrite(line: Live, parts: Iterable[tuple[str, str]], gap: str) -> None:
    """Overwrite a live line.

    Args:
        line: line from `start_live_line`.
        parts: texts in order of importance, each with its style for rich; texts beyond the width are left out.
        gap: text between two parts.
    """
    from rich.text import Text

    shown, most = Text(no_wrap=True, overflow="crop"), width(sys.stderr) - 1
    for part, style in parts:
        before = gap if shown else ""
        if shown and len(shown) + len(before) + len(part) > most:
            break
        shown.append(before).append(part, style)
    shown.truncate(most)
    line.update(shown, refresh=True)
