"""What a radar measures. Distances and velocities are compared with geometry and mechanics, not with rays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.devices.radar import Detections
from graphengine.devices.stage import Stage
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.physics.sensors.radar import RayRadar
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project
from tests.physics.ray_casting.casters import either_rays

EXACT = {"noise_std": 0.0, "resolution": 0.0, "velocity_std": 0.0, "velocity_resolution": 0.0, "angle_std": 0.0}
FACTS = {"rate": 20.0, "angles": (-0.2, 0.2, 0.1), "elevations": (-0.1, 0.0, 0.1), "ranges": (0.5, 50.0), **EXACT}
BEAMS = [(azimuth, elevation) for elevation in (-0.1, 0.0, 0.1) for azimuth in (-0.2, -0.1, 0.0, 0.1, 0.2)]
AHEAD = [(math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)) for a, e in BEAMS]


def radar_of(
    bodies: str,
    velocities: Sequence[float] = (),
    rays: RaysChoice = "auto",
    *,
    carrier: str | None = None,
    seed: int = 0,
    path: str = "/Radar",
    **facts: object,
) -> RayRadar:
    """A radar at the origin that looks along x, or on a body, while joints move with these velocities."""
    stage = Stage()
    prim = stage.add(path, "radar", facts=FACTS | facts, body=carrier)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"/><compiler angle="radian"/><worldbody>{bodies}</worldbody></mujoco>'
    )
    simulation = Simulation(model, stage, Fraction(60), 1, seed=seed, rays=rays)
    simulation.data.qvel[: len(velocities)] = velocities
    simulation.refresh()
    simulation.begin_tick(1)
    return simulation.device(RayRadar, prim)


def wall(distance: float, joints: str = '<joint type="slide" axis="1 0 0"/>') -> str:
    """A wall that moves along x; its front is that far away."""
    return f'<body pos="{distance} 0 0">{joints}<geom type="box" size=".05 9 9" pos=".05 0 0" mass="1"/></body>'


def rows(sample: Detections) -> list[tuple[float, ...]]:
    """Points with their velocity and intensity."""
    return [
        (*point, velocity, power)
        for point, velocity, power in zip(
            sample.points.tolist(), sample.radial_velocities.tolist(), sample.intensities.tolist(), strict=True
        )
    ]


@either_rays
@pytest.mark.parametrize("speed", [0.0, 1.6, -3.0])
def test_a_wall_that_moves_away_has_its_speed_along_each_ray(rays: RaysChoice, speed: float) -> None:
    sample = radar_of(wall(6.0), [speed], rays).detections()
    assert (sample.time, sample.index) == (1 / 60, 0)
    expected = [(6.0, 6.0 * y / x, 6.0 * z / x) for x, y, z in AHEAD]
    np.testing.assert_allclose(sample.points, expected, atol=1e-5)
    np.testing.assert_allclose(sample.radial_velocities, [speed * x for x, _, _ in AHEAD], atol=1e-6)


@pytest.mark.parametrize("time", [0.0, 0.7, 2.1])
def test_the_sheets_of_isaac_sims_example_have_the_radial_velocities_of_their_oscillation(time: float) -> None:
    """Sheets at 45 degrees on both sides; their distances are r + A sin(w t + p), so their speeds A w cos(w t + p)."""
    sheets, speeds, turns = "", [], (-math.pi / 4, math.pi / 4)
    for turn, amplitude, rate, phase in zip(turns, (2.0, 2.5), (0.8, 1.2), (0.0, math.pi / 3), strict=True):
        distance = 6.0 + amplitude * math.sin(rate * time + phase)
        speeds.append(amplitude * rate * math.cos(rate * time + phase))
        x, y = distance * math.cos(turn), distance * math.sin(turn)
        sheets += f'<body pos="{x} {y} 0" euler="0 0 {turn}"><joint type="slide" axis="1 0 0"/>'
        sheets += '<geom type="box" size=".05 1 .75" pos=".05 0 0" mass="1"/></body>'
    radar = radar_of(sheets, speeds, angles=(turns[0], turns[1], math.pi / 2), elevations=(0.0,))
    np.testing.assert_allclose(radar.detections().radial_velocities, speeds, atol=1e-6)


@either_rays
def test_a_turning_body_has_the_velocity_of_the_surface_that_is_hit(rays: RaysChoice) -> None:
    """A sphere at 5 m that turns about an axis through (5, 0.4): each point of it moves with w x r."""
    body = '<body pos="5 .4 0"><joint type="hinge" axis="0 0 1"/><geom type="sphere" size="1.5" pos="0 -.4 0" mass="1"/></body>'
    sample = radar_of(body, [2.0], rays).detections()
    assert len(sample.points) == len(AHEAD)
    arms = sample.points - (5.0, 0.4, 0.0)
    surface = np.cross((0.0, 0.0, 2.0), arms)
    along = sample.points / np.linalg.norm(sample.points, axis=1, keepdims=True)
    np.testing.assert_allclose(sample.radial_velocities, np.sum(surface * along, axis=1), atol=1e-5)
    assert np.abs(sample.radial_velocities).max() > 0.5


def test_a_radar_that_moves_sees_the_world_come_nearer_and_not_its_own_robot() -> None:
    cart = '<body name="cart"><joint type="slide" axis="1 0 0"/><geom type="sphere" size=".7" mass="1"/></body>'
    still = '<geom type="box" size=".05 9 9" pos="8.05 0 0"/>'
    sample = radar_of(cart + still, [1.5], carrier="cart").detections()
    np.testing.assert_allclose(sample.points[:, 0], 8.0, atol=1e-5)
    np.testing.assert_allclose(sample.radial_velocities, [-1.5 * x for x, _, _ in AHEAD], atol=1e-6)


def test_a_radar_that_is_turned_measures_in_its_own_frame() -> None:
    mast = '<body name="mast" euler="0 0 1.5707963"><joint type="hinge" axis="0 0 1"/><geom size=".1" mass="1"/></body>'
    wall = '<body pos="0 6 0"><joint type="slide" axis="0 1 0"/><geom type="box" size="9 .05 9" pos="0 .05 0" mass="1"/></body>'
    sample = radar_of(mast + wall, [0.0, 1.2], carrier="mast").detections()
    np.testing.assert_allclose(sample.points[:, 0], 6.0, atol=1e-5)
    np.testing.assert_allclose(sample.radial_velocities, [1.2 * x for x, _, _ in AHEAD], atol=1e-6)


def test_power_falls_with_the_fourth_power_of_the_distance_to_0_db_at_the_maximum_range() -> None:
    beam: dict[str, Any] = {"angles": (0.0, 0.1, 0.1), "elevations": (0.0,)}
    near, half, far = (radar_of(wall(d), **beam).detections().intensities[0] for d in (12.5, 25.0, 49.99))
    assert far == pytest.approx(0.0, abs=0.01)
    assert half - far == pytest.approx(12.04, abs=0.02)
    assert near - half == pytest.approx(12.04, abs=0.02)


def test_objects_out_of_range_are_not_detected() -> None:
    for bodies in ("", wall(60.0), wall(0.4)):
        sample = radar_of(bodies).detections()
        assert (sample.points.shape, rows(sample)) == ((0, 3), [])


def test_distances_and_velocities_are_rounded_to_their_resolutions() -> None:
    sample = radar_of(wall(6.0), [1.13], resolution=0.4, velocity_resolution=0.25).detections()
    distances = np.linalg.norm(sample.points, axis=1)
    np.testing.assert_allclose(distances / 0.4, np.round(distances / 0.4), atol=1e-5)
    assert set(sample.radial_velocities.tolist()) <= {1.0, 1.25}


def test_errors_are_normal_with_the_deviations_of_the_profile_and_independent() -> None:
    deviations: dict[str, Any] = {"noise_std": 0.2, "velocity_std": 0.05, "angle_std": 0.01}
    ball = '<geom type="sphere" size="9" pos="0 0 0"/>'  # seen from inside: all distances are 9 m
    rings = np.linspace(-0.5, 0.5, 20)
    radar = radar_of(ball, angles=(-0.7, 0.7, 1.4 / 199), elevations=tuple(rings), **deviations)
    sample = radar.detections()
    assert len(sample.points) == 4000
    azimuth = np.arctan2(sample.points[:, 1], sample.points[:, 0]) - np.tile(np.linspace(-0.7, 0.7, 200), 20)
    distance = np.linalg.norm(sample.points, axis=1)
    elevation = np.arcsin(sample.points[:, 2] / distance) - np.repeat(rings, 200)
    errors = np.array([distance - 9.0, sample.radial_velocities, azimuth, elevation])
    np.testing.assert_allclose(errors.std(axis=1), (0.2, 0.05, 0.01, 0.01), rtol=0.05)
    np.testing.assert_allclose(errors.mean(axis=1) / errors.std(axis=1), 0.0, atol=0.06)
    np.testing.assert_allclose(np.corrcoef(errors), np.eye(4), atol=0.06)


def test_the_errors_of_a_sample_depend_on_seed_prim_and_number_alone() -> None:
    noise: dict[str, Any] = {"noise_std": 0.2, "velocity_std": 0.05, "angle_std": 0.01}
    one = rows(radar_of(wall(6.0), seed=3, **noise).detections())
    assert one == rows(radar_of(wall(6.0), seed=3, **noise).detections())
    assert one != rows(radar_of(wall(6.0), seed=4, **noise).detections())
    assert one != rows(radar_of(wall(6.0), seed=3, path="/Other", **noise).detections())


def test_all_callers_share_a_sample() -> None:
    radar = radar_of(wall(6.0), noise_std=0.2)
    assert radar.detections() is radar.detections()


MOUNTED = "sensors:\n  eye: {type: radar, profile: PROFILE, parent: base_link, position: [0.3, 0.0, 0.5]}\n"


def test_a_robot_file_mounts_the_radar_of_a_shipped_profile(project: Project) -> None:
    project.robot(MOUNTED.replace("PROFILE", "radar_77ghz")).world('<geom type="box" size=".1 9 9" pos="5.4 0 0"/>')
    simulation = project.load().simulation
    simulation.begin_tick(1)
    radar = simulation.device(RayRadar, simulation.stage.find("/bot/base_link/eye/Radar"))
    assert (radar.rate, radar.ranges) == (20.0, (0.2, 100.0))
    points = radar.detections().points
    ahead = points[(np.abs(points[:, 1]) < 0.3) & (points[:, 2] > -0.3)]
    np.testing.assert_allclose(ahead[:, 0], 5.0, atol=0.5)  # five times the deviation of a distance


@pytest.mark.parametrize(
    ("figures", "message"),
    [
        ("velocity_std: -1.0", "velocity_std"),
        ("angle_std_deg: 90.0", "angle_std_deg"),
        ("near: 200.0", "near must be less than far"),
        ("clutter: 1.0", "clutter"),
    ],
)
def test_figures_that_no_radar_has_are_refused(project: Project, figures: str, message: str) -> None:
    beams = "rate: 20.0, beams: {first_deg: -45.0, last_deg: 45.0, count: 10}, far: 100.0"
    near = "" if figures.startswith("near") else "near: 0.2, "
    project.robot(MOUNTED.replace("PROFILE", f"{{{beams}, {near}{figures}}}"))
    assert any(message in error for error in project.errors())
