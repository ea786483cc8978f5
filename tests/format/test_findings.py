"""Findings: their order, their text, their records, and the names that are suggested."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from graphengine.format.diagnostics import CODES, CheckError, Finding, Findings, Source, Span, to_json
from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.scene import build

CASES = Path(__file__).parent / "cases"

NUMBER = {"type": ["integer", "null"], "minimum": 1}
PLACE: dict[str, Any] = {"path": {"type": ["string", "null"]}, "line": NUMBER, "column": NUMBER, "length": NUMBER}
RECORD: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "array",
    "items": {
        "type": "object",
        "properties": {
            "code": {"enum": sorted(CODES)},
            "title": {"enum": sorted(CODES.values())},
            "severity": {"enum": ["error", "warning", "note"]},
            "message": {"type": "string", "minLength": 1},
            "help": {"type": "array", "items": {"type": "string", "minLength": 1}},
            "related": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {**PLACE, "message": {"type": "string", "minLength": 1}},
                    "required": [*PLACE, "message"],
                    "additionalProperties": False,
                },
            },
            **PLACE,
        },
        "required": ["code", "title", "severity", "message", "help", "related", *PLACE],
        "additionalProperties": False,
    },
}


def span(line: int, column: int = 1, length: int = 1, *, text: str = "abc", path: str = "a.yaml") -> Span:
    return Span(Source(path, (text,) * line), line, column, length)


# Records


@pytest.mark.parametrize("path", sorted(CASES.glob("*.yaml")), ids=lambda path: path.stem)
def test_records_have_the_promised_shape(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(CASES)
    assembly = build.load(Path(path.name))
    records = json.loads(to_json(assembly.findings.sorted()))
    jsonschema.Draft202012Validator(RECORD).validate(records)
    assert records
    for record in records:
        assert record["title"] == CODES[record["code"]]


def test_a_record_contains_all_fields() -> None:
    finding = Finding("G103", "twice", span(2, 3, 4), ("remove one",), ((span(1, path="b.yaml"), "first here"),))
    assert finding.record() == {
        "code": "G103",
        "title": "duplicate key",
        "severity": "error",
        "message": "twice",
        "path": "a.yaml",
        "line": 2,
        "column": 3,
        "length": 4,
        "help": ["remove one"],
        "related": [{"path": "b.yaml", "line": 1, "column": 1, "length": 1, "message": "first here"}],
    }
    nowhere = Finding("N102", "not checked").record()
    assert (nowhere["path"], nowhere["line"], nowhere["severity"]) == (None, None, "note")


def test_titles_and_codes_are_in_order_and_unique() -> None:
    assert len(set(CODES.values())) == len(CODES)
    assert all(code[0] in "GSWN" and code[1:].isdigit() and len(code) == 4 for code in CODES)
    assert list(CODES) == sorted(CODES, key=lambda code: ("GSWN".index(code[0]), code))


def test_severity_follows_from_the_code() -> None:
    severities = {code[0]: Finding(code, "x").severity for code in CODES}
    assert severities == {"G": "error", "S": "error", "W": "warning", "N": "note"}


# Order


def test_findings_are_sorted_by_file_and_position() -> None:
    findings = Findings()
    findings.add("G106", "third", span(2, 1))
    findings.add("G106", "fourth", span(1, 1, path="b.yaml"))
    findings.add("G106", "second", span(1, 9))
    findings.add("G103", "first", span(1, 9))
    findings.add("N102", "last")
    assert [finding.message for finding in findings.sorted()] == ["first", "second", "third", "fourth", "last"]


def test_equal_findings_are_kept_once() -> None:
    findings = Findings()
    for text in ("a", "b"):  # the same file read twice has other lines
        findings.add("G106", "x", span(1, text=text), "help", related=[(span(2), "y")])
    findings.add("G106", "x", span(1), "other help")
    findings.add("G106", "x", span(2))
    findings.add("G106", "x")
    assert len(findings.items) == 4


def test_only_errors_are_raised() -> None:
    findings = Findings()
    findings.add("W101", "never runs", span(1))
    findings.raise_errors()
    findings.add("G101", "gone", span(1))
    with pytest.raises(CheckError, match="error G101: gone") as raised:
        findings.raise_errors()
    assert len(raised.value.findings) == 2


# Text


def test_empty_help_is_dropped() -> None:
    findings = Findings()
    findings.add("G106", "x", None, "", "did you mean 'y'?", "")
    assert findings.items[0].render() == "error G106: x\n  did you mean 'y'?"


def test_carets_mark_the_reported_text() -> None:
    for text, column, length, under in [
        ("key: value", 6, 5, "value"),
        ("\tkey: value", 7, 5, "value"),
        ("名前: value", 5, 5, "value"),
        ("x: 名前", 4, 2, "名前"),
        ("é: value", 4, 5, "value"),  # a combining accent
        ("🤖: value", 4, 5, "value"),
        ("key: value", 6, 99, "value"),
    ]:
        line, caret = Finding("G106", "x", span(1, column, length, text=text)).render().split("\n")[1:]
        first = caret.index("^")
        columns = ""
        for character in line:
            width = {"́": 0, "名": 2, "前": 2, "🤖": 2}.get(character, 1)
            columns += character * width
        assert columns[first : first + caret.count("^")] == "".join(c * (2 if c in "名前" else 1) for c in under)


def test_a_caret_can_be_behind_the_last_character() -> None:
    assert Finding("G102", "x", span(1, 4, text="abc")).render().split("\n")[2] == "       |    ^"
    assert Finding("G102", "x", span(1, 1, text="")).render().split("\n")[2] == "       | ^"
    assert Finding("G102", "x", span(1, 1 << 31, text="abc")).render().split("\n")[2] == "       |    ^"


def test_a_position_without_its_line_has_no_excerpt() -> None:
    assert Finding("G101", "x", Span(Source("a.yaml", ()), 1, 1)).render() == "a.yaml:1:1: error G101: x"


def test_unprintable_characters_are_replaced() -> None:
    hostile = "\x1b[31m\x07\u202e\x9b"
    text = Finding("G106", hostile, span(1, text=hostile, path=hostile), (hostile,), ((span(1), hostile),)).render()
    assert all(character.isprintable() or character == "\n" for character in text)


def test_further_lines_of_a_message_are_indented() -> None:
    assert Finding("G307", "first\nsecond", None, ("help",)).render() == "error G307: first\n  second\n  help"


# Suggestions


@pytest.mark.parametrize(
    ("name", "legal", "said"),
    [
        ("whel", ["wheel", "arm"], "'wheel'"),
        ("WHEEL", ["wheel", "arm"], "'wheel'"),
        ("left_wheel", ["left_wheel_joint", "right_wheel_joint"], "'left_wheel_joint'"),
        ("wheel_joint", ["left_wheel_joint", "lift_wheel_joint"], "'left_wheel_joint' or 'lift_wheel_joint'"),
        ("zzz", ["wheel", "arm"], ""),
        ("", ["wheel"], ""),
        ("wheel", [], ""),
        ("nope.yaml", ["demo.yaml", "hope.yaml"], "'hope.yaml'"),
        ("/robot_0000/odom", ["/robot_0000/scan", "/robot_0000/tf"], ""),
        ("/robot_0000/odm", ["/robot_0000/scan", "/robot_0000/odom"], "'/robot_0000/odom'"),
        ("/robot/scan", ["/scan"], "'/scan'"),
        ("/rbot/scan", ["/robot/scan", "/robot/odom"], "'/robot/scan'"),
        ("x" * 100_000, ["wheel"], ""),
        ("griper", [*(f"wheel_{i}" for i in range(20_000)), "gripper"], "'gripper'"),
        ("wheel_x7_front", [*(f"wheel_{i:05}_rear" for i in range(20_000)), "wheel_x_front"], "'wheel_x_front'"),
    ],
)
def test_similar_names_are_found(name: str, legal: list[str], said: str) -> None:
    assert did_you_mean(name, legal) == (f"did you mean {said}?" if said else "")


def test_listings_end_after_twenty() -> None:
    assert listing(["a", "b"], "keys") == "keys: a, b"
    assert listing([]) == "legal: none"
    assert listing(map(str, range(20)), "joints").endswith("18, 19")
    assert listing(map(str, range(22)), "joints").endswith("18, 19, … (2 more)")


def test_values_are_shown_in_a_short_form() -> None:
    values = [True, None, {"a": 1}, [1], 1.5, "text", "x" * 100]
    told = ["true", "nothing", "a mapping", "a list", "1.5", "'text'", f"'{'x' * 56}..."]
    assert list(map(shown, values)) == told
