"""DOM elements for xacro that keep their source locations, even when they are copied."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.dom import Node as NodeType
from xml.dom import minidom

from graphengine.descriptions.files.xml import MAX_DEPTH, Element
from graphengine.format.diagnostics import Span

_KEY = "place"
"""Key under which the user data of a DOM node holds the source location."""


_NAME = re.compile(r"[^\W\d][\w.:-]*")
_TEXT = re.compile("[\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]*")
"""Matches text that consists only of characters that XML allows."""


class UnwritableError(Exception):
    """The expanded document has an element that XML cannot represent, or that is nested too deeply: `node`."""

    def __init__(self, message: str, node: minidom.Element) -> None:
        super().__init__(message)
        self.node = node


def node_of(element: Element, document: minidom.Document) -> minidom.Element:
    """Convert an element and its children to DOM nodes with their source locations."""
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
    """User-data handler of a DOM node. When the node is copied, the copy receives the source location of the original."""

    def handle(self, operation: int, key: str, place: Span, source: minidom.Node, copy: minidom.Node | None) -> None:
        if copy is not None:
            copy.setUserData(key, place, self)


_CARRIER = _Carrier()


def place_of(node: minidom.Element | None) -> Span | None:
    """Return the source location of a DOM node; None if it has none."""
    place = node.getUserData(_KEY) if node is not None else None
    return place if isinstance(place, Span) else None


def elements(node: minidom.Element, above: Span, depth: int = 1) -> Iterator[tuple[int, Element]]:
    """Yield the depth and the element of a node and of every node below it, in document order.

    The elements have no children; their depths describe the tree. The first depth is 1.

    Args:
        node: DOM node.
        above: source location for nodes without a source location.
        depth: depth of the node.

    Raises:
        UnwritableError: a node is nested too deeply, or contains names or characters that XML forbids.
    """
    found = [child for child in node.childNodes if child.nodeType == NodeType.ELEMENT_NODE]
    text = "".join(child.data for child in node.childNodes if child.nodeType == NodeType.TEXT_NODE).strip()
    element = Element(node.tagName, dict(node.attributes.items()), place_of(node) or above, [], text)
    if depth > MAX_DEPTH:
        raise UnwritableError(f"the file expands to elements more than {MAX_DEPTH} levels deep", node)
    if why := unwritable(element):
        raise UnwritableError(why, node)
    yield depth, element
    for child in found:
        yield from elements(child, element.span, depth + 1)


def unwritable(element: Element) -> str:
    """Return why an element cannot be written as XML: an illegal name or character; empty if it can.

    If an element with an illegal name were written, it could be read back as other elements.
    """
    for name in (element.tag, *element.attributes):
        if not _NAME.fullmatch(name):
            return f"{name!r} is not a valid XML name"
    for value in (element.text, *element.attributes.values()):
        if not _TEXT.fullmatch(value):
            return f"{value!r} contains characters that XML forbids"
    return ""
