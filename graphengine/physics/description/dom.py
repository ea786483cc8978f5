"""DOM elements for xacro that keep their source location, also in copies."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.dom import Node as NodeType
from xml.dom import minidom

from graphengine.format.diagnostics import Span
from graphengine.physics.files.xml import MAX_DEPTH, Element

_KEY = "place"
"""Of a node's user data."""


_NAME = re.compile(r"[^\W\d][\w.:-]*")
_TEXT = re.compile("[\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]*")
"""What XML can hold."""


class UnwritableError(Exception):
    """Content that a description must not have, and the node that contains it."""

    def __init__(self, message: str, node: minidom.Element) -> None:
        super().__init__(message)
        self.node = node


def node_of(element: Element, document: minidom.Document) -> minidom.Element:
    """Convert an element to a DOM node with its source location."""
    made = document.createElement(element.tag)
    made.setUserData(_KEY, element.span, _CARRIER)
    for name, value in element.attributes.items():
        made.setAttribute(name, value)
    if element.text:
        made.appendChild(document.createTextNode(element.text))
    for child in element.children:
        made.appendChild(node_of(child, document))
    return made


class _Carrier:
    """Handler that DOM calls when it copies an element; it gives the copy the source location of the original."""

    def handle(self, operation: int, key: str, place: Span, source: minidom.Node, copy: minidom.Node | None) -> None:
        if copy is not None:
            copy.setUserData(key, place, self)


_CARRIER = _Carrier()


def place_of(node: minidom.Element | None) -> Span | None:
    """Return the source location of a node."""
    place = node.getUserData(_KEY) if node is not None else None
    return place if isinstance(place, Span) else None


def elements(node: minidom.Element, above: Span, depth: int = 1) -> Iterator[tuple[int, Element]]:
    """Yield a node and all nodes below it, each with its depth and without its children.

    Raises:
        UnwritableError: a node is nested too deeply, or contains characters that XML forbids.
    """
    found = [child for child in node.childNodes if child.nodeType == NodeType.ELEMENT_NODE]
    text = "".join(child.data for child in node.childNodes if child.nodeType == NodeType.TEXT_NODE).strip()
    element = Element(node.tagName, dict(node.attributes.items()), place_of(node) or above, [], text)
    if depth > MAX_DEPTH:
        raise UnwritableError(f"it expands to elements more than {MAX_DEPTH} levels deep", node)
    if why := unwritable(element):
        raise UnwritableError(why, node)
    yield depth, element
    for child in found:
        yield from elements(child, element.span, depth + 1)


def unwritable(element: Element) -> str:
    """Return the part of an element that XML forbids, or an empty string; when written, it could become other elements."""
    for name in (element.tag, *element.attributes):
        if not _NAME.fullmatch(name):
            return f"{name!r} is no name of XML"
    for value in (element.text, *element.attributes.values()):
        if not _TEXT.fullmatch(value):
            return f"XML cannot hold {value!r}"
    return ""
