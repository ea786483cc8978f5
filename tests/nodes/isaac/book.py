"""Which case is held by which function: `@runs` asserts what a case expects, `@differs` gives our value."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import yaml

from graphengine.node import Node
from tests.nodes.harness import HERE, Player, facts

Case = dict[str, Any]
N = TypeVar("N", bound=Node)
Runs = Callable[[Case, Player], None]
Differs = Callable[[Case, Player], Any]


def by_name(entries: list[Case]) -> dict[str, Case]:
    """Cases by `node: case`."""
    named = {f"{entry['node']}: {entry['case']}": entry for entry in entries}
    assert len(named) == len(entries)
    return named


CASES = by_name(facts("cases.json")["cases"])
DIFFERS = by_name(yaml.safe_load((HERE.parent / "isaac_differs.yaml").read_text("utf-8")))
RUN: dict[str, Runs] = {}
OURS: dict[str, Differs] = {}


def runs(node: str, *cases: str) -> Callable[[Runs], Runs]:
    """The function asserts what these cases expect."""

    def register(function: Runs) -> Runs:
        for case in cases:
            assert f"{node}: {case}" not in RUN
            RUN[f"{node}: {case}"] = function
        return function

    return register


def differs(node: str, case: str) -> Callable[[Differs], Differs]:
    """The function gives our value of a case that differs on purpose."""

    def register(function: Differs) -> Differs:
        assert f"{node}: {case}" not in OURS
        OURS[f"{node}: {case}"] = function
        return function

    return register


def made(cls: type[N], case: Case, /, **others: Any) -> N:
    """A node with the inputs that a case names, and others by their Python names."""
    inputs = [port for port in cls.fields.values() if port.side == "inputs" and port.name in case["inputs"]]
    return cls(**{port.field: case["inputs"][port.name] for port in inputs} | others)


def at(numbers: Any) -> tuple[float, float, float]:
    """A position of a case, as floats."""
    x, y, z = map(float, numbers)
    return x, y, z
