"""Targets, which are lists of prims, put together, taken apart and compared (`omni.graph.nodes`)."""

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
    """The prims of several targets one after the other."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type="target")}

    allow_duplicates: bool = In(default=False, doc="whether a prim that is there already comes again")
    input0: Target = In(default=(), doc="come first")
    input1: Target = In(default=(), doc="come next; input2 and so on are there when a file names them")
    targets: Target = Out(doc="prims of them all")

    def compute(self) -> None:
        """Join them."""
        paths = [path for name in self.series["input"] for path in getattr(self, name)]
        self.targets = tuple(paths if self.allow_duplicates else dict.fromkeys(paths))


class GetTargets(Node, type="omni.graph.nodes.GetTargets"):
    """Some of the prims of a target."""

    count: Int = In(default=1, doc="how many; -1 and what is too many reach to the end")
    index: Int = In(
        default=0, doc="of the first, from 0; negative ones count from the end; beyond either end is an error"
    )
    targets_in: Target = In(default=(), name="targets", doc="prims to choose from")
    targets_out: Target = Out(name="targets", doc="the chosen ones; none of none")

    def compute(self) -> None:
        """Cut them out.

        Raises:
            BadValueError: there is no such prim.
        """
        found = self.targets_in
        start = position(self.index, len(found)) if found else 0
        self.targets_out = found[start : None if self.count < 0 else start + self.count]


class FindTarget(Node, type="omni.graph.nodes.FindTarget"):
    """Which of the prims of a target a prim is."""

    search_target: Target = In(default=(), doc="the prim; of several the first counts")
    targets: Target = In(default=(), doc="prims to look among")
    index: Int = Out(doc="number of the first that it is, from 0; -1 where it is none of them")

    def compute(self) -> None:
        """Look for it."""
        sought = self.search_target[:1]
        self.index = self.targets.index(sought[0]) if sought and sought[0] in self.targets else -1


class GetParentPrims(Node, type="omni.graph.nodes.GetParentPrims"):
    """The prims above others, such as /World above /World/box."""

    prims: Target = In(default=(), doc="any prims")
    parent_prims: Target = Out(doc="one for each")

    def compute(self) -> None:
        """Cut the last names off."""
        self.parent_prims = tuple(map(parent_of, self.prims))


class CompareTargets(Node, type="omni.graph.nodes.CompareTargets"):
    """Whether two targets are of the same prims in the same order; or for each prim of one, whether it is that of the other."""

    a: Target = In(default=(), doc="one of them")
    b: Target = In(default=(), doc="the other")
    compare_each: bool = In(default=False, setup=True, doc="whether there is an answer for each prim")
    operation: Token = In(default="==", tokens=("==", "!="))
    result: Any = Out(type=BOOLEANS, doc="an array where each is compared")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """An answer, or an array of them."""
        return {"result": PortType("bool", array=self.compare_each)}

    def compute(self) -> None:
        """Compare.

        Raises:
            BadValueError: there is no such operation, or there are not as many prims.
        """
        wanted = one_of("operation", self.operation, ("==", "!=")) == "=="
        if not self.compare_each:
            self.result = (self.a == self.b) == wanted
            return
        same_length(a=self.a, b=self.b)
        self.result = np.array([(one == other) == wanted for one, other in zip(self.a, self.b, strict=True)], np.bool_)
