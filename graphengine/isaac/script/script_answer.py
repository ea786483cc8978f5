"""The output of the script process: the graphs that the script builds, and the findings."""

from __future__ import annotations

from dataclasses import dataclass, field

from graphengine.format.diagnostics import Finding
from graphengine.isaac.recorded_graph import RecordedGraph


@dataclass(slots=True)
class ScriptAnswer:
    """The result of one run of a script.

    Attributes:
        graphs: graphs that the script built.
        namespaces: `isaac:namespace` by prim path.
        findings: findings of the run.
        prims: paths of other prims that the script created.
        stages: paths of USD files that the script opened and whose graphs were not available.
        granted: paths of prims that the script queried and that were assumed to exist.
        may_differ: whether the script may build more on a stage with other prims.
        stopped: whether the script failed after it had built graphs.
        executed: whether the script must be run as Python; a script of literals is only evaluated.
    """

    graphs: list[RecordedGraph] = field(default_factory=list)
    namespaces: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    prims: set[str] = field(default_factory=set)
    stages: list[str] = field(default_factory=list)
    granted: set[str] = field(default_factory=set)
    may_differ: bool = False
    stopped: bool = False
    executed: bool = False

    def __post_init__(self) -> None:
        if any(name != node.name for graph in self.graphs for name, node in graph.nodes.items()):
            raise ValueError(self.graphs)

    @property
    def failed(self) -> bool:
        """Whether the script cannot be imported."""
        return any(finding.severity == "error" for finding in self.findings)

    @property
    def nodes(self) -> set[str]:
        """Paths of the graphs' nodes."""
        return {f"{graph.path}/{name}" for graph in self.graphs for name in graph.nodes}

    @property
    def made(self) -> set[str]:
        """Paths that the script created: graphs, nodes and other prims."""
        return {*self.prims, *self.nodes, *(graph.path for graph in self.graphs)}
