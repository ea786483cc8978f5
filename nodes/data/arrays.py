"""Nodes that read and change arrays (`omni.graph.nodes`).

Every node outputs a new array and leaves its inputs unchanged. A string is treated as an array of its UTF-8 bytes. In Isaac Sim's
menu, ArrayGetSize is called "Get Array Size". Isaac Sim's ArrayLength, a node for bundles, is not available.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from graphengine.node import In, Node, Numbered, Out
from graphengine.node.types import ARRAYS, ELEMENTS, Int, PortType, UnionType, plain
from graphengine.nodes.data.sequences import (
    INDEX,
    as_array,
    checked_length,
    element_of,
    fits,
    joined,
    places,
    position,
    zeros,
)
from graphengine.nodes.known_inputs import LENGTHS, KnownInputs

SEQUENCES = f"{ARRAYS}|string"


class ArrayNode(Node):
    """Base class of nodes whose array ports all have the same type. Element ports have the element type of these arrays."""

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the types of the array and element ports, or an empty mapping until the type of one array is known."""
        fields = type(self).fields.items()
        unions = {name: port.type for name, port in fields if isinstance(port.type, UnionType)}
        arrays = [name for name, union in unions.items() if PortType("bool", array=True) in union.alternatives]
        array = next((known[name] for name in arrays if name in known), None)
        if array is None:
            return {}
        element = element_of(array)
        fitting = [name for name, given in known.items() if fits(given, element)]
        elements = [name for name in unions if name not in (*arrays, *fitting)]
        return dict.fromkeys(arrays, array) | dict.fromkeys(elements, element)


class ArrayEdit(ArrayNode):
    """Base class of nodes that output a changed copy of an array."""

    array_in: Any = In(type=SEQUENCES, name="array", required=True)
    array_out: Any = Out(type=SEQUENCES, name="array")

    def compute(self) -> None:
        """Set the output to the changed copy of the array.

        Raises:
            BadValueError: an index is out of range, or the new array is too long.
        """
        self.array_out = joined(self.array_in, *self._parts(as_array(self.array_in)))

    def _parts(self, array: Any) -> Iterable[Any]:
        """Return the parts of the new array in order; each part is an array or a list of elements."""
        raise NotImplementedError


class ArrayGetSize(Node, type="omni.graph.nodes.ArrayGetSize"):
    """Counts the elements of an array, or the UTF-8 bytes of a string."""

    array: Any = In(type=SEQUENCES, required=True)
    size: Int = Out()

    def compute(self) -> None:
        """Set `size` to the number of elements or bytes."""
        self.size = len(as_array(self.array))


class ArrayIndex(ArrayNode, type="omni.graph.nodes.ArrayIndex"):
    """Reads the element at `index` of an array."""

    array: Any = In(type=SEQUENCES, required=True)
    index: Int = In(default=0, doc=INDEX)
    value: Any = Out(type=ELEMENTS, doc="element at `index`")

    def compute(self) -> None:
        """Set `value` to the element at `index`.

        Raises:
            BadValueError: `index` is out of range.
        """
        array = as_array(self.array)
        self.value = plain(array[position(self.index, len(array))])


class ArraySetIndex(ArrayEdit, type="omni.graph.nodes.ArraySetIndex"):
    """Replaces the element at `index` of an array."""

    index: Int = In(default=0, doc=INDEX)
    resize_to_fit: bool = In(default=False, doc="true: if `index` is beyond the end, extend the array with zeros")
    value: Any = In(type=ELEMENTS, required=True, doc="new element at `index`")

    def _parts(self, array: Any) -> Iterable[Any]:
        if self.resize_to_fit and self.index >= len(array):
            array = joined(array, array, zeros(array, checked_length("index", self.index + 1) - len(array)))
        index = position(self.index, len(array))
        return array[:index], [self.value], array[index + 1 :]


class ArrayAppendValue(ArrayEdit, type="omni.graph.nodes.ArrayAppendValue"):
    """Appends an element to an array."""

    value: Any = In(type=ELEMENTS, required=True, doc="element to append")

    def _parts(self, array: Any) -> Iterable[Any]:
        return array, [self.value]


class ArrayInsertValue(ArrayEdit, type="omni.graph.nodes.ArrayInsertValue"):
    """Inserts an element into an array, before the element at `index`."""

    index: Int = In(default=0, doc="index of the new element, limited to the range from 0 to the array's length")
    value: Any = In(type=ELEMENTS, required=True, doc="element to insert")

    def _parts(self, array: Any) -> Iterable[Any]:
        index = max(self.index, 0)
        return array[:index], [self.value], array[index:]


class ArrayRemoveIndex(ArrayEdit, type="omni.graph.nodes.ArrayRemoveIndex"):
    """Removes the element at `index` from an array."""

    index: Int = In(default=0, doc=INDEX)

    def _parts(self, array: Any) -> Iterable[Any]:
        index = position(self.index, len(array))
        return array[:index], array[index + 1 :]


class ArrayRemoveValue(ArrayEdit, type="omni.graph.nodes.ArrayRemoveValue"):
    """Removes the first element that equals `value` from an array, or all elements that equal `value`."""

    value: Any = In(type=ELEMENTS, required=True, doc="value to remove")
    remove_all: bool = In(default=False, doc="older name of `removeAllFound`; if either input is true, all are removed")
    remove_all_found: bool = In(default=False, doc="true: remove all elements equal to `value`; false: only the first")
    found: bool = Out(doc="whether the array contained `value`")

    def _parts(self, array: Any) -> Iterable[Any]:
        gone = places(array, self.value)
        self.found = bool(gone)
        if not (self.remove_all or self.remove_all_found):
            gone = gone[:1]
        ends = itertools.pairwise([-1, *gone, len(array)])
        return (array[start + 1 : stop] for start, stop in ends)


class ArrayReplaceValue(ArrayEdit, type="omni.graph.nodes.ArrayReplaceValue"):
    """Replaces the first array element that equals `value`, or all elements that equal `value`."""

    value: Any = In(type=ELEMENTS, required=True, doc="value to search for")
    new_value: Any = In(type=ELEMENTS, required=True, doc="element that replaces `value`")
    replace_all_found: bool = In(default=False, doc="true: replace all elements equal to `value`; false: the first")
    found: bool = Out(doc="whether the array contained `value`")

    def _parts(self, array: Any) -> Iterable[Any]:
        there = places(array, self.value)[: None if self.replace_all_found else 1]
        self.found = bool(there)
        kept = [array[start + 1 : stop] for start, stop in itertools.pairwise([-1, *there, len(array)])]
        changed = [part for piece in kept[:-1] for part in (piece, [self.new_value])]
        return *changed, kept[-1]


class ArrayFindValue(ArrayNode, type="omni.graph.nodes.ArrayFindValue"):
    """Finds the first array element that equals a value."""

    array: Any = In(type=SEQUENCES, required=True)
    value: Any = In(type=ELEMENTS, required=True, doc="value to search for")
    index: Int = Out(doc="index of the first element equal to `value`, from 0; -1 if there is none")

    def compute(self) -> None:
        """Set `index` to the index of the first match, or to -1."""
        self.index = next(iter(places(as_array(self.array), self.value)), -1)


class ArrayFill(ArrayNode, type="omni.graph.nodes.ArrayFill"):
    """Fills an array with one value; the length and the type stay the same."""

    array_in: Any = In(type=SEQUENCES, name="array", required=True, doc="array with the length and type of the output")
    fill_value: Any = In(type=ELEMENTS, required=True, doc="value of every element")
    array_out: Any = Out(type=SEQUENCES, name="array")

    def compute(self) -> None:
        """Set the output to an array in which every element is `fillValue`."""
        self.array_out = joined(self.array_in, [self.fill_value] * len(as_array(self.array_in)))


class ArrayResize(ArrayEdit, type="omni.graph.nodes.ArrayResize"):
    """Changes the length of an array: truncates it, or extends it with zeros."""

    new_size: Int = In(default=0, doc="new length; negative values count as 0")

    def _parts(self, array: Any) -> Iterable[Any]:
        size = checked_length("newSize", self.new_size)
        return array[:size], zeros(array, size - len(array))


class ArrayRotate(ArrayEdit, type="omni.graph.nodes.ArrayRotate"):
    """Shifts the elements of an array to the right; elements shifted out at the end enter at the start."""

    steps: Int = In(default=0, doc="number of positions to shift to the right; negative values shift to the left")

    def _parts(self, array: Any) -> Iterable[Any]:
        cut = -self.steps % len(array) if len(array) else 0
        return array[cut:], array[:cut]


class ArrayReverse(ArrayEdit, type="omni.graph.nodes.ArrayReverse"):
    """Reverses the order of the elements of an array."""

    def _parts(self, array: Any) -> Iterable[Any]:
        return (array[::-1],)


class ArraySlice(ArrayEdit, type="omni.graph.nodes.ArraySlice"):
    """Extracts the elements of an array from index `start` to the end, or to the element before index `end`."""

    start: Int = In(default=0, doc="index of the first element, as in Python: negative values count from the end")
    end: Int = In(default=0, doc="index after the last element, as in Python; ignored if `useLength` is true")
    use_length: bool = In(default=True, doc="true: slice to the end of the array; false: slice up to `end`")

    def _parts(self, array: Any) -> Iterable[Any]:
        return (array[self.start : None if self.use_length else self.end],)


class AppendArray(ArrayNode, type="omni.graph.nodes.AppendArray"):
    """Concatenates two or more arrays."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=SEQUENCES)}

    input0: Any = In(type=SEQUENCES, required=True, doc="first array")
    input1: Any = In(type=SEQUENCES, required=True, doc="second array; a graph can add `input2`, `input3`, …")
    array: Any = Out(type=SEQUENCES)

    def compute(self) -> None:
        """Set `array` to the concatenation of all inputs."""
        self.array = joined(self.input0, *(as_array(getattr(self, name)) for name in self.series["input"]))


def _total(inputs: KnownInputs, _: str) -> int | None:
    lengths = [inputs.length(name) for name in inputs.instance.cls.series["input"]]
    known = [length for length in lengths if length is not None]
    return sum(known) if len(known) == len(lengths) else None


LENGTHS[ArrayFill] = LENGTHS[ArrayRotate] = LENGTHS[ArrayReverse] = KnownInputs.same
LENGTHS[AppendArray] = _total
LENGTHS[ArrayResize] = lambda inputs, _: inputs.value("new_size")
