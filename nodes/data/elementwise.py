"""Base classes of nodes that compute with numbers of any type; a subclass defines the ports and the operation."""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

from graphengine.node import Bound, Context, In, Node, Numbered, PortType, UnionType
from graphengine.nodes.data.broadcast import Operand, Operation, common, lift, type_of
from graphengine.nodes.data.unions import NUMERICS
from graphengine.nodes.known_inputs import LENGTHS, KnownInputs


class TypedNode(Node):
    """Base class of nodes whose output types follow from their input types."""

    like: ClassVar[str] = ""
    """Name of the input whose type is the type of the outputs; if empty, the outputs have the common type of all inputs.

    If any input is an array, the outputs are arrays too.
    """

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the types of the outputs, or an empty mapping until the types of all inputs are known.

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
        """Return the type of the outputs for the given input types.

        Args:
            given: a dict from the port name of each union input to its type.

        Raises:
            ValueError: the types are incompatible.
        """
        if self.like:
            return replace(given[self.like], array=any(port_type.array for port_type in given.values()))
        return common(given)

    def port_types(self) -> Mapping[str, PortType]:
        """Return the types of all ports by Python name. Outside a graph, the types follow from the values of the inputs."""
        fields = type(self).fields.values()
        known = {port.field: port.type for port in fields if isinstance(port.type, PortType)} | dict(self.settled)
        for port in fields:
            if port.side == "inputs" and port.field not in known:
                known[port.field] = type_of(getattr(self, port.field))
        return {**self.resolve_types(known, {}), **known}


class Elementwise(TypedNode):
    """Base class of nodes with one output that apply the same operation to all numbers of their operands.

    `operation` takes one numpy array per operand, in the order of the ports; the arrays broadcast against each other. A subclass
    can define faster versions of `operation`: `on_numbers` is called with Python numbers, for scalars and for each component of
    tuples; `on_tuples` is called with scalars and whole tuples if no operand is an array.
    """

    operation: ClassVar[Operation]
    on_numbers: ClassVar[Operation | None] = None
    on_tuples: ClassVar[Operation | None] = None

    operate: Operation = Bound()
    operand_values: Callable[[Node], tuple[Any, ...]] = Bound()
    output_field: str = Bound()

    def setup(self, context: Context) -> None:
        """Select the implementation for the resolved port types."""
        cls, known, fields = type(self), self.port_types(), self.operands()
        self.output_field = next(port.field for port in cls.fields.values() if port.side == "outputs")
        operands = [Operand.of(known[field], cls.fields[field].name) for field in fields]
        self.operate = self.lifted(operands, known[self.output_field])
        one = operator.attrgetter(fields[0])
        self.operand_values = operator.attrgetter(*fields) if len(fields) > 1 else lambda node: (one(node),)

    def compute(self) -> None:
        """Set the output to the result of the operation on the operands."""
        setattr(self, self.output_field, self.operate(*self.operand_values(self)))

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the operation as a function of port values of the given types."""
        cls = type(self)
        if cls.on_tuples is not None and not any(one.array for one in inputs):
            return cls.on_tuples
        return lift(cls.operation, inputs, output, cls.on_numbers)

    @classmethod
    def operands(cls) -> list[str]:
        """Return the Python names of the operands: all inputs with a numeric type or a union type."""
        inputs = [port for port in cls.fields.values() if port.side == "inputs"]
        return [port.field for port in inputs if isinstance(port.type, UnionType) or port.type.is_number]


LENGTHS[Elementwise] = KnownInputs.same


class Folded(Elementwise):
    """Base class of nodes that combine inputs from left to right: `a`, `b`, then `input2`, `input3`, … if a graph adds them."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=NUMERICS, required=True)}

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function of two or more port values that applies the operation from left to right."""
        if len(inputs) == 2:
            return super().lifted(inputs, output)
        cls = type(self)
        fold = functools.partial(_fold, cls.operation)
        return lift(fold, inputs, output, cls.on_numbers and functools.partial(_fold, cls.on_numbers))


def _fold(function: Operation, *values: Any) -> Any:
    return functools.reduce(function, values)
