"""Array operations (`omni.graph.nodes`).

Every node makes a new array. A string counts as the array of its UTF-8 bytes. ArrayGetSize is "Get Array Size" in Isaac Sim's
menu. Isaac Sim's ArrayLength is missing here: it is a node for bundles.
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

SEQUENCES = f"{ARRAYS}|string"


class ArrayNode(Node):
    """Base of nodes whose arrays all have the same type, and whose other values are elements of such an array."""

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the types of all arrays and elements, once the type of one array is known."""
        fields = type(self).fields.items()
        unions = {name: port.type for name, port in fields if isinstance(port.type, UnionType)}
        arrays = [name for name, union in unions.items() if PortType("bool", array=True) in union.alternatives]
        array = next((known[name] for name in arrays if name in known), None)
        if array is None:
            return {}
        element = element_of(array)
        elements = [
            name for name in unions if name not in arrays and not (name in known and fits(known[name], element))
        ]
        return dict.fromkeys(arrays, array) | dict.fromkeys(elements, element)


class ArrayEdit(ArrayNode):
    """Base of nodes that output a changed copy of an array."""

    array_in: Any = In(type=SEQUENCES, name="array", required=True)
    array_out: Any = Out(type=SEQUENCES, name="array")

    def compute(self) -> None:
        """Join the parts of the new array.

        Raises:
            BadValueError: an index is out of range.
        """
        self.array_out = joined(self.array_in, *self._parts(as_array(self.array_in)))

    def _parts(self, array: Any) -> Iterable[Any]:
        """The parts of the new array, in order: arrays and lists of elements."""
        raise NotImplementedError


class ArrayGetSize(Node, type="omni.graph.nodes.ArrayGetSize"):
    """Number of elements in an array, or of UTF-8 bytes in a string."""

    array: Any = In(type=SEQUENCES, required=True)
    size: Int = Out()

    def compute(self) -> None:
        """Count the elements."""
        self.size = len(as_array(self.array))


class ArrayIndex(ArrayNode, type="omni.graph.nodes.ArrayIndex"):
    """The element of an array at an index."""

    array: Any = In(type=SEQUENCES, required=True)
    index: Int = In(default=0, doc=INDEX)
    value: Any = Out(type=ELEMENTS, doc="element at `index`")

    def compute(self) -> None:
        """Look up the element.

        Raises:
            BadValueError: the index is out of range.
        """
        array = as_array(self.array)
        self.value = plain(array[position(self.index, len(array))])


class ArraySetIndex(ArrayEdit, type="omni.graph.nodes.ArraySetIndex"):
    """An array with the element at an index replaced."""

    index: Int = In(default=0, doc=INDEX)
    resize_to_fit: bool = In(default=False, doc="true: an `index` beyond the end extends the array with zeros")
    value: Any = In(type=ELEMENTS, required=True, doc="new element at `index`")

    def _parts(self, array: Any) -> Iterable[Any]:
        if self.resize_to_fit and self.index >= len(array):
            array = joined(array, array, zeros(array, checked_length("index", self.index + 1) - len(array)))
        index = position(self.index, len(array))
        return array[:index], [self.value], array[index + 1 :]


class ArrayAppendValue(ArrayEdit, type="omni.graph.nodes.ArrayAppendValue"):
    """An array with a value appended."""

    value: Any = In(type=ELEMENTS, required=True, doc="element to append")

    def _parts(self, array: Any) -> Iterable[Any]:
        return array, [self.value]


class ArrayInsertValue(ArrayEdit, type="omni.graph.nodes.ArrayInsertValue"):
    """An array with a value inserted before an index."""

    index: Int = In(default=0, doc="index of the new element; below 0 inserts at the start, beyond the end appends")
    value: Any = In(type=ELEMENTS, required=True, doc="element to insert")

    def _parts(self, array: Any) -> Iterable[Any]:
        index = max(self.index, 0)
        return array[:index], [self.value], array[index:]


class ArrayRemoveIndex(ArrayEdit, type="omni.graph.nodes.ArrayRemoveIndex"):
    """An array without the element at an index."""

    index: Int = In(default=0, doc=INDEX)

    def _parts(self, array: Any) -> Iterable[Any]:
        index = position(self.index, len(array))
        return array[:index], array[index + 1 :]


class ArrayRemoveValue(ArrayEdit, type="omni.graph.nodes.ArrayRemoveValue"):
    """An array without the first element equal to a value, or without all such elements."""

    value: Any = In(type=ELEMENTS, required=True, doc="value to remove")
    remove_all: bool = In(default=False, doc="older name of `removeAllFound`; if either is true, all are removed")
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
    """An array in which the first element equal to a value is replaced, or all such elements."""

    value: Any = In(type=ELEMENTS, required=True, doc="value to search for")
    new_value: Any = In(type=ELEMENTS, required=True, doc="element to put in place of `value`")
    replace_all_found: bool = In(
        default=False, doc="true: replace all elements equal to `value`; false: only the first"
    )
    found: bool = Out(doc="whether the array contained `value`")

    def _parts(self, array: Any) -> Iterable[Any]:
        there = places(array, self.value)[: None if self.replace_all_found else 1]
        self.found = bool(there)
        kept = [array[start + 1 : stop] for start, stop in itertools.pairwise([-1, *there, len(array)])]
        changed = [part for piece in kept[:-1] for part in (piece, [self.new_value])]
        return *changed, kept[-1]


class ArrayFindValue(ArrayNode, type="omni.graph.nodes.ArrayFindValue"):
    """Index of the first element equal to a value."""

    array: Any = In(type=SEQUENCES, required=True)
    value: Any = In(type=ELEMENTS, required=True, doc="value to search for")
    index: Int = Out(doc="index of the first element equal to `value`, from 0; -1 if there is none")

    def compute(self) -> None:
        """Search for the value."""
        self.index = next(iter(places(as_array(self.array), self.value)), -1)


class ArrayFill(ArrayNode, type="omni.graph.nodes.ArrayFill"):
    """An array of the same length as the input array, filled with one value."""

    array_in: Any = In(type=SEQUENCES, name="array", required=True, doc="array whose length and type the output gets")
    fill_value: Any = In(type=ELEMENTS, required=True, doc="value of every element")
    array_out: Any = Out(type=SEQUENCES, name="array")

    def compute(self) -> None:
        """Repeat the value."""
        self.array_out = joined(self.array_in, [self.fill_value] * len(as_array(self.array_in)))


class ArrayResize(ArrayEdit, type="omni.graph.nodes.ArrayResize"):
    """An array with a new length, truncated or extended with zeros."""

    new_size: Int = In(default=0, doc="new length; negative values count as 0")

    def _parts(self, array: Any) -> Iterable[Any]:
        size = checked_length("newSize", self.new_size)
        return array[:size], zeros(array, size - len(array))


class ArrayRotate(ArrayEdit, type="omni.graph.nodes.ArrayRotate"):
    """An array rotated to the right; elements shifted out at the end are shifted in at the start."""

    steps: Int = In(default=0, doc="positions to shift; negative values shift to the left")

    def _parts(self, array: Any) -> Iterable[Any]:
        cut = -self.steps % len(array) if len(array) else 0
        return array[cut:], array[:cut]


class ArrayReverse(ArrayEdit, type="omni.graph.nodes.ArrayReverse"):
    """An array in reverse order."""

    def _parts(self, array: Any) -> Iterable[Any]:
        return (array[::-1],)


class ArraySlice(ArrayEdit, type="omni.graph.nodes.ArraySlice"):
    """The elements of an array from index `start` to the end of the array, or up to but not including index `end`."""

    start: Int = In(
        default=0,
        doc="index of the first element; negative values count from the end, values out of range are clamped",
    )
    end: Int = In(
        default=0,
        doc="index after the last element; negative values count from the end; ignored if `useLength` is true",
    )
    use_length: bool = In(
        default=True, doc="true: slice to the end of the array and ignore `end`; false: slice up to `end`"
    )

    def _parts(self, array: Any) -> Iterable[Any]:
        return (array[self.start : None if self.use_length else self.end],)


class AppendArray(ArrayNode, type="omni.graph.nodes.AppendArray"):
    """Concatenation of arrays."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=SEQUENCES)}

    input0: Any = In(type=SEQUENCES, required=True, doc="first array")
    input1: Any = In(
        type=SEQUENCES, required=True, doc="second array; a graph file can name further inputs `input2`, `input3`, …"
    )
    array: Any = Out(type=SEQUENCES)

    def compute(self) -> None:
        """Concatenate the arrays."""
        self.array = joined(self.input0, *(as_array(getattr(self, name)) for name in self.series["input"]))
