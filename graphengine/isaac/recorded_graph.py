"""The graph model that the importers of scripts and stages return; names are those of OmniGraph.

Compounds are flattened: a node in a compound is named `Compound/Node`, and wires connect the inner nodes directly.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.prim_paths import at_or_below
from graphengine.format.yaml_text import Reference

PipelineStage = Literal["simulation", "pre_render", "post_render", "on_demand"]
PIPELINE_STAGES: tuple[PipelineStage, ...] = ("simulation", "pre_render", "post_render", "on_demand")
EVALUATORS = ("execution", "push", "dirty_push")
VARIABLE = "graph:variable:"
POSITION = "ui:nodegraph:node:pos"
IMPULSE = "state:enableImpulse"
"""Attribute of an OnImpulseEvent node; a script sets it to make the node fire once."""
NAMESPACE = "isaac:namespace"
"""Attribute of a prim that sets the ROS 2 namespace of the graphs below it."""
GRAPH, NODE = "OmniGraph", "OmniGraphNode"
"""USD type names of graph prims and node prims."""
MAX_ITEMS = 100_000
"""Maximum number of items in one value, including items of nested lists."""
MAX_GRAPHS = 1000
"""Maximum number of graphs, and maximum number of namespaces, in one import."""
MAX_NAME = 2000
"""Maximum length of a path or name, characters."""


@dataclass(slots=True)
class RecordedValue:
    """The value of an attribute.

    Attributes:
        data: None, bool, int, float, str, or nested lists of them. Tuples and arrays are lists, prim paths are strings, a
            quaternion is [x, y, z, w], a matrix is a list of rows or a flat list.
        type: OmniGraph's type name, such as `double[3]`; empty if the source does not give it. Needed for union and `any` ports.
        span: position in the source where the value is set.
    """

    data: Any
    type: str = ""
    span: Span | None = None


@dataclass(slots=True)
class RecordedNode:
    """A node in a recorded graph.

    Attributes:
        name: path relative to the graph.
        type: name of the node type in the source; may be an old name, or empty.
        values: attribute values by full attribute name, such as `inputs:wheelRadius`.
        attributes: types of the attributes that were added to the node, by full name.
        position: position in the graph editor (`ui:nodegraph:node:pos`).
        span: position in the source where the node is created.
    """

    name: str
    type: str
    values: dict[str, RecordedValue] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)
    position: tuple[float, float] | None = None
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class RecordedWire:
    """A wire between two nodes of a graph; port names are full attribute names, such as `outputs:tick`."""

    source: str
    source_port: str
    target: str
    target_port: str
    span: Span | None = field(default=None, compare=False)

    @property
    def ends(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """The pairs (node, port) of the source and of the target."""
        return (self.source, self.source_port), (self.target, self.target_port)

    def __str__(self) -> str:
        return f"{self.source}.{self.source_port} -> {self.target}.{self.target_port}"


@dataclass(slots=True)
class RecordedGraph:
    """A graph of a script or stage.

    Attributes:
        path: prim path.
        evaluator: `execution`, `push` or `dirty_push`.
        pipeline_stage: stage of the frame in which the graph is evaluated; `on_demand` for physics steps or scripts.
        nodes: nodes by name, in order of creation.
        wires: wires in order of creation.
        variables: default value and type of each variable, by name.
        span: position in the source where the graph is created.
    """

    path: str
    evaluator: str = "push"
    pipeline_stage: PipelineStage = "simulation"
    nodes: dict[str, RecordedNode] = field(default_factory=dict)
    wires: list[RecordedWire] = field(default_factory=list)
    variables: dict[str, RecordedValue] = field(default_factory=dict)
    span: Span | None = None

    def use_parameter(self, name: str, path: str) -> int:
        """Replace a prim path in the graph's own path and in all values by a reference to a parameter, `$(name)`.

        Args:
            name: name of the parameter.
            path: prim path; at the beginning of a longer path it is replaced, too.

        Returns:
            Number of replacements.
        """
        count = 0

        def referred(text: str) -> str:
            nonlocal count
            if not at_or_below(text, path):
                return text
            count += 1
            return Reference(f"$({name}){text[len(path) :]}")

        self._change_texts(referred)
        return count

    def move_prims(self, places: Mapping[str, str]) -> None:
        """Replace prim paths in the graph and in its own path; the longest path in `places` that contains a prim counts."""

        def moved(text: str) -> str:
            parts = text.split("/")
            for end in range(len(parts), 1, -1):
                if (place := places.get("/".join(parts[:end]))) is not None:
                    return "/".join([place, *parts[end:]])
            return text

        self._change_texts(lambda text: moved(text) if text.startswith("/") else text)

    def _change_texts(self, change: Callable[[str], str]) -> None:
        """Change the graph's own path and all texts in values."""

        def changed(data: Any) -> Any:
            if isinstance(data, list):
                return [changed(item) for item in data]
            return change(data) if isinstance(data, str) else data

        self.path = change(self.path)
        for node in self.nodes.values():
            node.values = {key: replace(value, data=changed(value.data)) for key, value in node.values.items()}

    def names(self) -> Iterator[str]:
        """Yield all names, paths and type names in the graph, whose length and characters an importer checks."""
        yield from (self.path or "\0", *self.nodes, *self.variables, *(value.type for value in self.variables.values()))
        yield from (end for wire in self.wires for ends in wire.ends for end in ends)
        for node in self.nodes.values():
            yield from (node.type, *node.values, *node.attributes, *node.attributes.values())


def pipeline_stage(name: str) -> PipelineStage | None:
    """Return the pipeline stage for a name like `GRAPH_PIPELINE_STAGE_ONDEMAND` or `pipelineStageOnDemand`; None if unknown."""
    word = re.sub(".*_STAGE_|^pipelineStage|_", "", name).lower()
    return next((stage for stage in PIPELINE_STAGES if stage.replace("_", "") == word), None)


def carried(items: Collection[Any], names: Callable[[Any], Iterable[str]], what: str, findings: Findings) -> list[Any]:
    """Return the items for which `names` yields only legal names, at most `MAX_GRAPHS`; report the number of other items."""
    kept = [item for item in items if all(len(name) <= MAX_NAME and name.isprintable() for name in names(item))]
    if left := len(items) - len(kept[:MAX_GRAPHS]):
        legal = f"at most {MAX_GRAPHS}, with printable names of at most {MAX_NAME} characters"
        findings.add("W302", f"{left} {what} are left out; legal: {legal}")
    return kept[:MAX_GRAPHS]
