"""Registry of lints for node types, by finding code. They run on every scene after its nodes were set up without physics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar, cast

if TYPE_CHECKING:
    from graphengine.compiler.graph import Graph, Instance
    from graphengine.devices.stage import Stage
    from graphengine.format.diagnostics import Findings, Span
    from graphengine.messages.endpoints import EndpointClaim
    from graphengine.node.node_class import Node

N = TypeVar("N", bound="Node")


@dataclass(slots=True)
class LintContext:
    """The parts of a scene that a lint can inspect, and the findings to which it adds warnings."""

    graphs: Sequence[Graph]
    stage: Stage
    claims: Sequence[EndpointClaim]
    findings: Findings

    def nodes(self, cls: type[N]) -> Iterator[tuple[Graph, Instance, N]]:
        """Yield the nodes of a type: the graph, the instance, and a node whose inputs have their initial values."""
        for graph in self.graphs:
            for instance in graph.instances:
                if issubclass(instance.cls, cls):
                    yield graph, instance, cast("N", instance.make_node())

    def disagree(self, code: str, message: str, claim: EndpointClaim, other: EndpointClaim, remedy: str) -> None:
        """Report two incompatible endpoint claims, such as different message types of one topic, at the node of `claim`."""
        span = self.span(other)
        self.findings.add(code, message, self.span(claim), remedy, related=[(span, "the other one")] if span else [])

    def span(self, claim: EndpointClaim) -> Span | None:
        """Return the position in its file of the node that made the claim; None if no graph has this node."""
        instance = self.instance(claim.node)
        return instance.span if instance else None

    def instance(self, prim_path: str) -> Instance | None:
        """Return the instance of the node at a prim path, or None."""
        for graph in self.graphs:
            for instance in graph.instances:
                if f"{graph.prim_path}/{instance.id}" == prim_path:
                    return instance
        return None


LintFunction = Callable[["LintContext"], None]

L = TypeVar("L", bound=LintFunction)

LINTS: dict[str, list[LintFunction]] = {}


def lint(code: str) -> Callable[[L], L]:
    """Return a decorator that registers a lint under a finding code; it runs after all nodes were set up without physics."""

    def register(function: L) -> L:
        LINTS.setdefault(code, []).append(function)
        return function

    return register
