"""Variables of a graph (`omni.graph.core`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, PortType, Target, Token, Variable
from graphengine.node.variable import find_variable

_IGNORED = "means nothing, as in the reference"


class VariableNode(Node):
    """A node that has to do with one variable of its graph, whose type is that of `value`."""

    variable_name: Token = In(default="", setup=True, required=True, doc="one of the graph's `variables:`")
    graph: Target = In(default=(), doc=_IGNORED)
    target_path: Token = In(default="", doc=_IGNORED)

    variable: Variable = Bound()

    def setup(self, context: Context) -> None:
        """Bind the variable.

        Raises:
            ContextError: the graph has none of that name.
        """
        self.variable = context.variable(self.variable_name)

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """The variable's type.

        Raises:
            ContextError: the graph has none of that name.
        """
        if not self.variable_name:
            return {}
        values = [name for name in type(self).fields if name.startswith("value")]
        return dict.fromkeys(values, find_variable(variables, self.variable_name))


class ReadVariable(VariableNode, type="omni.graph.core.ReadVariable", volatile=True):
    """The value of a variable."""

    value: Any = Out(type="any", doc="what was last written, or the default")

    def compute(self) -> None:
        """Read it."""
        self.value = self.variable.value

    def reads(self) -> Iterable[str]:
        """The variable."""
        return (f"variable:{self.variable_name}",)


class WriteVariable(VariableNode, type="omni.graph.core.WriteVariable"):
    """Writes a variable; who reads it later in the same pass sees it."""

    exec_in = ExecIn()
    value_in: Any = In(type="any", name="value", required=True, doc="to be written")
    exec_out = ExecOut()
    value_out: Any = Out(type="any", name="value", doc="what was written")

    def compute(self) -> None:
        """Write it."""
        self.variable.value = self.value_out = self.value_in

    def writes(self) -> Iterable[str]:
        """The variable."""
        return (f"variable:{self.variable_name}",)
