"""Contents of a stage as plain data: graphs, nodes, and other prims that graphs refer to."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

SUFFIXES = (".usd", ".usda", ".usdc")
INSTANCES = "omniGraphs"
"""Relationship of a prim to the graphs that are evaluated for it."""
COMPOUND = "omni:graph:compoundGraph"
"""Relationship of a compound to its graph, which lies below it."""
PLACE = re.compile(r"/.*?:(?P<line>\d{1,9}):(?P<column>\d{1,9}): (?P<what>.*)", re.DOTALL)
"""Matches the beginning of USD's messages about syntax errors: path, line and column."""


@dataclass(slots=True)
class StageAttribute:
    """An attribute of a graph or node.

    Attributes:
        type: OmniGraph's type name; for an extended type the resolved one, or empty.
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
    """A graph, a node, or another prim that graphs refer to.

    Attributes:
        path: path of the prim.
        type: type of its schema, such as `OmniGraphNode`.
        attributes: attributes by full name, sorted.
        targets: absolute paths of the targets of relationships, by full name.
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
        """Return the value of an attribute if it is a string, else an empty string."""
        value = self.attributes[name].value if name in self.attributes else None
        return value if isinstance(value, str) else ""


@dataclass(slots=True)
class StageContents:
    """The graphs of a stage and the prims that they refer to.

    Attributes:
        prims: prims by path, in stage order.
        plain: attributes of other prims to which nodes are connected, by path.
        left_out: parts that could not be read, each with the reason.
        failure: reason why nothing was read; empty if the stage was read.
        used: files that were read.
        choices: variant selections of prims, such as `/World: ros = none, of none, ros2`.
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
