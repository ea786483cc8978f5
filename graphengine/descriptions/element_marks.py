"""Finds the element of a description whose source location an error of MuJoCo repeats."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.descriptions.files.xml import Element


def marked(error: Exception, roots: Iterable[Element]) -> Element | None:
    """Return the element of a description whose location an error of MuJoCo repeats; None without a location."""
    elements = (element for root in roots for element in root.walk())
    return next((element for element in elements if str(error).endswith(f", {element.span}")), None)


def called(element: Element) -> str:
    """Return the name of an element in messages: for a mesh its file, otherwise its attribute `name`."""
    return element.get("filename") or element.get("name")
