"""The plain data that the stage process returns: graphs, nodes, and other prims on which graphs depend."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

INSTANCES = "omniGraphs"
"""Name of the relationship that links a prim to the graphs that are evaluated for this prim."""
COMPOUND = "omni:graph:compoundGraph"
"""Name of the relationship that links a compound node to its inner graph, which is below the compound."""


@dataclass(slots=True)
class StageAttribute:
    """An attribute of a graph, a node, or another prim to which a node is connected.

    Attributes:
        type: OmniGraph's type name; for a union or `any` port, the resolved type, or empty if it is not resolved.
        value: the value, in the form of `RecordedValue.data`; None if the stage has no value.
        sources: absolute paths of the connected attributes.
        execution: whether the attribute is an execution port.
    """

    type: str
    value: Any = None
    sources: list[str] = field(default_factory=list)
    execution: bool = False


@dataclass(slots=True)
class StagePrim:
    """A graph, a node, or another prim with a namespace or graph instances.

    Attributes:
        path: path of the prim.
        type: name of the USD type, such as `OmniGraphNode`.
        attributes: attributes by full name, in order of their names.
        targets: absolute target paths of each relationship, by full name.
    """

    path: str
    type: str
    attributes: dict[str, StageAttribute] = field(default_factory=dict)
    targets: dict[str, list[str]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Last part of the path."""
        return self.path.rpartition("/")[2]

    def text(self, name: str) -> str:
        """Return the value of an attribute if it is a string, otherwise an empty string."""
        value = self.attributes[name].value if name in self.attributes else None
        return value if isinstance(value, str) else ""


@dataclass(slots=True)
class StageContents:
    """The parts of a stage that concern graphs.

    Attributes:
        prims: graphs, nodes, and prims with namespaces or graph instances, by path, in stage order.
        plain: attributes outside of nodes to which nodes are connected, by path of the attribute.
        left_out: pairs (path, reason) of the parts that could not be read.
        failure: reason why nothing was read; empty if the stage was read.
        used: paths of the files that were read.
        choices: variant selections as text with the available variants, such as `/World: ros = none, of none, ros2`.
    """

    prims: dict[str, StagePrim] = field(default_factory=dict)
    plain: dict[str, StageAttribute] = field(default_factory=dict)
    left_out: list[tuple[str, str]] = field(default_factory=list)
    failure: str = ""
    used: list[str] = field(default_factory=list)
    choices: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        if any(path != prim.path for path, prim in self.prims.items()):
            raise ValueError(self.prims)
