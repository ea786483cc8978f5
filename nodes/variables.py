"""Nodes that read and write the variables of a graph (`omni.graph.core`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, PortType, Target, Token, Variable
from graphengine.node.variable import find_variable

_IGNORED = "no effect; Isaac Sim ignores this input too"


class VariableNode(Node):
    """Base of nodes that read or write a graph variable. The ports named `value` have the type of the variable."""

    variable_name: Token = In(default="", setup=True, required=True, doc="variable from `variables:` of the graph file")
    graph: Target = In(default=(), doc=_IGNORED)
    target_path: Token = In(default="", doc=_IGNORED)

    variable: Variable = Bound()

    def setup(self, context: Context) -> None:
        """Look up the graph variable `variableName` and keep it.

        Raises:
            ContextError: the graph has no variable of this name.
        """
        self.variable = context.variable(self.variable_name)

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the variable as the type of all ports named `value`.

        Raises:
            ContextError: the graph has no variable of this name.
        """
        if not self.variable_name:
            return {}
        values = [name for name in type(self).fields if name.startswith("value")]
        return dict.fromkeys(values, find_variable(variables, self.variable_name))


class ReadVariable(VariableNode, type="omni.graph.core.ReadVariable", volatile=True):
    """Reads a variable of the graph."""

    value: Any = Out(type="any", doc="last written value, or the variable's default if none was written")

    def compute(self) -> None:
        """Output the current value of the variable."""
        self.value = self.variable.value

    def reads(self) -> Iterable[str]:
        """Return the resource key of the variable."""
        return (f"variable:{self.variable_name}",)


class WriteVariable(VariableNode, type="omni.graph.core.WriteVariable"):
    """Writes a variable of the graph; nodes that read it later in the same pass get the new value."""

    exec_in = ExecIn()
    value_in: Any = In(type="any", name="value", required=True, doc="value to write")
    exec_out = ExecOut()
    value_out: Any = Out(type="any", name="value", doc="the written value")

    def compute(self) -> None:
        """Write the input `value` to the variable, and copy it to the output `value`."""
        self.variable.value = self.value_out = self.value_in

    def writes(self) -> Iterable[str]:
        """Return the resource key of the variable."""
        return (f"variable:{self.variable_name}",)
