"""Lints for node types: registered by code, run on every scene after the dry setup."""

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
    """What a lint may look at, and where it tells."""

    graphs: Sequence[Graph]
    stage: Stage
    claims: Sequence[EndpointClaim]
    findings: Findings

    def nodes(self, cls: type[N]) -> Iterator[tuple[Graph, Instance, N]]:
        """The nodes of a type: their graph, their place in it, and a node with the values that its inputs have at the start."""
        for graph in self.graphs:
            for instance in graph.instances:
                if issubclass(instance.cls, cls):
                    yield graph, instance, cast("N", instance.make_node())

    def disagree(self, code: str, message: str, claim: EndpointClaim, other: EndpointClaim, remedy: str) -> None:
        """Tell of a claim that cannot live together with another one."""
        span = self.span(other)
        self.findings.add(code, message, self.span(claim), remedy, related=[(span, "the other one")] if span else [])

    def span(self, claim: EndpointClaim) -> Span | None:
        """The node that claims."""
        instance = self.instance(claim.node)
        return instance.span if instance else None

    def instance(self, prim_path: str) -> Instance | None:
        """The node at a prim path."""
        for graph in self.graphs:
            for instance in graph.instances:
                if f"{graph.prim_path}/{instance.id}" == prim_path:
                    return instance
        return None


LintFunction = Callable[["LintContext"], None]

L = TypeVar("L", bound=LintFunction)

LINTS: dict[str, list[LintFunction]] = {}


def lint(code: str) -> Callable[[L], L]:
    """Register a check that knows node types; it runs on every scene after the dry setup."""

    def register(function: L) -> L:
        LINTS.setdefault(code, []).append(function)
        return function

    return register
