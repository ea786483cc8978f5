"""Which way execution goes (`omni.graph.action`)."""

from __future__ import annotations

from typing import ClassVar

from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Numbered, Pushes, State, Token


class Branch(Node, type="omni.graph.action.Branch"):
    """Fires one of two outputs, as the condition says."""

    exec_in = ExecIn()
    condition: bool = In(default=False, doc="whether execTrue fires, and not execFalse")
    exec_true = ExecOut()
    exec_false = ExecOut()

    def compute(self) -> Fire:
        """Choose."""
        return self.exec_true if self.condition else self.exec_false


class Multisequence(Node, type="omni.graph.action.Multisequence"):
    """Fires its outputs one after the other; what hangs on one has ended before the next begins. Isaac's menu says Sequence."""

    numbered: ClassVar[Numbered] = {"output": ExecOut}

    exec_in = ExecIn()
    output0 = ExecOut(doc="the first; output1 and so on are there when a wire begins at them")

    def compute(self) -> Pushes:
        """One after the other, by their numbers."""
        for output in self.series["output"]:
            yield getattr(self, output)


class Sequence(Node, type="omni.graph.action.Sequence", counts=True):
    """Fires a and b in turn. What Isaac's menu calls Sequence is Multisequence, this is an older type that is hidden there."""

    exec_in = ExecIn()
    a = ExecOut(doc="at the first execution since play, and every other one")
    b = ExecOut()

    odd: bool = State(default=False)

    def compute(self) -> Fire:
        """Take turns."""
        self.odd = not self.odd
        return self.a if self.odd else self.b


class SwitchToken(Node, type="omni.graph.action.SwitchToken", gated=True):
    """Fires the output whose branch has the value, such as output1 where branch1 is the value; the lowest of several, or none.

    Ports branch0, output0, branch1, output1 and so on are there when a file names them.
    """

    numbered: ClassVar[Numbered] = {"branch": lambda: In(type="token", default=""), "output": ExecOut}

    exec_in = ExecIn()
    value: Token = In(default="", doc="what is looked for among the branches")

    def compute(self) -> Fire:
        """Look the value up."""
        for branch in self.series["branch"]:
            if getattr(self, branch) == self.value:
                fired: Fire = getattr(self, f"output{branch.removeprefix('branch')}", None)
                return fired
        return None
