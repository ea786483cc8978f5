"""The lidar profiles that ship have the vendor's figures, and a bad profile is told where it is bad."""

from __future__ import annotations

import math

import pytest

from graphengine.format.diagnostics import Findings
from graphengine.format.spec_reader import read
from graphengine.physics.model.profiles import SensorProfile
from graphengine.physics.sensors.lidar import MAX_BEAMS, LidarProfile
from tests.physics.harness import SHIPPED, Project

ROBOT = "robot: bot\nurdf: bot.urdf\nsensors:\n  eye: {type: lidar, profile: mine, parent: arm%s}\n"
PROFILE = """sensor: mine
lidar:
  rate: 10.0
  beams: {first_deg: -90.0, last_deg: 90.0, count: 181}
  near: 0.1
  far: 12.0
"""


def shipped(name: str) -> LidarProfile:
    findings = Findings()
    profile = read(SensorProfile, SHIPPED / "sensors" / f"{name}.yaml", findings)
    assert profile is not None
    [(_, lidar)] = profile.spec.devices()
    assert isinstance(lidar, LidarProfile)
    return lidar


MICROSCAN3 = {
    "4m0_33hz": (0.030, 0.51, 40.0),
    "4m0_25hz": (0.040, 0.39, 40.0),
    "5m5_33hz": (0.030, 0.51, 40.0),
    "5m5_25hz": (0.040, 0.39, 40.0),
    "9m_25hz": (0.040, 0.125, 64.0),
    "9m_20hz": (0.050, 0.1, 64.0),
    "light": (0.050, 0.51, 64.0),
}
"""Scan cycle (s), angle between beams (degrees) and distance measuring range (m) of the vendor's variants, and of a light one."""


@pytest.mark.parametrize("variant", MICROSCAN3)
def test_a_microscan3_sees_275_degrees_at_the_data_sheets_cycle_step_and_range(variant: str) -> None:
    cycle, step, far = MICROSCAN3[variant]
    lidar = shipped(f"microscan3_{variant}")
    first, last, increment = lidar.angles
    assert 1 / lidar.rate == pytest.approx(cycle, rel=1e-12)
    assert (first, last) == (math.radians(-137.5), math.radians(137.5))
    assert math.degrees(increment) == pytest.approx(step, abs=0.002)
    assert (lidar.near, lidar.far) == (0.05, far)
    assert lidar.elevations == (0.0,)


@pytest.mark.parametrize(
    ("name", "rings", "lowest", "highest"),
    [("lidar_3d_16", 16, -15.0, 15.0), ("lidar_3d_32", 32, -92 / 3, 32 / 3), ("lidar_3d_64", 64, -22.5, 22.5)],
)
def test_a_3d_lidar_has_its_rings_and_looks_all_around_once(
    name: str, rings: int, lowest: float, highest: float
) -> None:
    lidar = shipped(name)
    degrees = [math.degrees(elevation) for elevation in lidar.elevations]
    assert degrees == pytest.approx([lowest + (highest - lowest) * ring / (rings - 1) for ring in range(rings)])
    first, last, increment = lidar.angles
    assert last + increment - first == pytest.approx(2 * math.pi)


def test_the_lidars_that_ship_are_these() -> None:
    files = (SHIPPED / "sensors").glob("*.yaml")
    lidars = {path.stem for path in files if "\nlidar:" in path.read_text(encoding="utf-8")}
    rings = {f"lidar_3d_{count}" for count in (16, 32, 64)}
    assert lidars == {"lidar_360", *rings, *(f"microscan3_{variant}" for variant in MICROSCAN3)}


def test_rings_may_be_given_one_by_one(project: Project) -> None:
    rings = "  rings: {each_deg: [-25.0, -1.667, 0.0, 15.0]}\n"
    project.write("bot.yaml", ROBOT % "").write("sensors/mine.yaml", PROFILE + rings)
    facts = project.load().stage.find("/bot/base_link/arm/eye/Lidar").facts
    assert facts["elevations"] == pytest.approx([math.radians(ring) for ring in (-25.0, -1.667, 0.0, 15.0)])


@pytest.mark.parametrize(("entry", "noise"), [("", 0.02), (", noise_std: 0.1", 0.1), (", noise_std: 0.0", 0.0)])
def test_noise_is_the_profiles_unless_the_robot_says_otherwise(project: Project, entry: str, noise: float) -> None:
    project.write("bot.yaml", ROBOT % entry).write("sensors/mine.yaml", PROFILE + "  noise_std: 0.02\n")
    assert project.load().stage.find("/bot/base_link/arm/eye/Lidar").facts["noise_std"] == noise


RINGS = "rings: define rings either by first_deg, last_deg and count, or by each_deg"
AROUND = "beams: beams go counter-clockwise: last_deg must be greater than first_deg, by at most 360"
RESOLUTION = "resolution must be 0, or at least one micrometre and less than far"
UPWARDS = "rings: rings must be in ascending order"


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("near: 0.1", "near: 12.0", "2:1: error G109: lidar: near must be less than far, but 12 is not less than 12"),
        ("near: 0.1", "near: -1.0", "5:9: error G109: near: expected a value ≥ 0, got -1.0"),
        ("far: 12.0", "far: .inf", "6:8: error G109: far: "),
        ("rate: 10.0", "rate: 0.0", "3:9: error G109: rate: expected a value ≥ 0.001, got 0.0"),
        ("rate: 10.0", "rate: fast", "3:9: error G108: rate: expected a number, got 'fast'"),
        ("  rate: 10.0\n", "", "2:1: error G107: missing key 'rate'"),
        ("last_deg: 90.0", "last_deg: -90.0", f"4:3: error G109: {AROUND}"),
        ("last_deg: 90.0", "last_deg: 271.0", f"4:3: error G109: {AROUND}"),
        ("count: 181", "count: 1", "4:52: error G109: count: expected a value ≥ 2, got 1"),
        ("near:", "noise_std: -0.1\n  near:", "5:14: error G109: noise_std: expected a value ≥ 0, got -0.1"),
        ("near:", "resolution: -0.1\n  near:", "5:15: error G109: resolution: expected a value ≥ 0, got -0.1"),
        ("near:", "resolution: 1e-320\n  near:", f"2:1: error G109: lidar: {RESOLUTION}"),
        ("near:", "resolution: 12.0\n  near:", f"2:1: error G109: lidar: {RESOLUTION}"),
        ("near:", "noise_std: 1e300\n  near:", "5:14: error G109: noise_std: expected a value ≤ 1000, got 1e+300"),
        ("far: 12.0", "far: 1e39", "6:8: error G109: far: expected a value ≤ 1e+06, got 1e+39"),
        ("near:", "rings: {first_deg: -1.0, count: 4}\n  near:", f"5:3: error G109: {RINGS}"),
        ("near:", "rings: {count: 4, each_deg: [1.0]}\n  near:", f"5:3: error G109: {RINGS}"),
        ("near:", "rings: {}\n  near:", f"5:3: error G109: {RINGS}"),
        ("near:", "rings: {each_deg: [1.0, -1.0]}\n  near:", f"5:3: error G109: {UPWARDS}"),
        ("near:", "rings: {first_deg: 5, last_deg: 5, count: 2}\n  near:", f"5:3: error G109: {UPWARDS}"),
        ("near:", "rings: {each_deg: [1.0, 91.0]}\n  near:", "5:27: error G109: each_deg[1]: expected a value ≤ 90"),
        (
            "near:",
            "rings: {first_deg: -9, last_deg: 9, count: 1025}\n  near:",
            "5:46: error G109: count: expected a value ≤ 1024, got 1025",
        ),
        ("near:", "ring: 4\n  near:", "5:3: error G106: unknown key 'ring'"),
        (
            "181}",
            "9000}\n  rings: {first_deg: -9, last_deg: 9, count: 64}",
            f"2:1: error G109: lidar: 64 rings of 9000 beams are too many: at most {MAX_BEAMS} beams in all",
        ),
    ],
)
def test_an_error_in_a_profile_names_the_line_of_the_profile(project: Project, old: str, new: str, error: str) -> None:
    assert old in PROFILE
    project.write("bot.yaml", ROBOT % "").write("sensors/mine.yaml", PROFILE.replace(old, new))
    assert project.error().startswith(f"sensors/mine.yaml:{error}")
