"""Bases of nodes that compute with numbers of any type: a subclass defines ports and an operation on arrays."""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

from graphengine.node import Bound, Context, In, Node, Numbered, PortType, UnionType
from graphengine.nodes.data.broadcast import Operand, Operation, common, lift, type_of
from graphengine.nodes.data.unions import NUMERICS


class TypedNode(Node):
    """Base of nodes whose output types follow from their input types."""

    like: ClassVar[str] = ""
    """Input whose type the outputs get, as arrays if any input is an array; empty if all inputs determine the type."""

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Types of the outputs, once all input types are known.

        Raises:
            ValueError: the input types are incompatible.
        """
        ports = [port for port in type(self).fields.values() if isinstance(port.type, UnionType)]
        inputs = [port for port in ports if port.side == "inputs"]
        if not all(port.field in known for port in inputs):
            return {}
        given = {port.name: known[port.field] for port in inputs}
        result = self.result_type(given)
        return {port.field: result for port in ports if port.side == "outputs"}

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """The type of the outputs.

        Args:
            given: types of the inputs of union type, by name.

        Raises:
            ValueError: the types are incompatible.
        """
        if self.like:
            return replace(given[self.like], array=any(port_type.array for port_type in given.values()))
        return common(given)

    def port_types(self) -> Mapping[str, PortType]:
        """Types of all ports by Python name: those resolved by the graph, or for a node outside a graph those of its values."""
        fields = type(self).fields.values()
        known = {port.field: port.type for port in fields if isinstance(port.type, PortType)} | dict(self.settled)
        for port in fields:
            if port.side == "inputs" and port.field not in known:
                known[port.field] = type_of(getattr(self, port.field))
        return {**self.resolve_types(known, {}), **known}


class Elementwise(TypedNode):
    """Base of nodes that apply one operation to all numbers and have one output.

    `operation` gets the operands as arrays that broadcast, in the order of the ports. `on_numbers` for scalars and
    `on_tuples` for whole tuples replace it where numpy would be slow.
    """

    operation: ClassVar[Operation]
    on_numbers: ClassVar[Operation | None] = None
    on_tuples: ClassVar[Operation | None] = None

    operate: Operation = Bound()
    operand_values: Callable[[Node], tuple[Any, ...]] = Bound()
    output_field: str = Bound()

    def setup(self, context: Context) -> None:
        """Choose the implementation for the resolved types."""
        cls, known, fields = type(self), self.port_types(), self.operands()
        self.output_field = next(port.field for port in cls.fields.values() if port.side == "outputs")
        operands = [Operand.of(known[field], cls.fields[field].name) for field in fields]
        self.operate = self.lifted(operands, known[self.output_field])
        one = operator.attrgetter(fields[0])
        self.operand_values = operator.attrgetter(*fields) if len(fields) > 1 else lambda node: (one(node),)

    def compute(self) -> None:
        """Set the output to the operation on the operands."""
        setattr(self, self.output_field, self.operate(*self.operand_values(self)))

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """The operation for values of the given types."""
        cls = type(self)
        if cls.on_tuples is not None and not any(one.array for one in inputs):
            return cls.on_tuples
        return lift(cls.operation, inputs, output, cls.on_numbers)

    @classmethod
    def operands(cls) -> list[str]:
        """Python names of the operands among the inputs."""
        inputs = [port for port in cls.fields.values() if port.side == "inputs"]
        return [port.field for port in inputs if isinstance(port.type, UnionType) or port.type.is_number]


class Folded(Elementwise):
    """Base of nodes that combine `a`, `b` and any further `input2`, `input3`, … of the graph file from left to right."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=NUMERICS, required=True)}

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """The operation applied to two or more values."""
        if len(inputs) == 2:
            return super().lifted(inputs, output)
        cls = type(self)
        fold = functools.partial(_fold, cls.operation)
        return lift(fold, inputs, output, cls.on_numbers and functools.partial(_fold, cls.on_numbers))


def _fold(function: Operation, *values: Any) -> Any:
    return functools.reduce(function, values)
