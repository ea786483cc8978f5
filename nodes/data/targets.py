"""Nodes that combine, search and compare targets, that is, lists of prims (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from graphengine.node import In, Int, Node, Numbered, Out, PortType, Target, Token
from graphengine.nodes.checked import one_of, same_length
from graphengine.nodes.data.paths import parent_of
from graphengine.nodes.data.sequences import INDEX, position
from graphengine.nodes.data.unions import BOOLEANS


class AppendTargets(Node, type="omni.graph.nodes.AppendTargets"):
    """Concatenates the prim lists of two or more target inputs."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type="target")}

    allow_duplicates: bool = In(default=False, doc="true: keep all occurrences of a prim; false: only the first")
    input0: Target = In(default=(), doc="first target")
    input1: Target = In(default=(), doc="second target; a graph file can add inputs `input2`, `input3`, …")
    targets: Target = Out(doc="prims of all inputs, in order")

    def compute(self) -> None:
        """Set `targets` to the prims of all inputs."""
        paths = [path for name in self.series["input"] for path in getattr(self, name)]
        self.targets = tuple(paths if self.allow_duplicates else dict.fromkeys(paths))


class GetTargets(Node, type="omni.graph.nodes.GetTargets"):
    """Selects consecutive prims of a target, by index."""

    count: Int = In(default=1, doc="number of prims; a negative or too large number selects all up to the end")
    index: Int = In(default=0, doc=f"first prim: {INDEX}")
    targets_in: Target = In(default=(), name="targets", doc="prims to select from")
    targets_out: Target = Out(name="targets", doc="selected prims; empty if the input is empty")

    def compute(self) -> None:
        """Set the output to the selected prims.

        Raises:
            BadValueError: `index` is out of range.
        """
        found = self.targets_in
        start = position(self.index, len(found)) if found else 0
        self.targets_out = found[start : None if self.count < 0 else start + self.count]


class FindTarget(Node, type="omni.graph.nodes.FindTarget"):
    """Finds the index of a prim in the prim list of a target input."""

    search_target: Target = In(default=(), doc="prim to search for; if there are several, the first one")
    targets: Target = In(default=(), doc="prims to search in")
    index: Int = Out(doc="index of the prim in `targets`, from 0; -1 if `targets` does not contain the prim")

    def compute(self) -> None:
        """Set `index` to the index of the prim, or to -1."""
        sought = self.search_target[:1]
        self.index = self.targets.index(sought[0]) if sought and sought[0] in self.targets else -1


class GetParentPrims(Node, type="omni.graph.nodes.GetParentPrims"):
    """Outputs the parents of prims, such as `/World` for `/World/box`."""

    prims: Target = In(default=(), doc="prims whose parents are output")
    parent_prims: Target = Out(doc="one parent for each prim")

    def compute(self) -> None:
        """Set `parentPrims` to the path of each prim without its last name."""
        self.parent_prims = tuple(map(parent_of, self.prims))


class CompareTargets(Node, type="omni.graph.nodes.CompareTargets"):
    """Compares two targets prim by prim, or as a whole, including the order of the prims."""

    a: Target = In(default=(), doc="first target")
    b: Target = In(default=(), doc="second target")
    compare_each: bool = In(default=False, setup=True, doc="true: compare prim by prim; false: as a whole")
    operation: Token = In(default="==", tokens=("==", "!="))
    result: Any = Out(type=BOOLEANS, doc="result of the comparison; array of bools if `compareEach` is true")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the output: bool, or bool[] if `compareEach` is true."""
        return {"result": PortType("bool", array=self.compare_each)}

    def compute(self) -> None:
        """Set `result` to the result of the comparison.

        Raises:
            BadValueError: `operation` is unknown, or `compareEach` is true and the targets differ in length.
        """
        wanted = one_of("operation", self.operation, ("==", "!=")) == "=="
        if not self.compare_each:
            self.result = (self.a == self.b) == wanted
            return
        same_length(a=self.a, b=self.b)
        self.result = np.array([(one == other) == wanted for one, other in zip(self.a, self.b, strict=True)], np.bool_)
