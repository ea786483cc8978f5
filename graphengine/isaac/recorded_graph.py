"""A graph as an importer found it, in OmniGraph's names; shared by scripts and stages.

Compounds are flat: a node inside of one is called `Compound/Node`, and wires lead to the inner nodes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

from graphengine.format.diagnostics import Findings, Span

PipelineStage = Literal["simulation", "pre_render", "post_render", "on_demand"]
PIPELINE_STAGES: tuple[PipelineStage, ...] = ("simulation", "pre_render", "post_render", "on_demand")
EVALUATORS = ("execution", "push", "dirty_push")
VARIABLE = "graph:variable:"
POSITION = "ui:nodegraph:node:pos"
IMPULSE = "state:enableImpulse"
NAMESPACE = "isaac:namespace"
"""Attributes of prims; scripts set the impulse to let a node fire once."""
GRAPH, NODE = "OmniGraph", "OmniGraphNode"
"""Types of prims."""
MAX_ITEMS = 100_000
"""Of one value, lists in it counted too."""
MAX_GRAPHS = 1000
"""Of one import, and as many namespaces."""
MAX_NAME = 2000
"""Characters of a path or name."""


@dataclass(slots=True)
class RecordedValue:
    """The value of an attribute, and its place.

    Attributes:
        data: None, bool, int, float, str, or lists of them; tuples and arrays are lists, prim paths are text, a quaternion is
            [x, y, z, w], a matrix its rows or all its numbers.
        type: OmniGraph's name of its type, such as `double[3]`, where it was given: on ports that take several.
        span: where it was set.
    """

    data: Any
    type: str = ""
    span: Span | None = None


@dataclass(slots=True)
class RecordedNode:
    """A node.

    Attributes:
        name: its path below the graph.
        type: registered name, as it was found.
        values: by the attribute's full name, such as `inputs:wheelRadius`.
        attributes: those that were added to the node, by full name; the type of each as OmniGraph writes it.
        position: `ui:nodegraph:node:pos`.
        span: where it was made.
    """

    name: str
    type: str
    values: dict[str, RecordedValue] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)
    position: tuple[float, float] | None = None
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class RecordedWire:
    """A wire; ports have their full names, such as `outputs:tick`."""

    source: str
    source_port: str
    target: str
    target_port: str
    span: Span | None = field(default=None, compare=False)

    @property
    def ends(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Node and port of the source, then of the target."""
        return (self.source, self.source_port), (self.target, self.target_port)

    def __str__(self) -> str:
        return f"{self.source}.{self.source_port} -> {self.target}.{self.target_port}"


@dataclass(slots=True)
class RecordedGraph:
    """A graph.

    Attributes:
        path: its own prim.
        evaluator: `execution`, `push` or `dirty_push`.
        pipeline_stage: when it is evaluated.
        nodes: by name, in the order in which they were made.
        wires: in the order in which they were made.
        variables: defaults by name; `type` is there.
        span: where it was made.
    """

    path: str
    evaluator: str = "push"
    pipeline_stage: PipelineStage = "simulation"
    nodes: dict[str, RecordedNode] = field(default_factory=dict)
    wires: list[RecordedWire] = field(default_factory=list)
    variables: dict[str, RecordedValue] = field(default_factory=dict)
    span: Span | None = None

    def names(self) -> Iterator[str]:
        """All names and types in the graph."""
        yield from (self.path or "\0", *self.nodes, *self.variables, *(value.type for value in self.variables.values()))
        yield from (end for wire in self.wires for ends in wire.ends for end in ends)
        for node in self.nodes.values():
            yield from (node.type, *node.values, *node.attributes, *node.attributes.values())


def pipeline_stage(name: str) -> PipelineStage | None:
    """The pipeline stage of an enumerator's name or of a USD token such as `pipelineStageOnDemand`; None of others."""
    word = re.sub(".*_STAGE_|^pipelineStage|_", "", name).lower()
    return next((stage for stage in PIPELINE_STAGES if stage.replace("_", "") == word), None)


def carried(items: Collection[Any], names: Callable[[Any], Iterable[str]], what: str, findings: Findings) -> list[Any]:
    """The graphs or namespaces of an import with legal names, up to the limit."""
    kept = [item for item in items if all(len(name) <= MAX_NAME and name.isprintable() for name in names(item))]
    if left := len(items) - len(kept[:MAX_GRAPHS]):
        legal = f"at most {MAX_GRAPHS}, of printable names up to {MAX_NAME} characters"
        findings.add("W302", f"{left} {what} left out; legal: {legal}")
    return kept[:MAX_GRAPHS]
