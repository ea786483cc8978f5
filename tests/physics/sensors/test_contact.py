"""What a contact sensor feels: weights, impacts, and only what touches its own body."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import ORIGIN, Vector3
from graphengine.devices.stage import Stage
from graphengine.physics.sensors.contact import BodyContactSensor
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project, ticks

G = 9.81
FACTS: dict[str, Any] = {"threshold": 0.0, "limit": 1e5, "radius": 0.0}
BALL = '<body name="it" pos="0 0 {height}"><freejoint/><geom size=".1" mass="2"/></body>'
STACK = """
  <body name="it" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/></body>
  <body name="other" pos="0 0 .3"><freejoint/><geom type="box" size=".1 .1 .1" mass="5"/></body>
"""


def sensing(
    bodies: str, body: str = "it", position: Vector3 = ORIGIN, tick_rate: int = 60, substeps: int = 4, **facts: float
) -> BodyContactSensor:
    """A sensor on a body above a floor."""
    option = f'<option integrator="discrete" timestep="{1 / tick_rate / substeps!r}"/>'
    world = f'<mujoco>{option}<worldbody><geom type="plane" size="0 0 1"/>{bodies}</worldbody></mujoco>'
    stage = Stage()
    stage.add("/it", "body", body=body)
    stage.add("/it/Sensor", "contact", position=position, facts=FACTS | facts)
    simulation = Simulation(mujoco.MjModel.from_xml_string(world), stage, Fraction(tick_rate), substeps)
    return simulation.device(BodyContactSensor, stage.find("/it/Sensor"))


def tick(sensor: BodyContactSensor, count: int = 1) -> float:
    """Run; the force after the last tick."""
    ticks(sensor._simulation, count)
    return sensor.reading().force


def test_a_contact_sensor_reads_0_in_the_air_and_the_bodys_weight_at_rest() -> None:
    sensor = sensing(BALL.format(height=0.3))
    tick(sensor)
    assert (sensor.reading().in_contact, sensor.reading().force, sensor.reading().time) == (False, 0.0, 1 / 60)
    assert tick(sensor, 120) == pytest.approx(2 * G, rel=1e-3)
    assert sensor.reading().in_contact


@pytest.mark.parametrize(("body", "weight"), [("it", 3 * G), ("other", 5 * G)])
def test_forces_from_above_and_below_are_summed_as_vectors(body: str, weight: float) -> None:
    assert tick(sensing(STACK, body), 120) == pytest.approx(weight, rel=1e-3)


@settings(max_examples=15)
@given(height=st.floats(0.11, 0.6), substeps=st.integers(1, 8))
def test_forces_add_up_to_the_momentum_of_an_impact(height: float, substeps: int) -> None:
    # What the floor gave a ball in a second is what it weighs in a second, and the change of its momentum.
    sensor = sensing(BALL.format(height=height), substeps=substeps)
    impulse = sum(tick(sensor) for _ in range(60)) / 60
    velocity = float(sensor._simulation.data.qvel[2])
    assert impulse == pytest.approx(2 * G + 2 * velocity, rel=1e-9)


def test_a_touch_that_is_over_by_the_end_of_its_tick_is_felt() -> None:
    bouncy = BALL.format(height=0.2).replace("size", 'solref="-20000 0" size')
    sensor = sensing(bouncy, tick_rate=10, substeps=100)
    tick(sensor)
    assert not sensor.reading().in_contact
    tick(sensor)
    assert sensor._simulation.data.ncon == 0
    assert sensor._simulation.data.qvel[2] > 0.0
    assert sensor.reading().in_contact


def test_graphs_of_physics_steps_get_the_force_of_each_step() -> None:
    sensor = sensing(BALL.format(height=0.1))
    forces, times = [], []
    for _ in range(4):
        sensor._simulation.step()
        forces.append(sensor.reading().force)
        times.append(sensor.reading().time)
    sensor._simulation.begin_tick(1)
    assert times == [1 / 240, 2 / 240, 3 / 240, 4 / 240]
    assert len(set(forces)) > 1
    assert sensor.reading().force == pytest.approx(sum(forces) / 4)


@pytest.mark.parametrize(("body", "weight"), [("it", 0.0), ("foot", 3 * G)])
def test_contacts_of_another_body_fixed_to_the_sensors_body_do_not_count(body: str, weight: float) -> None:
    legged = """
      <body name="it" pos="0 0 .5"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/>
        <body name="foot" pos="0 0 -.4"><geom type="box" size=".1 .1 .1" mass="2"/></body></body>
    """
    assert tick(sensing(legged, body), 60) == pytest.approx(weight, rel=1e-3)


def test_a_contact_sensor_ignores_forces_below_its_threshold_and_clips_at_its_limit() -> None:
    ball = BALL.format(height=0.1)
    deaf, dull, fine = sensing(ball, threshold=19.7), sensing(ball, limit=12.5), sensing(ball, threshold=19.5)
    assert tick(deaf, 60) == 0.0
    assert not deaf.reading().in_contact
    assert tick(dull, 60) == 12.5
    assert dull.reading().in_contact
    assert tick(fine, 60) == pytest.approx(2 * G, rel=1e-3)


def test_with_a_radius_only_contacts_near_the_sensor_are_felt() -> None:
    # Of a plank's four corners, 2 m by 1 m apart, two are within 0.6 m of the middle of a short side.
    plank = '<body name="it" pos="0 0 .05"><freejoint/><geom type="box" size="1 .5 .05" mass="2"/></body>'
    assert tick(sensing(plank, position=(1.0, 0.0, -0.05), radius=0.6), 60) == pytest.approx(G, rel=1e-3)
    assert tick(sensing(plank, position=(1.0, 0.0, -0.05), radius=0.4), 60) == 0.0
    assert tick(sensing(plank, position=(1.0, 0.0, -0.05)), 60) == pytest.approx(2 * G, rel=1e-3)


def test_a_contact_sensor_reads_zero_after_a_reset_and_then_repeats_its_readings() -> None:
    sensor = sensing(BALL.format(height=0.1))
    first = [tick(sensor) for _ in range(5)]
    sensor._simulation.reset()
    assert sensor.reading().force == 0.0
    assert [tick(sensor) for _ in range(5)] == first


def test_a_sensor_of_a_robot_file_feels_its_link(project: Project) -> None:
    simulation = project.robot("sensors:\n  bumper: {type: contact, parent: base_link}").load().simulation
    sensor = simulation.device(BodyContactSensor, simulation.stage.find("/bot/base_link/bumper"))
    assert not sensor.reading().in_contact
    assert tick(sensor, 120) == pytest.approx(6 * G, rel=0.02)
