"""Helpers for the text of messages: suggestions of similar names, lists of names, and safe printing of text from files."""

from __future__ import annotations

import bisect
import difflib
import functools
import re
import shlex
from collections.abc import Iterable, Sequence

_LONGEST = 2000
"""Maximum length of a file's text in a message, characters."""


def printable(text: str) -> str:
    """Return a text in which U+FFFD replaces each control character and line end; a very long text is cut."""
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def quoted(word: object) -> str:
    """Return a printable word for a command that users copy into a shell, in quotes if the shell needs quotes."""
    return shlex.quote(printable(str(word)))


def allowing(folder: object) -> str:
    """Return the remedy for a file that may not be read: the option that allows its folder."""
    return f"allow it with --allow {quoted(folder)}"


_MANY = 1000
"""Number of names above which `did_you_mean` compares only names with the same first letter and a similar length."""
_BESIDE = 150
_ALIKE = 0.6
"""Lowest `SequenceMatcher.ratio` of a suggestion and the name: 0 without common letters, 1 for equal names."""


def _worth_comparing(name: str, legal: Iterable[str]) -> list[str]:
    """Return the legal names to compare with `name`: all, or if there are more than `_MANY`, only those with similar spelling."""
    names = set(legal)
    if len(names) <= _MANY:
        return sorted(names)
    alike = sorted(other for other in names if other[:1] == name[:1] and abs(len(other) - len(name)) < 3)
    place = bisect.bisect(alike, name)
    return alike[max(0, place - _BESIDE) : place + _BESIDE]


def did_you_mean(name: str, legal: Iterable[str]) -> str:
    """Return a suggestion such as `did you mean 'dd100'?` with the most similar legal names; empty if no name is similar."""
    near = similar(name, legal)
    return f"did you mean {' or '.join(map(repr, near))}?" if near else ""


def similar(name: str, legal: Iterable[str]) -> Sequence[str]:
    """Return the up to three legal names that are most similar to a name, the most similar first."""
    return _similar(name[:200], tuple(_worth_comparing(name[:200], legal)))


@functools.lru_cache(maxsize=200)
def _similar(name: str, names: Sequence[str]) -> Sequence[str]:
    close = difflib.get_close_matches(name, names, n=10, cutoff=_ALIKE)
    near = [other for other in close if _differ_little(name, other)]
    if near:
        scores = {other: difflib.SequenceMatcher(None, other, name).ratio() for other in near}
        nearest = max(scores.values())
        near = sorted((o for o in near if scores[o] > nearest - 0.05), key=lambda other: (-scores[other], other))[:3]
    else:
        folded = {n.lower(): n for n in names}
        near = [folded[name.lower()]] if name.lower() in folded else []
    return near


def _differ_little(name: str, other: str) -> bool:
    """Return whether two names are similar without the folders, namespaces and suffixes that they share.

    The names `nope.yaml` and `demo.yaml` have half of their letters in common, but only because of the suffix.
    """
    one, two = re.split(r"(^--|[/.:])", name), re.split(r"(^--|[/.:])", other)
    for end in (0, -1):
        while one and two and one[end] == two[end]:
            del one[end], two[end]
    parts = "".join(one), "".join(two)
    return not all(parts) or difflib.SequenceMatcher(None, *parts).ratio() >= _ALIKE


def unknown(what: str, name: str, legal: Iterable[str]) -> str:
    """Return the message `no WHAT NAME`, such as `no robot 'doog'`, and a second line with a suggestion or the legal names."""
    names = list(dict.fromkeys(legal))
    return f"no {what} {name!r}\n  {did_you_mean(name, names) or listing(names, f'{what}s')}"


def listing(names: Iterable[str], what: str = "legal", most: int = 20) -> str:
    """Return a text such as `legal: a, b, c` with up to `most` names, and the number of the other names."""
    all_names = list(names)
    if not all_names:
        return f"{what}: none"
    more = f", … ({len(all_names) - most} more)" if len(all_names) > most else ""
    return f"{what}: {', '.join(all_names[:most])}{more}"


def got_value(error: object, value: object) -> str:
    """Return the text `, got VALUE` for the end of an error message; empty if the message already has such a text."""
    return "" if ", got " in str(error) else f", got {shown(value)}"


def shown(value: object) -> str:
    """Return a short form of a value from a file, for messages such as `got …`."""
    if isinstance(value, bool):
        return str(value).lower()
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return "a mapping"
    text = "a list" if isinstance(value, list) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
