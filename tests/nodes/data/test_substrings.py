"""Texts changed, found in others, taken out of them, put into them and replaced."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.nodes.data import sequences
from graphengine.nodes.data.strings import CapitalizeString, SplitString
from graphengine.nodes.data.substrings import FindString, GetString, InsertString, RemoveString, ReplaceString
from tests.nodes.data.harness import computed, shown
from tests.nodes.harness import Player

TEXTS = st.text(max_size=12)


@pytest.mark.parametrize(
    ("operation", "expected"),
    [
        ("UpperCase", "LEFT WHEEL_JOINT"),
        ("LowerCase", "left wheel_joint"),
        ("Capitalize", "Left wheel_joint"),
        ("Title", "Left Wheel_joint"),
    ],
)
def test_a_text_is_written_in_capitals_or_small_letters(operation: str, expected: str) -> None:
    assert computed(CapitalizeString, string_in="leFT wheel_JOINT", operation=operation).string_out == expected
    both = computed(CapitalizeString, string_in=("leFT wheel_JOINT", ""), operation=operation).string_out
    assert both == (expected, "")


def test_an_unknown_operation_is_an_error() -> None:
    node = CapitalizeString(string_in="a")
    node.operation = "Upper"
    with pytest.raises(ValueError, match=r"operation must be one of UpperCase, .*, it is 'Upper'"):
        node.compute()


@given(st.lists(st.text("abc", max_size=3), min_size=1, max_size=5))
def test_splitting_a_joined_string_gives_its_parts(parts: list[str]) -> None:
    found = computed(SplitString, string="/-".join(parts), delimiter="/-").elements
    assert found == (tuple(parts) if parts != [""] else ())


def test_without_a_delimiter_there_are_no_parts() -> None:
    assert computed(SplitString, string="a b", delimiter="").elements == ()
    assert computed(SplitString, string=" a  b").elements == ("", "a", "", "b")


def test_a_text_of_too_many_parts_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sequences, "MAX_LENGTH", 3)
    with pytest.raises(ValueError, match="string must be of 3 elements or fewer, it is 4"):
        computed(SplitString, string="a b c d")


@pytest.mark.parametrize(
    ("inputs", "index"),
    [
        ({"value": "link"}, 5),
        ({"value": "link", "pos": 6}, 15),
        ({"value": "link", "pos": 16}, -1),
        ({"value": "arm"}, -1),
        ({"value": ""}, -1),
        ({"value": "base", "pos": -5}, 0),
        ({"value": "k", "pos": 99}, -1),
    ],
)
def test_the_search_starts_at_the_given_position(inputs: dict[str, Any], index: int) -> None:
    assert computed(FindString, string="base_link/base_link", **inputs).index == index


@given(TEXTS, st.integers(-14, 14), st.integers(-2, 14))
def test_an_extracted_part_and_the_remaining_string_make_up_the_whole(text: str, index: int, count: int) -> None:
    inputs = {"string_in": text, "index": index, "count": count}
    if text and not -len(text) <= index < len(text):
        with pytest.raises(ValueError, match=f"index must be from {-len(text)} to {len(text) - 1}, it is {index}"):
            computed(GetString, **inputs)
        return
    part, left = computed(GetString, **inputs).string_out, computed(RemoveString, **inputs).string_out
    start = index % len(text) if text else 0
    assert left[:start] + part + left[start:] == text
    assert len(part) == (min(count, len(text) - start) if count >= 0 else len(text) - start)


@given(TEXTS, TEXTS, st.integers(-3, 15))
def test_an_inserted_string_can_be_removed_again(text: str, value: str, index: int) -> None:
    whole = computed(InsertString, string_in=text, value=value, index=index).string_out
    start = min(max(index, 0), len(text))
    assert whole[:start] + whole[start + len(value) :] == text
    assert whole[start : start + len(value)] == value


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        ({"replace": "/", "value": "::"}, "a::b/c"),
        ({"replace": "/", "value": "", "replace_all": True}, "abc"),
        ({"replace": "", "value": "x", "replace_all": True}, "a/b/c"),
        ({"replace": "z", "value": "x"}, "a/b/c"),
    ],
)
def test_the_first_or_every_occurrence_of_a_string_is_replaced(inputs: dict[str, Any], expected: str) -> None:
    assert computed(ReplaceString, string_in="a/b/c", **inputs).string_out == expected


def test_a_result_longer_than_the_limit_is_an_error() -> None:
    with pytest.raises(ValueError, match="value must be so short that the result has"):
        computed(ReplaceString, string_in="a" * 5000, replace="a", value="b" * 5000, replace_all=True)


def test_in_a_graph_a_token_stays_a_token(play: Player) -> None:
    nodes = {
        "Name": "{type: ConstantToken, inputs: {value: front_wheel}}",
        "Cut": "{type: RemoveString, inputs: {index: 5}}",
        "Loud": "{type: CapitalizeString}",
        "Put": "{type: InsertString, inputs: {value: my_}}",
        "Swap": "{type: ReplaceString, inputs: {replace: MY, value: our}}",
        "Part": "{type: GetString, inputs: {index: -5}}",
    }
    chain = ["Cut", "Put", "Loud", "Swap", "Part"]
    wires = ["Name.value -> Cut.string", *(f"{a}.string -> {b}.string" for a, b in itertools.pairwise(chain))]
    assert shown(play, "token Swap.string", nodes, wires) == "our_FRONT"
    assert shown(play, "token Part.string", nodes, wires) == "FRONT"
