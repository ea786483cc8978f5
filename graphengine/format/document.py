"""Reads YAML as plain data with the position of each value; the size, the nesting and the number of values are limited.

`core_schema` determines the type of a plain scalar. A loop reads the parser's events without recursion, so that `MAX_DEPTH`
limits the nesting, not the C stack.
"""

from __future__ import annotations

import codecs
import io
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from graphengine.format.core_schema import resolve
from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.given_text import GivenText
from graphengine.format.regular_files import StrPath, open_regular
from graphengine.format.syntax_errors import report_syntax
from graphengine.format.wording import did_you_mean

MAX_BYTES = 8_000_000  # maximum size of a YAML file
MAX_DEPTH = 64
"""Maximum number of nesting levels; an alias adds the levels of its value."""
MAX_VALUES = 400_000
"""Maximum number of values in a document; each alias adds the number of values that it repeats."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Loader class with the event parser of libyaml, or without libyaml with PyYAML's parser, which takes 15 times as long."""

_LINE_END = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
"""Pattern of a line end in the parser's sense."""
_ILLEGAL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufeff\ufffe\uffff]")

_TOO_DEEP = f"nested more than {MAX_DEPTH} levels deep"
Location = tuple[str | int, ...]


@dataclass(slots=True)
class Value:
    """A scalar, mapping or sequence with its position in the file; a mapping also has the position of each key."""

    span: Span
    data: Any
    """A Python scalar, a dict from str to Value, or a list of Value."""
    keys: dict[str, Span] = field(default_factory=dict)
    plain: bool = True
    """False for a quoted or block scalar, whose text can differ from the text in the file because of escapes or line folding."""

    def child(self, part: str | int) -> Value | None:
        """Return the value at a key of a mapping or an index of a list; None if there is no such key or index."""
        found: Value | None = None
        if isinstance(self.data, dict):
            found = self.data.get(part)
        elif isinstance(self.data, list) and isinstance(part, int) and 0 <= part < len(self.data):
            found = self.data[part]
        return found

    def to_data(self) -> Any:
        """Return the value as plain Python data, without positions."""
        if isinstance(self.data, dict):
            return {key: value.to_data() for key, value in self.data.items()}
        if isinstance(self.data, list):
            return [value.to_data() for value in self.data]
        return self.data


class Document:
    """One YAML file: its data, and the positions of all values and keys."""

    def __init__(self, source: Source, root: Value, size: int) -> None:
        self.source = source
        self.root = root
        self.size = size
        """Number of values; each alias adds the number of values that it repeats."""
        self.data: Any = root.to_data()

    @property
    def path(self) -> Path:
        """Path of the file as messages show it."""
        return Path(self.source.path)

    def find(self, *location: str | int) -> Value | None:
        """Return the value at a location such as `("nodes", "Diff", "inputs")`; None if the location has no value."""
        value: Value | None = self.root
        for part in location:
            value = value.child(part) if value is not None else None
        return value

    def span(self, *location: str | int) -> Span:
        """Return the position of the value at a location, or of the innermost existing value on the way to the location."""
        for end in range(len(location), -1, -1):
            value = self.find(*location[:end])
            if value is not None:
                return value.span
        return self.root.span

    def key_span(self, *location: str | int) -> Span:
        """Return the position of the last key of a location; if the file lacks the key, the result of `span`."""
        parent = self.find(*location[:-1])
        if parent is not None and location and location[-1] in parent.keys:
            return parent.keys[str(location[-1])]
        return self.span(*location)


def load(
    path: StrPath,
    findings: Findings,
    shown_as: str | None = None,
    *,
    given: GivenText | None = None,
    merge_keys: bool = False,
) -> Document | None:
    """Read a YAML file; add errors to `findings`, and return None if the file cannot be read or parsed.

    Args:
        path: path of the file.
        findings: receives the errors.
        shown_as: path to show in messages; None shows `path`.
        given: text to read instead of the file.
        merge_keys: as in `parse`.
    """
    shown, label = shown_as or os.fspath(path), given.label if given is not None else ""
    start = Span(Source(shown, (), label), 1, 1)
    try:
        with open_regular(path) if given is None else io.BytesIO(given.data) as file:
            raw = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        findings.add("G101", f"cannot read {shown!r}: {reason}", start)
        return None
    if len(raw) > MAX_BYTES:
        what = f"{shown!r} is larger than {MAX_BYTES // 1_000_000} MB"
        findings.add("G105", what, start, "split it into several files")
        return None
    raw = raw.removeprefix(codecs.BOM_UTF8)
    try:
        text = raw.decode()
    except UnicodeDecodeError as error:
        source = Source(shown, tuple(_LINE_END.split(raw.decode("utf-8", "replace"))), label)
        span = _span_behind(raw[: error.start].decode("utf-8", "ignore"), source)
        what = f"{shown!r} is not UTF-8 text: byte 0x{raw[error.start]:02x}"
        findings.add("G101", what, span, "save the file as UTF-8")
        return None
    found = parse(text, shown, findings, label=label, merge_keys=merge_keys)
    if found is not None and given is not None and given.keyed:
        found.source.keys.update(_key_paths(found.root))
    return found


def _key_paths(root: Value) -> Iterator[tuple[int, str]]:
    """Yield the line and the path of each key and list item, such as `robots.bot.position[0]`."""
    yield root.span.line, ""
    pending = [("", root)]
    while pending:
        path, value = pending.pop()
        if isinstance(value.data, dict):
            inner = [(f"{path}.{key}" if path else key, value.keys[key], child) for key, child in value.data.items()]
        else:
            items = value.data if isinstance(value.data, list) else []
            inner = [(f"{path}[{index}]", child.span, child) for index, child in enumerate(items)]
        yield from ((span.line, name) for name, span, _ in inner)
        pending += [(name, child) for name, _, child in inner]


def parse(
    text: str, shown_as: str, findings: Findings, *, label: str = "", merge_keys: bool = False
) -> Document | None:
    """Parse YAML text; add errors to `findings`, and return None if the text cannot be parsed.

    `shown_as` is the path in messages, and `label` that of `Source`. With `merge_keys`, a key may occur twice, as in ROS 2
    parameter files: two mappings are merged, and any other value replaces the earlier value.
    """
    source = Source(shown_as, tuple(_LINE_END.split(text)), label)
    if illegal := _ILLEGAL.search(text):
        span = _span_behind(text[: illegal.start()], source)
        number = f"{ord(illegal[0]):04X}"  # none is above U+FFFF
        advice = f"remove the character, or write \\u{number} in double quotes"
        findings.add("G102", f"YAML syntax: character U+{number} is not allowed", span, advice)
        return None
    tags = next((number for number, line in enumerate(source.lines, 1) if line.startswith("%TAG")), None)
    if tags is not None:  # refused here, because the parser takes minutes for thousands of tags
        findings.add("G104", "tags and the directive %TAG are not allowed", Span(source, tags, 1, 4), "remove the line")
        return None
    builder = _ValueBuilder(source, findings, merge_keys=merge_keys)
    try:
        for event in _events(text):
            if not builder.add(event):
                return None
    except yaml.MarkedYAMLError as error:
        report_syntax(error, source, findings, _TOO_DEEP)
        return None
    if builder.root is None or builder.root.data is None:
        findings.add("G102", "the file is empty", Span(source, 1, 1))
        return None
    return Document(source, builder.root, builder.count)


def _span_behind(text: str, source: Source) -> Span:
    """Return the position after `text`, with which the file begins."""
    lines = _LINE_END.split(text)
    return Span(source, len(lines), len(lines[-1]) + 1)


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
    key: tuple[str, Span] | None = None
    """In a mapping: the last read key if it has no value yet, with the key's position."""
    drop: bool = False
    """Whether the value of `key` is discarded, because the key is not allowed."""
    anchor: str | None = None
    first: int = 0
    """Number of values in the document before this value; the difference to a later count is the size of this value."""
    depth: int = 1
    """Number of nesting levels of the value; 1 for a mapping or list of scalars."""


class _ValueBuilder:
    """Builds values from parser events, with a stack instead of recursion."""

    def __init__(self, source: Source, findings: Findings, *, merge_keys: bool) -> None:
        self.source = source
        self.findings = findings
        self.merge_keys = merge_keys
        self.merged: dict[int, Value] = {}
        """Mappings that `_merge` created, by `id`; these may change, because no anchor refers to them."""
        self.root: Value | None = None
        self.stack: list[_Open] = []
        self.anchors: dict[str, tuple[Value, int, int]] = {}
        """For each anchor: the value, the number of values that an alias repeats, and the number of nesting levels."""
        self.count = 0
        self.documents = 0

    def add(self, event: Any) -> bool:
        """Process one parser event; return False if reading cannot continue."""
        if isinstance(event, yaml.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                what = "the file contains several YAML documents"
                return self._refuse("G104", what, self._span(event), "remove the line `---`")
        elif isinstance(event, yaml.ScalarEvent):
            return self._scalar(event)
        elif isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            return self._open(event)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            frame = self.stack.pop()
            return self._place(frame.value, frame.anchor, self.count - frame.first, frame.depth)
        elif isinstance(event, yaml.AliasEvent):
            return self._alias(event)
        return True

    def _span(self, event: Any) -> Span:
        start, end = event.start_mark, event.end_mark
        length = end.column - start.column if end.line == start.line else 1
        return Span(self.source, start.line + 1, start.column + 1, max(length, 1))

    def _refuse(self, code: str, message: str, span: Span, *help: str) -> bool:
        """Add an error after which reading cannot continue; return False."""
        self.findings.add(code, message, span, *help)
        return False

    def _counted(self, span: Span, more: int = 1) -> bool:
        self.count += more
        if self.count <= MAX_VALUES:
            return True
        message = f"more than {MAX_VALUES} values in one file, including values that aliases repeat"
        return self._refuse("G105", message, span, "split the file, or use fewer aliases")

    def _shallow(self, span: Span, levels: int) -> bool:
        return len(self.stack) + levels <= MAX_DEPTH or self._refuse("G105", _TOO_DEEP, span)

    def _at_key(self) -> bool:
        """Return whether the next event is a key of a mapping."""
        return bool(self.stack) and isinstance(self.stack[-1].value.data, dict) and self.stack[-1].key is None

    def _tag_refused(self, event: Any, span: Span) -> None:
        if event.tag is not None:
            what = f"tags are not allowed: {str(event.tag).replace('tag:yaml.org,2002:', '!!')[:80]!r}"
            self.findings.add("G104", what, span, "remove the tag; a value in quotes is a string")

    def _open(self, event: Any) -> bool:
        span = self._span(event)
        if not self._shallow(span, 1):
            return False
        self._tag_refused(event, span)
        if self._at_key():
            what = f"a key must be a string, not a {'mapping' if isinstance(event, yaml.MappingStartEvent) else 'list'}"
            return self._refuse("G104", what, span, "put it in quotes if it is a string")
        data: Any = {} if isinstance(event, yaml.MappingStartEvent) else []
        self.stack.append(_Open(Value(span, data), anchor=event.anchor, first=self.count))
        return self._counted(span)

    def _scalar(self, event: Any) -> bool:
        span = self._span(event)
        self._tag_refused(event, span)
        plain = not event.style  # libyaml gives "", the Python parser None
        if self._at_key():
            return self._key(event, plain, span)
        data = resolve(event.value, span, self.findings) if plain else event.value
        return self._counted(span) and self._place(Value(span, data, plain=plain), event.anchor, 1, 0)

    def _key(self, event: Any, plain: bool, span: Span) -> bool:
        frame, text = self.stack[-1], event.value
        frame.key, frame.drop = (text, span), False
        if plain and text == "<<":
            self.findings.add("G104", "merge keys are not allowed", span, "write out the keys that `<<` would merge")
            frame.drop = True
        elif plain and not isinstance(resolve(text, span, self.findings), str):
            quoted = f'"{text[:80]}"' if text else '""'
            self.findings.add("G104", f"a key must be a string, but {text[:80]} is not", span, f"write {quoted}")
            frame.drop = True
        if event.anchor is not None:
            self.anchors[event.anchor] = (Value(span, text, plain=plain), 1, 0)
        return True

    def _alias(self, event: Any) -> bool:
        span = self._span(event)
        if event.anchor not in self.anchors:
            hint = did_you_mean(event.anchor, self.anchors) or "put text that begins with '*' in quotes"
            return self._refuse("G102", f"YAML syntax: no anchor {event.anchor!r} precedes this alias", span, hint)
        if self._at_key():
            return self._refuse("G104", "a key must be a string, not an alias", span, "write the key itself")
        value, size, depth = self.anchors[event.anchor]
        return self._counted(span, size) and self._shallow(span, depth) and self._place(value, None, size, depth)

    def _place(self, value: Value, anchor: str | None, size: int, depth: int) -> bool:
        """Add a finished value to the mapping or sequence around it; report a repeated key.

        Returns:
            Always True: reading can continue.
        """
        if anchor is not None:
            self.anchors[anchor] = (value, size, depth)
        if not self.stack:
            self.root = value
            return True
        frame = self.stack[-1]
        frame.depth = max(frame.depth, depth + 1)
        if isinstance(frame.value.data, list):
            frame.value.data.append(value)
            return True
        assert frame.key is not None
        (key, span), frame.key = frame.key, None
        if key in frame.value.data and self.merge_keys:
            frame.value.data[key] = self._merge(frame.value.data[key], value)
        elif key in frame.value.data:
            what, related = f"key {key[:80]!r} occurs twice", [(frame.value.keys[key], "first here")]
            self.findings.add("G103", what, span, "rename or remove one", related=related)
        elif not frame.drop:
            frame.value.data[key] = value
            frame.value.keys[key] = span
        return True

    def _merge(self, first: Value, second: Value) -> Value:
        """Return both values of a key as one mapping if both are mappings, otherwise the second value."""
        if not (isinstance(first.data, dict) and isinstance(second.data, dict)):
            return second
        merged = self.merged.get(id(first)) or Value(first.span, dict(first.data), dict(first.keys))
        self.merged[id(merged)] = merged
        for key, value in second.data.items():
            merged.data[key] = self._merge(merged.data[key], value) if key in merged.data else value
            merged.keys.setdefault(key, second.keys[key])
        return merged
