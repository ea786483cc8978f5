"""Parses XML of limited size and depth, and keeps the source location of each element.

This module parses robot descriptions and worlds first. MuJoCo receives only the output of `write`; no entity or encoding of an
untrusted file reaches the parser of MuJoCo.
"""

from __future__ import annotations

import re
import xml.parsers.expat
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.regular_files import open_regular

MAX_BYTES = 16_000_000
"""Maximum size of an XML file, bytes."""
MAX_DEPTH = 200
"""Maximum nesting depth of XML elements."""
MAX_ELEMENTS = 200_000
"""Maximum number of elements of an XML file."""
_ENTITIES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})
_IN_QUOTES = _ENTITIES | str.maketrans({'"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})
"""Escape sequences of characters in attribute values. `xml.sax.saxutils` has them too, but imports HTTP and TLS modules."""


@dataclass(slots=True, eq=False)
class Element:
    """An element with attributes, text and child elements; in mixed content, all text is kept before the children."""

    tag: str
    attributes: dict[str, str]
    span: Span
    children: list[Element] = field(default_factory=list, repr=False)
    text: str = ""

    def get(self, attribute: str, default: str = "") -> str:
        """Return the value of an attribute, or `default` if the element does not have it."""
        return self.attributes.get(attribute, default)

    def first(self, tag: str) -> Element | None:
        """Return the first child with the given tag; None if there is none."""
        return next((child for child in self.children if child.tag == tag), None)

    def all(self, tag: str) -> list[Element]:
        """Return all children with the given tag."""
        return [child for child in self.children if child.tag == tag]

    def at(self, tag: str, attribute: str, default: str = "") -> str:
        """Return an attribute of the first child with a tag; `default` if the child or the attribute is missing."""
        child = self.first(tag)
        return child.get(attribute, default) if child is not None else default

    def walk(self) -> Iterator[Element]:
        """Yield the element itself, then all elements below it, in order of the file."""
        pending = [self]
        while pending:
            element = pending.pop()
            yield element
            pending.extend(reversed(element.children))

    def place(self, attribute: str) -> Span:
        """Return the source location of an attribute's value; if it is not found, the location of the element."""
        lines = self.span.source.lines
        column = self.span.column - 1
        for number in range(self.span.line, min(self.span.line + 20, len(lines) + 1)):
            line = lines[number - 1]
            found = re.compile(rf"\b{re.escape(attribute)}\s*=\s*([\"'])(.*?)(?:\1|$)").search(line, column)
            if found:
                return Span(self.span.source, number, found.start(2) + 1, max(found.end(2) - found.start(2), 1))
            if ">" in line[column:]:
                break
            column = 0
        return self.span


class _RefusedError(Exception):
    """The parser refuses the content of a file. The arguments of the exception are the reason and, optionally, remedies."""


def read(path: Path, findings: Findings, code: str) -> Element | None:
    """Return the root element of an XML file; None after an error, which is added to `findings` with `code`."""
    raw = read_bytes(path, findings, code)
    return parse(raw, str(path), findings, code) if raw is not None else None


def read_bytes(path: Path, findings: Findings, code: str) -> bytes | None:
    """Return the content of a file of at most `MAX_BYTES`; None after an error, which is added to `findings` with `code`."""
    nowhere = Span(Source(str(path), ()), 1, 1)
    try:
        with open_regular(path) as file:
            raw = file.read(MAX_BYTES + 1)
    except OSError as error:
        findings.add(code, f"cannot read {str(path)!r}: {error.strerror or error}", nowhere)
        return None
    if len(raw) > MAX_BYTES:
        findings.add(code, f"{str(path)!r} is larger than {MAX_BYTES // 1_000_000} MB", nowhere)
        return None
    return raw


def parse(raw: bytes, name: str, findings: Findings, code: str) -> Element | None:
    """Return the root element of XML text; None after an error, which is added to `findings` with `code`.

    `name` is the name of the text in messages.
    """
    source = Source(name, tuple(raw.decode("utf-8", "replace").split("\n")))
    if len(raw) > MAX_BYTES:
        findings.add(code, f"{name!r} is larger than {MAX_BYTES // 1_000_000} MB", Span(Source(name, ()), 1, 1))
        return None
    builder = _TreeBuilder(source)
    try:
        builder.parser.Parse(raw, True)
    except xml.parsers.expat.ExpatError as error:
        span = Span(source, error.lineno, error.offset + 1)
        findings.add(code, f"XML syntax: {xml.parsers.expat.ErrorString(error.code)}", span)
    except _RefusedError as error:
        findings.add(code, str(error.args[0]), builder.span(), *error.args[1:])
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        findings.add(code, f"XML syntax: {error}", Span(source, 1, 1), "write the file in UTF-8")
    else:
        return builder.root
    return None


class _TreeBuilder:
    """Builds a tree of elements from the callbacks of the expat parser."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.root: Element | None = None
        self.open: list[Element] = []
        self.texts: list[list[str]] = []
        """Parts of the text of each open element."""
        self.count = 0
        self.parser = xml.parsers.expat.ParserCreate(namespace_separator=None)
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._doctype

    def span(self, length: int = 1) -> Span:
        """Return the current position of the parser as a source location of the given length."""
        return Span(self.source, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1, length)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self.span(len(tag) + 1))
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise _RefusedError(f"more than {MAX_ELEMENTS} elements in one file")
        if len(self.open) >= MAX_DEPTH:
            raise _RefusedError(f"nested more than {MAX_DEPTH} levels deep")
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)
        self.texts.append([])

    def _text(self, text: str) -> None:
        self.texts[-1].append(text)

    def _end(self, tag: str) -> None:
        self.open.pop().text = "".join(self.texts.pop()).strip()

    def _doctype(self, *_: object) -> None:
        raise _RefusedError("a document type is not allowed", "remove <!DOCTYPE …>; entities are not expanded")


def document_text(root: Element) -> str:
    """Return an XML document with the given root element as text."""
    return f'<?xml version="1.0"?>\n{write(root)[0]}\n'


def write(root: Element) -> tuple[str, list[Span]]:
    """Return an element as XML text with one tag per line, and for each line the source location of its element."""
    lines: list[str] = []
    spans: list[Span] = []
    pending: list[Element | str] = [root]
    span = root.span
    while pending:
        item = pending.pop()
        if isinstance(item, str):
            line = f"</{item}>"
        else:
            span = item.span
            attributes = "".join(f' {name}="{value.translate(_IN_QUOTES)}"' for name, value in item.attributes.items())
            end = ">" if item.children or item.text else "/>"
            line = f"<{item.tag}{attributes}{end}{item.text.translate(_ENTITIES)}"
            if item.children:
                pending.append(item.tag)
                pending.extend(reversed(item.children))
            elif item.text:
                line += f"</{item.tag}>"
        lines.append(line)
        spans += [span] * (line.count("\n") + 1)
    return "\n".join(lines), spans


def numbers(text: str, count: int) -> tuple[float, ...] | None:
    """Return the numbers of a text that consists of `count` finite numbers separated by spaces; None for any other text."""
    if "_" in text or not text.isascii():  # Python reads `1_0` and the digits of all scripts
        return None
    try:
        values = tuple(float(part) for part in text.split())
    except ValueError:
        return None
    return values if len(values) == count and all(abs(value) < 1e300 for value in values) else None


def number(text: str) -> float | None:
    """Return the value of a text that is one finite number; None for any other text."""
    values = numbers(text, 1)
    return values[0] if values is not None else None


_LINE = re.compile(r"\bline (\d+)")
_NAME = re.compile(r"Element name '([^']+)'")


def mujoco_says(error: Exception) -> tuple[str, str, int]:
    """Split an error of MuJoCo into its message, the name of the element concerned, and the line in the parsed text.

    If the error does not contain them, the name is empty and the line is 0.
    """
    text = str(error)
    sentence = text.split("\n")[0].removeprefix("XML Error: ").removeprefix("Error: ")
    name, line = _NAME.search(text), _LINE.search(text)
    return sentence, name[1] if name else "", int(line[1]) if line else 0


def place_of(spans: Sequence[Span], line: int) -> Span:
    """Return the source location of a line that `write` produced; `spans` comes from `write`, lines count from 1."""
    return spans[min(max(line, 1), len(spans)) - 1]
