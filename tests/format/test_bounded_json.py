"""JSON from strangers is measured before it is parsed."""

from __future__ import annotations

import json
from typing import Any

import pytest

from graphengine.format.bounded_json import MAX_BYTES, MAX_CONTAINERS, MAX_DEPTH, MAX_PARTS, parse

MANY = 10_000_000


@pytest.mark.parametrize(
    "value",
    [
        None,
        {},
        {"a": [1, -2.5e3, True, "x"], "b": {"c": []}},
        '[[[{"',
        "\\",
        'a"b\\"[',
        "[" * 1000 + '"' * 7 + "\\" * 9,
        {"ключ": "значение ∞ \u2028", "\udc80": 1},
        list(range(1000)),
    ],
)
def test_values_are_parsed_as_python_parses_them(value: Any) -> None:
    for text in (json.dumps(value), json.dumps(value, indent=1)):
        assert parse(text) == parse(text.encode()) == value


def test_the_limits_are_exact() -> None:
    deepest = "[" * MAX_DEPTH + "]" * MAX_DEPTH
    assert parse(deepest) == json.loads(deepest)
    assert len(parse(f"[{','.join(['[]'] * (MAX_CONTAINERS - 1))}]", MANY)) == MAX_CONTAINERS - 1
    assert len(parse(f"[{','.join(['1'] * MAX_PARTS)}]", MANY)) == MAX_PARTS
    assert parse(f'"{"x" * (MAX_BYTES - 2)}"') == "x" * (MAX_BYTES - 2)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (f"[{'[' * MAX_DEPTH}{']' * MAX_DEPTH}]", "nested more than 40 levels deep"),
        (f"[{'{}' * 3}{'[' * MAX_DEPTH}{']' * MAX_DEPTH}]", "nested more than 40 levels deep"),
        ('{"a":' * 100_000, "nested more than 40 levels deep"),
        ("[" * MANY, "lists and objects"),
        (f"[{','.join(['[]'] * MAX_CONTAINERS)}]", "lists and objects"),
        (f"[{','.join(['[{}]'] * 1_000_000)}]", "lists and objects"),
        (f"[{','.join(['1'] * (MAX_PARTS + 1))}]", "or 4000000 values"),
        (f'"{"x" * MANY}"', "larger than 10 MB"),
        (f"[{',' * MANY}]", "larger than 10 MB"),
    ],
    ids=["deep", "wide and deep", "open objects", "open lists", "flat", "pairs", "numbers", "long", "commas"],
)
def test_a_text_beyond_a_limit_is_refused_before_it_is_parsed(
    monkeypatch: pytest.MonkeyPatch, text: str, reason: str
) -> None:
    monkeypatch.setattr(json, "loads", lambda _: pytest.fail("it was parsed"))
    for one in (text, text.encode()):
        with pytest.raises(ValueError, match=reason):
            parse(one, MANY)


@pytest.mark.parametrize("text", ['"' + '\\"' * 400_000, '"' * 999_999, "\\" * 999_999, '"\\'], ids=len)
def test_unterminated_strings_are_refused_in_linear_time(text: str) -> None:
    """Each of 400 000 quotes would be looked at once for each quote before it."""
    with pytest.raises(ValueError, match="line 1 column"):
        parse(text)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32", "utf-8-sig"])
def test_other_encodings_than_utf_8_are_refused_because_they_would_hide_brackets(encoding: str) -> None:
    with pytest.raises(ValueError, match=r"codec|line 1 column 1"):
        parse("[]".encode(encoding))


def test_an_error_is_reported_with_its_position() -> None:
    for text in ("[1, 2", '{"a": [1}', "{"):
        with pytest.raises(ValueError, match="line 1 column"):
            parse(text)
