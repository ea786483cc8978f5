"""Nodes that build arrays from elements (`omni.graph.nodes`).

In Isaac Sim's menu, ConstructArray is called "Make Array".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from graphengine.node import In, Node, Numbered, Out, types
from graphengine.node.types import ARRAYS, ELEMENTS, Int, PortType, Token
from graphengine.nodes.data.broadcast import type_of
from graphengine.nodes.data.sequences import checked_length, element_of, fits, made
from graphengine.nodes.data.unions import arrays_of
from graphengine.nodes.known_inputs import LENGTHS

_SPECIFIC = "bool double float half int int64 token uchar uint uint64 double[2] double[3] double[4]"
_SPECIFIC += " matrixd[2] matrixd[3] matrixd[4]"
_SPECIFIC += " float[2] float[3] float[4] half[2] half[3] half[4] int[2] int[3] int[4] timecode frame[4]"
_SPECIFIC += " colord[3] colorf[3] colorh[3] colord[4] colorf[4] colorh[4] normald[3] normalf[3] normalh[3]"
_SPECIFIC += " pointd[3] pointf[3] pointh[3] quatd[4] quatf[4] quath[4] texcoordd[2] texcoordf[2] texcoordh[2]"
_SPECIFIC += " texcoordd[3] texcoordf[3] texcoordh[3] vectord[3] vectorf[3] vectorh[3]"
ARRAY_TYPES = ("auto", *(f"{element}[]" for element in _SPECIFIC.split()))
_FIVE = "|".join(element for element in ELEMENTS.split("|") if element not in ("bool", "matrixd[2]"))


class ConstructedNode(Node):
    """Base class of nodes that build an array of `arraySize` elements; if too few are given, the last one is repeated."""

    array_size: Int
    array: Any

    def element_type(self, known: Mapping[str, PortType]) -> PortType | None:
        """Return the first element type to which all other elements convert; None until the types of all elements are known.

        Raises:
            ValueError: there is no element type to which all elements convert.
        """
        elements = self.elements()
        given = [known[name] for name in elements if name in known]
        if len(given) < len(elements):
            return None
        for element in given:
            if all(fits(other, element) for other in given):
                return element
        types_given = ", ".join(map(str, dict.fromkeys(given)))
        raise ValueError(f"elements of the types {types_given} cannot form one array; convert them to one type first")

    def elements(self) -> Sequence[str]:
        """Return the Python names of the element inputs, in order."""
        raise NotImplementedError

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the array, and the element type for each input whose type does not convert to the element type.

        The compiler converts the literals of these inputs to the element type, or reports an error.

        Raises:
            ValueError: the elements have incompatible types.
        """
        element = self.element_type(known)
        if element is None:
            return {}
        misfits = [name for name in self.elements() if name in known and not fits(known[name], element)]
        return dict.fromkeys(misfits, element) | {"array": PortType(element.base, element.count, True, element.role)}

    def compute(self) -> None:
        """Set `array` to the first `arraySize` elements; if there are fewer, repeat the last one."""
        size = checked_length("arraySize", self.array_size)
        values = [getattr(self, name) for name in self.elements()][:size]
        values += values[-1:] * (size - len(values))
        if "array" in self.settled:
            element: PortType | None = element_of(self.settled["array"])
        else:
            element = self.element_type({name: type_of(getattr(self, name)) for name in self.elements()})
        assert element is not None
        self.array = made(values, element)


LENGTHS[ConstructedNode] = lambda inputs, _: inputs.value("array_size")


class ConstructArray(ConstructedNode, type="omni.graph.nodes.ConstructArray"):
    """Builds an array of `arraySize` elements from `input0`, `input1`, …; if these are too few, the last one is repeated."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=ELEMENTS)}

    array_size: Int = In(default=1, ge=0, doc="number of elements; if there are fewer inputs, the last is repeated")
    array_type: Token = In(
        default="auto", tokens=ARRAY_TYPES, doc="type of the array; auto: first input type to which all convert"
    )
    input0: Any = In(type=ELEMENTS, required=True, doc="first element; a graph can add `input1`, `input2`, …")
    array: Any = Out(type=ARRAYS, doc="array of type `arrayType`")

    def elements(self) -> Sequence[str]:
        """Return the Python names of the inputs `input0`, `input1`, …, in order."""
        return self.series["input"]

    def element_type(self, known: Mapping[str, PortType]) -> PortType | None:
        """Return the element type of `arrayType`; for auto, the first element type to which all other elements convert."""
        if self.array_type == "auto":
            return super().element_type(known)
        asked = types.parse(self.array_type)
        assert isinstance(asked, PortType)
        return element_of(asked)

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the array, and the element type for each input whose type does not convert to the element type.

        The compiler converts the literals of these inputs to the element type, or reports an error.

        Raises:
            ValueError: the elements have incompatible types, or the input numbers have a gap.
        """
        for number, name in enumerate(self.elements()):
            if int(name.removeprefix("input")) != number:
                raise ValueError(f"{name} is given, but input{number} is missing")
        return super().resolve_types(known, variables)


class MakeArray(ConstructedNode, type="omni.graph.nodes.MakeArray"):
    """Builds an array of `arraySize` elements from the inputs `a` to `e`; after the fifth element, `e` is repeated.

    ConstructArray is the newer node type.
    """

    array_size: Int = In(default=0, ge=0, doc="number of elements; after the fifth element, `e` is repeated")
    a: Any = In(type=_FIVE, required=True, doc="first element")
    b: Any = In(type=_FIVE, required=True, doc="second element")
    c: Any = In(type=_FIVE, required=True, doc="third element")
    d: Any = In(type=_FIVE, required=True, doc="fourth element")
    e: Any = In(type=_FIVE, required=True, doc="fifth element and all further ones")
    array: Any = Out(type=arrays_of(_FIVE))

    def elements(self) -> Sequence[str]:
        """Return the names of the five inputs `a` to `e`."""
        return ("a", "b", "c", "d", "e")
