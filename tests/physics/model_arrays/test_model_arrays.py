"""Each description gives the same model as before: all arrays of a URDF or MJCF bit by bit, those of an SDF up to rounding.

`python -m tests.physics.model_arrays --write` stores the arrays of a model that is meant to change.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import mujoco
import pytest

from tests.physics.model_arrays.described import Described, all_described, model_of, source_of
from tests.physics.model_arrays.figures import figures
from tests.physics.model_arrays.machine import probe
from tests.physics.model_arrays.stored import Stored, told

STORED = Path(__file__).parent / "stored.json"
RENEW = "if this is meant to change: python -m tests.physics.model_arrays --write"
ALL = list(all_described())


@lru_cache(maxsize=1)
def stored() -> Stored:
    return Stored(STORED)


@lru_cache(maxsize=1)
def same_machine() -> bool:
    return probe() == stored().probe


def test_the_stored_descriptions_are_these() -> None:
    assert stored().sources == {described.name: source_of(described) for described in ALL}, RENEW


@pytest.mark.parametrize("described", ALL, ids=lambda described: described.name)
def test_a_description_gives_the_same_model_as_before(tmp_path: Path, described: Described) -> None:
    if mujoco.__version__ != stored().mujoco:
        pytest.skip(f"the arrays are those of MuJoCo {stored().mujoco}")
    model = model_of(described, tmp_path)
    exact = same_machine() and described.format != "sdf"
    found = stored().compare(described.name, figures(model), exact=exact)
    assert not found, f"{described.name}:\n{told(found, model)}\n{RENEW}"
