"""What Isaac Sim's own tests assert about these nodes, and what follows from its formulae: case by case, from cases.json.

A case either runs or differs, in a function of `isaac/`; what differs, and why, is in isaac_differs.yaml. Where a case drives
physics, it runs in MuJoCo.
"""

from __future__ import annotations

import importlib
from typing import Any

import pytest

from tests.nodes.harness import HERE, Player
from tests.nodes.isaac.book import CASES, DIFFERS, OURS, RUN

for family in sorted((HERE / "isaac").glob("*.py")):
    importlib.import_module(f"tests.nodes.isaac.{family.stem}")  # which registers its cases


def test_every_case_is_either_supported_or_listed_as_different() -> None:
    assert set(RUN) | set(OURS) == set(CASES)
    assert set(RUN) & set(OURS) == set()


def test_every_case_that_differs_has_a_value_and_a_reason() -> None:
    assert set(DIFFERS) == set(OURS)
    assert all(set(entry) == {"node", "case", "our_value", "reason"} for entry in DIFFERS.values())


@pytest.mark.parametrize("name", RUN)
def test_a_supported_case_has_isaac_sims_values(play: Player, name: str) -> None:
    RUN[name](CASES[name], play)


def near(value: Any, expected: Any) -> bool:
    """Equal, floats to 1e-9."""
    if isinstance(expected, dict):
        return set(value) == set(expected) and all(near(value[key], expected[key]) for key in expected)
    if isinstance(expected, list):
        return len(value) == len(expected) and all(near(*pair) for pair in zip(value, expected, strict=True))
    return bool(value == (pytest.approx(expected, rel=0.0, abs=1e-9) if isinstance(expected, float) else expected))


@pytest.mark.parametrize("name", OURS)
def test_a_case_listed_as_different_has_the_listed_value(play: Player, name: str) -> None:
    value = OURS[name](CASES[name], play)
    assert near(value, DIFFERS[name]["our_value"]), value
