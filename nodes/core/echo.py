"""IsaacTestNode, a node for tests of graphs (`isaacsim.core.nodes`)."""

from __future__ import annotations

from graphengine.node import ExecIn, In, Node, Out, String


class IsaacTestNode(Node, type="isaacsim.core.nodes.IsaacTestNode"):
    """Copies the text in `input` to `output` at each execution; for tests of graphs."""

    exec_in = ExecIn()
    input_in: String = In(default="", name="input", doc="text to copy")
    output: String = Out(doc="value of `input` at the last execution")

    def compute(self) -> None:
        """Copy `input` to `output`."""
        self.output = self.input_in
