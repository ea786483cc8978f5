"""Operations on targets, which are lists of prims (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from graphengine.node import In, Int, Node, Numbered, Out, PortType, Target, Token
from graphengine.nodes.checked import one_of, same_length
from graphengine.nodes.data.paths import parent_of
from graphengine.nodes.data.sequences import position
from graphengine.nodes.data.unions import BOOLEANS


class AppendTargets(Node, type="omni.graph.nodes.AppendTargets"):
    """Concatenation of targets."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type="target")}

    allow_duplicates: bool = In(default=False, doc="true: keep all occurrences of a prim; false: only the first")
    input0: Target = In(default=(), doc="first target")
    input1: Target = In(default=(), doc="second target; a graph file can name further inputs `input2`, `input3`, …")
    targets: Target = Out(doc="prims of all inputs, in order")

    def compute(self) -> None:
        """Concatenate the targets."""
        paths = [path for name in self.series["input"] for path in getattr(self, name)]
        self.targets = tuple(paths if self.allow_duplicates else dict.fromkeys(paths))


class GetTargets(Node, type="omni.graph.nodes.GetTargets"):
    """Selects consecutive prims of a target, by index."""

    count: Int = In(default=1, doc="number of prims; a negative or too large number extends to the end")
    index: Int = In(
        default=0, doc="index of the first prim, from 0; negative values count from the end; out of range is an error"
    )
    targets_in: Target = In(default=(), name="targets", doc="prims to select from")
    targets_out: Target = Out(name="targets", doc="selected prims; empty if the input is empty")

    def compute(self) -> None:
        """Select the prims.

        Raises:
            BadValueError: the index is out of range.
        """
        found = self.targets_in
        start = position(self.index, len(found)) if found else 0
        self.targets_out = found[start : None if self.count < 0 else start + self.count]


class FindTarget(Node, type="omni.graph.nodes.FindTarget"):
    """Index of a prim in a target."""

    search_target: Target = In(default=(), doc="prim to search for; only the first of several counts")
    targets: Target = In(default=(), doc="prims to search in")
    index: Int = Out(doc="index of the prim in `targets`, from 0; -1 if it is not there")

    def compute(self) -> None:
        """Search for the prim."""
        sought = self.search_target[:1]
        self.index = self.targets.index(sought[0]) if sought and sought[0] in self.targets else -1


class GetParentPrims(Node, type="omni.graph.nodes.GetParentPrims"):
    """The parents of prims, such as `/World` for `/World/box`."""

    prims: Target = In(default=(), doc="prims whose parents are output")
    parent_prims: Target = Out(doc="one parent for each prim")

    def compute(self) -> None:
        """Remove the last name of each path."""
        self.parent_prims = tuple(map(parent_of, self.prims))


class CompareTargets(Node, type="omni.graph.nodes.CompareTargets"):
    """Compares two targets: as a whole, including the order of their prims, or prim by prim."""

    a: Target = In(default=(), doc="first target")
    b: Target = In(default=(), doc="second target")
    compare_each: bool = In(default=False, setup=True, doc="true: compare prim by prim; false: as a whole")
    operation: Token = In(default="==", tokens=("==", "!="))
    result: Any = Out(type=BOOLEANS, doc="bool, or array of bools if `compareEach` is true")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return a bool, or an array of bools to compare prim by prim."""
        return {"result": PortType("bool", array=self.compare_each)}

    def compute(self) -> None:
        """Compare the targets.

        Raises:
            BadValueError: the operation is unknown, or the numbers of prims differ.
        """
        wanted = one_of("operation", self.operation, ("==", "!=")) == "=="
        if not self.compare_each:
            self.result = (self.a == self.b) == wanted
            return
        same_length(a=self.a, b=self.b)
        self.result = np.array([(one == other) == wanted for one, other in zip(self.a, self.b, strict=True)], np.bool_)
