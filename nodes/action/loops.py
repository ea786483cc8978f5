"""What runs several times in one tick (`omni.graph.action`).

The body of a loop runs to its end for each element. A break acts when the body that asked for it has ended, and is nothing to a
loop that does not run; `finished` fires after a break too. Outputs keep what they were in the last round.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, In, Node, Out, Pushes
from graphengine.node.types import ARRAYS, ELEMENTS, Int, Target, plain


class ForLoop(Node, type="omni.graph.action.ForLoop"):
    """Fires its body for start, start + step and so on, as long as that is below stop, or above it where step is negative."""

    exec_in = ExecIn()
    break_loop = ExecIn(control=True, doc="to be fired by the body: this round is the last one")
    start: Int = In(default=0, doc="the first number")
    stop: Int = In(default=0, doc="the first number that is not reached")
    step: Int = In(default=1, doc="0 is an error")
    loop_body = ExecOut()
    index: Int = Out(doc="number of the round, from 0")
    value: Int = Out(doc="start + step * index")
    finished = ExecOut()

    breaks: bool = Bound()

    def setup(self, context: Context) -> None:
        """See whether the loop can end before it reaches stop."""
        self.breaks = context.wires_into("break_loop") > 0

    def compute(self) -> Pushes:
        """Round by round.

        Raises:
            BadValueError: the step is 0, or there are too many rounds.
        """
        if self.break_loop and not self.exec_in:
            return
        if not self.step:
            raise BadValueError("step", self.step, "a positive or a negative number")
        rounds = range(self.start, self.stop, self.step)
        if len(rounds) > self.max_pushes and not self.breaks:
            raise BadValueError("start, stop, step", rounds, f"{self.max_pushes} numbers or fewer")
        for index, value in enumerate(rounds):
            self.index, self.value = index, value
            yield self.loop_body
            if self.break_loop:
                break
        yield self.finished


def _check_rounds(node: Node, port: str, elements: Any) -> None:
    if len(elements) > node.max_pushes:
        raise BadValueError(port, len(elements), f"of {node.max_pushes} elements or fewer")


class ForEach(Node, type="omni.graph.action.ForEach"):
    """Fires its body for each element of an array."""

    exec_in = ExecIn()
    array_in: Any = In(type=ARRAYS, couple="array", required=True)
    loop_body = ExecOut()
    element: Any = Out(type=ELEMENTS, couple="array", element=True, doc="what the array has there")
    array_index: Int = Out(doc="number of the element, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Element by element.

        Raises:
            BadValueError: there are too many.
        """
        _check_rounds(self, "arrayIn", self.array_in)
        for index, element in enumerate(self.array_in):
            self.array_index = index
            self.element = plain(element)
            yield self.loop_body
        yield self.finished


class ForEachTarget(Node, type="omni.graph.action.ForEachTarget"):
    """Fires its body for each of some prims."""

    exec_in = ExecIn()
    targets: Target = In(default=(), doc="prims to go through")
    loop_body = ExecOut()
    target: Target = Out(doc="the prim of the round, alone")
    array_index: Int = Out(doc="number of the prim, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Prim by prim.

        Raises:
            BadValueError: there are too many.
        """
        _check_rounds(self, "targets", self.targets)
        for index, path in enumerate(self.targets):
            self.array_index, self.target = index, (path,)
            yield self.loop_body
        yield self.finished


class WhileLoop(Node, type="graphengine.action.WhileLoop"):
    """Fires its body as long as a condition holds, which is looked at before each round."""

    rereads = True

    exec_in = ExecIn()
    break_loop = ExecIn(control=True, doc="to be fired by the body: this round is the last one")
    condition: bool = In(default=False, doc="whether there is another round")
    loop_body = ExecOut()
    index: Int = Out(doc="number of the round, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Round by round.

        Raises:
            BadValueError: the condition does not become false.
        """
        if self.break_loop and not self.exec_in:
            return
        self.index = rounds = 0
        while self.condition:
            if rounds == self.max_pushes:
                raise BadValueError("condition", True, f"false after {rounds} rounds at the latest")
            self.index = rounds
            yield self.loop_body
            if self.break_loop:
                break
            rounds += 1
        yield self.finished
