"""Finds values of inputs and lengths of arrays that are known before a run, and reports wrong values and lengths."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

from graphengine.node import Node

if TYPE_CHECKING:
    from graphengine.compiler.graph import Graph, Instance, Wire
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.format.diagnostics import Findings, Span

N = TypeVar("N", bound=Node)


@dataclass(slots=True)
class KnownInputs:
    """The facts about one node's inputs that are known before a run: values that are not wired, and lengths of arrays."""

    graph: Graph
    instance: Instance
    findings: Findings
    _above: frozenset[int] = frozenset()
    """Indices of the nodes downstream whose lengths are being looked up."""
    _wires: dict[tuple[int, str], Wire] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self._wires:
            self._wires = {(wire.target, wire.target_field): wire for wire in self.graph.data_wires}

    def value(self, name: str) -> Any:
        """Return the value of the input with this Python name; None if it is wired or left to the user of a subgraph."""
        node = self.instance
        is_declared = (node.id, node.cls.fields[name].name) in self.graph.declared_inputs
        is_open = is_declared or (node.index, name) in self._wires
        return None if is_open or name in node.refused else node.value(name)

    def source(self, name: str) -> str:
        """Return the output that is wired to an input, such as `Array.array`; empty if the input is not wired."""
        wire = self._wires.get((self.instance.index, name))
        return "" if wire is None else str(wire.entry.source)

    def length(self, name: str) -> int | None:
        """Return the length of the array input with this Python name; None if it is unknown before the run."""
        wire = self._wires.get((self.instance.index, name))
        if wire is None:
            value = self.value(name)
            return None if value is None else len(value)
        source, port = self.graph.source(wire)
        if source.index in self._above:
            return None
        inputs = KnownInputs(self.graph, source, self.findings, self._above | {self.instance.index}, self._wires)
        if port.side == "inputs":  # of a constant, whose wires start at its input
            return inputs.length(port.field)
        rule = next((LENGTHS[cls] for cls in source.cls.__mro__ if cls in LENGTHS), None)
        return rule(inputs, port.field) if rule else None

    def same(self, _: str) -> int | None:
        """Return the common length of the array inputs, which is the length of the outputs; None if it is unknown."""
        from graphengine.compiler.graph import known_type  # which node types must not need

        ports = [port for port in self.instance.cls.fields.values() if port.side == "inputs"]
        arrays = [port.field for port in ports if (kind := known_type(self.instance, port)) and kind.array]
        lengths = {self.length(name) for name in arrays} - {None}
        return lengths.pop() if len(lengths) == 1 else None

    def warn_of_length(self, name: str, needed: int, reason: str, *, may_be_empty: bool = False) -> None:
        """Add W215 if an array input does not have the needed length.

        Args:
            name: Python name of the input.
            needed: length that the node needs.
            reason: help line that says why the node needs this length.
            may_be_empty: whether the node also takes an empty array.
        """
        length, node = self.length(name), self.instance
        if length is None or length == needed or (may_be_empty and not length):
            return
        port, source = node.cls.fields[name], self.source(name)
        elements = "1 element" if length == 1 else f"{length} elements"
        message = f"{node.id}: {port.name} has {elements}, but the node needs {needed}"
        span = node.span if source else self._span(name)
        origin = f"the array comes from {source}" if source else ""
        self.findings.add("W215", message, span, origin, reason, related=node.entry.via)

    def warn_of_unequal(self, *names: str) -> None:
        """Add W215 for each array input whose length differs from the length of the first array input."""
        needed = self.length(names[0])
        if needed is not None:
            first = self.instance.cls.fields[names[0]].name
            for name in names[1:]:
                self.warn_of_length(name, needed, f"its length must be that of {first}")

    def warn_of_value(self, name: str, message: str, remedy: str) -> None:
        """Add W216 for the value of an input that is not wired.

        Args:
            name: Python name of the input.
            message: text that says what is wrong with the value.
            remedy: help line.
        """
        node = self.instance
        self.findings.add("W216", f"{node.id}: {message}", self._span(name), remedy, related=node.entry.via)

    def _span(self, name: str) -> Span:
        """Return the position of an input's value in the file; the position of the node if the file does not set the input."""
        node = self.instance
        key = node.literal_key(node.cls.fields[name])
        return node.entry.span("inputs", key) if key in node.entry.spec.inputs else node.span


LENGTHS: dict[type[Node], Callable[[KnownInputs, str], int | None]] = {}
"""A dict from node types to functions that return the length of an array output, or None if it is unknown before the run.

A function gets the inputs of the node and the Python name of the output. The modules of the node types add the functions.
"""


def known_inputs(context: LintContext, cls: type[N]) -> Iterator[tuple[KnownInputs, N]]:
    """Yield the known inputs of each node of a type, and a node object with the initial values of the inputs."""
    for graph, instance, node in context.nodes(cls):
        yield KnownInputs(graph, instance, context.findings), node
