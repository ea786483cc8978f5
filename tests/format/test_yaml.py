"""YAML 1.2 core: what a plain scalar is, and what a file may not hold."""

from __future__ import annotations

import math
from typing import Any

import pytest

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document


def parse(text: str) -> tuple[Document | None, Findings]:
    findings = Findings()
    return document.parse(text, "a.yaml", findings), findings


def data(text: str) -> Any:
    found, findings = parse(text)
    assert not findings.items, [item.render() for item in findings.items]
    assert found is not None
    return found.data


def refusal(text: str) -> str:
    """The one finding as `code line:column message`."""
    _, findings = parse(text)
    (finding,) = findings.items
    assert finding.span is not None
    return f"{finding.code} {finding.span.line}:{finding.span.column} {finding.message}"


TEXTS = ["no", "on", "yes", "off", "y", "tRUE", "nuLL", "0o8", "-0o7", "0b11", "1_000", ".", "1e", "e3", "12:30:00"]
TEXTS += ["190:20:30.15", "2001-12-14", "=", "inf", "nan", "\u0661\u0662"]
"""Scalars that are texts, the last one of digits that are not ASCII."""


@pytest.mark.parametrize(
    ("scalar", "value"),
    [
        *zip(TEXTS, TEXTS, strict=True),
        ("true", True),
        ("TRUE", True),
        ("False", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("NULL", None),
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("+12", 12),
        ("-0", 0),
        ("1e3", 1000.0),
        ("1E+3", 1000.0),
        ("1.", 1.0),
        (".5", 0.5),
        ("-.5e-1", -0.05),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("'12'", "12"),
        ('"true"', "true"),
        ('"\\x41\\n"', "A\n"),
        ("|\n  1e3\n", "1e3\n"),
    ],
)
def test_plain_scalars_have_the_types_of_the_core_schema(scalar: str, value: object) -> None:
    found = data(f"a: {scalar}\n")["a"]
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("text", "merged"),
    [
        ("a: 1\nb: 2\na: 3\n", {"a": 3, "b": 2}),
        (
            "a: {x: 1, y: {p: 1}}\na: {y: {q: 2}, z: 3}\na: {y: {p: 4}}\n",
            {"a": {"x": 1, "y": {"p": 4, "q": 2}, "z": 3}},
        ),
        ("a: {x: 1}\na: 2\n", {"a": 2}),
        ("a: [1]\na: [2]\n", {"a": [2]}),
        ("a: &a {x: 1}\nb: *a\na: {x: 2}\nb: {y: 3}\n", {"a": {"x": 2}, "b": {"x": 1, "y": 3}}),
    ],
)
def test_repeated_keys_merge_in_parameter_files_of_ros(text: str, merged: object) -> None:
    findings = Findings()
    found = document.parse(text, "a.yaml", findings, merge_keys=True)
    assert not findings.items
    assert found is not None
    assert found.data == merged


def test_nan_is_read_as_nan() -> None:
    assert math.isnan(data("a: .NaN\n")["a"])


def test_numbers_that_python_cannot_hold_faithfully_are_refused() -> None:
    assert refusal("a: 1e999").startswith("G109 1:4 1e999 is too large")
    assert refusal(f"a: {'9' * 41}").startswith("G109 1:4 the whole number has more than 40")
    assert refusal(f"a: 0x{'f' * 60}").startswith("G109 1:4 the whole number has more than 40")
    assert refusal(f"a: 0o{'7' * 60}").startswith("G109 1:4 the whole number has more than 40")
    assert data(f"a: {'9' * 40}")["a"] == int("9" * 40)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a: 1\nb: 2\na: 3\n", "G103 3:1 key 'a' occurs twice"),
        ("x: [{y: {a: 1, a: 1}}]\n", "G103 1:16 key 'a' occurs twice"),
        ("x:\n  - y:\n      a: 1\n      a: 2\n", "G103 4:7 key 'a' occurs twice"),
        ("a: 1\n'a': 2\n", "G103 2:1 key 'a' occurs twice"),
        ("a: !!str 1\n", "G104 1:4 tags are not allowed: '!!str'"),
        ("a: !mine {x: 1}\n", "G104 1:4 tags are not allowed: '!mine'"),
        ("a: ! 12\n", "G104 1:4 tags are not allowed: '!'"),
        ("!!str a: 1\n", "G104 1:1 tags are not allowed: '!!str'"),
        (
            "a: !!python/object/apply:os.system [x]\n",
            "G104 1:4 tags are not allowed: '!!python/object/apply:os.system'",
        ),
        ("%TAG ! tag:example.com,2000:\n---\na: 1\n", "G104 1:1 tags and the directive %TAG are not allowed"),
        ("b: &b {x: 1}\na:\n  <<: *b\n", "G104 3:3 merge keys are not allowed"),
        ("a: 1\n---\nb: 2\n", "G104 2:1 the file contains several YAML documents"),
        ("a: 1\n...\n---\n", "G104 3:1 the file contains several YAML documents"),
        ("1: x\n", "G104 1:1 a key must be a string, but 1 is not"),
        ("true: x\n", "G104 1:1 a key must be a string, but true is not"),
        ("null: x\n", "G104 1:1 a key must be a string, but null is not"),
        ("1e3: x\n", "G104 1:1 a key must be a string, but 1e3 is not"),
        ("[a]: x\n", "G104 1:1 a key must be a string, not a list"),
        ("? {a: 1}\n: x\n", "G104 1:3 a key must be a string, not a mapping"),
        ("a: &a x\n*a : y\n", "G104 2:1 a key must be a string, not an alias"),
        ("a: *b\n", "G102 1:4 YAML syntax: no anchor 'b' precedes this alias"),
        ("a: &a [*a]\n", "G102 1:8 YAML syntax: no anchor 'a' precedes this alias"),
        ("", "G102 1:1 the file is empty"),
        ("# nothing\n# at all\n", "G102 1:1 the file is empty"),
        ("---\n", "G102 1:1 the file is empty"),
        ("a: 'x\nb: y\n", "G102 1:4 YAML syntax: found unexpected end of stream"),
        ("a:\n\tb: 1\n", "G102 2:1 YAML syntax: found character that cannot start any token"),
        ("a: x\0y\n", "G102 1:5 YAML syntax: character U+0000 is not allowed"),
        ("é: x\nb: \x1b[31m\n", "G102 2:4 YAML syntax: character U+001B is not allowed"),
        ("a: \ufeffx\n", "G102 1:4 YAML syntax: character U+FEFF is not allowed"),
        ("a: \ud800\n", "G102 1:4 YAML syntax: character U+D800 is not allowed"),
        ("a: '\x9b31m'\n", "G102 1:5 YAML syntax: character U+009B is not allowed"),
        ("%YAML 3.0\n---\na: 1\n", "G102 1:1 YAML syntax: found incompatible YAML document"),
    ],
)
def test_each_refused_construct_has_one_finding_at_its_position(text: str, told: str) -> None:
    assert refusal(text) == told


def test_every_tab_in_indentation_is_reported_with_a_remedy() -> None:
    for text in ("a:\n\tb: 1\n", "a:\tx\n\tb: 1\n", "a:\n  b: 1\n\tc: 2\n"):
        _, findings = parse(text)
        assert findings.items[0].help == ("indent with spaces, not tabs",)


def test_tabs_that_separate_are_legal() -> None:
    assert data("a:\tx\nb: [1,\t2]\t# c\n") == {"a": "x", "b": [1, 2]}


def test_unusual_but_legal_yaml_is_read() -> None:
    assert data("%YAML 1.1\n---\na: no\n...\n") == {"a": "no"}
    assert data("'1': x\n\"<<\": y\n") == {"1": "x", "<<": "y"}
    assert data("? a\n: b\n") == {"a": "b"}
    assert data("{a: 1, b: [x, {c: d}]}") == {"a": 1, "b": ["x", {"c": "d"}]}
    assert data("a: |\n  %TAG is a text here\n") == {"a": "%TAG is a text here\n"}


def test_aliases_repeat_the_value_and_its_position() -> None:
    found, findings = parse("a: &a {x: [1, 2]}\nb: *a\nc: [*a, *a]\n&k d: *a\ne: *k\n")
    assert not findings.items
    assert found is not None
    assert found.data == {"a": {"x": [1, 2]}} | {
        "b": {"x": [1, 2]},
        "c": [{"x": [1, 2]}] * 2,
        "d": {"x": [1, 2]},
        "e": "d",
    }
    assert found.data["b"] is not found.data["a"]  # so that nobody changes both
    assert found.span("b", "x", 1).line == 1
    assert found.key_span("b").line == 2


def test_a_refused_entry_is_left_out_and_reported_once() -> None:
    found, findings = parse("a: &a {x: 1}\nb: {<<: *a, y: 2}\n3: c\n")
    assert [finding.code for finding in findings.items] == ["G104", "G104"]
    assert found is not None
    assert found.data == {"a": {"x": 1}, "b": {"y": 2}}


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\x85", "\u2028"])
def test_lines_are_counted_as_the_parser_counts_them(end: str) -> None:
    _, findings = parse(end.join(["a: 1", "b: 2", "a: 3", ""]))
    assert findings.items[0].render().split("\n")[:3] == [
        "a.yaml:3:1: error G103: key 'a' occurs twice",
        "     3 | a: 3",
        "       | ^",
    ]


def test_values_and_keys_have_their_positions() -> None:
    found, _ = parse("nodes:\n  Diff: {type: x, 'inputs': [1, 22]}\n")
    assert found is not None
    places = {
        "value": found.span("nodes", "Diff", "inputs", 1),
        "key": found.key_span("nodes", "Diff"),
        "quoted key": found.key_span("nodes", "Diff", "inputs"),
        "missing: its mapping": found.span("nodes", "Diff", "doc"),
        "out of the list: the list": found.span("nodes", "Diff", "inputs", 7),
    }
    assert {what: (span.line, span.column, span.length) for what, span in places.items()} == {
        "value": (2, 33, 2),
        "key": (2, 3, 4),
        "quoted key": (2, 19, 8),
        "missing: its mapping": (2, 9, 1),
        "out of the list: the list": (2, 29, 1),
    }
