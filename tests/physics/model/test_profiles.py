"""Profiles of cameras, inertial units, contact sensors and rigs: what is wrong is told where it is wrong."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import Findings
from graphengine.format.spec_reader import read
from graphengine.physics.model.profiles import SensorProfile
from tests.physics.harness import SHIPPED, Project

FIELD = "fov_deg: a pinhole camera sees from 0.1 to 179 degrees"
CLIP = "clip: write [nearest, farthest], from 0.001 to 1000000 m"


def mistake(project: Project, kind: str, profile: str) -> str:
    """What the only error says of a profile that is written in one line, the third of its file."""
    project.write("sensors/mine.yaml", f"format: 1\nsensor: mine\n{profile}\n")
    project.robot(f"sensors:\n  it: {{type: {kind}, profile: mine, parent: arm}}")
    place, _, message = project.error().partition(": error ")
    assert place.startswith("sensors/mine.yaml:3:")
    return message.partition("\n")[0]


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ("size: [0, 48]", "G109 size[0]: expected a value ≥ 1, got 0"),
        ("size: [9000, 48]", "G109 size[0]: expected a value ≤ 8192, got 9000"),
        ("size: [64]", "G108 size: expected 2 values, got 1"),
        ("size: [6.5, 4]", "G108 size[0]: expected a whole number, got 6.5"),
        ("fov_deg: [180.0, 75.0]", f"G109 {FIELD}"),
        ("fov_deg: [1e-300, 75.0]", f"G109 {FIELD}"),
        ("fov_deg: [.nan, 75.0]", "G109 fov_deg[0]: expected a finite number, got nan"),
        ("clip: [1e-40, 100.0]", f"G109 {CLIP}"),
        ("clip: [1.0, 1e300]", f"G109 {CLIP}"),
        ("clip: [2.0, 1.0]", f"G109 {CLIP}"),
        ("rate: 0", "G109 rate: expected a value ≥ 0.001, got 0"),
        ("latency: 11", "G109 latency: expected a value ≤ 10, got 11"),
        ("colour_noise: 256", "G109 colour_noise: expected a value ≤ 255, got 256"),
        ("depth_noise: -1", "G109 depth_noise: expected a value ≥ 0, got -1"),
        ("fov: 90", "G106 unknown key 'fov'"),
    ],
)
def test_a_bad_camera(project: Project, entry: str, error: str) -> None:
    values = {"size": "[64, 48]", "fov_deg": "[90.0, 75.0]"}
    key, _, value = entry.partition(": ")
    profile = ", ".join(f"{name}: {given}" for name, given in (values | {key: value}).items())
    assert mistake(project, "camera", f"camera: {{{profile}}}") == error.replace(" ", ": ", 1)


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ("rate: 1e5", "G109 rate: expected a value ≤ 10000, got 100000.0"),
        ("acceleration_noise: 1e308", "G109 acceleration_noise: expected a value ≤ 1000, got 1e+308"),
        ("angular_velocity_noise: -1", "G109 angular_velocity_noise: expected a value ≥ 0, got -1"),
        ("acceleration_bias: [1, 2]", "G108 acceleration_bias: expected 3 values, got 2"),
        (
            "angular_velocity_bias: [0, -1e9, 0]",
            "G109 angular_velocity_bias[1]: expected a value ≥ -1000, got -1000000000.0",
        ),
    ],
)
def test_a_bad_inertial_unit(project: Project, entry: str, error: str) -> None:
    assert mistake(project, "imu", f"imu: {{{entry}}}") == error.replace(" ", ": ", 1)


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ("threshold: 5, limit: 5", "G109 contact: threshold must be less than limit, and 5 is not less than 5"),
        ("limit: 0", "G109 limit: expected a value > 0, got 0"),
        ("radius: -1", "G109 radius: expected a value ≥ 0, got -1"),
    ],
)
def test_a_bad_contact_sensor(project: Project, entry: str, error: str) -> None:
    assert mistake(project, "contact", f"contact: {{{entry}}}") == error.replace(" ", ": ", 1)


@pytest.mark.parametrize(
    ("parts", "error"),
    [
        ("{eye: {}}", "G109 eye: a part is a camera or an imu"),
        ("{eye: {imu: {}, camera: {size: [4, 3], fov_deg: [9, 9]}}}", "G109 eye: a part is a camera or an imu"),
        ("{eye ball: {imu: {}}}", "G109 'eye ball' is not a name: letters, digits and '_', not beginning with a digit"),
    ],
)
def test_a_bad_rig(project: Project, parts: str, error: str) -> None:
    assert mistake(project, "realsense_d455", f"rig: {{housing: it, parts: {parts}}}") == error.replace(" ", ": ", 1)


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
