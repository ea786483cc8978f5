"""Targets and paths put together, taken apart and compared."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graphengine.nodes.data.paths import AppendPath, GetParentPath
from graphengine.nodes.data.targets import AppendTargets, CompareTargets, FindTarget, GetParentPrims, GetTargets
from tests.nodes.data.harness import computed, shown
from tests.nodes.harness import Player

THREE = ("/a", "/b", "/c")


def test_targets_are_joined_and_repeated_prims_are_kept_only_if_allowed() -> None:
    assert computed(AppendTargets, input0=("/a", "/b"), input1=("/b", "/a", "/c")).targets == THREE
    both = computed(AppendTargets, input0=("/a",), input1=("/a",), allow_duplicates=True)
    assert both.targets == ("/a", "/a")


def test_in_a_graph_a_third_target_comes_third(play: Player) -> None:
    nodes = {"All": "{type: AppendTargets, inputs: {input0: /a, input2: [/c], input1: /b}}"}
    assert shown(play, "target All.targets", nodes) == THREE


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        ({}, ("/a",)),
        ({"index": -1}, ("/c",)),
        ({"index": 1, "count": -1}, ("/b", "/c")),
        ({"index": -2, "count": 9}, ("/b", "/c")),
        ({"count": 0}, ()),
    ],
)
def test_get_targets_selects_consecutive_prims(inputs: dict[str, Any], expected: tuple[str, ...]) -> None:
    assert computed(GetTargets, targets_in=THREE, **inputs).targets_out == expected


def test_an_index_out_of_range_is_an_error_except_for_an_empty_target() -> None:
    with pytest.raises(ValueError, match="index must be from -3 to 2, it is 3"):
        computed(GetTargets, targets_in=THREE, index=3)
    assert computed(GetTargets, index=3).targets_out == ()


def test_find_target_outputs_the_index_of_a_prim() -> None:
    assert computed(FindTarget, targets=THREE, search_target=("/c", "/a")).index == 2
    assert computed(FindTarget, targets=THREE, search_target="/d").index == -1
    assert computed(FindTarget, targets=THREE).index == -1


@pytest.mark.parametrize(
    ("path", "above"),
    [
        ("/World/box", "/World"),
        ("/World", "/"),
        ("/", "/"),
        ("/World/box.mass", "/World/box"),
        ("/v1.0/box", "/v1.0"),
        ("", ""),
        ("box", "box"),
    ],
)
def test_the_parent_of_a_path_lacks_its_last_name(path: str, above: str) -> None:
    assert computed(GetParentPath, path=path).parent_path == above
    assert computed(GetParentPath, path=(path, "/a/b")).parent_path == (above, "/a")
    assert computed(GetParentPrims, prims=[path, "/a/b"] if path else ["/a/b"]).parent_prims[-1] == "/a"


@pytest.mark.parametrize(
    ("path", "suffix", "whole"),
    [
        ("/World", "box/lid", "/World/box/lid"),
        ("/", "World", "/World"),
        ("/World", ".mass", "/World.mass"),
        ("/World", "", "/World"),
        ("", "box", ""),
    ],
)
def test_append_path_appends_names_to_a_path(path: str, suffix: str, whole: str) -> None:
    assert computed(AppendPath, path_in=path, suffix=suffix).path_out == whole
    assert computed(AppendPath, path_in=(path, path), suffix=suffix).path_out == (whole, whole)


def test_appending_an_absolute_path_is_an_error() -> None:
    with pytest.raises(ValueError, match="suffix must be names to append, without a leading /"):
        computed(AppendPath, path_in="/World", suffix="/box")


def test_targets_are_compared_whole_or_prim_by_prim() -> None:
    assert computed(CompareTargets, a=THREE, b=THREE).result is True
    assert computed(CompareTargets, a=THREE, b=THREE[:2]).result is False
    assert computed(CompareTargets, a=THREE, b=THREE[::-1], operation="!=").result is True
    each = computed(CompareTargets, a=THREE, b=THREE[::-1], compare_each=True).result
    assert (each.tolist(), each.dtype) == ([False, True, False], np.bool_)
    other = computed(CompareTargets, a=THREE, b=THREE[::-1], compare_each=True, operation="!=").result
    assert other.tolist() == [True, False, True]
    with pytest.raises(ValueError, match=r"a, b must be of the same length, it is \[3, 1\]"):
        computed(CompareTargets, a=THREE, b=["/a"], compare_each=True)


@pytest.mark.parametrize(
    ("each", "port_type", "expected"), [("false", "bool", False), ("true", "bool[]", [True, False])]
)
def test_in_a_graph_compare_each_determines_the_type_of_the_result(
    play: Player, each: str, port_type: str, expected: Any
) -> None:
    nodes = {"Same": f"{{type: CompareTargets, inputs: {{a: [/a, /b], b: [/a, /c], compareEach: {each}}}}}"}
    found = shown(play, f"{port_type} Same.result", nodes)
    assert (found.tolist() if isinstance(found, np.ndarray) else found) == expected
