"""Forces that act on robots and objects from outside for a while."""

from __future__ import annotations

import math
from fractions import Fraction

import mujoco
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.rotation import Vector3
from graphengine.devices.stage import Stage
from graphengine.format.errors import UsageError
from graphengine.physics.simulation import Simulation
from tests.physics.dynamics.things import BALL, SHELF, SPACE, add, run, world
from tests.physics.harness import Project


@given(duration=st.floats(1e-4, 0.5), force=st.tuples(*[st.floats(-100, 100)] * 3))
def test_the_impulse_of_a_push_is_force_times_duration(duration: float, force: Vector3) -> None:
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{SPACE}<worldbody>{BALL}</worldbody></mujoco>")
    stage = Stage()
    stage.add("/World/ball", "body", body="ball")
    simulation = Simulation(model, stage, Fraction(1, 1) / Fraction(repr(model.opt.timestep)), 1)
    simulation.entities.push("ball", force, duration)
    run(simulation, duration + 0.02)
    state = simulation.entities.state("ball")
    assert state.linear_velocity == pytest.approx([f * duration / 2.0 for f in force], rel=1e-9, abs=1e-9)
    assert state.angular_velocity == pytest.approx((0, 0, 0), abs=1e-12)


def test_pushes_add_up_and_a_push_beside_the_centre_of_mass_turns_the_body(project: Project) -> None:
    simulation = world(project, BALL, options=SPACE).simulation
    simulation.entities.push("ball", (4, 0, 0), 0.1, (5, 0.1, 1))
    simulation.entities.push("ball", (0, 2, 0), 0.1)
    run(simulation, 1 / 240)
    inertia = 0.4 * 2.0 * 0.1**2
    assert simulation.entities.state("ball").angular_velocity == pytest.approx((0, 0, -0.4 / 240 / inertia))
    assert simulation.entities.state("ball").linear_acceleration == pytest.approx((2, 1, 0), rel=1e-3)
    run(simulation, 0.2)
    assert simulation.entities.state("ball").linear_velocity == pytest.approx((0.2, 0.1, 0))
    assert not simulation.data.xfrc_applied.any()


def test_a_push_wakes_a_sleeping_body_and_transfers_its_whole_impulse(project: Project) -> None:
    ice = '<body name="puck" pos="5 0 .05"><freejoint/><geom type="box" size=".1 .1 .05" mass="2" friction="0 0 0"/></body>'
    simulation = world(project, ice, options='<option><flag sleep="enable"/></option>').simulation
    for geom in range(simulation.model.ngeom):
        simulation.model.geom_friction[geom, 0] = 1e-5
    run(simulation, 2.0)
    assert (simulation.data.tree_asleep >= 0).any()
    simulation.entities.push("puck", (6, 0, 0), 0.5)
    run(simulation, 0.5)
    assert simulation.entities.state("puck").linear_velocity[0] == pytest.approx(1.5, rel=1e-3)


def test_a_push_goes_on_when_others_come_and_go_and_ends_with_its_entity(project: Project) -> None:
    loaded = world(project, BALL, options=SPACE)
    simulation = loaded.simulation
    add(loaded, "late")
    simulation.entities.push("ball", (4, 0, 0), 0.5)
    simulation.entities.push("late", (4, 0, 0), 0.5)
    run(simulation, 0.25)
    loaded.remove("late")
    run(simulation, 0.5)
    assert simulation.entities.state("ball").linear_velocity == pytest.approx((1, 0, 0))
    assert not simulation.data.xfrc_applied.any()


@pytest.mark.parametrize(
    ("name", "force", "duration", "point", "words"),
    [
        ("ball", (math.nan, 0, 0), 1.0, None, "invalid force nan"),
        ("ball", (1e9, 0, 0), 1.0, None, "invalid force 1e.09"),
        ("ball", (1, 0, 0), 0.0, None, "must be greater than 0 s"),
        ("ball", (1, 0, 0), math.inf, None, "invalid duration inf"),
        ("ball", (1, 0, 0), 1.0, (0, 0, math.nan), "invalid point nan"),
        ("shelf", (1, 0, 0), 1.0, None, "fixed to the world"),
    ],
)
def test_a_push_that_cannot_be_is_refused(
    project: Project, name: str, force: Vector3, duration: float, point: Vector3 | None, words: str
) -> None:
    simulation = world(project, BALL, SHELF).simulation
    with pytest.raises(UsageError, match=words):
        simulation.entities.push(name, force, duration, point)
    assert not simulation.data.xfrc_applied.any()
