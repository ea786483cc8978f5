"""Scenario files with small faults: each is legal, or gives findings or errors with their places."""

from __future__ import annotations

import random
import re
from collections import Counter
from pathlib import Path

import pytest

from graphengine.experiments.case_run import run_case
from graphengine.experiments.scenario import read_scenario
from graphengine.format.diagnostics import Findings

MUTATIONS = 200
GRAPH = "graph: tick\nnodes: {OnPlaybackTick: OnPlaybackTick, Value: {type: ConstantDouble, inputs: {value: 1.0}}}\n"
VALID = """format: 1
scenario: mutated
doc: A valid scenario.
scene: tick.yaml
seed: 1
set: {Value.value: 30}
matrix: {seed: [0, 1], Value.value: [1, 2]}
runs: 2
pass: 1
requires: [python3]
transport: memory
do:
  - wait: 0.05s
  - set: {address: Value.value, value: 3}
  - parallel:
    - - wait: time > 0.02
    - - wait: 20ms
expect:
  - always: time < 9
  - never: port("OnPlaybackTick.time") > 5
  - within: 1s
    reach: time > 0.05
  - until: time > 0.1
    keep: time < 5
  - holds: time >= 0
    for: 0.05s
  - settles: time > 0.01
    after: 0.05s
  - count: time > 0.05
    at_least: 1
    at_most: 1
stop: {after: 0.2s}
"""
VALUES = (
    *(
        "null",
        "[]",
        "{}",
        "-1",
        "1e999",
        ".nan",
        "true",
        "''",
        "[[1]]",
        "{a: {b: c}}",
        "2024-01-01",
        "&a [*a]",
        "*b",
        "<<: {a: 1}",
    ),
    *(
        "!!python/object/apply:os.system ['touch written']",
        "10000000000000000000000000",
        '"\\0"',
        '"\\ud800"',
        '"\\e[31m"',
        "😀",
    ),
    *(
        "!!binary aGVsbG8=",
        "? [1, 2]",
        "- - -",
        "1" * 5000,
        "12:30:45",
        "[1, a, null, {x: .inf}]",
        "9**9**9 > time",
        "time <",
    ),
)
MARKS = ":{}[]-,#&*!|>'\"%@` \t\0\x07é"


def mutated(draw: random.Random) -> str:
    lines = VALID.splitlines()
    for _ in range(draw.choice([1, 1, 1, 2, 3])):
        at = draw.randrange(len(lines))
        line, split = lines[at], draw.randint(0, len(lines[at]))
        lines[at] = draw.choice(
            [
                "",
                f"{line}\n{line}",
                f"{line.split(':')[0]}: {draw.choice(VALUES)}",
                re.sub(r"[\w.\"()]+", lambda word: draw.choice([word[0], word[0], draw.choice(VALUES)]), line),
                line[:split] + draw.choice(MARKS) + line[split:],
                "  " * draw.randrange(4) + line.lstrip(),
                line[:split],
            ]
        )
    return "\n".join(lines) + "\n"


def outcome_of(path: Path) -> str:
    """What becomes of a file; each finding and error has its place in it."""
    findings = Findings()
    scenario = read_scenario(path, findings)
    if scenario is None:
        assert findings.errors
        assert all(f"{path.name}:" in finding.render() for finding in findings.items)
        return "finding"
    result = run_case(scenario, next(scenario.cases()))
    assert result.outcome != "error" or re.search(rf"{path.name}:\d+: ", result.report()), result.report()
    assert all(character.isprintable() or character == "\n" for character in result.report() + result.name)
    return result.outcome


@pytest.mark.timeout(300)
def test_each_mutation_is_legal_or_has_a_finding_or_an_error_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "tick.yaml").write_text(GRAPH)
    path = tmp_path / "mutated.scenario.yaml"
    path.write_text(VALID)
    assert outcome_of(path) == "passed"
    draw, outcomes = random.Random(35), Counter[str]()
    for _ in range(MUTATIONS):
        path.write_text(mutated(draw), encoding="utf-8")
        outcomes[outcome_of(path)] += 1
    assert {"finding", "error", "passed"} <= {*outcomes} <= {"finding", "error", "failed", "passed", "skipped"}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("do: [wait: null]", "6:6: error G109: do[0]: 'wait' needs a value"),
        ("expect: [{holds: time > 1, for: null}]", "6:10: error G109: expect[0]: 'holds' needs the key 'for'"),
        ("expect: [always: null]", "6:10: error G109: expect[0]: 'always' needs a value"),
    ],
)
def test_a_key_without_a_value_is_a_finding(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "empty.scenario.yaml"
    path.write_text(f"format: 1\nscenario: empty\ndoc: ''\nscene: tick.yaml\nseed: 1\n{text}\n")
    findings = Findings()
    assert read_scenario(path, findings) is None
    assert told in findings.items[0].render()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("scene: missing.yaml\n", "3: no file 'missing.yaml'"),
        ("scene: tick.yaml\nset:\n  Valu.value: 3\n", "5: Valu.value: no node 'Valu'"),
        (
            "scene: tick.yaml\nmatrix:\n  seed: [1]\n  Value.valu: [3]\n",
            "6: Value.valu: ConstantDouble has no input 'valu'",
        ),
    ],
)
def test_a_scene_that_cannot_be_loaded_is_an_error_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "tick.yaml").write_text(GRAPH)
    path = tmp_path / "wrong.scenario.yaml"
    path.write_text(f"format: 1\nscenario: wrong\n{text}expect: [always: time < 9]\n")
    scenario = read_scenario(path, Findings())
    assert scenario is not None
    result = run_case(scenario, next(scenario.cases()))
    assert (result.outcome, f"{path}:{told}" in result.report()) == ("error", True), result.report()
