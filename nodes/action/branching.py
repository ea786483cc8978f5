"""Nodes that select which execution outputs fire, or in which order (`omni.graph.action`)."""

from __future__ import annotations

from typing import ClassVar

from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Numbered, Pushes, State, Token


class Branch(Node, type="omni.graph.action.Branch"):
    """Fires `execTrue` if `condition` is true, else `execFalse`."""

    exec_in = ExecIn()
    condition: bool = In(default=False, doc="true fires `execTrue`, false fires `execFalse`")
    exec_true = ExecOut()
    exec_false = ExecOut()

    def compute(self) -> Fire:
        """Return `execTrue` or `execFalse`, depending on `condition`."""
        return self.exec_true if self.condition else self.exec_false


class Multisequence(Node, type="omni.graph.action.Multisequence"):
    """Fires `output0`, `output1`, … one after the other; the nodes behind an output finish before the next output fires.

    In the menu of Isaac Sim, this node is called Sequence.
    """

    numbered: ClassVar[Numbered] = {"output": ExecOut}

    exec_in = ExecIn()
    output0 = ExecOut(doc="first output; a wire from `output1`, `output2`, … adds that output")

    def compute(self) -> Pushes:
        """Yield the wired outputs in the order of their numbers."""
        for output in self.series["output"]:
            yield getattr(self, output)


class Sequence(Node, type="omni.graph.action.Sequence", counts=True):
    """Fires `a` and `b` alternately; the first execution after play fires `a`.

    Isaac Sim's menu hides this older node type; the menu entry Sequence creates a Multisequence.
    """

    exec_in = ExecIn()
    a = ExecOut(doc="fires at the first, third, fifth, … execution since play")
    b = ExecOut()

    odd: bool = State(default=False)

    def compute(self) -> Fire:
        """Return `a` and `b` alternately."""
        self.odd = not self.odd
        return self.a if self.odd else self.b


class SwitchToken(Node, type="omni.graph.action.SwitchToken", gated=True):
    """Fires `output0` if `value` equals `branch0`, `output1` if it equals `branch1` and so on; only the first match fires.

    The graph file adds the ports `branch0`, `output0`, `branch1`, `output1`, … Nothing fires if no branch equals `value`.
    """

    numbered: ClassVar[Numbered] = {"branch": lambda: In(type="token", default=""), "output": ExecOut}

    exec_in = ExecIn()
    value: Token = In(default="", doc="token to compare with `branch0`, `branch1`, …")

    def compute(self) -> Fire:
        """Return the output of the first branch that equals `value`; None if no branch equals it."""
        for branch in self.series["branch"]:
            if getattr(self, branch) == self.value:
                fired: Fire = getattr(self, f"output{branch.removeprefix('branch')}", None)
                return fired
        return None
