"""Vectors taken apart and put together (`omni.graph.nodes`)."""

from __future__ import annotations

from typing import Any

from graphengine.node import In, Node, Out

_TRIPLES = (
    "double[3]|float[3]|half[3]|int[3]|vectord[3]|vectorf[3]|vectorh[3]|pointd[3]|pointf[3]|pointh[3]"
    "|normald[3]|normalf[3]|normalh[3]|colord[3]|colorf[3]|colorh[3]|texcoordd[3]|texcoordf[3]|texcoordh[3]"
)
_NUMBERS = "double|float|half|int"


class BreakVector3(Node, type="omni.graph.nodes.BreakVector3"):
    """The three components of a vector, whatever its role."""

    tuple_in: Any = In(type=_TRIPLES, name="tuple", couple="number", required=True, doc="vector of three numbers")
    x: Any = Out(type=_NUMBERS, couple="number", component=True)
    y: Any = Out(type=_NUMBERS, couple="number", component=True)
    z: Any = Out(type=_NUMBERS, couple="number", component=True)

    def compute(self) -> None:
        """Take it apart."""
        self.x, self.y, self.z = self.tuple_in
