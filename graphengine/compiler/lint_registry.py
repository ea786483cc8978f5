"""Registry of the lints that the modules of node types define; each adds warnings about the graphs of a scene.

The lints run when a graph or scene is checked, after its nodes were set up in a world without physics.
"""

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
    """The argument of a lint: graphs, stage and endpoint claims of a scene, and the findings to which the lint adds warnings."""

    graphs: Sequence[Graph]
    stage: Stage
    claims: Sequence[EndpointClaim]
    findings: Findings

    def nodes(self, cls: type[N]) -> Iterator[tuple[Graph, Instance, N]]:
        """Yield a tuple for each node of a type or a subclass of it.

        The tuple has the graph, the node as an `Instance` of this graph, and a new `Node` whose inputs have the values of the
        literals.
        """
        for graph in self.graphs:
            for instance in graph.instances:
                if issubclass(instance.cls, cls):
                    yield graph, instance, cast("N", instance.make_node())

    def disagree(self, code: str, message: str, claim: EndpointClaim, other: EndpointClaim, remedy: str) -> None:
        """Add a finding about two incompatible endpoint claims, such as one topic with two message types.

        Args:
            code: code of the finding.
            message: text of the finding.
            claim: claim whose node gives the finding its position.
            other: claim that contradicts it; the finding also shows the position of this claim's node.
            remedy: help line.
        """
        span = self.span(other)
        self.findings.add(code, message, self.span(claim), remedy, related=[(span, "the other one")] if span else [])

    def span(self, claim: EndpointClaim) -> Span | None:
        """Return the file position of the node that made a claim; None if the node belongs to none of the graphs."""
        instance = self.instance(claim.node)
        return instance.span if instance else None

    def instance(self, prim_path: str) -> Instance | None:
        """Return the instance of the node at a prim path; None if none of the graphs has it."""
        instances = ((graph, instance) for graph in self.graphs for instance in graph.instances)
        return next((one for graph, one in instances if f"{graph.prim_path}/{one.id}" == prim_path), None)


LintFunction = Callable[["LintContext"], None]

L = TypeVar("L", bound=LintFunction)

LINTS: dict[str, list[LintFunction]] = {}


def lint(code: str) -> Callable[[L], L]:
    """Return a decorator that registers a function as lint under a finding code; lints run in the order of their codes."""

    def register(function: L) -> L:
        LINTS.setdefault(code, []).append(function)
        return function

    return register
