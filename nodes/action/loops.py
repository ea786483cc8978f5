"""Loops within one tick (`omni.graph.action`).

The body of a loop runs to its end in each iteration. A break takes effect at the end of the body that fired it; a loop that is
not running ignores it. `finished` fires after a break too. Outputs keep their values of the last iteration.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, In, Node, Out, Pushes
from graphengine.node.types import ARRAYS, ELEMENTS, Int, Target, plain


class ForLoop(Node, type="omni.graph.action.ForLoop"):
    """Fires its body for start, start + step and so on, while the value is below stop (above stop for a negative step)."""

    exec_in = ExecIn()
    break_loop = ExecIn(control=True, doc="fired by the body: ends the loop after this iteration")
    start: Int = In(default=0, doc="first value")
    stop: Int = In(default=0, doc="bound, not included")
    step: Int = In(default=1, doc="increment, which may be negative; 0 is an error")
    loop_body = ExecOut()
    index: Int = Out(doc="number of the iteration, from 0")
    value: Int = Out(doc="start + step * index")
    finished = ExecOut()

    breaks: bool = Bound()

    def setup(self, context: Context) -> None:
        """Find out whether a break is wired."""
        self.breaks = context.wires_into("break_loop") > 0

    def compute(self) -> Pushes:
        """Yield the body for each value, then finished.

        Raises:
            BadValueError: the step is 0, or the loop has too many iterations.
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
    element: Any = Out(type=ELEMENTS, couple="array", element=True, doc="element of this iteration")
    array_index: Int = Out(doc="index of the element, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Yield the body for each element, then finished.

        Raises:
            BadValueError: the loop has too many iterations.
        """
        _check_rounds(self, "arrayIn", self.array_in)
        for index, element in enumerate(self.array_in):
            self.array_index = index
            self.element = plain(element)
            yield self.loop_body
        yield self.finished


class ForEachTarget(Node, type="omni.graph.action.ForEachTarget"):
    """Fires its body for each prim of a target."""

    exec_in = ExecIn()
    targets: Target = In(default=(), doc="prims to iterate over")
    loop_body = ExecOut()
    target: Target = Out(doc="prim of this iteration")
    array_index: Int = Out(doc="index of the prim, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Yield the body for each prim, then finished.

        Raises:
            BadValueError: the loop has too many iterations.
        """
        _check_rounds(self, "targets", self.targets)
        for index, path in enumerate(self.targets):
            self.array_index, self.target = index, (path,)
            yield self.loop_body
        yield self.finished


class WhileLoop(Node, type="graphengine.action.WhileLoop"):
    """Fires its body while a condition holds; the condition is read before each iteration."""

    rereads = True

    exec_in = ExecIn()
    break_loop = ExecIn(control=True, doc="fired by the body: ends the loop after this iteration")
    condition: bool = In(default=False, doc="whether to run another iteration")
    loop_body = ExecOut()
    index: Int = Out(doc="number of the iteration, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Yield the body while the condition holds, then finished.

        Raises:
            BadValueError: the loop has too many iterations.
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
