"""SelectIf, texts, conversions, time, random numbers and paths of prims: alone, and in graphs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node.node_class import grown
from graphengine.nodes.data import conversion
from graphengine.nodes.data.paths import GetGraphTargetPrim, GetPrimPath, GetPrimPaths, GraphTarget
from graphengine.nodes.data.random import (
    RandomBoolean,
    RandomGaussian,
    RandomNode,
    RandomNumeric,
    RandomUnitQuaternion,
    RandomUnitVector,
)
from graphengine.nodes.data.selection import IsEmpty, SelectIf, SelectTargetIf
from graphengine.nodes.data.sequences import MAX_LENGTH
from graphengine.nodes.data.strings import AppendString, BuildString, EndsWith, StartsWith
from graphengine.nodes.data.time import ReadTime
from graphengine.scene.loaded_scene import Options
from graphengine.testing import RecordingContext
from tests.nodes.data.harness import output_of
from tests.nodes.harness import Player, ready

# SelectIf, SelectTargetIf, IsEmpty


@pytest.mark.parametrize(
    ("condition", "if_true", "if_false", "expected"),
    [
        (True, 1, 2, 1),
        (False, 1, 2.5, 2.5),
        (True, 1, 2.5, 1.0),
        (False, "a", "b", "b"),
        (True, (1.0, 2.0), (3.0, 4.0), (1.0, 2.0)),
        (np.array([True, False]), 1.5, 2.5, [1.5, 2.5]),
        (np.array([True, False]), np.array([1, 2]), 9, [1, 9]),
        (False, np.array([1, 2]), 9, [9, 9]),
        (np.array([False, True]), (1.0, 2.0), (3.0, 4.0), [[3.0, 4.0], [1.0, 2.0]]),
    ],
)
def test_a_condition_selects_a_value_or_element_by_element(
    condition: Any, if_true: Any, if_false: Any, expected: Any
) -> None:
    node = ready(SelectIf, RecordingContext(), condition=condition, if_true=if_true, if_false=if_false)
    result = output_of(node, "result")
    assert (result, type(result)) == (expected, type(expected))


def test_selecting_from_arrays_of_different_lengths_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"condition, ifTrue must be of the same length, it is \[3, 2\]"):
        ready(
            SelectIf, RecordingContext(), condition=np.array([True] * 3), if_true=np.array([1, 2]), if_false=0
        ).compute()


def test_values_without_common_type_are_reported(play: Player) -> None:
    with pytest.raises(CheckError, match="ifTrue is double and ifFalse is token, which have no common type"):
        play.graph(
            "nodes:\n  S: {type: SelectIf, inputs: {condition: true, ifTrue: 1.5, ifFalse: a}}\nconnections: []\n"
        )


def test_targets_are_selected_whole_or_prim_by_prim() -> None:
    assert output_of(SelectTargetIf(condition=False, if_true=("/a",), if_false=("/b", "/c")), "result") == ("/b", "/c")
    each = SelectTargetIf(condition=np.array([True, False]), if_true=("/a", "/b"), if_false=("/c", "/d"))
    assert output_of(each, "result") == ("/a", "/d")
    with pytest.raises(ValueError, match=r"condition, ifTrue, ifFalse must be of the same length, it is \[1, 2, 0\]"):
        SelectTargetIf(condition=np.array([True]), if_true=("/a", "/b")).compute()


@pytest.mark.parametrize(
    ("value", "empty"), [("", True), (" ", False), (np.zeros(0), True), (0.0, False), ((0, 0), False), ((), True)]
)
def test_an_empty_array_has_no_elements(value: Any, empty: bool) -> None:
    assert output_of(IsEmpty(input_in=value), "is_empty") is empty


# Texts


def test_build_string_joins_all_inputs_that_a_file_names() -> None:
    made: Any = grown(BuildString, {"a": "", "b": "", "input3": "", "input2": ""}, DEFINITIONS)
    assert output_of(made(a="a", b="b", input2="c", input3="d"), "value") == "abcd"
    assert output_of(BuildString(a=("a", "b"), b="/x"), "value") == ("a/x", "b/x")
    assert output_of(BuildString(a=("a", "b"), b=("c", "d")), "value") == ("ac", "bd")
    with pytest.raises(ValueError, match="b must be one string"):
        BuildString(a="a", b=("c", "d")).compute()
    with pytest.raises(ValueError, match="b must be one string, or 2 strings"):
        BuildString(a=("a", "b"), b=("c",)).compute()


@pytest.mark.parametrize("texts", ["x" * (MAX_LENGTH - 1), ("a", "x" * (MAX_LENGTH - 1))])
def test_a_string_longer_than_the_limit_is_refused(texts: str | tuple[str, ...]) -> None:
    with pytest.raises(
        ValueError, match=f"suffix must be so short that the result has {MAX_LENGTH} characters or fewer"
    ):
        AppendString(value_in=texts, suffix="yz").compute()


def test_the_older_node_type_appends_one_element() -> None:
    assert output_of(AppendString(value_in="a", suffix="ß"), "value_out") == "aß"


@pytest.mark.parametrize(("value", "part"), [("wheel_left", "wheel"), ("wheel", "wheel"), ("a", "")])
def test_a_text_starts_with_its_prefix(value: str, part: str) -> None:
    assert output_of(StartsWith(value=value, prefix=part), "is_prefix") is True
    assert output_of(StartsWith(value=value, prefix="Wheel"), "is_prefix") is False


@pytest.mark.parametrize(("value", "part"), [("left_wheel", "wheel"), ("wheel", "wheel"), ("a", "")])
def test_a_text_ends_with_its_suffix(value: str, part: str) -> None:
    assert output_of(EndsWith(value=value, suffix=part), "is_suffix") is True
    assert output_of(EndsWith(value=value, suffix="heels"), "is_suffix") is False


# Conversions


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("ToBool", 0.0, False),
        ("ToBool", np.array([0, -2]), [False, True]),
        ("ToInt", -2.9, -2),
        ("ToInt", (1.5, -1.5), (1, -1)),
        ("ToInt64", np.array([2.0**40, -0.5]), [2**40, 0]),
        ("ToUint", -1, 2**32 - 1),
        ("ToUint64", -2.5, 2**64 - 2),
        ("ToUint64", True, 1),
        ("ToUchar", -1.0, 255),
        ("ToUchar", "ab", [97, 98]),
        ("ToFloat", 0.1, float(np.float32(0.1))),
        ("ToFloat", 1e300, math.inf),
        ("ToHalf", (1.0, 1e6), (1.0, math.inf)),
        ("ToDouble", 3, 3.0),
        ("ToDouble", True, 1.0),
        ("ToDouble", np.array([[1, 2]]), [[1.0, 2.0]]),
        ("ToString", 1234000.0, "1.234e+06"),
        ("ToString", 2.0, "2"),
        ("ToString", -3, "-3"),
        ("ToString", True, "True"),
        ("ToString", (1.5, -0.03), "[1.5, -0.03]"),
        ("ToString", np.array([[1, 2], [3, 4]]), "[[1, 2], [3, 4]]"),
        ("ToString", np.array([97, 98], np.uint8), "ab"),
        ("ToString", "first", "first"),
        ("ToString", ("first", "second"), '["first", "second"]'),
        ("ToString", math.inf, "inf"),
        ("ToToken", 0.5, "0.5"),
        ("ToTarget", "/a", ("/a",)),
        ("ToTarget", "", ()),
        ("ToTarget", ("/a", "/b"), ("/a", "/b")),
    ],
)
def test_a_value_is_converted_to_another_type(name: str, value: Any, expected: Any) -> None:
    result = output_of(getattr(conversion, name)(value=value), "converted")
    assert (result, type(result)) == (expected, type(expected))


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e19])
def test_nan_and_numbers_too_large_for_an_integer_are_reported(value: float) -> None:
    with pytest.raises(ValueError, match="value must be a number that the type int can hold"):
        conversion.ToInt(value=value).compute()


def test_a_converted_value_gets_a_role_if_its_shape_has_this_role(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Three: {type: ToFloat, inputs: {role: Vector, value: {type: 'double[3]', value: [1, 2, 3]}}}
          One: {type: ToFloat, inputs: {role: Vector, value: 1.5}}
          Count: Counter
        connections: [Tick.tick -> Count.execIn]
        """
    )
    types = {name: str(playing.node(name).settled["converted"]) for name in ("Three", "One")}
    assert types == {"Three": "vectorf[3]", "One": "float"}


def test_a_converter_makes_a_wire_between_other_types_legal(play: Player) -> None:
    text = """
        nodes:
          Tick: OnPlaybackTick
          Text: {type: ToToken}
          Publish: {type: ROS2Publisher, inputs: {messagePackage: std_msgs, messageName: String, topicName: said}}
        connections: [Tick.tick -> Publish.execIn, Tick.time -> Text.value, Text.converted -> Publish.data]
        """
    playing = play.graph(text).tick(2)
    assert [message.data for message in playing.published("/said")] == ["0.0166667", "0.0333333"]
    with pytest.raises(CheckError, match=r"is a double, Publish\.data takes a token"):
        play.graph(text.replace("Text.converted", "Tick.time"))


# ReadTime


def test_read_time_outputs_all_times_of_the_clock(context: RecordingContext) -> None:
    node = ready(ReadTime, context)
    context.tick(3)
    node.compute()
    assert (node.time, node.frame, node.delta_seconds, node.is_playing) == (3 / 60, 3.0, 1 / 60, True)
    assert node.time_since_start == node.absolute_sim_time == context.clock.monotonic_time


# Random numbers


def drawn(node: RandomNode, count: int = 4) -> list[Any]:
    """Several values, one after the other."""
    return [output_of(node, "random") for _ in range(count)]


RANDOM: list[tuple[type[RandomNode], dict[str, Any]]] = [
    (RandomBoolean, {}),
    (RandomUnitVector, {}),
    (RandomUnitQuaternion, {}),
    (RandomNumeric, {"minimum": 0.0, "maximum": 1.0}),
    (RandomGaussian, {"mean": 0.0, "stdev": 1.0}),
]
every_random = pytest.mark.parametrize(("cls", "inputs"), RANDOM)


@every_random
def test_random_values_repeat_in_an_equal_session_and_after_a_stop(
    cls: type[RandomNode], inputs: dict[str, Any], context: RecordingContext
) -> None:
    node = ready(cls, context, **inputs)
    first = drawn(node, 30)
    assert len({str(value) for value in first}) > 1
    assert drawn(ready(cls, RecordingContext(), **inputs), 30) == first
    context.stop(node)
    assert drawn(node, 30) == first


@every_random
def test_two_nodes_give_different_random_values_unless_they_share_a_seed(
    cls: type[RandomNode], inputs: dict[str, Any]
) -> None:
    one, other = RecordingContext("/World/graph/one"), RecordingContext("/World/graph/other")
    assert drawn(ready(cls, one, **inputs), 30) != drawn(ready(cls, other, **inputs), 30)
    seeded = [drawn(ready(cls, context, seed=7, use_seed=True, **inputs), 30) for context in (one, other)]
    assert seeded[0] == seeded[1]


@every_random
def test_noise_is_one_value_for_each_seed(cls: type[RandomNode], inputs: dict[str, Any]) -> None:
    node = ready(cls, RecordingContext(), is_noise=True, seed=3, **inputs)
    assert len({str(value) for value in drawn(node)}) == 1


def test_directions_and_orientations_have_length_one() -> None:
    for cls in (RandomUnitVector, RandomUnitQuaternion):
        lengths = [math.hypot(*value) for value in drawn(ready(cls, RecordingContext()), 20)]
        assert lengths == pytest.approx([1.0] * 20)


def test_whole_numbers_reach_both_ends_and_real_ones_stay_below() -> None:
    whole = drawn(ready(RandomNumeric, RecordingContext(), minimum=-1, maximum=1), 100)
    assert set(whole) == {-1, 0, 1}
    real = drawn(ready(RandomNumeric, RecordingContext(), minimum=2.0, maximum=3.0), 100)
    assert min(real) >= 2.0
    assert max(real) < 3.0
    with pytest.raises(ValueError, match="min, max must be in ascending order"):
        ready(RandomNumeric, RecordingContext(), minimum=1, maximum=0).compute()


def test_without_bounds_a_number_is_drawn_from_0_to_1_and_a_normal_one_around_0(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Any: RandomNumeric
          Die: {type: RandomNumeric, inputs: {max: 6}}
          Normal: RandomGaussian
          Wide: {type: RandomGaussian, inputs: {stdev: [1.0, 100.0]}}
        connections: [Tick.tick -> Any.execIn, Tick.tick -> Die.execIn, Tick.tick -> Normal.execIn, Tick.tick -> Wide.execIn]
        """
    )
    drawn: dict[str, list[Any]] = {name: [] for name in ("Any", "Die", "Normal", "Wide")}
    for _ in range(200):
        playing.tick()
        for name, values in drawn.items():
            values.append(playing.node(name).random)
    assert 0.0 <= min(drawn["Any"]) < 0.1 < 0.9 < max(drawn["Any"]) < 1.0
    assert set(drawn["Die"]) == set(range(7))
    assert np.mean(drawn["Normal"]) == pytest.approx(0.0, abs=5 / math.sqrt(200))
    assert np.std(np.array(drawn["Wide"]), axis=0) == pytest.approx([1.0, 100.0], rel=0.3)


def test_each_number_of_arrays_and_tuples_is_drawn_separately() -> None:
    node = ready(RandomNumeric, RecordingContext(), minimum=np.array([0, 10]), maximum=np.array([1, 11]))
    assert all(low in (0, 1) and high in (10, 11) for low, high in drawn(node, 10))
    both = ready(RandomGaussian, RecordingContext(), mean=(0.0, 100.0), stdev=1.0)
    assert all(abs(a) < 10.0 and abs(b - 100.0) < 10.0 for a, b in drawn(both, 10))


def test_a_normal_distribution_has_its_mean_and_deviation() -> None:
    values = drawn(ready(RandomGaussian, RecordingContext(), mean=5.0, stdev=2.0), 2000)
    assert np.mean(values) == pytest.approx(5.0, abs=5 * 2.0 / math.sqrt(2000))
    assert np.std(values) == pytest.approx(2.0, rel=0.1)
    logarithms = np.log(drawn(ready(RandomGaussian, RecordingContext(), mean=5.0, stdev=2.0, use_log=True), 2000))
    assert np.mean(logarithms) == pytest.approx(5.0, abs=5 * 2.0 / math.sqrt(2000))


def test_the_seed_of_the_session_decides_the_random_values(play: Player) -> None:
    text = """
        nodes: {Tick: OnPlaybackTick, Draw: {type: RandomNumeric, inputs: {min: 0.0, max: 1.0}}}
        connections: [Tick.tick -> Draw.execIn]
        """
    values = []
    for seed in (1, 1, 2):
        playing = play.graph(text, options=Options(seed=seed)).tick(2)
        values.append(playing.node("Draw").random)
    assert values[0] == values[1] != values[2]


# Paths


def test_the_paths_of_prims_are_output() -> None:
    node = GetPrimPath(prim=("/a", "/b"))
    node.compute()
    assert node.path == node.prim_path == "/a"
    assert output_of(GetPrimPath(), "path") == ""
    assert output_of(GetPrimPaths(prims=("/a", "/b")), "prim_paths") == ("/a", "/b")


def test_a_graph_target_is_the_prim_of_the_graph(play: Player) -> None:
    context = RecordingContext("/World/here/node")
    assert output_of(ready(GraphTarget, context), "prim_path") == "/World/here"
    assert output_of(ready(GetGraphTargetPrim, context), "prim") == ("/World/here",)
    playing = play.graph(
        """
        at: /World/there
        nodes:
          Tick: OnPlaybackTick
          Where: GraphTarget
          Publish: {type: ROS2Publisher, inputs: {messagePackage: std_msgs, messageName: String, topicName: said}}
          Text: ToToken
        connections: [Tick.tick -> Publish.execIn, Where.primPath -> Text.value, Text.converted -> Publish.data]
        """
    ).tick()
    assert playing.published("/said")[0].data == "/World/there"
