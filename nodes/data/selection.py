"""Nodes that select one of two values, or check whether a value is empty (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from graphengine.node import Bound, Context, In, Node, Out, types
from graphengine.node.types import ARRAYS, ELEMENTS, PortType, Target
from graphengine.nodes.checked import same_length
from graphengine.nodes.data.broadcast import Operation, type_of
from graphengine.nodes.data.sequences import fits, made
from graphengine.nodes.data.unions import BOOLEANS

ANYTHING = f"{ELEMENTS}|{ARRAYS}|string|path"
_CHOICE = ("condition", "ifTrue", "ifFalse")


class SelectIf(Node, type="omni.graph.nodes.SelectIf"):
    """Selects one of two values by a condition. If an input is an array, the elements are selected one by one."""

    condition: Any = In(type=BOOLEANS, required=True, doc="true selects `ifTrue`, false selects `ifFalse`")
    if_true: Any = In(type=ANYTHING, required=True)
    if_false: Any = In(type=ANYTHING, required=True)
    result: Any = Out(
        type=ANYTHING, doc="selected value, or array of selected elements; a single value applies to all elements"
    )

    choose: Operation = Bound()

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the output, to which both values convert, or an empty mapping until all input types are known.

        Raises:
            ValueError: the values have no common type.
        """
        if not {"condition", "if_true", "if_false"} <= known.keys():
            return {}
        array = any(known[name].array for name in ("condition", "if_true", "if_false"))
        values = [replace(known[name], array=False) for name in ("if_true", "if_false")]
        for wanted in values:
            if all(fits(value, wanted) for value in values) and not (array and wanted.base in ("string", "path")):
                return {"result": replace(wanted, array=array)}
        raise ValueError(f"ifTrue is {known['if_true']} and ifFalse is {known['if_false']}, which have no common type")

    def setup(self, context: Context) -> None:
        """Select the implementation for the resolved port types."""
        known = dict(self.settled)
        for name in ("condition", "if_true", "if_false"):
            known.setdefault(name, type_of(getattr(self, name)))
        result = known.get("result") or self.resolve_types(known, {})["result"]
        arrays = tuple(known[name].array for name in ("condition", "if_true", "if_false"))
        self.choose = _each_of(arrays, result) if result.array else _one_of(known["if_true"], known["if_false"], result)

    def compute(self) -> None:
        """Set `result` to the selected value, or to an array of the selected elements.

        Raises:
            BadValueError: two arrays differ in length.
        """
        self.result = self.choose(self.condition, self.if_true, self.if_false)


def _one_of(yes: PortType, no: PortType, result: PortType) -> Operation:
    """Return a function that selects one of two values and converts it to the result type."""
    widen_yes, widen_no = (types.CONVERTERS.get(types.conversion(one, result) or "", _as_it_is) for one in (yes, no))
    return lambda condition, if_true, if_false: widen_yes(if_true) if condition else widen_no(if_false)


def _as_it_is(value: Any) -> Any:
    return value


def _each_of(arrays: tuple[bool, ...], result: PortType) -> Operation:
    """Return a function that selects element by element; `arrays` says for each of its arguments whether it is an array."""
    element = replace(result, array=False)

    def choose(*values: Any) -> Any:
        given = {name: value for name, value, array in zip(_CHOICE, values, arrays, strict=True) if array}
        same_length(**given)
        length = len(next(iter(given.values())))
        parts = [value if array else [value] * length for value, array in zip(values, arrays, strict=True)]
        return made([yes if chosen else no for chosen, yes, no in zip(*parts, strict=True)], element)

    return choose


class SelectTargetIf(Node, type="omni.graph.nodes.SelectTargetIf"):
    """Selects one of two lists of prims by a condition. If the condition is an array, the prims are selected one by one."""

    condition: Any = In(type=BOOLEANS, required=True, doc="true selects `ifTrue`, false selects `ifFalse`")
    if_true: Target = In(default=())
    if_false: Target = In(default=())
    result: Target = Out(doc="selected prims")

    def compute(self) -> None:
        """Set `result` to the selected target, or to the prims selected one by one.

        Raises:
            BadValueError: `condition` is an array, and its length is not the number of prims in each target.
        """
        if not isinstance(self.condition, np.ndarray):
            self.result = self.if_true if self.condition else self.if_false
            return
        same_length(condition=self.condition, ifTrue=self.if_true, ifFalse=self.if_false)
        both = zip(self.condition, self.if_true, self.if_false, strict=True)
        self.result = tuple(yes if chosen else no for chosen, yes, no in both)


class IsEmpty(Node, type="omni.graph.nodes.IsEmpty"):
    """Checks whether a string or an array is empty; numbers and tuples are never empty."""

    input_in: Any = In(type=ANYTHING, name="input", required=True, doc="value to check")
    is_empty: bool = Out()

    def compute(self) -> None:
        """Set `isEmpty` to whether the input is a string or an array of length 0."""
        self.is_empty = isinstance(self.input_in, str | tuple | np.ndarray) and len(self.input_in) == 0
