"""A value in the text of a YAML file is changed, and nothing else is."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Location
from graphengine.format.yaml_patch import PatchError, location_at, remove_value, set_value
from graphengine.format.yaml_text import flow

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = sorted(path for folder in ("graphs", "scenes") for path in (ROOT / folder).rglob("*.yaml"))


def data_of(text: str) -> Any:
    findings = Findings()
    found = document.parse(text, "t.yaml", findings)
    assert found is not None
    assert not findings.errors
    return found.data


def numbers(data: Any, at: Location = ()) -> Iterator[Location]:
    """The locations of all numbers."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, item in items:
        yield from numbers(item, (*at, key))
    if isinstance(data, int | float) and not isinstance(data, bool):
        yield at


def at(data: Any, location: Location) -> Any:
    for key in location:
        data = data[key]
    return data


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: str(path.relative_to(ROOT)))
def test_each_number_of_a_file_can_be_changed_and_only_its_line_changes(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for location in numbers(data_of(text)):
        changed = set_value(text, location, 0.125)
        assert at(data_of(changed), location) == 0.125
        differing = [pair for pair in zip(text.splitlines(), changed.splitlines(), strict=True) if pair[0] != pair[1]]
        assert len(differing) <= 1
        assert all(old.partition("#")[2] == new.partition("#")[2] for old, new in differing)


def test_the_comment_is_above_the_line_and_replaces_the_previous_comment() -> None:
    text = "a:\n  b: 1  # one\n  c: 2\n"
    once = set_value(text, ("a", "b"), 3, "graphrun calibrate: first")
    assert once == "a:\n  # graphrun calibrate: first\n  b: 3  # one\n  c: 2\n"
    assert set_value(once, ("a", "b"), 4, "graphrun calibrate: second") == once.replace("first", "second").replace(
        "3", "4"
    )


@pytest.mark.parametrize(
    ("text", "location", "expected"),
    [
        ("a: {b: 1}\n", ("a", "c"), "a: {b: 1, c: 5}\n"),
        ("a: {b: {d: [1, 2]}}  # note\n", ("a", "c"), "a: {b: {d: [1, 2]}, c: 5}  # note\n"),
        ("a: {b: 1,}\n", ("a", "c"), "a: {b: 1, c: 5}\n"),
        ("a: {}\n", ("a", "c"), "a: {c: 5}\n"),
        ("a: {b: 1,\n    d: 2}\n", ("a", "c"), "a: {c: 5, b: 1,\n    d: 2}\n"),
        ("a:\n  b: 1\n# end\nz: 2\n", ("a", "c"), "a:\n  b: 1\n  c: 5\n# end\nz: 2\n"),
        ("a:\n  b:\n  - 1\n  - 2\nz: 2\n", ("a", "c"), "a:\n  b:\n  - 1\n  - 2\n  c: 5\nz: 2\n"),
        ("a:\n  b: 1", ("a", "c"), "a:\n  b: 1\n  c: 5\n"),
        ("a:\r\n  b: 1\r\n", ("a", "c"), "a:\r\n  b: 1\r\n  c: 5\r\n"),
        ("a:\n  b: 1\n", ("c", "d"), "a:\n  b: 1\nc: {d: 5}\n"),
        ("- {b: 1}\n", (0, "c"), "- {b: 1, c: 5}\n"),
    ],
)
def test_a_missing_key_is_added_in_the_style_of_its_mapping(text: str, location: Location, expected: str) -> None:
    assert set_value(text, location, 5) == expected


@pytest.mark.parametrize(
    ("text", "location"),
    [
        ("a: &x {b: 1}\nc: *x\n", ("c", "b")),  # changes a too
        ("a: &x 1\nc: *x\n", ("a",)),
        ("a:\n- 1\n", ("a",)),
        ("a:\n  b: 1\n", ("a",)),
        ("a: [1,\n  2]\n", ("a",)),
        ("a: 1\n", ("a", "b")),
        ("a: [1]\n", ("a", 3)),
        ("a: 'one\n  two'\n", ("a",)),
        ("a: [\n", ("a",)),
    ],
)
def test_a_change_that_affects_other_values_is_refused(text: str, location: Location) -> None:
    with pytest.raises(PatchError):
        set_value(text, location, 5)


@pytest.mark.parametrize(
    ("text", "location", "value", "expected"),
    [
        ("a: [1, 2]  # two\n", ("a",), [3.5], "a: [3.5]  # two\n"),
        ("a: {b: [1, {c: 2}]}\n", ("a", "b"), [], "a: {b: []}\n"),
        ("a: type\n", ("a",), {"type": "type", "x": 1}, "a: {type: type, x: 1}\n"),
        ("a: [1, 2]\n", ("a", 2), 3, "a: [1, 2, 3]\n"),
        ("a: []\n", ("a", 0), 3, "a: [3]\n"),
        ("a:\n  - 1\n  - 2  # two\nb: 1\n", ("a", 2), 3, "a:\n  - 1\n  - 2  # two\n  - 3\nb: 1\n"),
        ("a:\n- x -> y\n", ("a", 1), "y -> z", 'a:\n- x -> y\n- "y -> z"\n'),
    ],
)
def test_a_list_on_one_line_is_replaced_and_an_item_is_added_at_its_end(
    text: str, location: Location, value: Any, expected: str
) -> None:
    assert set_value(text, location, value) == expected


@pytest.mark.parametrize(
    ("text", "location", "expected"),
    [
        ("a: 1  # one\nb: 2\n", ("a",), "b: 2\n"),
        ("a:\n  b:\n    c: 1\n    d: 2\n  # of e\n  e: 3\n", ("a", "b"), "a:\n  # of e\n  e: 3\n"),
        ("a: {b: 1, c: [2], d: 3}  # note\n", ("a", "c"), "a: {b: 1, d: 3}  # note\n"),
        ("a: {b: 1, c: [2]}\n", ("a", "c"), "a: {b: 1}\n"),
        ("a: {b: 1}\n", ("a", "b"), "a: {}\n"),
        ("a:  # of a\n  b: 1\nz: 2\n", ("a", "b"), "a: {}  # of a\nz: 2\n"),
        ("a: [1, 2, 3]\n", ("a", 1), "a: [1, 3]\n"),
        ("a:\n  - x: 1\n    y: 2\n  - x: 3\n", ("a", 0), "a:\n  - x: 3\n"),
        ("a:\n- 1\n- 2\nb: 3\n", ("a", 1), "a:\n- 1\nb: 3\n"),
        ("a:\n- 1\nb: 3\n", ("a", 0), "a: []\nb: 3\n"),
        ("a:\n- 1\n- 2\nb: 3\n", ("a",), "b: 3\n"),
    ],
)
def test_a_value_is_removed_with_its_line_or_its_comma(text: str, location: Location, expected: str) -> None:
    assert remove_value(text, location) == expected


@pytest.mark.parametrize(
    ("text", "location"),
    [
        ("a: &x {b: 1}\nc: *x\n", ("c", "b")),
        ("a: 1\n", ("b",)),
        ("- a: 1\n  b: 2\n", (0, "a")),
        ("a: {b: [1,\n  2], c: 3}\n", ("a", "b")),
    ],
)
def test_a_removal_that_affects_other_values_is_refused(text: str, location: Location) -> None:
    with pytest.raises(PatchError):
        remove_value(text, location)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: str(path.relative_to(ROOT)))
def test_each_number_of_a_file_is_found_by_its_position_and_can_be_removed(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    found = document.parse(text, "t.yaml", Findings())
    assert found is not None
    for location in numbers(found.data):
        span = found.span(*location)
        assert location_at(text, span.line, span.column) == location
        with contextlib.suppress(PatchError):  # such as the first key of a list element
            assert location not in set(numbers(data_of(remove_value(text, location)))) or isinstance(location[-1], int)


_keys = st.text("abcd", min_size=1, max_size=3)
_trees = st.recursive(
    st.integers(-9, 9) | st.floats(-9, 9) | st.sampled_from(["x y", "#1", "{"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_keys, inner, max_size=3),
    max_leaves=12,
)


def _block(data: dict[str, Any], indent: int) -> str:
    """YAML with mappings in block style and a comment on each line."""
    lines = ""
    for key, item in data.items():
        more = isinstance(item, dict) and item
        value = f"\n{_block(item, indent + 2)}" if more else f" {flow(item)}  # of {key}\n"
        lines += f"{' ' * indent}{key}:{value}"
    return lines


@given(st.dictionaries(_keys, _trees, min_size=1, max_size=4), st.data())
def test_setting_any_value_changes_the_data_there_and_keeps_all_comments(
    tree: dict[str, Any], data: st.DataObject
) -> None:
    text = _block(tree, 0)
    inner: list[Location] = [()]
    for location in inner:
        node = at(tree, location)
        inner += [(*location, key) for key, item in node.items() if isinstance(item, dict)]
    parent = data.draw(st.sampled_from(inner))
    key = data.draw(_keys)
    assume(not isinstance(at(tree, parent).get(key), list | dict))
    changed = set_value(text, (*parent, key), 0.5, "graphrun calibrate: measured")
    at(tree, parent)[key] = 0.5
    assert data_of(changed) == tree
    assert re.findall(r"# of \w+", changed) == re.findall(r"# of \w+", text)
