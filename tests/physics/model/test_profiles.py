"""Profiles of cameras, inertial units, contact sensors and rigs: what is wrong is told where it is wrong."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import Findings
from graphengine.format.spec_reader import read
from graphengine.physics.model.profiles import SensorProfile
from tests.physics.harness import SHIPPED, Project

FIELD = "fov_deg: the field of view of a pinhole camera must be from 0.1 to 179 degrees"
CLIP = "clip: must be [nearest, farthest] in ascending order, from 0.001 to 1000000 m"
TOO_LOW = "expected a value ≥ -1000, got -1000000000.0"
THRESHOLD = "threshold must be less than limit, but 5 is not less than 5"
PART = "a part is a camera or an imu"
NAME = "letters, digits and '_', but no leading digit"


def camera(**changed: str) -> str:
    """A camera with a value that is bad."""
    given = {"size": "[64, 48]", "fov_deg": "[90.0, 75.0]"} | changed
    return f"camera: {{{', '.join(f'{name}: {value}' for name, value in given.items())}}}"


RIG = "realsense_d455"


BAD = pytest.mark.parametrize(
    ("kind", "profile", "error"),
    [
        ("camera", camera(size="[0, 48]"), "G109: size[0]: expected a value ≥ 1, got 0"),
        ("camera", camera(size="[9000, 48]"), "G109: size[0]: expected a value ≤ 8192, got 9000"),
        ("camera", camera(size="[64]"), "G108: size: expected 2 values, got 1"),
        ("camera", camera(size="[6.5, 4]"), "G108: size[0]: expected a whole number, got 6.5"),
        ("camera", camera(fov_deg="[180.0, 75.0]"), f"G109: {FIELD}"),
        ("camera", camera(fov_deg="[1e-300, 75.0]"), f"G109: {FIELD}"),
        ("camera", camera(fov_deg="[.nan, 75.0]"), "G109: fov_deg[0]: expected a finite number, got nan"),
        ("camera", camera(clip="[1e-40, 100.0]"), f"G109: {CLIP}"),
        ("camera", camera(clip="[1.0, 1e300]"), f"G109: {CLIP}"),
        ("camera", camera(clip="[2.0, 1.0]"), f"G109: {CLIP}"),
        ("camera", camera(rate="0"), "G109: rate: expected a value ≥ 0.001, got 0"),
        ("camera", camera(latency="11"), "G109: latency: expected a value ≤ 10, got 11"),
        ("camera", camera(colour_noise="256"), "G109: colour_noise: expected a value ≤ 255, got 256"),
        ("camera", camera(depth_noise="-1"), "G109: depth_noise: expected a value ≥ 0, got -1"),
        ("camera", camera(fov="90"), "G106: unknown key 'fov'"),
        ("imu", "imu: {rate: 1e5}", "G109: rate: expected a value ≤ 10000, got 100000.0"),
        ("imu", "imu: {acceleration_noise: 1e308}", "G109: acceleration_noise: expected a value ≤ 1000, got 1e+308"),
        ("imu", "imu: {angular_velocity_noise: -1}", "G109: angular_velocity_noise: expected a value ≥ 0, got -1"),
        ("imu", "imu: {acceleration_bias: [1, 2]}", "G108: acceleration_bias: expected 3 values, got 2"),
        ("imu", "imu: {angular_velocity_bias: [0, -1e9, 0]}", f"G109: angular_velocity_bias[1]: {TOO_LOW}"),
        ("imu", "imu: {gyroscope: {noise_density_dps: -1}}", "G109: noise_density_dps: expected a value ≥ 0, got -1"),
        ("imu", "imu: {gyroscope: {noise_density_ug: 1}}", "G106: unknown key 'noise_density_ug'"),
        (
            "imu",
            "imu: {accelerometer: {scale_error_percent: [1, 2]}}",
            "G108: scale_error_percent: expected 3 values, got 2",
        ),
        ("contact", "contact: {threshold: 5, limit: 5}", f"G109: contact: {THRESHOLD}"),
        ("contact", "contact: {limit: 0}", "G109: limit: expected a value > 0, got 0"),
        ("contact", "contact: {radius: -1}", "G109: radius: expected a value ≥ 0, got -1"),
        (RIG, "rig: {housing: it, parts: {eye: {}}}", f"G109: eye: {PART}"),
        (RIG, f"rig: {{housing: it, parts: {{eye: {{imu: {{}}, {camera()}}}}}}}", f"G109: eye: {PART}"),
        (RIG, "rig: {housing: it, parts: {eye ball: {imu: {}}}}", f"G109: 'eye ball' is not a valid name: use {NAME}"),
    ],
)


@BAD
def test_a_bad_profile_is_an_error_at_its_place(project: Project, kind: str, profile: str, error: str) -> None:
    project.write("sensors/mine.yaml", f"format: 1\nsensor: mine\n{profile}\n")
    project.robot(f"sensors: {{it: {{type: {kind}, profile: mine, parent: arm}}}}")
    place, _, message = project.error().partition(": error ")
    assert place.startswith("sensors/mine.yaml:3:")
    assert message.partition("\n")[0] == error


@BAD
def test_bad_figures_in_a_robot_file_are_errors_at_their_place(
    project: Project, kind: str, profile: str, error: str
) -> None:
    figures = profile.partition(": ")[2]
    project.robot(f"sensors: {{it: {{type: {kind}, parent: arm,\n profile: {figures}}}}}")
    place, _, message = project.error().partition(": error ")
    assert place.startswith("bot.yaml:4:")
    assert message.partition("\n")[0] == error


def test_figures_in_a_robot_file_are_a_profile(project: Project) -> None:
    project.robot("sensors: {it: {type: imu, profile: {rate: 50.0, acceleration_noise: 0.1}, parent: arm}}")
    facts = project.load().stage.find("/bot/arm/it").facts
    assert (facts["rate"], facts["acceleration_noise"], facts["angular_velocity_noise"]) == (50.0, 0.1, 0.0)


def test_a_profile_is_a_name_or_figures(project: Project) -> None:
    project.robot("sensors: {it: {type: imu, profile: 7, parent: arm}}")
    assert "profile: expected the name of a profile, or a mapping with its values, got 7" in project.error()


def test_a_profile_is_of_one_sensor(project: Project) -> None:
    both = project.write("both.yaml", "sensor: both\nimu: {}\ncontact: {}\n").folder / "both.yaml"
    none = project.write("none.yaml", "sensor: none\n").folder / "none.yaml"
    for path in (both, none):
        findings = Findings()
        assert read(SensorProfile, path, findings) is None
        _, kinds = findings.errors[0].message.split("a profile is one of: ")
        assert set(kinds.split(", ")) >= {"lidar", "camera", "imu", "contact", "range", "rig"}


def test_all_that_ship_are_good() -> None:
    findings = Findings()
    paths = sorted((SHIPPED / "sensors").glob("*.yaml"))
    profiles = [read(SensorProfile, path, findings) for path in paths]
    assert [profile.spec.sensor for profile in profiles if profile is not None] == [path.stem for path in paths]
    assert not findings.errors
