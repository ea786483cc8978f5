"""Nodes that make, change and take apart arrays: alone, and in graphs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Node
from graphengine.node.node_class import grown
from graphengine.nodes.data import arrays
from graphengine.nodes.data.construction import ConstructArray, MakeArray
from graphengine.nodes.data.sequences import MAX_LENGTH
from tests.nodes.data.harness import output_of
from tests.nodes.harness import Player

NUMBERS = np.array([4.0, 5.0, 6.0])


def constructed(**literals: Any) -> Any:
    """What ConstructArray makes of a file's values."""
    made: type[Node] = grown(ConstructArray, literals, DEFINITIONS)
    fields = {"arraySize": "array_size", "arrayType": "array_type"}
    return output_of(made(**{fields.get(name, name): value for name, value in literals.items()}), "array")


def test_the_last_given_element_is_repeated_up_to_the_size() -> None:
    assert constructed(arraySize=4, input0=1.5, input1=2.5) == [1.5, 2.5, 2.5, 2.5]
    assert constructed(arraySize=1, input0=1.5, input1=2.5) == [1.5]
    assert constructed(arraySize=0, input0=1.5) == []


def test_inputs_are_taken_by_their_numbers() -> None:
    assert constructed(arraySize=3, input10="c", input2="b", input0="a") == ("a", "b", "c")


def test_an_array_has_the_first_element_type_to_which_all_elements_convert() -> None:
    assert constructed(arraySize=2, input0=1, input1=2.5) == [1.0, 2.5]
    assert constructed(arraySize=2, arrayType="int64[]", input0=1, input1=2) == [1, 2]
    with pytest.raises(ValueError, match="elements of the types double, token cannot form one array"):
        constructed(arraySize=2, input0=1.5, input1="a")


def test_tuples_make_an_array_of_rows() -> None:
    node = ConstructArray(array_size=2, input0=(1.0, 2.0, 3.0))
    assert output_of(node, "array") == [[1.0, 2.0, 3.0]] * 2


def test_an_array_longer_than_the_limit_is_refused() -> None:
    with pytest.raises(
        ValueError, match=f"arraySize must be of {MAX_LENGTH} elements or fewer, it is {MAX_LENGTH + 1}"
    ):
        ConstructArray(array_size=MAX_LENGTH + 1, input0=1.0).compute()
    half = np.zeros(MAX_LENGTH // 2 + 1, np.uint8)
    with pytest.raises(ValueError, match=f"array must be of {MAX_LENGTH} elements or fewer, it is {MAX_LENGTH + 2}"):
        arrays.AppendArray(input0=half, input1=half).compute()


@pytest.mark.parametrize(("size", "expected"), [(0, []), (2, [1.0, 2.0]), (7, [1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0])])
def test_the_older_type_makes_arrays_of_five_inputs(size: int, expected: list[float]) -> None:
    node = MakeArray(array_size=size, a=1.0, b=2.0, c=3.0, d=4.0, e=5.0)
    assert output_of(node, "array") == expected


@pytest.mark.parametrize(
    ("name", "inputs", "output", "expected"),
    [
        ("ArrayGetSize", {"array": NUMBERS}, "size", 3),
        ("ArrayGetSize", {"array": "häß"}, "size", 5),
        ("ArrayGetSize", {"array": ()}, "size", 0),
        ("ArrayIndex", {"array": NUMBERS, "index": 2}, "value", 6.0),
        ("ArrayIndex", {"array": NUMBERS, "index": -3}, "value", 4.0),
        ("ArrayIndex", {"array": np.array([[1, 2], [3, 4]]), "index": 1}, "value", (3, 4)),
        ("ArrayIndex", {"array": ("a", "b"), "index": -1}, "value", "b"),
        ("ArrayIndex", {"array": "ab", "index": 1}, "value", 98),
        ("ArraySetIndex", {"array_in": NUMBERS, "index": -1, "value": 9.0}, "array_out", [4.0, 5.0, 9.0]),
        ("ArraySetIndex", {"array_in": ("a",), "index": 0, "value": "z"}, "array_out", ("z",)),
        (
            "ArraySetIndex",
            {"array_in": NUMBERS, "index": 4, "value": 9.0, "resize_to_fit": True},
            "array_out",
            [4.0, 5.0, 6.0, 0.0, 9.0],
        ),
        ("ArrayAppendValue", {"array_in": NUMBERS, "value": 7}, "array_out", [4.0, 5.0, 6.0, 7.0]),
        ("ArrayAppendValue", {"array_in": "a", "value": 98}, "array_out", "ab"),
        ("ArrayAppendValue", {"array_in": np.zeros((0, 2)), "value": (1.0, 2.0)}, "array_out", [[1.0, 2.0]]),
        ("ArrayInsertValue", {"array_in": NUMBERS, "index": 1, "value": 9.0}, "array_out", [4.0, 9.0, 5.0, 6.0]),
        ("ArrayInsertValue", {"array_in": NUMBERS, "index": -7, "value": 9.0}, "array_out", [9.0, 4.0, 5.0, 6.0]),
        ("ArrayInsertValue", {"array_in": NUMBERS, "index": 99, "value": 9.0}, "array_out", [4.0, 5.0, 6.0, 9.0]),
        ("ArrayRemoveIndex", {"array_in": NUMBERS, "index": 1}, "array_out", [4.0, 6.0]),
        ("ArrayRemoveIndex", {"array_in": ("a", "b"), "index": -1}, "array_out", ("a",)),
        ("ArrayFindValue", {"array": NUMBERS, "value": 5.0}, "index", 1),
        ("ArrayFindValue", {"array": NUMBERS, "value": 7.0}, "index", -1),
        ("ArrayFindValue", {"array": np.array([[1, 2], [1, 3]]), "value": (1, 3)}, "index", 1),
        ("ArrayFill", {"array_in": NUMBERS, "fill_value": 0.5}, "array_out", [0.5, 0.5, 0.5]),
        ("ArrayFill", {"array_in": (), "fill_value": "a"}, "array_out", ()),
        ("ArrayResize", {"array_in": NUMBERS, "new_size": 2}, "array_out", [4.0, 5.0]),
        ("ArrayResize", {"array_in": NUMBERS, "new_size": 4}, "array_out", [4.0, 5.0, 6.0, 0.0]),
        ("ArrayResize", {"array_in": ("a",), "new_size": 2}, "array_out", ("a", "")),
        ("ArrayResize", {"array_in": NUMBERS, "new_size": -1}, "array_out", []),
        ("ArrayRotate", {"array_in": NUMBERS, "steps": 1}, "array_out", [6.0, 4.0, 5.0]),
        ("ArrayRotate", {"array_in": NUMBERS, "steps": -4}, "array_out", [5.0, 6.0, 4.0]),
        ("ArrayRotate", {"array_in": (), "steps": 1}, "array_out", ()),
        ("ArrayReverse", {"array_in": NUMBERS}, "array_out", [6.0, 5.0, 4.0]),
        ("ArrayReverse", {"array_in": ("a", "b")}, "array_out", ("b", "a")),
        ("ArrayReverse", {"array_in": "abc"}, "array_out", "cba"),
        ("ArrayReplaceValue", {"array_in": NUMBERS, "value": 5, "new_value": 7}, "array_out", [4.0, 7.0, 6.0]),
        ("ArrayReplaceValue", {"array_in": NUMBERS, "value": 9, "new_value": 7}, "array_out", [4.0, 5.0, 6.0]),
        ("ArrayReplaceValue", {"array_in": NUMBERS, "value": 9, "new_value": 7}, "found", False),
        (
            "ArrayReplaceValue",
            {"array_in": ("a", "b", "a"), "value": "a", "new_value": "c"},
            "array_out",
            ("c", "b", "a"),
        ),
        (
            "ArrayReplaceValue",
            {"array_in": ("a", "b", "a"), "value": "a", "new_value": "c", "replace_all_found": True},
            "array_out",
            ("c", "b", "c"),
        ),
        ("ArraySlice", {"array_in": NUMBERS, "start": 1}, "array_out", [5.0, 6.0]),
        ("ArraySlice", {"array_in": NUMBERS, "start": -9, "end": -1, "use_length": False}, "array_out", [4.0, 5.0]),
        ("ArraySlice", {"array_in": NUMBERS, "start": 2, "end": 1, "use_length": False}, "array_out", []),
        ("ArraySlice", {"array_in": "abc", "start": 1}, "array_out", "bc"),
        ("AppendArray", {"input0": NUMBERS, "input1": np.array([7.0])}, "array", [4.0, 5.0, 6.0, 7.0]),
        ("AppendArray", {"input0": ("a",), "input1": ("b", "c")}, "array", ("a", "b", "c")),
    ],
)
def test_outside_a_graph_array_nodes_give_the_expected_arrays(
    name: str, inputs: dict[str, Any], output: str, expected: Any
) -> None:
    assert output_of(getattr(arrays, name)(**inputs), output) == expected


@pytest.mark.parametrize(
    ("remove_all", "value", "left", "found"),
    [(False, 5.0, [4.0, 5.0], True), (True, 5.0, [4.0], True), (True, 7.0, [4.0, 5.0, 5.0], False)],
)
def test_the_first_or_every_occurrence_of_a_value_is_removed(
    remove_all: bool, value: float, left: list[float], found: bool
) -> None:
    node = arrays.ArrayRemoveValue(array_in=np.array([4.0, 5.0, 5.0]), value=value, remove_all_found=remove_all)
    assert (output_of(node, "array_out"), node.found) == (left, found)


@pytest.mark.parametrize("name", ["ArrayIndex", "ArraySetIndex", "ArrayRemoveIndex"])
@pytest.mark.parametrize(("index", "legal"), [(3, "index must be from -3 to 2"), (-4, "index must be from -3 to 2")])
def test_the_error_of_an_index_beyond_the_end_gives_the_legal_range(name: str, index: int, legal: str) -> None:
    cls = getattr(arrays, name)
    inputs = {"array" if name == "ArrayIndex" else "array_in": NUMBERS, "index": index}
    with pytest.raises(ValueError, match=legal):
        cls(**inputs, **({"value": 1.0} if name == "ArraySetIndex" else {})).compute()


def test_inputs_are_not_modified() -> None:
    given = NUMBERS.copy()
    node = arrays.ArraySetIndex(array_in=given, index=0, value=9.0)
    node.compute()
    assert given.tolist() == [4.0, 5.0, 6.0]


@given(st.lists(st.integers(-100, 100)), st.integers(-20, 20))
def test_rotating_there_and_back_gives_the_original_array(items: list[int], steps: int) -> None:
    there = output_of(arrays.ArrayRotate(array_in=np.array(items, np.int32), steps=steps), "array_out")
    back = output_of(arrays.ArrayRotate(array_in=np.array(there, np.int32), steps=-steps), "array_out")
    assert back == items


@given(st.lists(st.text()), st.integers(-20, 20), st.integers(-20, 20))
def test_a_slice_follows_pythons_rules(items: list[str], start: int, end: int) -> None:
    node = arrays.ArraySlice(array_in=tuple(items), start=start, end=end, use_length=False)
    assert output_of(node, "array_out") == tuple(items[start:end])


WHEELS = """
nodes:
  Tick: OnPlaybackTick
  Speed: {type: ReadTime}
  Both: {type: ConstructArray, inputs: {arraySize: 2, input0: VALUE}}
  More: {type: ArrayAppendValue, inputs: {value: APPENDED}}
  Each: ForEach
connections:
  - Tick.tick -> Each.execIn
  - Both.array -> More.array
  - More.array -> Each.arrayIn
"""


def wheels(value: str, appended: str) -> str:
    return WHEELS.replace("VALUE", value).replace("APPENDED", appended)


def test_types_follow_from_the_elements_through_a_graph(play: Player) -> None:
    playing = play.graph(wheels("{type: float, value: 0.5}", "1.5") + "  - Speed.time -> Both.input1\n").tick(2)
    made = playing.node("More").array_out
    assert (made.dtype, made.tolist()) == (np.float64, [0.5, 2 / 60, 1.5])
    assert playing.node("Each").element == 1.5


def test_a_literal_becomes_an_element_of_the_array(play: Player) -> None:
    playing = play.graph(wheels("{type: float, value: 0.5}", "1.5")).tick()
    made = playing.node("More").array_out
    assert (made.dtype, made.tolist()) == (np.float32, [0.5, 0.5, 1.5])


def test_a_value_that_does_not_convert_to_the_element_type_is_refused(play: Player) -> None:
    with pytest.raises(CheckError, match="More: value must be a double, but it is a token"):
        play.graph(wheels("0.5", "left"))


def test_an_index_beyond_the_end_of_a_constant_is_reported_before_the_run(play: Player) -> None:
    with pytest.raises(CheckError, match="Third: index must be from -2 to 1, it is 2"):
        play.graph(INDEXED)


def test_an_index_beyond_the_end_from_a_wire_keeps_the_previous_output(play: Player) -> None:
    playing = play.graph(
        INDEXED.replace(", index: 2", "") + "  - Count.count -> Third.index\n  - Tick.tick -> Count.execIn\n"
    ).tick()
    assert playing.node("Third").value == 2.0
    playing.tick()
    assert playing.node("Third").value == 2.0
    assert playing.dropped == {"/World/graph/Third": 1}


INDEXED = """
nodes:
  Tick: OnPlaybackTick
  Count: Counter
  Third: {type: ArrayIndex, inputs: {array: [1.0, 2.0], index: 2}}
  Odometry: PublishOdometry
connections:
  - Tick.tick -> Odometry.execIn
  - Third.value -> Odometry.timeStamp
"""
