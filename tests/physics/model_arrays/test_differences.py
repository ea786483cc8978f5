"""Differences between arrays: last bits, rounding errors, and inertias with their axes in another order."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.physics.model_arrays.differences import differences
from tests.physics.model_arrays.figures import Array, digests, figures
from tests.physics.model_arrays.stored import Figures, Stored, told, write

MODEL = """<mujoco><worldbody><body name="top"><joint name="turn" axis="0 1 0"/><geom name="ball" size="0.1"/>
<body name="tip" pos="0.3 0 0"><inertial pos="0 0 0" mass="2" diaginertia="0.1 0.2 0.25"/></body></body></worldbody></mujoco>"""


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(MODEL)


def lines(model: mujoco.MjModel, before: dict[str, Array], *, exact: bool) -> list[str]:
    """The differences of a model from earlier arrays, as text."""
    now = figures(model)
    old, new = digests(before), digests(now)
    changed = [name for name in now if old[name] != new[name]]
    flat = {name: array.ravel() for name, array in before.items()}
    return [each.told(model) for each in differences(flat, now, changed, () if exact else now)]


def test_a_last_bit_is_a_difference_with_its_place_and_its_owner(model: mujoco.MjModel) -> None:
    before = figures(model)
    model.body_pos[2, 0] = math.nextafter(0.3, 1.0)
    place = (
        "body_pos[2, 0] (body tip): stored 0.3, now 0.30000000000000004; 1 of its elements differ, by up to 5.55e-17"
    )
    assert lines(model, before, exact=True) == [place]
    assert lines(model, before, exact=False) == []
    model.body_pos[2, 0] = 0.3 + 1e-11
    assert len(lines(model, before, exact=False)) == 1


def test_a_zero_of_another_sign_is_a_difference(model: mujoco.MjModel) -> None:
    before = figures(model)
    model.dof_armature[0] = -0.0
    (line,) = lines(model, before, exact=True)
    assert line.startswith("dof_armature[0] (jnt turn): stored 0.0, now -0.0")
    assert lines(model, before, exact=False) == []


def test_equal_tensors_with_axes_in_another_order_are_equal_up_to_rounding(model: mujoco.MjModel) -> None:
    before = figures(model)
    model.body_inertia[2] = 0.2, 0.1, 0.25
    model.body_iquat[2] = math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)  # a quarter turn about z exchanges x and y
    assert {line.partition("[")[0] for line in lines(model, before, exact=True)} == {"body_inertia", "body_iquat"}
    assert lines(model, before, exact=False) == []
    model.body_inertia[2, 0] += 1e-9
    (line,) = lines(model, before, exact=False)
    assert line.startswith("inertia tensor of body[2, ")


def test_a_quaternion_of_the_other_sign_is_the_same_rotation(model: mujoco.MjModel) -> None:
    before = figures(model)
    model.geom_quat[0] *= -1
    assert len(lines(model, before, exact=True)) == 1
    assert lines(model, before, exact=False) == []


def test_stored_arrays_are_read_back_and_large_ones_only_as_digests(tmp_path: Path, model: mujoco.MjModel) -> None:
    arrays = figures(model)
    larger = {**arrays, "mesh_vert": np.zeros((50, 3), np.float32)}
    write(tmp_path / "s.json", {"one": Figures("a", arrays), "two": Figures("b", larger)}, largest=120)
    stored = Stored(tmp_path / "s.json")
    assert stored.sources == {"one": "a", "two": "b"}
    assert stored.compare("one", arrays) == stored.compare("two", larger) == []
    assert stored.array("two", "mesh_vert") is None
    assert stored.array("two", "body_pos") == pytest.approx(arrays["body_pos"].ravel())
    changed = {**larger, "mesh_vert": np.ones((50, 3), np.float32), "body_pos": arrays["body_pos"][:2]}
    del changed["nq"]
    assert told(stored.compare("two", changed), model).splitlines() == [
        "body_pos: 9 elements of type float64 are stored, now it has the shape (2, 3) of type float64",
        "mesh_vert: its digest differs, and its elements are not stored",
        "nq: is missing",
    ]
