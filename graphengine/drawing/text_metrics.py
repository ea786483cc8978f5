"""Text widths that are the same on every machine, and truncation.

No font is loaded. The widths are at least those of DejaVu Sans, one of the widest fonts that browsers use for `sans-serif`. So a
text also fits its box in other fonts.
"""

from __future__ import annotations

import unicodedata

from graphengine.format.wording import printable

FONTS = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"

_WIDTHS = (
    ("'ijl", 0.29),
    (" ,./:;I\\|", 0.34),
    ("-ft()[]!r", 0.42),
    ('"J_`szc?', 0.55),
    ("*FLPTYkvxy", 0.62),
    ("abdeghnopquES0123456789${}", 0.64),
    ("ABCKRVXZ", 0.70),
    ("DGHNOQU&", 0.79),
    ("#+<=>^~w", 0.84),
    ("Mm%W@", 1.0),
)
"""Upper bounds of the widths of characters, relative to the font size."""
_WIDTH_OF = {letter: width for letters, width in _WIDTHS for letter in letters}
_BOLD = 1.2
"""Upper bound of the ratio between the bold and the regular width of a character."""
_WIDE = 1.4
"""Width of an ideograph or emoji, relative to the font size."""
_OTHER = 1.05
_ROUNDING = 1e-6
"""Tolerance for rounding errors in sums of widths."""


def width(text: str, size: float, *, bold: bool = False) -> float:
    """Return an upper bound of a text's width, in the unit of `size`."""
    return size * (_BOLD if bold else 1.0) * sum(map(_letter, text))


def _letter(letter: str) -> float:
    known = _WIDTH_OF.get(letter)
    if known is not None:
        return known
    if unicodedata.combining(letter):
        return 0.0
    return _WIDE if unicodedata.east_asian_width(letter) in ("W", "F") or ord(letter) > 0xFFFF else _OTHER


def fitted(text: str, size: float, limit: float, *, bold: bool = False, tail: bool = False) -> str:
    """Return the text in printable form, shortened to a width of at most `limit`.

    A shortened text keeps its beginning and ends in `…`; with `tail`, it keeps its end and begins with `…`.
    """
    text = printable(text)
    if width(text, size, bold=bold) <= limit:
        return text
    room = limit - width("…", size, bold=bold) - _ROUNDING
    kept: list[str] = []
    for letter in reversed(text) if tail else text:
        room -= width(letter, size, bold=bold)
        if room < 0:
            break
        kept.append(letter)
    return f"…{''.join(reversed(kept))}" if tail else f"{''.join(kept)}…"
