"""Finds the source positions of values in a graph file whose parameters `$(name)` have been replaced."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Protocol

from graphengine.format.diagnostics import Span
from graphengine.format.document import Document, Location, Value

PARAMETER = re.compile(r"\$\$|\$\(([^$()]*)\)")
"""Pattern of a parameter `$(name)` in a text, and of `$$`, which stands for `$`."""


class Places(Protocol):
    """Source of positions: a YAML file, or a section of a file such as a node."""

    def span(self, *location: str | int) -> Span:
        """Return the position of the value at a location such as `("nodes", "Drive")`."""

    def key_span(self, *location: str | int) -> Span:
        """Return the position of the last key of a location such as `("nodes", "Drive")`."""


@dataclass(frozen=True, slots=True)
class Use:
    """A place where a scene, a robot or another graph uses a graph file and sets the graph's parameters.

    Attributes:
        span: position of the path of the graph file.
        file: scene or robot file that uses the graph; for a subgraph, the node that uses it.
        location: location of the parameter values in `file`.
        given: names of the parameters whose values are written in a file; the engine sets others, such as `robot`.
        within: prefix of the ids of the graph's nodes if the graph is a subgraph, such as `State/`; otherwise empty.
    """

    span: Span
    file: Places
    location: Location
    given: Collection[str]
    within: str = ""

    def value_span(self, name: str, *rest: str | int) -> Span:
        """Return the position of the value that `file` sets for a parameter, or of the element at `rest` within this value."""
        return self.file.span(*self.location, name, *rest)

    def key_span(self, name: str) -> Span:
        """Return the position of a parameter's name in `file`, which sets the value."""
        return self.file.key_span(*self.location, name)


class FilledDocument(Document):
    """A graph file in which a value `$(name)` has the position where the parameter's value is written, even in another file."""

    def __init__(self, document: Document, bound: Collection[str], use: Use | None) -> None:
        self.source, self.root, self.size, self.data = document.source, document.root, document.size, document.data
        self.bound = bound
        """Names of the parameters that the use of the graph sets, including those that the engine sets, such as `robot`."""
        self.use = use

    def span(self, *location: str | int) -> Span:
        """Return the position of the value at a location; for `$(name)`, the position where the parameter's value is written.

        If no file contains the parameter's value, return the position of `$(name)`.
        """
        return self.origin(*location) or super().span(*location)

    def origin(self, *location: str | int) -> Span | None:
        """Return the position where the value at a location is written, after following `$(name)`.

        Returns:
            The position; None for `$(name)` if no file contains the value, because the engine sets the parameter.
        """
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
        """Return the position of the parameter value that replaces `$(name)` in a text; None if the engine sets the parameter.

        A text with several parameters has its own position, because an error can be in any of them.
        """
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
        """Return the position of a parameter's value, given or default; None if no file contains the value."""
        if self.use is not None and name in self.use.given:
            return self.use.value_span(name, *rest)
        if name in self.bound or self.find("parameters", name, "default") is None:
            return None
        default = super().span("parameters", name, "default", *rest)
        if self.use is None:
            return default
        return replace(default, through=((self.use.span, f"the graph is used here without {name}"),))

    def _reader(self, location: Location) -> str:
        """Return the name of the input or variable at a location for messages, such as `State/Odometry.wheelRadius`."""
        names = [str(part) for part in location if isinstance(part, str)]
        within = self.use.within if self.use is not None else ""
        if names[0] == "variables":
            return f"variable {within}{names[1]}"
        return f"{within}{names[1]}.{names[-1]}" if names[0] == "nodes" else f"{within}{names[0]}"


def is_literal(location: Location, value: Value) -> bool:
    """Return whether parameters are not replaced at a location: in wires, node types, parameters, and the graph's name."""
    if location[0] in ("parameters", "graph", "format", "connections", "layout"):
        return True
    short_form = len(location) == 2 and isinstance(value.data, str)
    return location[0] == "nodes" and (short_form or (len(location) == 3 and location[2] in ("type", "subgraph")))
