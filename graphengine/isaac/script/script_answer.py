"""The result that the script process returns: the graphs of a script, and findings."""

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
        prims: paths of other prims that the script created, and names that the user passes with `--assume`.
        stages: paths of the USD files that the script opened but whose graphs the request did not contain.
        granted: paths of the prims that were assumed to exist when the script queried them.
        may_differ: whether the script might build other graphs if more prims existed on the stage.
        stopped: whether a statement of the script failed, but the graphs that the script built are kept.
        executed: whether the script must be run as Python code; a script of literals is evaluated without running it.
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
        """Whether the findings contain an error, so that the script cannot be imported."""
        return any(finding.severity == "error" for finding in self.findings)

    @property
    def nodes(self) -> set[str]:
        """Prim paths of all nodes."""
        return {f"{graph.path}/{name}" for graph in self.graphs for name in graph.nodes}

    @property
    def made(self) -> set[str]:
        """Prim paths of everything that the script created: graphs, nodes and other prims."""
        return {*self.prims, *self.nodes, *(graph.path for graph in self.graphs)}
