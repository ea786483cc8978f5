"""Contents of a stage as plain data: graphs, nodes, and prims that concern them."""

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
"""How USD's messages of mistakes in text begin."""


@dataclass(slots=True)
class StageAttribute:
    """An attribute of a graph or a node.

    Attributes:
        type: OmniGraph's name of its type; of an extended port the type it is resolved to, empty where it is not.
        value: as `RecordedValue.data`; None where the stage gives none.
        sources: what it is connected to, as absolute paths.
        execution: whether it carries execution.
    """

    type: str
    value: Any = None
    sources: list[str] = field(default_factory=list)
    execution: bool = False


@dataclass(slots=True)
class StagePrim:
    """A graph, a node, or another prim that graphs refer to.

    Attributes:
        path: where it is.
        type: of its schema, such as `OmniGraphNode`.
        attributes: by full name, in order of their names.
        targets: absolute paths that relationships lead to, by full name.
    """

    path: str
    type: str
    attributes: dict[str, StageAttribute] = field(default_factory=dict)
    targets: dict[str, list[str]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition("/")[2]

    def text(self, name: str) -> str:
        """An attribute's value if it is text, else the empty string."""
        value = self.attributes[name].value if name in self.attributes else None
        return value if isinstance(value, str) else ""


@dataclass(slots=True)
class StageContents:
    """The graphs of a stage and the prims they refer to.

    Attributes:
        prims: by path, in order of the stage.
        plain: attributes of other prims, which nodes are connected to, by path.
        left_out: what could not be read, and why.
        failure: why nothing was read; empty where it was.
        used: files that were read.
        choices: of variants that prims have, as `/World: ros = none, of none, ros2`.
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
