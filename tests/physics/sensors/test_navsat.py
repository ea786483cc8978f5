"""What a navsat receiver measures, from the scene's place on Earth to its noise and its outages."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from graphengine.descriptions.earth import EARTH
from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.stage import Stage
from graphengine.physics.sensors.geodesy import TangentPlane
from graphengine.physics.sensors.navsat import NavSatProfile, NavSatReceiver
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project, ticks

ZURICH = (47.38, 8.54, 408.0, 30.0)
PLACE = "spherical_coordinates: {latitude_deg: 47.38, longitude_deg: 8.54, elevation: 408, heading_deg: 30}\n"
GPS = "robot: bot\nurdf: bot.urdf\nsensors:\n  gps: {type: navsat, parent: base_link, position: [0.3, 0, 0.2]}\n"
METRE = 1 / 111_000
"""About a degree of latitude per metre."""


def receiver(seed: int = 0, path: str = "/Gps", **figures: object) -> NavSatReceiver:
    """A receiver 10 m along x from the origin of a world in Zürich."""
    stage = Stage()
    facts = NavSatProfile.model_validate({"rate": 60.0, **figures}).facts()
    prim = stage.add(path, "navsat", position=(10.0, 0.0, 0.0), facts=facts)
    numbers = " ".join(map(str, ZURICH))
    text = f'<mujoco><custom><numeric name="{EARTH}" data="{numbers}"/></custom></mujoco>'
    simulation = Simulation(mujoco.MjModel.from_xml_string(text), stage, Fraction(60), 1, seed=seed)
    simulation.begin_tick(1)
    return simulation.device(NavSatReceiver, prim)


def errors(sensor: NavSatReceiver, count: int) -> Floats:
    """Errors to the north, to the east and upwards of successive samples, m."""
    true = np.array(TangentPlane(*ZURICH).geodetic((10.0, 0.0, 0.0)))
    found = []
    for tick in range(1, count + 1):
        sensor._simulation.begin_tick(tick)
        reading = sensor.reading()
        found.append((reading.latitude, reading.longitude, reading.altitude))
    per_degree = math.radians(1.0) * 6378137.0
    metres = np.array((per_degree, per_degree * math.cos(math.radians(ZURICH[0])), 1.0))
    apart: Floats = (np.array(found, float) - true) * metres
    return apart


def test_a_receiver_without_noise_measures_its_own_position() -> None:
    reading = receiver().reading()
    assert (reading.time, reading.index) == (1 / 60, 1)
    expected = TangentPlane(*ZURICH).geodetic((10.0, 0.0, 0.0))
    assert (reading.latitude, reading.longitude, reading.altitude) == expected


def test_noise_has_the_standard_deviations_of_the_profile() -> None:
    found = errors(receiver(horizontal_noise=2.0, vertical_noise=3.0), 2000)
    np.testing.assert_allclose(found.std(axis=0), (2.0, 2.0, 3.0), rtol=0.06)
    np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=0.2)
    np.testing.assert_allclose(np.corrcoef(found.T), np.eye(3), atol=0.1)


def test_noise_depends_on_seed_prim_and_sample_and_on_nothing_else() -> None:
    every = errors(receiver(seed=7, horizontal_noise=1.0), 9)
    again = receiver(seed=7, horizontal_noise=1.0)
    again._simulation.begin_tick(9)
    np.testing.assert_array_equal(errors(receiver(seed=7, horizontal_noise=1.0), 9), every)
    true = TangentPlane(*ZURICH).geodetic((10.0, 0.0, 0.0))[0]
    assert (again.reading().latitude - true) * math.radians(1.0) * 6378137.0 == pytest.approx(every[-1][0])
    assert len(set(every[:, 0])) == 9
    assert errors(receiver(seed=8, horizontal_noise=1.0), 9)[8][0] != every[8][0]
    assert errors(receiver(seed=7, path="/Other", horizontal_noise=1.0), 9)[8][0] != every[8][0]


def test_without_a_fix_all_coordinates_are_nan() -> None:
    reading = receiver(dropout=1.0).reading()
    assert all(map(math.isnan, (reading.latitude, reading.longitude, reading.altitude)))
    assert (reading.time, reading.index) == (1 / 60, 1)


def test_outages_take_their_share_of_the_time_in_stretches_of_their_duration() -> None:
    def without_fix(seconds: int) -> list[bool]:
        found = errors(receiver(dropout=0.3, dropout_duration=0.5), 60 * seconds)
        return [bool(missing) for missing in np.isnan(found[:, 0])]

    out = without_fix(150)
    assert np.mean(out) == pytest.approx(0.3, abs=0.06)
    changes = np.flatnonzero(np.diff(np.array(out, int))) + 2  # the ticks at which an outage begins or ends
    assert set(changes % 30) == {0}
    assert without_fix(10) == out[: 60 * 10]
    assert receiver(dropout=0.0)._is_out() is False


def test_a_robot_measures_where_the_scene_says_the_world_is(project: Project) -> None:
    project.scene(PLACE).write("bot.yaml", GPS)
    world, findings = project.load_with_findings()
    assert "W218" not in [finding.code for finding in findings.items]
    simulation = world.simulation
    sensor = simulation.device(NavSatReceiver, world.stage.find("/bot/base_link/gps"))
    ticks(simulation, 1)
    expected = TangentPlane(*ZURICH).geodetic(sensor.pose()[0])
    reading = sensor.reading()
    assert (reading.latitude, reading.longitude, reading.altitude) == expected
    assert reading.altitude == pytest.approx(408.0 + sensor.pose()[0][2], abs=1e-6)


def test_the_scene_overrides_the_place_of_the_world(project: Project) -> None:
    project.world(before=f'<custom><numeric name="{EARTH}" data="1 2 3 4"/></custom>').write("bot.yaml", GPS)
    one = project.load()
    other = project.scene(PLACE).load()
    latitudes = [
        world.simulation.device(NavSatReceiver, world.stage.find("/bot/base_link/gps")).reading().latitude
        for world in (one, other)
    ]
    assert latitudes == pytest.approx([1.0, 47.38], abs=METRE)


def test_an_sdf_world_has_its_place(project: Project) -> None:
    place = "<latitude_deg>47.38</latitude_deg><longitude_deg>8.54</longitude_deg><elevation>408</elevation>"
    tag = f"<spherical_coordinates><surface_model>EARTH_WGS84</surface_model>{place}</spherical_coordinates>"
    project.write("world.sdf", f"<sdf version='1.9'><world name='w'>{tag}</world></sdf>").write("bot.yaml", GPS)
    project.write("scene.yaml", "scene: s\nworld: world.sdf\nrobots: {bot: {use: bot.yaml}}\n")
    world = project.load()
    reading = world.simulation.device(NavSatReceiver, world.stage.find("/bot/base_link/gps")).reading()
    assert (reading.latitude, reading.altitude) == pytest.approx((47.38, 408.2), abs=1e-3)


def test_a_world_without_a_place_is_at_zero_and_a_warning_says_so(project: Project) -> None:
    world, findings = project.write("bot.yaml", GPS).load_with_findings()
    (warning,) = [finding for finding in findings.items if finding.code == "W218"]
    assert "/bot/Geometry/base_link/gps takes the world's origin for latitude 0, longitude 0" in warning.message
    reading = world.simulation.device(NavSatReceiver, world.stage.find("/bot/base_link/gps")).reading()
    assert (reading.latitude, reading.longitude) == pytest.approx((0.0, 0.3 * METRE), abs=METRE / 10)


@pytest.mark.parametrize(("profile", "horizontal"), [("navsat", 0.0), ("neo_m8n", 2.5 / math.sqrt(2 * math.log(2)))])
def test_half_of_the_fixes_are_within_the_accuracy_of_the_data_sheet(
    project: Project, profile: str, horizontal: float
) -> None:
    text = GPS.replace("type: navsat", f"type: navsat, profile: {profile}")
    facts = project.scene(PLACE).write("bot.yaml", text).load().stage.find("/bot/base_link/gps").facts
    assert facts["horizontal_noise"] == pytest.approx(horizontal, abs=0.005)


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ("latitude_deg: 91", "latitude_deg: expected a value ≤ 90, got 91"),
        ("longitude_deg: -181", "longitude_deg: expected a value ≥ -180, got -181"),
        ("altitude: 3", "unknown key 'altitude'"),
    ],
)
def test_a_wrong_place_is_an_error_at_its_key(project: Project, entry: str, error: str) -> None:
    given = {"latitude_deg": "47", "longitude_deg": "8"} | {entry.partition(": ")[0]: entry.partition(": ")[2]}
    place = ", ".join(f"{key}: {value}" for key, value in given.items())
    assert error in project.scene(f"spherical_coordinates: {{{place}}}\n").error()


def test_the_dropout_is_a_share(project: Project) -> None:
    text = GPS.replace("type: navsat", "type: navsat, profile: {dropout: 2}")
    assert "dropout: expected a value ≤ 1, got 2" in project.scene(PLACE).write("bot.yaml", text).error()
