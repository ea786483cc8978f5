"""Nodes for tests of the API."""

from __future__ import annotations

import numpy as np

from graphengine.node import Doubles, ExecIn, ExecOut, In, Node, Out, State, String


class Fails(Node, type="api.Fails"):
    """Counts its ticks, and raises in one of them."""

    exec_in = ExecIn()
    at: int = In(default=-1)
    label: String = In(default="")
    count: int = Out()
    squares: Doubles = Out()
    exec_out = ExecOut()

    total: int = State(default=0)

    def compute(self) -> None:
        self.count += 1
        self.total += self.count
        self.squares = np.arange(self.count, dtype=np.float64) ** 2
        if self.count == self.at:
            raise ArithmeticError("as it was told")
