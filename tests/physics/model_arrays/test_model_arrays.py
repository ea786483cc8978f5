"""Each description gives the same model as before: all arrays of a URDF or MJCF bit by bit, those of an SDF up to rounding.

On a machine that rounds otherwise (`machine.probe`), arrays that depend on the machine may have rounding errors.

`python -m tests.physics.model_arrays --write` stores the arrays of a model that is meant to change.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import mujoco
import pytest

from tests.physics.model_arrays.described import Described, all_described, model_of, source_of
from tests.physics.model_arrays.figures import figures
from tests.physics.model_arrays.stored import Stored, told

STORED = Path(__file__).parent / "stored.json"
RENEW = "if this is meant to change: python -m tests.physics.model_arrays --write"
ALL = list(all_described())


@lru_cache(maxsize=1)
def stored() -> Stored:
    return Stored(STORED)


def test_the_stored_descriptions_are_these() -> None:
    assert stored().sources == {described.name: source_of(described) for described in ALL}, RENEW


@pytest.mark.parametrize("described", ALL, ids=lambda described: described.name)
def test_a_description_gives_the_same_model_as_before(tmp_path: Path, described: Described) -> None:
    if mujoco.__version__ != stored().mujoco:
        pytest.skip(f"the arrays are those of MuJoCo {stored().mujoco}")
    model = model_of(described, tmp_path)
    arrays = figures(model)
    found = stored().compare(described.name, arrays, arrays if described.format == "sdf" else stored().of_machine)
    if found:
        pytest.fail(f"{described.name}:\n{told(found, model)}\n{RENEW}", pytrace=False)
