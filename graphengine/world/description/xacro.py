"""xacro files as URDF: expanded in a process of their own, which reads what it may and ends in time.

What comes back is the tree of elements, each with the place in the xacro file that it was written at.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from graphengine.diagnostics import Findings, Source, Span, did_you_mean, listing
from graphengine.world.files.confinement import ProcessError, ask
from graphengine.world.files.packages import Packages
from graphengine.world.files.xml import MAX_BYTES, Element

MAX_SECONDS = 30.0
SUFFIX = ".xacro"
_PROCESS = "graphengine.world.description.xacro_process"


def is_xacro(root: Element) -> bool:
    """Whether a description still has to be expanded; not every xacro file has a name that says so."""

    def holds(element: Element) -> bool:
        return element.tag.startswith("xacro:") or any("$(" in v or "${" in v for v in element.attributes.values())

    return any(holds(element) for element in root.walk())


def expand(
    path: Path,
    arguments: Mapping[str, str],
    packages: Packages,
    findings: Findings,
    places: Mapping[str, Span] = MappingProxyType({}),
) -> Element | None:
    """The robot that a xacro file describes.

    Args:
        path: the file.
        arguments: values of its `xacro:arg` elements.
        packages: what `$(find …)` finds; they also judge which files are read.
        findings: takes what is wrong.
        places: where the arguments are given, by name.
    """
    start = Span(Source(str(path), ()), 1, 1)
    request = {
        "path": str(path),
        "folder": str(packages.folder),
        "arguments": dict(arguments),
        "paths": [str(folder) for folder in packages.paths],
        "roots": [str(folder) for folder in packages.files.roots],
        "installed": [str(folder) for folder in packages.files.installed],
    }
    try:
        answer = json.loads(ask(_PROCESS, json.dumps(request).encode(), MAX_SECONDS))
    except ProcessError as error:
        findings.add("S103", f"xacro: {error}", start)
        return None
    for used in answer["used"]:
        packages.files.note(Path(used))
    sources = _Sources()
    for finding in answer["findings"]:
        related = [(span, text) for place, text in finding["related"] if (span := sources.span(place)) is not None]
        span = sources.span(finding["place"]) or start
        findings.add(finding["code"], finding["message"], span, *finding["help"], related=related)
    root, known = answer["root"], answer["known"]
    unknown = [name for name in arguments if name not in known] if root is not None else []
    for name in unknown:
        near = did_you_mean(name, known) or listing(known, "its arguments")
        findings.add("G111", f"{str(path)!r} has no argument {name!r}", places.get(name), near)
    return _element(root, sources, start) if root is not None and not unknown else None


class _Sources:
    """Places in files, whose lines are read once."""

    def __init__(self) -> None:
        self._sources: dict[str, Source] = {}

    def span(self, place: list[Any] | None) -> Span | None:
        """The place that a path, a line, a column and a length mean."""
        if place is None:
            return None
        path, line, column, length = place
        if path not in self._sources:
            with Path(path).open("rb") as file:
                text = file.read(MAX_BYTES).decode("utf-8", "replace")
            self._sources[path] = Source(path, tuple(text.split("\n")))
        return Span(self._sources[path], line, column, length)


def _element(data: dict[str, Any], sources: _Sources, above: Span) -> Element:
    span = sources.span(data["place"]) or above
    children = [_element(child, sources, span) for child in data["children"]]
    return Element(data["tag"], data["attributes"], span, children, data["text"])
