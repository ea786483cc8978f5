"""Findings: errors, warnings and notes about files, each with a code, a message, a position and help.

`errors` has all exceptions except CheckError, and `wording` has helpers for the text of messages.
"""

from __future__ import annotations

import json
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from graphengine.format.errors import GraphError
from graphengine.format.wording import did_you_mean, printable

Severity = Literal["error", "warning", "note"]

_TITLES = dict(line.split(" ", 1) for line in Path(__file__).with_name("codes.txt").read_text("utf-8").splitlines())
GROUPS = {code: title for code, title in _TITLES.items() if len(code) == 2}
"""Title of each group of codes, by the two characters with which the codes of the group begin."""
CODES = {code: title for code, title in _TITLES.items() if code not in GROUPS}
"""Title of each finding code; codes begin with G for errors in graphs, S for errors in scenes, W for warnings, N for notes."""


@dataclass(frozen=True, slots=True)
class Source:
    """The path and lines of a file, from which a finding shows its source line."""

    path: str
    lines: tuple[str, ...] = field(repr=False)
    label: str = ""
    """Name that messages show instead of the path; empty for a file."""
    keys: dict[int, str] = field(default_factory=dict, repr=False, compare=False)
    """Path of the key on each line, such as `robots.bot.use`, for messages instead of line and column; empty for YAML text."""


@dataclass(frozen=True, slots=True)
class Span:
    """A range of characters on one line of a file: the position of the first character, counted from 1, and the length."""

    source: Source
    line: int
    column: int
    length: int = 1
    parameter: str = field(default="", kw_only=True)
    """Name of the graph parameter whose value is written at this position; empty at all other positions."""
    through: tuple[tuple[Span, str], ...] = field(default=(), kw_only=True)
    """Position of each `$(name)` through which the parameter value gets from here to the node that uses it, each with a note."""

    def __str__(self) -> str:
        name = printable(self.source.label or self.source.path)
        if self.source.keys:
            return ": ".join(filter(None, (name, printable(self.source.keys.get(self.line, "")))))
        return f"{name}:{self.line}:{self.column}"

    def part(self, offset: int, length: int) -> Span:
        """Return a span of `length` characters on the same line, `offset` characters after the start of this span."""
        return replace(self, column=self.column + offset, length=max(length, 1))


@dataclass(frozen=True, slots=True)
class Finding:
    """One error, warning or note about a file: code, message, position, help lines, and related positions with labels."""

    code: str
    message: str
    span: Span | None = None
    help: tuple[str, ...] = ()
    related: tuple[tuple[Span, str], ...] = ()
    cause: Span | None = field(default=None, kw_only=True)
    """Position of another error that may be the cause of this finding; the finding is listed after the cause."""

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise ValueError(f"unknown finding code {self.code!r}")

    @property
    def severity(self) -> Severity:
        """Severity from the first letter of the code: `error` for G and S, `warning` for W, `note` for N."""
        return {"W": "warning", "N": "note"}.get(self.code[0], "error")  # type: ignore[return-value]

    def render(self) -> str:
        """Return the finding as lines of text: position, code, message, source line with carets, help, and related positions."""
        where = f"{self.span}: " if self.span else ""
        first, *more = self.message.split("\n")
        parts = [f"{where}{self.severity} {self.code}: {printable(first)}"]
        if self.span:
            parts += _excerpt(self.span)
        parts += [f"  {printable(line)}" for line in (*more, *self.help)]
        for span, label in self.related:
            parts.append(f"  {span}: {printable(label)}")
            parts += _excerpt(span)
        return "\n".join(parts)

    def record(self) -> dict[str, Any]:
        """Return the finding as a dictionary that can be written as JSON."""
        return {
            "code": self.code,
            "title": CODES[self.code],
            "severity": self.severity,
            "message": self.message,
            **_place(self.span),
            "help": list(self.help),
            "related": [{**_place(span), "message": label} for span, label in self.related],
        }


def _start(span: Span | None) -> tuple[str, int, int] | None:
    """Return path, line and column of a span, for the comparison of findings."""
    return None if span is None else (span.source.path, span.line, span.column)


def _place(span: Span | None) -> dict[str, Any]:
    if span is None:
        return {"path": None, "line": None, "column": None, "length": None}
    return {"path": span.source.path, "line": span.line, "column": span.column, "length": span.length}


_WIDTH = 160


def _excerpt(span: Span) -> list[str]:
    """Return the source line, and a line with carets below the text of the span; a very long line is cut around the span."""
    if not 1 <= span.line <= len(span.source.lines):
        return []
    line = span.source.lines[span.line - 1]
    length = len(line) - line.endswith("\r")
    start = max(0, min(span.column - 1 - _WIDTH // 2, length - _WIDTH))
    text = printable(line[start : min(start + _WIDTH, length)].replace("\t", " "))
    if start > 0:
        text = f"…{text[1:]}"
    if start + _WIDTH < length:
        text = f"{text[:-1]}…"
    at = max(span.column - 1 - start, 0)
    before, below = text[:at], text[at : at + max(span.length, 1)] or " "
    number = "" if span.source.keys else span.line
    return [f"{number:>6} | {text}", f"       | {' ' * _width(before)}{'^' * max(_width(below), 1)}"]


def _width(text: str) -> int:
    """Return the width of a text in terminal columns."""
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in ("W", "F") else 1 for c in text
    )


MAX_ERRORS = 1000
"""Maximum number of errors that `Findings` lists; all later findings are dropped."""
MAX_GUESSES = 50
"""Maximum number of searches for similar names, for suggestions such as `did you mean …`."""


class CheckError(GraphError):
    """Errors in the files of a graph or scene."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        super().__init__("\n".join(finding.render() for finding in findings))
        self.findings = tuple(findings)


@dataclass(slots=True)
class Findings:
    """A list to which all checks add findings, so that one run reports all errors instead of only the first."""

    items: list[Finding] = field(default_factory=list)
    _known: set[object] = field(default_factory=set, repr=False)
    _errors: int = 0
    _guesses: int = 0

    def add(
        self,
        code: str,
        message: str,
        span: Span | None = None,
        *help: str,
        related: Iterable[tuple[Span, str]] = (),
        cause: Span | None = None,
    ) -> None:
        """Make a finding without empty help lines, and append it as `put` does."""
        self.put(Finding(code, message, span, tuple(line for line in help if line), tuple(related), cause=cause))

    def put(self, finding: Finding) -> None:
        """Append a finding unless the list is full or has an equal finding.

        An error in a parameter value that several nodes use is reported once.
        """
        if self.full:
            return
        related = tuple((_start(span), label) for span, label in finding.related)
        key: object = (finding.code, finding.message, _start(finding.span), finding.help, related)
        if finding.span is not None and finding.span.through:
            key = (finding.code, _start(finding.span), finding.message.partition(": ")[2] or finding.message)
            finding = replace(finding, related=(*finding.span.through, *finding.related))
        if key in self._known:
            return
        self._known.add(key)
        self._errors += finding.severity == "error"
        if self._errors > MAX_ERRORS:
            finding = Finding("G105", f"more than {MAX_ERRORS} errors; further findings are not listed")
        self.items.append(finding)

    def guess(self, name: str, legal: Iterable[str]) -> str:
        """Return a suggestion such as `did you mean 'dd100'?`; empty if no legal name is similar.

        After MAX_GUESSES calls the result is always empty, because each search takes milliseconds.
        """
        self._guesses += 1
        return did_you_mean(name, legal) if self._guesses <= MAX_GUESSES else ""

    @property
    def full(self) -> bool:
        """Whether the list has more than the maximum number of errors; all later findings are dropped."""
        return self._errors > MAX_ERRORS

    @property
    def errors(self) -> list[Finding]:
        """All findings of severity `error`; a graph or scene with errors cannot run."""
        return [f for f in self.items if f.severity == "error"]

    @property
    def warnings(self) -> list[Finding]:
        """All findings of severity `warning`; with --strict, `graphrun check` fails on them."""
        return [f for f in self.items if f.severity == "warning"]

    def sorted(self) -> list[Finding]:
        """Return the findings file by file, in the order in which the files first occur; within a file, sorted by position.

        A finding that may follow from another error is listed after this error.
        """
        files: dict[str, int] = {}
        for item in self.items:
            files.setdefault(item.span.source.path if item.span else "", len(files))

        def key(item: Finding) -> tuple[int, int, int, bool, str]:
            span = item.cause or item.span
            if span is None:
                return (files[""], 0, 0, False, item.code)
            return (files.get(span.source.path, 0), span.line, span.column, item.cause is not None, item.code)

        return sorted(self.items, key=key)

    def raise_errors(self) -> None:
        """Raise a CheckError with all findings if at least one finding is an error."""
        if self.errors:
            raise CheckError(self.sorted())


def to_json(findings: Sequence[Finding]) -> str:
    """Return findings as the text of a JSON list."""
    return json.dumps([finding.record() for finding in findings], indent=2)
