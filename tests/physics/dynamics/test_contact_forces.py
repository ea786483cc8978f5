"""Contact points: where bodies touch, and the forces there."""

from __future__ import annotations

import numpy as np
import pytest

from graphengine.physics.simulation import Simulation
from tests.physics.dynamics.things import run, world
from tests.physics.harness import Project

BLOCK = '<body name="{}" pos="{} 0 {}"><freejoint/><geom type="box" size=".5 .5 .5" mass="{}"/></body>'


def carried(simulation: Simulation, name: str, by: str) -> np.ndarray:
    """Sum of the forces of one body on another."""
    contacts, names = simulation.contacts(), simulation.bodies().names
    upper, lower = names.index(name), names.index(by)
    first, second = contacts.bodies.T
    on_upper = contacts.forces[(first == lower) & (second == upper)].sum(axis=0)
    return np.asarray(on_upper - contacts.forces[(first == upper) & (second == lower)].sum(axis=0))


def test_contact_forces_carry_the_weight_of_the_bodies_above(project: Project) -> None:
    simulation = world(project, BLOCK.format("lower", 3, 0.5, 10), BLOCK.format("upper", 3, 1.5, 20)).simulation
    run(simulation, 2.0)
    assert carried(simulation, "upper", "lower") == pytest.approx([0, 0, 20 * 9.81], rel=0.01, abs=0.5)
    assert carried(simulation, "lower", "world") - carried(simulation, "lower", "upper") == pytest.approx(
        [0, 0, 2 * 20 * 9.81 + 10 * 9.81], rel=0.01, abs=0.5
    )


def test_a_normal_points_from_the_first_body_to_the_second(project: Project) -> None:
    simulation = world(project, BLOCK.format("block", 3, 0.5, 10)).simulation
    run(simulation, 1.0)
    contacts, names = simulation.contacts(), simulation.bodies().names
    own = (contacts.bodies == names.index("block")).any(axis=1)
    upwards = np.where(contacts.bodies[own, 1] == names.index("block"), 1.0, -1.0)
    assert own.sum() >= 4
    assert contacts.normals[own, 2] == pytest.approx(upwards)
    assert np.abs(contacts.points[own, 2]).max() < 0.01
    assert (contacts.points[own, 0] > 2.4).all()


def test_reading_contacts_does_not_change_the_motion(project: Project) -> None:
    watched, plain = (world(project, BLOCK.format("block", 3, 1, 10)).simulation for _ in range(2))
    for _ in range(300):
        watched.step()
        plain.step()
        watched.contacts()
    assert watched.poses().tobytes() == plain.poses().tobytes()
