"""Values that make no sense are told in words and at the place of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.nodes.data.construction import ARRAY_TYPES
from graphengine.scene import build

ONE_TYPE = ": a variable has a single type, such as double or token, got"
TICK = "graph: g\nnodes:\n  Tick: OnPlaybackTick\n"


def first(folder: Path, text: str) -> tuple[str, str, tuple[str, ...]]:
    """Message, marked text and help of the only error."""
    path = folder / "a.yaml"
    path.write_text(text)
    assembly = build.load(path)
    (finding,) = assembly.findings.errors
    assert finding.span is not None
    line, column = text.split("\n")[finding.span.line - 1], finding.span.column - 1
    return finding.message, line[column : column + finding.span.length], finding.help


@pytest.mark.parametrize(
    ("variable", "message", "marked"),
    [
        ("{type: uint, default: -1}", " is a uint: expected a value from 0 to 4294967295, got -1", "-1"),
        ("{type: 'double[3]', default: [1, 2]}", " is a double[3]: expected 3 values, got 2", "["),
        ("{type: token, default: 3}", " is a token: expected text, got 3", "3"),
        ("{type: double, default: fast}", " is a double: expected a number, got 'fast'", "fast"),
        ("{type: duble}", ": 'duble' is not a port type", "duble"),
        ("{type: execution}", f"{ONE_TYPE} execution", "execution"),
        ("{type: any, default: 1}", f"{ONE_TYPE} any", "any"),
        ("{type: bundle}", f"{ONE_TYPE} bundle", "bundle"),
        ("{type: int|double}", f"{ONE_TYPE} int | double", "int|double"),
    ],
)
def test_illegal_variables_are_reported(variable: str, message: str, marked: str, tmp_path: Path) -> None:
    assert first(tmp_path, f"graph: g\nvariables:\n  v: {variable}\n")[:2] == (f"variable 'v'{message}", marked)


@pytest.mark.parametrize(
    ("value", "message", "marked"),
    [
        ("{type: uint64, value: -5}", "A.a: expected a value from 0 to 18446744073709551615, got -5", "-5"),
        ("{type: double, value: fast}", "A.a is a double: expected a number, got 'fast'", "fast"),
        ("{type: dubble, value: 1}", "A.a: 'dubble' is not a port type", "dubble"),
        (
            "{type: token, value: a}",
            "A.a: expected one of int | int64 | uint64 | uint | uchar | double | float | half | ",
            "token",
        ),
    ],
)
def test_illegal_typed_values_are_reported(value: str, message: str, marked: str, tmp_path: Path) -> None:
    text = f"{TICK}  A: {{type: Add, inputs: {{b: 1, a: {value}}}}}\n"
    said, shown, _ = first(tmp_path, text)
    assert (said[: len(message)], shown) == (message, marked)
    assert "a mapping" not in said


def test_a_value_of_a_wired_input_is_reported_at_the_value(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    node = "  A: {type: ROS2PublishClock, inputs: {inputs:timeStamp: 1.0}}\n"
    path.write_text(f"{TICK}{node}connections: [Tick.tick -> A.execIn, Tick.time -> A.timeStamp]\n")
    (finding,) = build.load(path).findings.warnings
    assert finding.span is not None
    assert (finding.code, finding.span.column, finding.span.length) == ("W103", 40, len("inputs:timeStamp"))


def test_of_many_legal_texts_only_some_are_listed(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(f"{TICK}  Make: {{type: ConstructArray, inputs: {{arrayType: 'doubl[]', input0: 1}}}}\n")
    (finding,) = build.load(path).findings.errors
    assert finding.help == ("did you mean 'double[]'?",)
    assert finding.message.startswith("Make.arrayType: expected one of auto, bool[], double[], ")
    assert finding.message.endswith(f", … ({len(ARRAY_TYPES) - 20} more), got 'doubl[]'")
