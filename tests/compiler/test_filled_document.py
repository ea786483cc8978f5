"""Places of parameter values: a mistake is reported where the value is written, with the way to the node that uses it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.diagnostics import Finding, Findings
from tests.compiler.conftest import MakeFile
from tests.compiler.harness import resolved

INNER = """
    graph: inner
    parameters:
      speed: {type: any, default: 1.0}
      label: {type: string, default: a}
      values: {type: any, default: [1.0, 2.0]}
      often: {type: int, default: 2}
    inputs: {go: A.execIn}
    variables: {total: {type: "double[]", default: $(values)}}
    nodes:
      A: {type: Do, every: {ticks: $(often)}, inputs: {a: $(speed)}}
      B: {type: Do, inputs: {a: $(speed), b: 1.0}}
      C: {type: Do, inputs: {b: "$(label)"}}
      D: {type: Do, inputs: {b: "$(label)_1"}}
      E: {type: Do, inputs: {b: "$(label)_$(often)"}}
    connections: [A.execOut -> B.execIn, A.execOut -> C.execIn, A.execOut -> D.execIn, A.execOut -> E.execIn]
"""
MIDDLE = """
    graph: middle
    parameters:
      speed: {type: any, default: 1.0}
      values: {type: any, default: []}
      often: {type: int, default: 1}
    inputs: {go: Inner.go}
    nodes:
      Inner: {subgraph: inner.yaml, parameters: {speed: $(speed), values: $(values), often: $(often)}}
"""
OUTER = """
    graph: outer
    parameters: {fast: {type: any, default: quick}}
    nodes:
      Tick: Tick
      One: {subgraph: middle.yaml, parameters: {speed: 2.0}}
    connections: [Tick.tick -> One.go]
"""
PLAIN = "\n".join(line for line in INNER.split("\n") if "$(label)" not in line).split("    connections")[0]

Report = Callable[..., list[Finding]]


@pytest.fixture
def report(file: MakeFile) -> Report:
    """Findings of an outer graph whose subgraph has a subgraph, with a replaced use of the first one."""

    def check(given: str, inner: str = PLAIN, middle: str = MIDDLE, **bindings: Any) -> list[Finding]:
        file(inner, "inner.yaml")
        file(middle, "middle.yaml")
        findings = Findings()
        resolved(file(OUTER.replace("speed: 2.0", given), "outer.yaml"), findings, bindings)
        return findings.items

    return check


def underlined(finding: Finding) -> tuple[str, str]:
    span = finding.span
    assert span is not None
    line = span.source.lines[span.line - 1]
    return Path(span.source.path).name, line[span.column - 1 : span.column - 1 + span.length]


def ways(finding: Finding) -> list[str]:
    return [label for _, label in finding.related if not label.startswith("in subgraph")]


@pytest.mark.parametrize(
    ("given", "code", "at", "way"),
    [
        ("speed: slow", "G211", "slow", ["$(speed) to One/Inner.speed", "$(speed) to One/Inner/A.a"]),
        ("often: 0", "G109", "0", ["$(often) to One/Inner.often", "$(often) to One/Inner/A.ticks"]),
        ("values: fast", "G211", "fast", ["$(values) to One/Inner.values", "$(values) to variable One/Inner/total"]),
    ],
)
def test_a_wrong_value_is_reported_where_it_is_written_once_with_its_way_to_the_node(
    report: Report, given: str, code: str, at: str, way: list[str]
) -> None:
    (found,) = report(given)
    assert (found.code, underlined(found)) == (code, ("outer.yaml", at))
    assert ways(found) == [f"through {link}" for link in way]


def test_a_wrong_default_is_reported_at_the_default(report: Report) -> None:
    (found,) = report("speed: $(fast)")
    assert underlined(found) == ("outer.yaml", "quick")
    assert ways(found) == [
        *("through $(fast) to One.speed", "through $(speed) to One/Inner.speed", "through $(speed) to One/Inner/A.a")
    ]


def test_a_default_that_a_use_leaves_is_reported_with_the_place_of_the_use(report: Report) -> None:
    inner, middle = PLAIN.replace("[1.0, 2.0]", "many"), MIDDLE.replace("values: $(values), ", "")
    (found,) = report("speed: 2.0", inner, middle)
    assert underlined(found) == ("inner.yaml", "many")
    assert ways(found) == ["the graph is used here without values", "through $(values) to variable One/Inner/total"]


def test_a_value_that_no_file_sets_is_reported_at_the_parameter(report: Report) -> None:
    found = report("speed: $(fast)", fast="set by the engine")
    assert [underlined(one) for one in found] == [("inner.yaml", "$(speed)")] * 2


@pytest.mark.parametrize(
    ("node", "at"),
    [("C", ("middle.yaml", "x")), ("D", ("middle.yaml", "x")), ("E", ("inner.yaml", '"$(label)_$(often)"'))],
)
def test_a_text_with_one_given_parameter_has_the_position_of_the_value_and_a_text_with_two_its_own(
    report: Report, node: str, at: tuple[str, str]
) -> None:
    found = report("often: 3", INNER, MIDDLE.replace("speed: $(speed)", "label: x"))
    assert [underlined(one) for one in found if f"/{node}.b" in one.message] == [at]
