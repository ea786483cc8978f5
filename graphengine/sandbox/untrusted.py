"""Encodes and decodes the results of confined processes as JSON, which an untrusted file may have forged.

A dataclass becomes an object with the same fields; a span becomes a list of path, line, column and length. The process writes
its result with `answer`. The caller decodes the result with `read`, which checks the types of all fields.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable
from dataclasses import fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from types import UnionType
from typing import IO, Any, Literal, NoReturn, TypeVar, get_args, get_origin, get_type_hints

from graphengine.format import bounded_json
from graphengine.format.diagnostics import Finding, Findings, Source, Span
from graphengine.format.files import Files
from graphengine.format.regular_files import open_regular
from graphengine.format.wording import printable
from graphengine.sandbox.confinement import ProcessError

MAX_SOURCES = 8_000_000
"""Maximum number of bytes that are read from files to quote their lines in findings; further lines are not quoted."""
MAX_FINDINGS = 1000
"""Maximum number of findings that are taken from a confined process."""
MAX_LINES = 100
"""Maximum number of help lines of one finding, and of related positions."""
MAX_FILES = 20_000
"""Maximum number of files that a process may report as read; further files are ignored."""
MAX_NUMBER = 1 << 31
"""Maximum line number, column number and length of a span."""
MAX_DEPTH = 10
"""Maximum nesting depth of lists in an attribute value."""

_T = TypeVar("_T")


class Sources:
    """Reads the files to which the spans of a result refer, each file once.

    Args:
        files: decides which files may be read.
        known: files that are already read.
    """

    def __init__(self, files: Files, *known: Source) -> None:
        self._files, self._left = files, MAX_SOURCES
        self._known = {os.path.abspath(source.path): source for source in known}

    def span(self, path: str, line: int, column: int, length: int) -> Span:
        """Return a span in a file; line, column and length are clamped to 1 to `MAX_NUMBER`.

        Raises:
            OSError, ValueError: the file cannot or may not be read.
        """
        key = os.path.abspath(path)
        if key not in self._known:
            if not self._files.may_read(Path(path)):
                raise ValueError(path)
            with open_regular(path) as file:
                raw = file.read(self._left)
            self._left -= len(raw)
            self._known[key] = Source(path, tuple(raw.decode("utf-8", "replace").split("\n")))
        return Span(self._known[key], *(min(max(number, 1), MAX_NUMBER) for number in (line, column, length)))


def read(answer: bytes, kind: type[_T], most: int, span: Callable[..., Span] = Span) -> _T:
    """Decode the output of a process as an instance of the dataclass `kind`.

    Args:
        answer: output of the process.
        kind: dataclass to create.
        most: maximum size of the output, bytes.
        span: creates the spans, from path, line, column and length.

    Raises:
        ProcessError: the output is malformed or too large.
    """
    if len(answer) > most:
        raise ProcessError(f"answers with more than {most // 1_000_000} MB", b"")
    try:
        found: _T = typed(kind, bounded_json.parse(answer, most), span)
    except (ValueError, TypeError, LookupError, AttributeError, OverflowError, OSError):
        raise ProcessError("sends a malformed answer", b"") from None
    return found


def typed(kind: Any, data: Any, span: Callable[..., Span]) -> Any:
    """Return decoded JSON data as an instance of the type `kind`; lone surrogates in strings are replaced.

    Raises:
        ValueError, TypeError, LookupError, AttributeError, OverflowError: the data does not have this type.
    """
    if type(data) is kind:  # first, because most parts of an answer are strings and numbers
        return data if kind is not str or data.isascii() else data.encode("utf-8", "replace").decode()
    origin, inner = _shape(kind)
    if origin is UnionType:
        return None if data is None else typed(inner[0], data, span)
    if kind is Span:
        return span(typed(str, data[0], span), *[typed(int, number, span) for number in data[1:]])
    if isinstance(kind, type) and is_dataclass(kind):
        return kind(**{name: typed(hint, data[name], span) for name, hint in _hints(kind).items()})
    if origin is dict:
        return {typed(inner[0], key, span): typed(inner[1], item, span) for key, item in data.items()}
    if origin in (list, set) and isinstance(data, list) and (inner[0] is not Finding or len(data) <= 20 * MAX_FINDINGS):
        return origin([typed(inner[0], item, span) for item in data])
    if origin is tuple and isinstance(data, list):
        kinds = inner[:1] * len(data) if ... in inner else inner
        return tuple(typed(one, part, span) for one, part in zip(kinds, data, strict=True))
    if kind is Any:
        return _value(data)
    if kind is float and type(data) is int:
        return float(data)
    if origin is Literal and data in inner:
        return data
    raise TypeError(kind)


def _value(data: Any, depth: int = 0) -> Any:
    """Check and return an attribute value: a string, a 64 bit number, a boolean, None, or nested lists of them."""
    if isinstance(data, list) and depth < MAX_DEPTH:
        return [_value(item, depth + 1) for item in data]
    if data is None or (isinstance(data, int) and -(2**63) <= data < 2**64):
        return data
    return typed(str if isinstance(data, str) else float, data, Span)


@lru_cache(maxsize=200)
def _shape(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    return get_origin(kind), get_args(kind)


_hints = lru_cache(maxsize=200)(get_type_hints)


def take_findings(found: Iterable[Finding], findings: Findings) -> None:
    """Add the findings of a process, errors first; after `MAX_FINDINGS`, add only the number of the others."""
    ordered = sorted(found, key=lambda finding: finding.severity != "error")
    for finding in ordered[:MAX_FINDINGS]:
        lines, related = map(printable, finding.help[:MAX_LINES]), finding.related[:MAX_LINES]
        findings.add(finding.code, printable(finding.message), finding.span, *lines, related=related)
    if len(ordered) > MAX_FINDINGS:
        findings.add("W302", f"{len(ordered) - MAX_FINDINGS} further findings are not listed")


def note_used(used: Iterable[str], files: Files) -> None:
    """Record in `files` the files that a process reports as read; files that may not be read are ignored."""
    for path in list(used)[:MAX_FILES]:
        if os.path.isfile(path) and files.may_read(Path(path)):
            files.note(Path(path))


def reply() -> IO[str]:
    """Return a stream to the stdout of this process. Redirect stdout to stderr, so libraries cannot write to the stream."""
    stream = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    return stream


def answer(stream: IO[str], find: Callable[[], object]) -> NoReturn:
    """Write the dataclass that `find` returns to the stream, and end this process at once.

    Python's normal shutdown is skipped, because the audit hook would refuse it.
    """
    try:
        stream.write(encoded(find()))
        stream.flush()
    except BaseException as error:  # TimeIsUpError may be raised at any moment
        os.write(2, f"ends without an answer: {type(error).__name__}".encode("utf-8", "replace"))
        os._exit(1)
    os._exit(0)


def encoded(data: object) -> str:
    """Return data as JSON text; the data may contain dataclasses, sets and spans."""
    return json.dumps(data, default=_plain)


def _plain(data: Any) -> Any:
    if isinstance(data, Span):
        return data.source.path, data.line, data.column, data.length
    if isinstance(data, set):
        return sorted(data)
    return {field.name: getattr(data, field.name) for field in fields(data)}
