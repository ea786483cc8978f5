"""Remedies for wires between types of numbers."""

from __future__ import annotations

import re
from itertools import product
from typing import Any

import pytest

import graphengine.nodes.data.conversion as conversions
from graphengine.compiler.port_types import _number_hint
from graphengine.node import types
from graphengine.node.types import PortType


def number(name: str) -> PortType:
    parsed = types.parse(name)
    assert isinstance(parsed, PortType)
    return parsed


NUMBERS = [
    number(f"{base}{count}{array}")
    for base, count, array in product(sorted(types._DTYPES), ("", "[2]", "[3]", "[4]"), ("", "[]"))
]


def alternatives(node: Any, port: str) -> tuple[PortType, ...]:
    accepted: tuple[PortType, ...] = node.fields[port].type.alternatives
    return accepted


@pytest.mark.parametrize("gives", NUMBERS, ids=str)
def test_a_suggested_converter_has_an_input_and_an_output_of_the_two_types(gives: PortType) -> None:
    for takes in NUMBERS:
        named = re.search(r"put (To\w+) between", _number_hint(gives, takes))
        if named is None or types.conversion(gives, takes) is not None:
            continue
        node = getattr(conversions, named[1])
        assert any(types.conversion(gives, accepted) is not None for accepted in alternatives(node, "value"))
        assert any(types.conversion(given, takes) is not None for given in alternatives(node, "converted"))
        assert gives.array == takes.array


def test_for_an_array_at_a_scalar_input_the_remedy_is_arrayindex() -> None:
    assert _number_hint(number("double[]"), number("float")) == "take an element of the array with ArrayIndex"
    assert _number_hint(number("double"), number("timecode")) == "put a converter node between them"
    assert _number_hint(number("double"), number("float")) == "put ToFloat between them"
