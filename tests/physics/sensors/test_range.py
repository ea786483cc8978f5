"""What a range sensor measures. Distances are compared with geometry, not with rays."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.devices.stage import Stage
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.physics.sensors.range import RayCone
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project
from tests.physics.ray_casting.casters import either_rays

HALF = math.radians(15.0)
FACTS = {"radiation_type": "ultrasound", "rate": 20.0, "field_of_view": 2 * HALF, "rings": 4, "ranges": (0.1, 4.0)}
SONAR = "robot: bot\nurdf: bot.urdf\nsensors:\n  eye: {type: range, profile: PROFILE, parent: base_link}\n"


def looking_at(geoms: str, rays: RaysChoice = "auto", seed: int = 0, path: str = "/Range", **facts: object) -> RayCone:
    """A sensor at the origin that looks along x."""
    stage = Stage()
    prim = stage.add(path, "range", facts=FACTS | {"noise_std": 0.0} | facts)
    model = mujoco.MjModel.from_xml_string(f'<mujoco><compiler angle="radian"/><worldbody>{geoms}</worldbody></mujoco>')
    simulation = Simulation(model, stage, Fraction(60), 1, seed=seed, rays=rays)
    simulation.begin_tick(1)
    return simulation.device(RayCone, prim)


def wall(distance: float, yaw: float = 0.0, pitch: float = 0.0) -> str:
    """A wall whose front, turned about the point where the axis meets it, is that far away."""
    return f'<body pos="{distance} 0 0" euler="0 {pitch} {yaw}"><geom type="box" size=".05 9 9" pos=".05 0 0"/></body>'


@either_rays
@pytest.mark.parametrize("distance", [0.101, 0.5, 2.0, 3.999])
def test_the_range_of_a_wall_ahead_is_its_distance(rays: RaysChoice, distance: float) -> None:
    reading = looking_at(wall(distance), rays).reading()
    assert (reading.time, reading.index) == (1 / 60, 0)
    assert reading.range == pytest.approx(distance, abs=1e-6)


@pytest.mark.parametrize(("distance", "range_"), [(4.001, math.inf), (0.099, -math.inf)])
def test_out_of_range_is_infinity_as_in_rep_117(distance: float, range_: float) -> None:
    noisy = looking_at(wall(distance), noise_std=0.5)
    assert noisy.reading().range == range_
    assert looking_at("").reading().range == math.inf


@either_rays
@pytest.mark.parametrize("turn", [{"yaw": 0.6}, {"yaw": -0.6}, {"pitch": 0.6}, {"pitch": -0.6}])
def test_a_tilted_wall_is_measured_where_the_edge_of_the_cone_meets_it(
    rays: RaysChoice, turn: dict[str, float]
) -> None:
    nearest = 2.0 * math.cos(0.6) / math.cos(0.6 - HALF)
    assert looking_at(wall(2.0, **turn), rays).reading().range == pytest.approx(nearest, abs=1e-6)


def test_a_wall_that_is_tilted_by_less_than_the_cone_is_as_far_as_its_perpendicular() -> None:
    tilt, between = 0.6 * HALF, HALF / 4
    found = looking_at(wall(2.0, yaw=tilt)).reading().range
    assert 2.0 * math.cos(tilt) <= found <= 2.0 * math.cos(tilt) / math.cos(between / 2)


@either_rays
@pytest.mark.parametrize("axis", ["y", "z"])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("outside", "seen"), [(-0.002, True), (0.002, False)])
def test_the_cone_ends_at_its_edge(rays: RaysChoice, axis: str, side: int, outside: float, seen: bool) -> None:
    begin = side * (math.tan(HALF + outside) + 1.0)  # of a plate at x = 1, from the edge of the cone outwards
    place = f"1.0005 {begin} 0" if axis == "y" else f"1.0005 0 {begin}"
    size = ".0005 1 9" if axis == "y" else ".0005 9 1"
    found = looking_at(f'<geom type="box" size="{size}" pos="{place}"/>', rays).reading().range
    assert found == pytest.approx(1 / math.cos(HALF), abs=1e-6) if seen else found == math.inf


def test_rays_lie_in_rings_about_the_axis_up_to_the_edge() -> None:
    sensor = looking_at("", rings=2)
    away = np.arccos(np.clip(sensor.directions[:, 0], -1, 1))
    np.testing.assert_allclose(away, [0.0] + [HALF / 2] * 6 + [HALF] * 12, atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(sensor.directions, axis=1), 1.0)
    assert len(np.unique(sensor.directions.round(9), axis=0)) == 19


def test_noise_depends_on_seed_prim_and_sample_and_on_nothing_else() -> None:
    def found(seed: int, ticks: list[int], path: str = "/Range") -> dict[int, float]:
        sensor = looking_at(wall(2.0), seed=seed, path=path, noise_std=0.01)
        readings = {}
        for tick in ticks:
            sensor._simulation.begin_tick(tick)
            readings[tick] = sensor.reading().range
        return readings

    every = found(7, [1, 3, 6, 9])
    assert found(7, [9])[9] == every[9]  # whether the earlier ones were cast or not
    assert len(set(every.values())) == 4
    assert found(8, [9])[9] != every[9]
    assert found(7, [9], "/Other")[9] != every[9]


def test_noise_has_the_standard_deviation_it_is_given() -> None:
    sensor, errors = looking_at(wall(2.0), noise_std=0.02, rate=60.0), []
    for tick in range(1, 1001):
        sensor._simulation.begin_tick(tick)
        errors.append(sensor.reading().range - 2.0)
    assert np.std(errors) == pytest.approx(0.02, rel=0.1)
    assert np.mean(errors) == pytest.approx(0.0, abs=0.002)


def test_a_distance_is_rounded_to_the_nearest_multiple_of_the_resolution() -> None:
    assert looking_at(wall(2.1), resolution=0.25).reading().range == 2.0
    assert looking_at(wall(2.2), resolution=0.25).reading().range == 2.25


@either_rays
def test_rays_pass_through_the_sensors_own_robot(project: Project, rays: RaysChoice) -> None:
    project.write("world.xml", f"<mujoco><worldbody>{wall(1.5)}</worldbody></mujoco>")
    world = project.write("bot.yaml", SONAR.replace("PROFILE", "hc_sr04")).load()
    simulation = Simulation(world.simulation.model, world.stage, Fraction(60), 4, rays=rays)
    simulation.begin_tick(1)
    reading = simulation.device(RayCone, world.stage.find("/bot/base_link/eye")).reading()
    assert reading.range == pytest.approx(1.5, abs=5 * 0.003)  # the base link reaches from -0.2 to 0.2 m


def test_the_hc_sr04_has_the_figures_of_its_data_sheet(project: Project) -> None:
    world = project.write("bot.yaml", SONAR.replace("PROFILE", "hc_sr04")).load()
    sensor = world.simulation.device(RayCone, world.stage.find("/bot/base_link/eye"))
    assert (sensor.ranges, sensor.radiation_type) == ((0.02, 4.0), "ultrasound")
    assert math.degrees(sensor.field_of_view) == pytest.approx(15.0, abs=0.01)
    assert 1 / sensor.rate >= 0.060


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ("min_range: 5", "range: min_range must be less than max_range, but 5 is not less than 4"),
        ("resolution: 4", "range: resolution must be 0, or at least one micrometre and less than max_range"),
        ("field_of_view: 4", "field_of_view: expected a value ≤ 3.14159, got 4"),
        ("rings: 0", "rings: expected a value ≥ 1, got 0"),
        ("radiation_type: sonar", "radiation_type: expected 'ultrasound' or 'infrared', got 'sonar'"),
    ],
)
def test_a_bad_profile_is_an_error_at_its_place(project: Project, entry: str, error: str) -> None:
    given = {"rate": "10", "field_of_view": "0.5", "min_range": "0.1", "max_range": "4"}
    name, _, value = entry.partition(": ")
    section = ", ".join(f"{key}: {number}" for key, number in (given | {name: value}).items())
    project.write("sensors/bad.yaml", f"format: 1\nsensor: bad\nrange: {{{section}}}\n")
    assert error in project.write("bot.yaml", SONAR.replace("PROFILE", "bad")).error()


def test_a_robot_file_can_give_a_range_sensor_its_noise(project: Project) -> None:
    text = SONAR.replace("PROFILE,", "hc_sr04, noise_std: 0.1,")
    assert project.write("bot.yaml", text).load().stage.find("/bot/base_link/eye").facts["noise_std"] == 0.1
