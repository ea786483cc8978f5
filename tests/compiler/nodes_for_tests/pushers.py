"""Pushers, of which each push runs to its end."""

from __future__ import annotations

from graphengine.node import ExecIn, ExecOut, In, Node, Out, Pushes
from tests.compiler.nodes_for_tests.journal import Journaling


class Sequence(Node, type="test.Sequence"):
    """Fires its ports one after the other."""

    exec_in = ExecIn()
    a = ExecOut()
    b = ExecOut()
    c = ExecOut()

    def compute(self) -> Pushes:
        yield self.a
        yield self.b
        yield self.c


class Both(Node, type="test.Both"):
    """Fires two ports in one yield."""

    exec_in = ExecIn()
    a = ExecOut()
    b = ExecOut()
    index: float = Out()

    def compute(self) -> Pushes:
        for i in range(2):
            self.index = float(i)
            yield self.a | self.b


class ForLoop(Journaling, type="test.ForLoop"):
    """Fires for each number below `stop`, until it is told to break."""

    exec_in = ExecIn()
    break_loop = ExecIn(control=True)
    stop: int = In(default=3)
    loop_body = ExecOut()
    finished = ExecOut()
    index: float = Out()

    def compute(self) -> Pushes:
        for i in range(self.stop):
            self.index = float(i)
            yield self.loop_body
            if self.break_loop:
                self.write("breaks")
                break
        yield self.finished


class WhileLoop(Node, type="test.WhileLoop"):
    """Fires while a condition holds that is read before each round, but four times at most."""

    rereads = True

    exec_in = ExecIn()
    condition: bool = In(default=False)
    loop_body = ExecOut()
    index: float = Out()
    finished = ExecOut()

    def compute(self) -> Pushes:
        self.index = 0.0
        while self.condition and self.index < 4.0:
            yield self.loop_body
            self.index += 1.0
        yield self.finished
