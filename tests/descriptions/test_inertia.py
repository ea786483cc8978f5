"""Masses and inertias that a description lacks, or that no body has."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.inertia import LEAST_MOMENT, mended, possible
from tests.physics.harness import Project

terms = st.floats(-10, 10, allow_subnormal=False)


@given(st.lists(terms, min_size=6, max_size=6), st.sampled_from([1e-9, 1e-3, 1.0, 100.0]), st.integers(-6, 2))
@example([1.0, 1.0, 2.7e-12, 0.0, 0.0, 0.0], 1.0, 0)  # a rod: its middle moment cannot be raised
def test_any_inertia_becomes_one_that_mujoco_accepts(values: list[float], mass: float, power: int) -> None:
    xx, yy, zz, xy, xz, yz = (value * 10.0**power for value in values)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    became = mended(inertia, mass)
    assert possible(became)
    assert (became is inertia) == possible(inertia)
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="b", mass=mass, explicitinertial=True)
    body.fullinertia = [became[row, column] for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    body.add_freejoint()
    assert spec.compile().body("b").inertia.min() > 0


@given(st.lists(st.floats(0.01, 10), min_size=3, max_size=3), st.floats(0, 2 * math.pi))
def test_the_inertia_of_points_of_mass_stays_as_it_is(squares: list[float], angle: float) -> None:
    """I = sum of m (r2 - r rT): whatever the points, a body has it."""
    x, y, z = squares
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    inertia = turn @ np.diag((y + z, x + z, x + y)) @ turn.T
    assert mended(inertia, 1.0) is inertia


def test_the_rounded_inertia_of_a_thin_plate_is_kept() -> None:
    plate = np.diag((0.333333, 0.666666, 1.0))
    assert np.allclose(mended(plate, 1.0), plate, atol=2e-6)


def test_the_two_smaller_moments_are_raised_by_half_of_the_difference() -> None:
    assert np.allclose(mended(np.diag((0.3, 0.5, 1.0)), 1.0), np.diag((0.4, 0.6, 1.0)), atol=1e-6)


def test_impossible_products_of_inertia_become_zero_and_the_diagonal_stays() -> None:
    assert np.allclose(mended(np.full((3, 3), 0.001), 1.0), np.diag((0.001, 0.001, 0.001)))


def test_a_body_without_inertia_is_a_ball_of_water() -> None:
    """A ball of 1000 kg/m3 that weighs 4/3 pi kg has a radius of 0.1 m."""
    mass = 4 / 3 * math.pi
    assert np.allclose(mended(np.zeros((3, 3)), mass), np.eye(3) * 0.4 * mass * 0.01)
    assert mended(np.zeros((3, 3)), 1e-30)[0, 0] > LEAST_MOMENT


def load(project: Project, old: str, new: str) -> tuple[mujoco.MjModel, list[tuple[str, tuple[str, ...]]]]:
    world, findings = project.cart(old, new).load_with_findings()
    return world.simulation.model, [(finding.message, finding.help) for finding in findings.items]


ARM = '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'


@pytest.mark.parametrize("inertial", ["", ARM.replace('"1"', '"0"')])
def test_a_moving_link_without_mass_gets_the_mass_of_its_colliders(project: Project, inertial: str) -> None:
    """A ball of radius 0.05 m."""
    model, told = load(project, ARM, inertial)
    assert model.body("bot/arm").mass[0] == pytest.approx(1000 * 4 / 3 * math.pi * 0.05**3)
    assert told == [("moving links without a mass get the mass of their colliders at 1000 kg/m3", ("links: arm",))]


def test_a_moving_link_without_mass_and_colliders_weighs_a_gram(project: Project) -> None:
    ball = '<collision><origin xyz="0 0 .2"/><geometry><sphere radius=".05"/></geometry></collision>'
    model, told = load(project, f"{ARM}\n    {ball}", "")
    assert model.body("bot/arm").mass[0] == pytest.approx(0.001)
    assert told == [("moving links without mass and colliders get a mass of 1 g", ("links: arm",))]


def test_a_massless_link_fixed_to_a_link_with_mass_stays_massless(project: Project) -> None:
    box = '<link name="plate"><collision><geometry><box size="1 1 1"/></geometry></collision></link>'
    model, told = load(project, '<link name="plate"/>', box)
    assert model.body("bot/plate").mass[0] == 0
    assert (model.body_subtreemass[0], told) == (pytest.approx(6), [])


def test_a_replaced_inertia_is_reported(project: Project) -> None:
    _, told = load(project, 'ixx=".01" iyy=".01" izz=".01"', 'ixx=".01" iyy=".01" izz="1"')
    ((message, links),) = told
    assert message.startswith("a moment of inertia that is missing or zero, or exceeds the sum of the other two")
    assert links == ("links: arm",)


def test_a_mass_without_an_inertia_gets_the_inertia_of_a_ball(project: Project) -> None:
    model, ((message, links),) = load(project, ARM, '<inertial><mass value="1"/></inertial>')
    assert model.body("bot/arm").inertia == pytest.approx(mended(np.zeros((3, 3)), 1.0).diagonal())
    assert message.startswith("a moment of inertia that is missing")
    assert links == ("links: arm",)


@pytest.mark.parametrize("inertial", [ARM.replace('<mass value="1"/>', ""), '<inertial><mass value="0"/></inertial>'])
def test_an_inertia_without_a_mass_counts_as_no_mass(project: Project, inertial: str) -> None:
    plate = '<link name="plate"/>'
    _, told = load(project, plate, plate.replace("/>", f">{inertial}</link>"))
    assert told == []
    model, told = load(project, ARM, inertial)
    assert model.body("bot/arm").mass[0] > 0
    assert told == [("moving links without a mass get the mass of their colliders at 1000 kg/m3", ("links: arm",))]
