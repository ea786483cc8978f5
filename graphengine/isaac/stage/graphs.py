"""Converts the prims of a stage to recorded graphs. Compounds are flattened, and each instance becomes a graph of its own."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from graphengine.compiler.registry import Registry
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.format.diagnostics import Findings
from graphengine.isaac.graph_file import SCRIPT_NODE
from graphengine.isaac.node_replacements import upgrade
from graphengine.isaac.recorded_graph import (
    EVALUATORS,
    GRAPH,
    NODE,
    POSITION,
    VARIABLE,
    RecordedGraph,
    RecordedNode,
    RecordedValue,
    RecordedWire,
    pipeline_stage,
)
from graphengine.isaac.stage.instances import instances
from graphengine.isaac.stage.stage_contents import COMPOUND, INSTANCES, StageAttribute, StageContents, StagePrim

_GENERATED = ("/Render/", "SDGPipeline")
"""Path prefix of the graphs of render products, and name prefix of the graphs that Replicator creates at run time."""
MAX_DEPTH = 50
"""Maximum nesting depth of compounds."""
MAX_LEVELS = 200
"""Maximum number of prims between a node and its graph."""
MAX_PARTS = 500_000
"""Maximum number of followed connections, plus nodes, wires and values in instances, for all graphs of a stage."""
_SCRIPT_PORTS = ("inputs:script", "inputs:scriptPath", "inputs:usePath", "inputs:execIn", "outputs:execOut")


class TooManyError(Exception):
    """The graphs of a stage exceed a size limit; the message names the limit."""


def graphs_of(contents: StageContents, registry: Registry, spans: PrimSpans, findings: Findings) -> list[RecordedGraph]:
    """Return all graphs that Isaac Sim would evaluate, in stage order.

    A graph to which prims refer becomes one graph below each of these prims.

    Args:
        contents: contents of the stage.
        registry: registry with the current names of node types.
        spans: spans of the prims in the file.
        findings: receives a finding for each part that is left out or changed.

    Raises:
        TooManyError: the graphs have more than `MAX_PARTS` parts.
    """
    reader = _GraphReader(contents, registry, spans, findings)
    users: dict[str, list[StagePrim]] = {}
    for prim in contents.prims.values():
        for target in dict.fromkeys(prim.targets.get(INSTANCES, ())):
            users.setdefault(target, []).append(prim)
            if target not in contents.prims:
                reader.tell("W302", f"{prim.path} refers to a graph at {target}, but there is no graph", prim)
    found: list[RecordedGraph] = []
    for prim in contents.prims.values():
        if prim.type != GRAPH or prim.path in reader.inner:
            continue
        if prim.path.startswith(_GENERATED[0]) or prim.name.startswith(_GENERATED[1]):
            reader.tell("N302", f"the graph {prim.path} is left out: Isaac Sim creates it at run time", prim)
            continue
        graph, instanced = reader.read(prim), users.get(prim.path, [])
        reader.count(len(instanced) * (len(graph.wires) + sum(len(node.values) + 1 for node in graph.nodes.values())))
        found += instances(graph, prim, instanced, findings)
    return found


@dataclass(frozen=True, slots=True)
class _ConnectionSource:
    """The source of a connection: a port of a prim, or a prim alone (`port` is then empty)."""

    path: str
    prim: str
    port: str

    @staticmethod
    def of(path: str) -> _ConnectionSource:
        """Parse the path of a port (`Node.x`), of the prim of a bundle output (`Node/outputs_x`), or of another prim."""
        prim, _, port = path.partition(".")
        parent, _, name = prim.rpartition("/")
        if not port and name.startswith("outputs_"):
            return _ConnectionSource(path, parent, name.replace("_", ":", 1))
        return _ConnectionSource(path, prim, port)


class _GraphReader:
    """Converts the graphs of a stage one by one; `read` converts one graph.

    Args:
        contents: contents of the stage.
        registry: registry with the current names of node types.
        spans: spans of the prims in the file.
        findings: receives a finding for each part that is left out or changed.
    """

    def __init__(self, contents: StageContents, registry: Registry, spans: PrimSpans, findings: Findings) -> None:
        self.prims = contents.prims
        self.plain = contents.plain
        self.registry = registry
        self.spans = spans
        self.findings = findings
        self.nodes_in: dict[str, list[StagePrim]] = {}
        """Node prims by the path of their graph."""
        for prim in self.prims.values():
            if prim.type == NODE:
                self.nodes_in.setdefault(self._graph_above(prim.path), []).append(prim)
        compounds = [prim for prim in self.prims.values() if COMPOUND in prim.targets]
        self.inside = {prim.path: _below(prim, prim.targets[COMPOUND]) for prim in compounds}
        """Paths of the inner graphs, by the path of their compound."""
        self.inner = {path for paths in self.inside.values() for path in paths}
        self.names: dict[str, str] = {}
        """Names of the current graph's nodes, including those in compounds, by prim path."""
        self.opened: set[str] = set()
        """Paths of the compounds in the current graph that were already expanded."""
        self.parts = 0

    def count(self, parts: int) -> None:
        """Count followed connections, or nodes, wires and values of instances.

        Raises:
            TooManyError: there are more than `MAX_PARTS`.
        """
        self.parts += parts
        if self.parts > MAX_PARTS:
            raise TooManyError(f"the graphs of the stage have more than {MAX_PARTS} nodes, wires and values")

    def tell(self, code: str, message: str, prim: StagePrim) -> None:
        """Add a finding at the position of a prim."""
        self.findings.add(code, message, self.spans.of(prim.path))

    def read(self, prim: StagePrim) -> RecordedGraph:
        """Return the graph of a graph prim."""
        place = self.spans.of(prim.path)
        graph = RecordedGraph(prim.path, span=place)
        evaluator = prim.text("evaluator:type")
        if evaluator in EVALUATORS:
            graph.evaluator = evaluator
        elif evaluator:
            self.tell("W302", f"{prim.path} has an unknown evaluator {evaluator!r}; push is used instead", prim)
        graph.pipeline_stage = pipeline_stage(prim.text("pipelineStage")) or "simulation"
        for name, attribute in prim.attributes.items():
            if name.startswith(VARIABLE):
                variable = RecordedValue(attribute.value, attribute.type, place)
                graph.variables[name.removeprefix(VARIABLE)] = variable
        self.names, self.opened = {}, set()
        self._name_nodes(prim.path, "")
        for path, name in self.names.items():
            graph.nodes[name] = self._node(self.prims[path], name, graph)
        return graph

    def _name_nodes(self, path: str, prefix: str) -> None:
        """Choose names for the nodes of the graph at a path and of its compounds; inner nodes are named `Compound/Node`."""
        for prim in self.nodes_in.get(path, ()):
            name = prefix + prim.path[len(path) + 1 :]
            inside = self.inside.get(prim.path)
            if inside is None:
                self.names[prim.path] = name
            elif prefix.count("/") == MAX_DEPTH or not inside:
                what = (
                    f"it is over {MAX_DEPTH} levels deep" if prefix.count("/") == MAX_DEPTH else "it contains no graph"
                )
                self.tell("W302", f"the compound {prim.path} is left out: {what}", prim)
            elif prim.path not in self.opened:
                self.opened.add(prim.path)
                for graph in inside:
                    if graph in self.prims and any(name.startswith(VARIABLE) for name in self.prims[graph].attributes):
                        self.tell("W302", f"variables of the compound {prim.path} are left out", prim)
                    self._name_nodes(graph, f"{name}/")

    def _graph_above(self, path: str) -> str:
        """Return the path of the innermost graph around a prim; empty if no graph contains it."""
        for _ in range(MAX_LEVELS):
            path = path.rpartition("/")[0]
            above = self.prims.get(path)
            if above is not None and above.type == GRAPH:
                return path
        return ""

    def _node(self, prim: StagePrim, name: str, graph: RecordedGraph) -> RecordedNode:
        """Return a node with its values, and add the wires into the node to `graph`."""
        node = RecordedNode(name, prim.text("node:type"), span=self.spans.of(prim.path))
        for port, attribute in prim.attributes.items():
            if port.startswith("inputs:"):
                self._input(node, prim, port, attribute, graph)
            if node.type == SCRIPT_NODE and port.startswith(("inputs:", "outputs:")) and port not in _SCRIPT_PORTS:
                node.attributes[port] = "execution" if attribute.execution else attribute.type
        for port, targets in prim.targets.items():
            if port.startswith("inputs:"):
                self._target(node, port, targets, graph)
        match prim.attributes.get(POSITION):
            case StageAttribute(type="float[2]", value=[int() | float() as x, int() | float() as y]):
                node.position = (x, y)
        version = prim.attributes.get("node:typeVersion")
        if version is not None:
            found = self.registry.find(node.type)
            upgrade(node, found.cls.type_name if found else node.type, version.value, prim.path, self.findings)
        return node

    def _input(
        self, node: RecordedNode, prim: StagePrim, port: str, attribute: StageAttribute, graph: RecordedGraph
    ) -> None:
        """Add the wires into a data or execution port to the graph; for an unwired data port, add the value to the node."""
        value, wired = attribute, False
        for source in self._ends(attribute.sources):
            if source.prim in self.names:
                graph.wires.append(RecordedWire(self.names[source.prim], source.port, node.name, port, node.span))
                wired = True
            else:
                value = self._given(source, prim, port) or value
        if not wired and value.value is not None and not attribute.execution:
            node.values[port] = RecordedValue(value.value, attribute.type or value.type, node.span)

    def _target(self, node: RecordedNode, port: str, targets: list[str], graph: RecordedGraph) -> None:
        """Add the wires into a target port to the graph; targets that are no ports of nodes become the value of the port."""
        prims = []
        for source in self._ends(targets):
            if source.port and source.prim in self.names:
                graph.wires.append(RecordedWire(self.names[source.prim], source.port, node.name, port, node.span))
            elif not (source.port and source.prim in self.inside):  # an unconnected port of a compound
                prims.append(source.path)
        if prims:
            node.values[port] = RecordedValue(prims, "target", node.span)

    def _ends(self, paths: Iterable[str]) -> Iterator[_ConnectionSource]:
        """Yield the sources of connections; a source that is a port of a compound is replaced by the sources of that port."""
        pending, seen = deque(paths), set[str]()
        while pending:
            self.count(1)
            source = _ConnectionSource.of(pending.popleft())
            through = self._through(source)
            if not through:
                yield source
            elif source.path not in seen:
                seen.add(source.path)
                pending.extendleft(reversed(through))

    def _through(self, source: _ConnectionSource) -> list[str]:
        """Return the paths that are connected to a port of a compound; empty for all other ports."""
        if source.prim not in self.inside:
            return []
        prim = self.prims[source.prim]
        attribute = prim.attributes.get(source.port)
        return attribute.sources if attribute is not None else prim.targets.get(source.port, [])

    def _given(self, source: _ConnectionSource, prim: StagePrim, port: str) -> StageAttribute | None:
        """Return the attribute outside the graph to which a port is connected; its value replaces the wire.

        If it has no value, report the lost wire and return None.
        """
        if source.prim in self.inside:
            return self.prims[source.prim].attributes.get(source.port)
        found = self.plain.get(source.path)
        if found is not None and found.value is not None:
            what = f"{prim.path}.{port} keeps the value of {source.path}, which belongs to no node of the graph"
            self.tell("N301", what, prim)
            return found
        wire = f"{source.path} -> {prim.path}.{port}"
        self.tell("W302", f"the wire {wire} is left out: it does not begin at a node of the graph", prim)
        return None


def _below(prim: StagePrim, paths: Iterable[str]) -> list[str]:
    """Return the paths that are below a prim, without duplicates."""
    return [path for path in dict.fromkeys(paths) if path.startswith(f"{prim.path}/")]
