"""Arrays changed and taken apart (`omni.graph.nodes`).

Every node makes a new array. A string counts as the array of its UTF-8 bytes. Isaac's menu says Get Array Size for
ArrayGetSize; ArrayLength there is a node of bundles, which are not modelled.
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
    """A node whose arrays are all of one type, and whose single values are elements of it."""

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Types of the other arrays and of the elements, when that of one array is known."""
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
    """A node that makes an array of another."""

    array_in: Any = In(type=SEQUENCES, name="array", required=True)
    array_out: Any = Out(type=SEQUENCES, name="array")

    def compute(self) -> None:
        """Join the parts of the new array.

        Raises:
            BadValueError: there is no element at an index.
        """
        self.array_out = joined(self.array_in, *self._parts(as_array(self.array_in)))

    def _parts(self, array: Any) -> Iterable[Any]:
        """Arrays and lists of elements that follow each other in the new array."""
        raise NotImplementedError


class ArrayGetSize(Node, type="omni.graph.nodes.ArrayGetSize"):
    """Number of elements of an array; of a string, that of its bytes."""

    array: Any = In(type=SEQUENCES, required=True)
    size: Int = Out()

    def compute(self) -> None:
        """Count."""
        self.size = len(as_array(self.array))


class ArrayIndex(ArrayNode, type="omni.graph.nodes.ArrayIndex"):
    """The element of an array at an index."""

    array: Any = In(type=SEQUENCES, required=True)
    index: Int = In(default=0, doc=INDEX)
    value: Any = Out(type=ELEMENTS, doc="the element there")

    def compute(self) -> None:
        """Look it up.

        Raises:
            BadValueError: there is no such element.
        """
        array = as_array(self.array)
        self.value = plain(array[position(self.index, len(array))])


class ArraySetIndex(ArrayEdit, type="omni.graph.nodes.ArraySetIndex"):
    """An array with another value at an index."""

    index: Int = In(default=0, doc=INDEX)
    resize_to_fit: bool = In(default=False, doc="an index beyond the end makes the array longer, by zeros")
    value: Any = In(type=ELEMENTS, required=True, doc="what is to be there")

    def _parts(self, array: Any) -> Iterable[Any]:
        if self.resize_to_fit and self.index >= len(array):
            array = joined(array, array, zeros(array, checked_length("index", self.index + 1) - len(array)))
        index = position(self.index, len(array))
        return array[:index], [self.value], array[index + 1 :]


class ArrayAppendValue(ArrayEdit, type="omni.graph.nodes.ArrayAppendValue"):
    """An array with one more value at its end."""

    value: Any = In(type=ELEMENTS, required=True, doc="comes last")

    def _parts(self, array: Any) -> Iterable[Any]:
        return array, [self.value]


class ArrayInsertValue(ArrayEdit, type="omni.graph.nodes.ArrayInsertValue"):
    """An array with one more value before the one at an index."""

    index: Int = In(default=0, doc="0 or less puts it first, the array's length or more last")
    value: Any = In(type=ELEMENTS, required=True, doc="is put in")

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
    """An array without the first element that has a value, or without all of them."""

    value: Any = In(type=ELEMENTS, required=True, doc="is taken out")
    remove_all: bool = In(default=False, doc="an older name of removeAllFound; either will do")
    remove_all_found: bool = In(default=False, doc="takes out every element that has the value, not only the first")
    found: bool = Out(doc="whether there was one")

    def _parts(self, array: Any) -> Iterable[Any]:
        gone = places(array, self.value)
        self.found = bool(gone)
        if not (self.remove_all or self.remove_all_found):
            gone = gone[:1]
        ends = itertools.pairwise([-1, *gone, len(array)])
        return (array[start + 1 : stop] for start, stop in ends)


class ArrayReplaceValue(ArrayEdit, type="omni.graph.nodes.ArrayReplaceValue"):
    """An array with another value in the place of the first element that has a value, or of all of them."""

    value: Any = In(type=ELEMENTS, required=True, doc="is looked for")
    new_value: Any = In(type=ELEMENTS, required=True, doc="takes its place")
    replace_all_found: bool = In(default=False, doc="replaces every element that has the value, not only the first")
    found: bool = Out(doc="whether there was one")

    def _parts(self, array: Any) -> Iterable[Any]:
        there = places(array, self.value)[: None if self.replace_all_found else 1]
        self.found = bool(there)
        kept = [array[start + 1 : stop] for start, stop in itertools.pairwise([-1, *there, len(array)])]
        changed = [part for piece in kept[:-1] for part in (piece, [self.new_value])]
        return *changed, kept[-1]


class ArrayFindValue(ArrayNode, type="omni.graph.nodes.ArrayFindValue"):
    """Index of the first element that has a value."""

    array: Any = In(type=SEQUENCES, required=True)
    value: Any = In(type=ELEMENTS, required=True, doc="is looked for")
    index: Int = Out(doc="from 0; -1 where no element has the value")

    def compute(self) -> None:
        """Look for it."""
        self.index = next(iter(places(as_array(self.array), self.value)), -1)


class ArrayFill(ArrayNode, type="omni.graph.nodes.ArrayFill"):
    """An array as long as another, with one value everywhere."""

    array_in: Any = In(type=SEQUENCES, name="array", required=True, doc="gives the length and the type")
    fill_value: Any = In(type=ELEMENTS, required=True)
    array_out: Any = Out(type=SEQUENCES, name="array")

    def compute(self) -> None:
        """Repeat the value."""
        self.array_out = joined(self.array_in, [self.fill_value] * len(as_array(self.array_in)))


class ArrayResize(ArrayEdit, type="omni.graph.nodes.ArrayResize"):
    """An array with another length: cut off at its end, or made longer by zeros."""

    new_size: Int = In(default=0, doc="less than 0 is 0")

    def _parts(self, array: Any) -> Iterable[Any]:
        size = checked_length("newSize", self.new_size)
        return array[:size], zeros(array, size - len(array))


class ArrayRotate(ArrayEdit, type="omni.graph.nodes.ArrayRotate"):
    """An array shifted to the right; what leaves it at the end comes in at the front."""

    steps: Int = In(default=0, doc="how far; negative ones shift to the left")

    def _parts(self, array: Any) -> Iterable[Any]:
        cut = -self.steps % len(array) if len(array) else 0
        return array[cut:], array[:cut]


class ArrayReverse(ArrayEdit, type="omni.graph.nodes.ArrayReverse"):
    """An array from its end to its beginning."""

    def _parts(self, array: Any) -> Iterable[Any]:
        return (array[::-1],)


class ArraySlice(ArrayEdit, type="omni.graph.nodes.ArraySlice"):
    """The part of an array from one index up to, and without, another."""

    start: Int = In(default=0, doc="negative ones count from the end; beyond an end is that end")
    end: Int = In(default=0, doc="as start; not above start gives an empty array; unused while useLength is set")
    use_length: bool = In(default=True, doc="whether the part goes to the end of the array")

    def _parts(self, array: Any) -> Iterable[Any]:
        return (array[self.start : None if self.use_length else self.end],)


class AppendArray(ArrayNode, type="omni.graph.nodes.AppendArray"):
    """Arrays one after the other."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=SEQUENCES)}

    input0: Any = In(type=SEQUENCES, required=True, doc="comes first")
    input1: Any = In(type=SEQUENCES, required=True, doc="comes next; input2 and so on are there when a file names them")
    array: Any = Out(type=SEQUENCES)

    def compute(self) -> None:
        """Join them."""
        self.array = joined(self.input0, *(as_array(getattr(self, name)) for name in self.series["input"]))
