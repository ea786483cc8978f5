"""Vectors put together, taken apart and measured."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.data import vectors
from graphengine.nodes.data.vectors import (
    BreakVector3,
    CrossProduct,
    Distance3D,
    DotProduct,
    Magnitude,
    MakeVector3,
    Normalize,
)
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player

ROLES = [f"{role}{base}[3]" for role in ("vector", "point", "normal", "color", "texcoord") for base in "dfh"]
TRIPLES = ["double[3]", "float[3]", "half[3]", "int[3]", *ROLES]
TRIPLE = st.tuples(*[st.integers(-(10**6), 10**6).map(lambda number: number / 1000.0)] * 3)
PAIRS = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def from_variable(play: Player, port_type: str, value: str, node: str, port: str, wanted: str) -> Any:
    """What comes out of a node's first output when a variable of a type goes into one of its inputs."""
    playing = play.graph(
        f"""
        variables: {{given: {{type: "{port_type}", default: {value}}}, shown: {{type: "{wanted.split()[0]}"}}}}
        nodes:
          Tick: OnPlaybackTick
          Given: {{type: ReadVariable, inputs: {{variableName: given}}}}
          Node: {node}
          Show: {{type: WriteVariable, inputs: {{variableName: shown}}}}
        connections: [Tick.tick -> Show.execIn, Given.value -> Node.{port}, Node.{wanted.split()[1]} -> Show.value]
        """
    ).tick()
    return playing.node("Show").value_out


def test_the_components_of_a_vector_are_output_in_order() -> None:
    node = computed(BreakVector3, tuple_in=(1.5, -2.5, 3.5))
    assert (node.x, node.y, node.z) == (1.5, -2.5, 3.5)
    node = computed(BreakVector3, tuple_in=PAIRS)
    assert (node.x.tolist(), node.y.tolist(), node.z.tolist()) == ([1.0, 4.0], [2.0, 5.0], [3.0, 6.0])


@pytest.mark.parametrize("port_type", TRIPLES)
def test_in_a_graph_every_type_and_role_of_vector_is_split(play: Player, port_type: str) -> None:
    for port, expected in zip("xyz", (1.0, 2.0, 3.0), strict=True):
        assert from_variable(play, port_type, "[1, 2, 3]", "BreakVector3", "tuple", f"double {port}") == expected


@pytest.mark.parametrize("port_type", ["int[3][]", "float[3][]", "pointd[3][]"])
def test_in_a_graph_arrays_of_vectors_are_split_into_arrays(play: Player, port_type: str) -> None:
    found = from_variable(play, port_type, "[[1, 2, 3], [4, 5, 6]]", "BreakVector3", "tuple", "double[] y")
    assert found.tolist() == [2.0, 5.0]


@pytest.mark.parametrize("port_type", ["double[2]", "double[4]", "quatd[4]", "double[]"])
def test_in_a_graph_a_value_without_three_components_is_refused_at_the_wire(play: Player, port_type: str) -> None:
    value = "[1, 2, 3, 4]" if "4" in port_type else "[1, 2]"
    with pytest.raises(CheckError, match=r"Given\.value is an? .*, Node\.tuple takes"):
        from_variable(play, port_type, value, "BreakVector3", "tuple", "double x")


def test_in_a_graph_a_literal_needs_a_type_only_if_it_is_not_double(play: Player) -> None:
    plain = {"Break": "{type: BreakVector3, inputs: {tuple: [0.5, 0, 0]}}"}
    assert shown(play, "double Break.x", plain) == 0.5
    for given_type in ("int[3]", "vectord[3]"):
        nodes = {"Break": f"{{type: BreakVector3, inputs: {{tuple: {{type: '{given_type}', value: [2, 0, 0]}}}}}}"}
        assert shown(play, "double Break.x", nodes) == 2.0


@pytest.mark.parametrize("count", [2, 3, 4])
def test_splitting_a_built_vector_gives_its_components(count: int) -> None:
    names, numbers = "xyzw"[:count], (1.5, -2.0, 3.0, 0.25)[:count]
    made = computed(getattr(vectors, f"MakeVector{count}"), **dict(zip(names, numbers, strict=True)))
    assert made.tuple_out == numbers
    broken = computed(getattr(vectors, f"BreakVector{count}"), tuple_in=made.tuple_out)
    assert tuple(getattr(broken, name) for name in names) == numbers


def test_components_of_several_types_make_a_vector_of_the_widest(play: Player) -> None:
    assert computed(MakeVector3, x=1, y=2.5, z=3).tuple_out == (1.0, 2.5, 3.0)
    assert {type(part) for part in computed(MakeVector3, x=1, y=2.5, z=3).tuple_out} == {float}
    assert computed(MakeVector3, x=1, y=2, z=3).tuple_out == (1, 2, 3)
    assert shown(play, "double[3] Make.tuple", {"Make": "{type: MakeVector3, inputs: {x: 0, y: 0, z: 0.5}}"}) == (
        0.0,
        0.0,
        0.5,
    )


def test_arrays_of_components_make_an_array_of_vectors() -> None:
    made = typed(MakeVector3, {"x": "float[]", "y": "float", "z": "int"}, x=np.array([1, 2], np.float32), y=0.5, z=7)
    assert (made.tuple_out.tolist(), made.tuple_out.dtype) == ([[1.0, 0.5, 7.0], [2.0, 0.5, 7.0]], np.float32)


@given(TRIPLE)
def test_the_magnitude_of_a_vector_is_its_length(vector: tuple[float, ...]) -> None:
    assert computed(Magnitude, input_in=vector).magnitude == pytest.approx(math.hypot(*vector), rel=1e-14)


def test_the_magnitude_of_a_number_is_its_absolute_value() -> None:
    assert computed(Magnitude, input_in=-2.5).magnitude == 2.5
    assert repr(computed(Magnitude, input_in=-2).magnitude) == "2"
    assert computed(Magnitude, input_in=np.array([-1.0, 2.0])).magnitude.tolist() == [1.0, 2.0]


def test_the_magnitude_of_whole_vectors_is_a_double() -> None:
    node = typed(Magnitude, {"input_in": "int[2][]"}, input_in=np.array([[3, 4], [0, 1]], np.int32))
    assert (node.magnitude.tolist(), str(node.settled["magnitude"])) == ([5.0, 1.0], "double[]")


@given(TRIPLE)
def test_a_normalized_vector_has_length_1_and_the_direction_it_had(vector: tuple[float, ...]) -> None:
    length = math.hypot(*vector)
    result = computed(Normalize, vector=vector).result
    if length == 0.0:
        assert result == vector
    else:
        assert result == pytest.approx(tuple(part / length for part in vector), abs=1e-15)


def test_a_zero_vector_in_an_array_stays_zero() -> None:
    assert computed(Normalize, vector=np.array([[0.0, 0.0], [3.0, 4.0]])).result.tolist() == [[0.0, 0.0], [0.6, 0.8]]


@given(TRIPLE, TRIPLE)
def test_a_cross_product_is_perpendicular_to_both_and_has_the_length_of_their_area(
    a: tuple[float, ...], b: tuple[float, ...]
) -> None:
    cross = computed(CrossProduct, a=a, b=b).product
    tolerance = 1e-9 * (1.0 + math.hypot(*a) * math.hypot(*b)) ** 2
    for side in (a, b):
        assert computed(DotProduct, a=cross, b=side).product == pytest.approx(0.0, abs=tolerance)
    area = math.hypot(*a) ** 2 * math.hypot(*b) ** 2 - computed(DotProduct, a=a, b=b).product ** 2
    assert math.hypot(*cross) ** 2 == pytest.approx(area, abs=tolerance)


def test_products_of_arrays_are_the_products_of_their_pairs() -> None:
    others = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    assert computed(DotProduct, a=PAIRS, b=others).product.tolist() == [1.0, 5.0]
    assert computed(CrossProduct, a=PAIRS, b=others).product.tolist() == [[0.0, 3.0, -2.0], [-6.0, 0.0, 4.0]]
    assert computed(DotProduct, a=np.array([1.0, 2.0]), b=np.array([3.0, 4.0])).product == 11.0


@given(TRIPLE, TRIPLE)
def test_the_product_of_a_pair_equals_the_product_of_arrays_with_that_pair(
    a: tuple[float, ...], b: tuple[float, ...]
) -> None:
    many = {"a": np.array([a]), "b": np.array([b])}
    assert computed(CrossProduct, a=a, b=b).product == tuple(computed(CrossProduct, **many).product[0].tolist())
    dot = computed(DotProduct, **many).product[0]
    assert computed(DotProduct, a=a, b=b).product == pytest.approx(dot, rel=1e-12, abs=1e-9)


def test_the_dot_product_of_vectors_of_different_sizes_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"a is double\[\] and b is double\[3\]; give vectors of the same length"):
        computed(DotProduct, a=np.array([1.0, 2.0, 3.0]), b=(1.0, 2.0, 3.0))
    with pytest.raises(ValueError, match="a, b must be of the same length"):
        computed(DotProduct, a=np.zeros(2), b=np.zeros(3))


@given(TRIPLE, TRIPLE)
def test_a_distance_is_the_length_between_two_points(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    assert computed(Distance3D, a=a, b=b).distance == pytest.approx(math.dist(a, b), rel=1e-14)


def test_distances_of_many_points_from_one_are_an_array(play: Player) -> None:
    assert computed(Distance3D, a=PAIRS, b=(1.0, 2.0, 3.0)).distance.tolist() == [0.0, pytest.approx(math.sqrt(27.0))]
    nodes = {
        "Here": "{type: ConstantPoint3d, inputs: {value: [0, 3, 4]}}",
        "Far": "{type: Distance3D, inputs: {b: [0, 0, 0]}}",
    }
    assert shown(play, "double Far.distance", nodes, ["Here.inputs:value -> Far.a"]) == 5.0
