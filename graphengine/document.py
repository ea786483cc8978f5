"""YAML to plain data that remembers where each value stood; everything a file may hold is bounded here.

YAML 1.2 core rules decide what a plain scalar is: `no` and `12:30:00` are strings, `1e3` is a number. The parser's event stream
is read in a loop, not by recursion, so that depth is a limit of ours and not of the C stack.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from graphengine.diagnostics import Findings, Source, Span

MAX_BYTES = 8_000_000
MAX_DEPTH = 64
MAX_VALUES = 400_000
"""Values in a document, counted again for each alias that repeats them."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Only its event parser is used: 15 times faster with libyaml."""

_NULL = re.compile(r"(?:~|null|Null|NULL|)\Z")
_BOOL = re.compile(r"(?:true|True|TRUE|false|False|FALSE)\Z")
_INT = re.compile(r"[-+]?[0-9]+\Z")
_OCTAL = re.compile(r"0o[0-7]+\Z")
_HEX = re.compile(r"0x[0-9a-fA-F]+\Z")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_INF = re.compile(r"([-+]?)\.(?:inf|Inf|INF)\Z")
_NAN = re.compile(r"\.(?:nan|NaN|NAN)\Z")

Location = tuple[str | int, ...]


@dataclass(slots=True)
class Value:
    """A scalar, mapping or sequence and its place. A mapping's keys have places of their own."""

    span: Span
    data: Any
    """Python scalar; dict of str to Value; list of Value."""
    keys: dict[str, Span] = field(default_factory=dict)
    plain: bool = True
    """False for a quoted or block scalar, whose columns do not map to its text one to one."""

    def to_data(self) -> Any:
        """Plain Python data without places."""
        if isinstance(self.data, dict):
            return {key: value.to_data() for key, value in self.data.items()}
        if isinstance(self.data, list):
            return [value.to_data() for value in self.data]
        return self.data


class Document:
    """One YAML file: its data, and the place of everything in it."""

    def __init__(self, source: Source, root: Value) -> None:
        self.source = source
        self.root = root
        self.data: Any = root.to_data()

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self.source.path)

    def find(self, *location: str | int) -> Value | None:
        """The value at a location such as `("nodes", "Diff", "inputs")`."""
        value: Value | None = self.root
        for part in location:
            if value is None:
                return None
            if isinstance(value.data, dict):
                value = value.data.get(part)
            elif isinstance(value.data, list) and isinstance(part, int) and 0 <= part < len(value.data):
                value = value.data[part]
            else:
                return None
        return value

    def span(self, *location: str | int) -> Span:
        """Place of the value at a location, or of its nearest enclosing value that exists."""
        for end in range(len(location), -1, -1):
            value = self.find(*location[:end])
            if value is not None:
                return value.span
        return self.root.span

    def key_span(self, *location: str | int) -> Span:
        """Place of the key that leads to a location."""
        parent = self.find(*location[:-1])
        if parent is not None and location and location[-1] in parent.keys:
            return parent.keys[str(location[-1])]
        return self.span(*location)


def load(path: str | os.PathLike[str], findings: Findings, shown_as: str | None = None) -> Document | None:
    """Read a YAML file; what is wrong with it goes to `findings`, and None comes back if nothing could be read."""
    shown = shown_as or os.fspath(path)
    nowhere = Span(Source(shown, ()), 1, 1)
    try:
        with open(path, "rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except OSError as error:
        findings.add("G101", f"cannot read {shown!r}: {error.strerror or error}", nowhere)
        return None
    if len(raw) > MAX_BYTES:
        findings.add(
            "G105", f"{shown!r} is larger than {MAX_BYTES // 1_000_000} MB", nowhere, "split it into several files"
        )
        return None
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        span = Span(Source(shown, ()), line, error.start - raw.rfind(b"\n", 0, error.start))
        findings.add("G101", f"{shown!r} is not UTF-8 text: byte 0x{raw[error.start]:02x}", span)
        return None
    return parse(text, shown, findings)


def parse(text: str, shown_as: str, findings: Findings) -> Document | None:
    """Read YAML text; `shown_as` is the path that messages name."""
    source = Source(shown_as, tuple(text.split("\n")))
    builder = _Builder(source, findings)
    try:
        for event in _events(text):
            if not builder.add(event):
                return None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        span = Span(source, mark.line + 1, mark.column + 1) if mark else Span(source, 1, 1)
        problem = str(error.problem or error.context or "not YAML")
        tabs = "indent with spaces, not tabs" if "\\t" in problem else ""
        findings.add("G102", f"YAML syntax: {problem}", span, tabs)
        return None
    except yaml.reader.ReaderError as error:
        position = error.position if isinstance(error.position, int) else 0
        line = text.count("\n", 0, position) + 1
        findings.add("G102", f"YAML syntax: character that YAML does not allow ({error.reason})", Span(source, line, 1))
        return None
    if builder.root is None:
        findings.add("G102", "the file is empty", Span(source, 1, 1))
        return None
    return Document(source, builder.root)


def _events(text: str) -> Iterator[Any]:
    loader = _Loader(text)
    try:
        while loader.check_event():
            yield loader.get_event()
    finally:
        loader.dispose()


@dataclass(slots=True)
class _Open:
    value: Value
    key: str | None = None
    key_span: Span | None = None
    anchor: str | None = None
    first: int = 0
    """Number of values before this one, to know its size when an alias repeats it."""


class _Builder:
    """Turns events into values; keeps a stack in place of recursion."""

    def __init__(self, source: Source, findings: Findings) -> None:
        self.source = source
        self.findings = findings
        self.root: Value | None = None
        self.stack: list[_Open] = []
        self.anchors: dict[str, tuple[Value, int]] = {}
        self.count = 0
        self.documents = 0

    def add(self, event: Any) -> bool:
        """Take one event; False when reading on makes no sense."""
        if isinstance(event, yaml.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                self.findings.add("G104", "several documents in one file", self._span(event), "remove the line `---`")
                return False
        elif isinstance(event, yaml.ScalarEvent):
            return self._scalar(event)
        elif isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            return self._open(event)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            frame = self.stack.pop()
            return self._place(frame.value, frame.anchor, self.count - frame.first)
        elif isinstance(event, yaml.AliasEvent):
            return self._alias(event)
        return True

    def _span(self, event: Any) -> Span:
        start, end = event.start_mark, event.end_mark
        length = end.column - start.column if end.line == start.line else 1
        return Span(self.source, start.line + 1, start.column + 1, max(length, 1))

    def _counted(self, span: Span, more: int = 1) -> bool:
        self.count += more
        if self.count > MAX_VALUES:
            self.findings.add("G105", f"more than {MAX_VALUES} values in one file, aliases counted", span)
            return False
        return True

    def _tag_refused(self, event: Any, span: Span) -> None:
        if event.tag is not None and event.tag != "!":
            self.findings.add("G104", f"tag {str(event.tag)[:80]!r} is not allowed", span, "write plain YAML values")

    def _open(self, event: Any) -> bool:
        span = self._span(event)
        if len(self.stack) >= MAX_DEPTH:
            self.findings.add("G105", f"nested more than {MAX_DEPTH} levels deep", span)
            return False
        self._tag_refused(event, span)
        is_key = bool(self.stack) and isinstance(self.stack[-1].value.data, dict) and self.stack[-1].key is None
        if is_key:
            self.findings.add("G104", "a key must be a string", span)
            return False
        data: Any = {} if isinstance(event, yaml.MappingStartEvent) else []
        self.stack.append(_Open(Value(span, data), anchor=event.anchor, first=self.count))
        return self._counted(span)

    def _scalar(self, event: Any) -> bool:
        span = self._span(event)
        self._tag_refused(event, span)
        plain = not event.style  # libyaml says "", the Python parser None
        if self.stack and isinstance(self.stack[-1].value.data, dict) and self.stack[-1].key is None:
            return self._key(event.value, plain, span)
        data = self._resolve(event.value, span) if plain else event.value
        return self._counted(span) and self._place(Value(span, data, plain=plain), event.anchor, 1)

    def _key(self, text: str, plain: bool, span: Span) -> bool:
        frame = self.stack[-1]
        if plain and text == "<<":
            self.findings.add("G104", "merge keys are not allowed", span, "write the keys out")
        elif plain and not isinstance(self._resolve(text, span), str):
            self.findings.add("G104", f"a key must be a string, {text!r} is not", span, f'write "{text}"')
        frame.key, frame.key_span = text, span
        return True

    def _alias(self, event: Any) -> bool:
        span = self._span(event)
        if event.anchor not in self.anchors:
            self.findings.add("G102", f"YAML syntax: alias of an unknown anchor {event.anchor!r}", span)
            return False
        if self.stack and isinstance(self.stack[-1].value.data, dict) and self.stack[-1].key is None:
            self.findings.add("G104", "a key must be a string, not an alias", span)
            return False
        value, size = self.anchors[event.anchor]
        return self._counted(span, size) and self._place(value, None, size)

    def _place(self, value: Value, anchor: str | None, size: int) -> bool:
        """Put a finished value where it belongs."""
        if anchor is not None:
            self.anchors[anchor] = (value, size)
        if not self.stack:
            self.root = value
            return True
        frame = self.stack[-1]
        if isinstance(frame.value.data, list):
            frame.value.data.append(value)
            return True
        assert frame.key is not None
        assert frame.key_span is not None
        key, span, frame.key = frame.key, frame.key_span, None
        if key in frame.value.data:
            first = frame.value.keys[key]
            self.findings.add("G103", f"key {key[:80]!r} stands twice", span, related=[(first, "first here")])
        else:
            frame.value.data[key] = value
            frame.value.keys[key] = span
        return True

    def _resolve(self, text: str, span: Span) -> Any:
        """Python value of a plain scalar under the YAML 1.2 core schema."""
        if _NULL.match(text):
            return None
        if _BOOL.match(text):
            return text[0] in "tT"
        if _INT.match(text):
            if len(text) > 40:
                self.findings.add("G109", "an integer of more than 40 digits", span)
                return 0
            return int(text)
        if _OCTAL.match(text) or _HEX.match(text):
            return int(text, 0) if len(text) <= 42 else 0
        if _FLOAT.match(text):
            return float(text)
        if match := _INF.match(text):
            return float(match[1] + "inf")
        if _NAN.match(text):
            return float("nan")
        return text
