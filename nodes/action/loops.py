"""Loop nodes (`omni.graph.action`). They run all iterations within one tick.

In each iteration, all nodes behind `loopBody` run. If one of them fires the loop's input `breakLoop`, this iteration is the
last one. A loop that is not running ignores `breakLoop`. `finished` fires after a break too. After the loop, the outputs keep
the values of the last iteration.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, In, Node, Out, Pushes
from graphengine.node.types import ARRAYS, ELEMENTS, Int, Target, plain


class ForLoop(Node, type="omni.graph.action.ForLoop"):
    """Fires `loopBody` with `value` = `start`, `start` + `step`, … as long as `value` is below `stop`, then fires `finished`.

    If `step` is negative, the loop runs as long as `value` is above `stop`.
    """

    exec_in = ExecIn()
    break_loop = ExecIn(control=True, doc="ends the loop after the current iteration; wire it from the loop body")
    start: Int = In(default=0, doc="first `value`")
    stop: Int = In(default=0, doc="end of the range of `value`, not included")
    step: Int = In(default=1, doc="increment of `value` per iteration; it may be negative, but 0 is an error")
    loop_body = ExecOut()
    index: Int = Out(doc="number of the current iteration, from 0")
    value: Int = Out(doc="`start` + `step` * `index`")
    finished = ExecOut()

    breaks: bool = Bound()

    def setup(self, context: Context) -> None:
        """Check whether `breakLoop` is wired; a loop with a break may have any number of iterations."""
        self.breaks = context.wires_into("break_loop") > 0

    def compute(self) -> Pushes:
        """Yield `loopBody` for each value, then `finished`.

        Raises:
            BadValueError: `step` is 0, or the loop has too many iterations and `breakLoop` is not wired.
        """
        if self.break_loop and not self.exec_in:
            return
        if not self.step:
            raise BadValueError("step", self.step, "other than 0")
        rounds = range(self.start, self.stop, self.step)
        if len(rounds) > self.max_pushes and not self.breaks:
            raise BadValueError("start, stop, step", rounds, f"a range of {self.max_pushes} numbers or fewer")
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
    """Fires `loopBody` for each element of an array, then `finished`."""

    exec_in = ExecIn()
    array_in: Any = In(type=ARRAYS, couple="array", required=True)
    loop_body = ExecOut()
    element: Any = Out(type=ELEMENTS, couple="array", element=True, doc="array element of the current iteration")
    array_index: Int = Out(doc="index of the current element, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Yield `loopBody` for each element, then `finished`.

        Raises:
            BadValueError: the array has more elements than a loop may have iterations.
        """
        _check_rounds(self, "arrayIn", self.array_in)
        for index, element in enumerate(self.array_in):
            self.array_index = index
            self.element = plain(element)
            yield self.loop_body
        yield self.finished


class ForEachTarget(Node, type="omni.graph.action.ForEachTarget"):
    """Fires `loopBody` for each prim in `targets`, then `finished`."""

    exec_in = ExecIn()
    targets: Target = In(default=(), doc="prims to iterate over")
    loop_body = ExecOut()
    target: Target = Out(doc="prim of the current iteration")
    array_index: Int = Out(doc="index of the current prim, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Yield `loopBody` for each prim, then `finished`.

        Raises:
            BadValueError: there are more prims than a loop may have iterations.
        """
        _check_rounds(self, "targets", self.targets)
        for index, path in enumerate(self.targets):
            self.array_index, self.target = index, (path,)
            yield self.loop_body
        yield self.finished


class WhileLoop(Node, type="graphengine.action.WhileLoop"):
    """Fires `loopBody` as long as `condition` is true, then `finished`; `condition` is evaluated before each iteration."""

    rereads = True

    exec_in = ExecIn()
    break_loop = ExecIn(control=True, doc="ends the loop after the current iteration; wire it from the loop body")
    condition: bool = In(default=False, doc="whether to run another iteration; evaluated before each iteration")
    loop_body = ExecOut()
    index: Int = Out(doc="number of the current iteration, from 0")
    finished = ExecOut()

    def compute(self) -> Pushes:
        """Yield `loopBody` as long as `condition` is true, then `finished`.

        Raises:
            BadValueError: `condition` is still true after the largest allowed number of iterations.
        """
        if self.break_loop and not self.exec_in:
            return
        self.index = rounds = 0
        while self.condition:
            if rounds == self.max_pushes:
                raise BadValueError("condition", True, f"false after {rounds} iterations or fewer")
            self.index = rounds
            yield self.loop_body
            if self.break_loop:
                break
            rounds += 1
        yield self.finished
