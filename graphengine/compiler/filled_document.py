"""Source positions in a graph file whose parameters are filled in."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Protocol

from graphengine.format.diagnostics import Span
from graphengine.format.document import Document, Location, Value

PARAMETER = re.compile(r"\$\$|\$\(([^$()]*)\)")
"""A parameter `$(name)` in a text, or `$$`, which stands for `$`."""


class Places(Protocol):
    """A YAML file, or a section of one, that has the source position of each value and key."""

    def span(self, *location: str | int) -> Span:
        """Return the position of the value at a location such as `("nodes", "Drive")`."""

    def key_span(self, *location: str | int) -> Span:
        """Return the position of the last key of a location."""


@dataclass(frozen=True, slots=True)
class Use:
    """The use of a graph file by a scene, robot or other graph, which sets the graph's parameters.

    Attributes:
        span: position of the graph's path in the using file.
        file: file, or node of a graph, that uses the graph.
        location: location of the parameters in `file`.
        given: names of the parameters whose values are written in a file.
        given: names of the parameters whose values are written in a file.
    """

    span: Span
    file: Places
    location: Location
    given: Collection[str]
    within: str = ""

    def value_span(self, name: str, *rest: str | int) -> Span:
        """Return the position of a parameter's value in the using file, or of the element at `rest` within the value."""
        return self.file.span(*self.location, name, *rest)

    def key_span(self, name: str) -> Span:
        """Return the position of a parameter's name in the using file."""
        return self.file.key_span(*self.location, name)


class FilledDocument(Document):
    """A graph file that locates a value `$(name)` where the value of the parameter is written, which may be another file."""

    def __init__(self, document: Document, bound: Collection[str], use: Use | None) -> None:
        self.source, self.root, self.size, self.data = document.source, document.root, document.size, document.data
        self.bound = bound
        """Names of the parameters that the use of the graph sets, in a file or not."""
        self.use = use

    def span(self, *location: str | int) -> Span:
        """Return the source position of a value; for a parameter that a file sets, the position of the parameter's value."""
        return self.origin(*location) or super().span(*location)

    def origin(self, *location: str | int) -> Span | None:
        """Return the source position of a value, with parameters followed; None for a parameter that the engine sets."""
        value, here = self.root, super().span
        for end, part in enumerate(location, 1):
            inner = value.child(part)
            if inner is None:
                break
            value = inner
            if isinstance(value.data, str) and "$" in value.data and not is_literal(location[:end], value):
                return self._lead_out(value, location[:end], location[end:])
        return here(*location)

    def _lead_out(self, value: Value, location: Location, rest: Location) -> Span | None:
        """Return the position of the value that replaces `$(name)` in a text; None if the engine sets the parameter."""
        whole = PARAMETER.fullmatch(value.data)
        if whole and whole[1]:
            name, origin = whole[1], self._parameter_span(whole[1], rest)
            if origin is None:
                return None
        else:
            given = {match[1] for match in PARAMETER.finditer(value.data) if self.use and match[1] in self.use.given}
            if self.use is None or len(given) != 1:  # the mistake can be in any part of the text
                return value.span
            name = given.pop()
            origin = self.use.value_span(name)
        link = (value.span, f"through $({name}) to {self._reader(location)}")
        return replace(origin, parameter=origin.parameter or name, through=(*origin.through, link))

    def _parameter_span(self, name: str, rest: Location) -> Span | None:
        """Return the position of a parameter's given or default value; None if the engine sets the parameter."""
        if self.use is not None and name in self.use.given:
            return self.use.value_span(name, *rest)
        if name in self.bound or self.find("parameters", name, "default") is None:
            return None
        default = super().span("parameters", name, "default", *rest)
        if self.use is None:
            return default
        return replace(default, through=((self.use.span, f"the graph is used here without {name}"),))

    def _reader(self, location: Location) -> str:
        """Return the name of the input or variable at a location, such as `State/Odometry.wheelRadius`."""
        names = [str(part) for part in location if isinstance(part, str)]
        within = self.use.within if self.use is not None else ""
        if names[0] == "variables":
            return f"variable {within}{names[1]}"
        return f"{within}{names[1]}.{names[-1]}" if names[0] == "nodes" else f"{within}{names[0]}"


def is_literal(location: Location, value: Value) -> bool:
    """Return whether `$(name)` stays as it is at this location, as in wires, node types and the graph's name."""
    if location[0] in ("parameters", "graph", "format", "connections", "layout"):
        return True
    short_form = len(location) == 2 and isinstance(value.data, str)
    return location[0] == "nodes" and (short_form or (len(location) == 3 and location[2] in ("type", "subgraph")))
