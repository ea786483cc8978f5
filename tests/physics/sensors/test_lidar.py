"""What a lidar measures, when, and with which noise. Distances are compared with geometry, not with rays."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.devices.lidar import Scan
from graphengine.devices.rotation import compose, from_rpy, relative, rotate
from graphengine.devices.stage import Stage
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.physics.sensors.lidar import RayLidar
from graphengine.physics.simulation import Simulation
from tests.physics.conftest import Ship
from tests.physics.harness import SCENE, Project
from tests.physics.ray_casting.casters import either_rays

ROOM = """<mujoco><worldbody>
  <geom type="box" size=".1 8 3" pos="7.1 0 0"/><geom type="box" size=".1 8 3" pos="-5.1 0 0"/>
  <geom type="box" size="8 .1 3" pos="0 6.1 0"/><geom type="box" size="8 .1 3" pos="0 -4.1 0"/>
  <geom type="box" size="8 8 .1" pos="0 0 3.1"/><geom type="box" size="8 8 .1" pos="0 0 -2.1"/>
</worldbody></mujoco>"""
LOW, HIGH = np.array([-5.0, -4.0, -2.0]), np.array([7.0, 6.0, 3.0])


def room(
    rate: float = 20.0,
    tick_rate: Fraction = Fraction(60),
    beams: int = 2751,
    rays: RaysChoice = "auto",
    seed: int = 0,
    path: str = "/Lidar",
    **facts: object,
) -> RayLidar:
    """A lidar that hangs in a closed box of 12 m x 10 m x 5 m, tilted, at (1, -0.5, 0.4)."""
    stage = Stage()
    last = math.radians(137.5)
    known = {"rate": rate, "angles": (-last, last, 2 * last / (beams - 1)), "ranges": (0.05, 64.0)}
    pose = {"position": (1.0, -0.5, 0.4), "orientation": from_rpy(0.1, -0.2, 0.9)}
    prim = stage.add(path, "lidar", facts=known | facts, **pose)
    simulation = Simulation(mujoco.MjModel.from_xml_string(ROOM), stage, tick_rate, 1, rays=rays, seed=seed)
    return simulation.device(RayLidar, prim)


def scan_at(lidar: RayLidar, tick: int) -> Scan:
    lidar._simulation.begin_tick(tick)
    return lidar.scan()


def walls_along(beams: np.ndarray) -> np.ndarray:
    """Distances to the walls of the room, for directions in the lidar's frame."""
    turned = np.array([rotate(from_rpy(0.1, -0.2, 0.9), tuple(beam)) for beam in beams.tolist()])
    start = np.array([1.0, -0.5, 0.4])
    with np.errstate(divide="ignore"):
        distances: np.ndarray = np.where(turned > 0, (HIGH - start) / turned, (LOW - start) / turned).min(axis=1)
    return distances


@either_rays
def test_every_beam_measures_the_distance_to_the_wall_it_meets(rays: RaysChoice) -> None:
    lidar = room(rays=rays)
    scan = scan_at(lidar, 1)
    assert len(scan.ranges) == 2751
    np.testing.assert_allclose(scan.ranges, walls_along(lidar.directions), atol=1e-6, rtol=0)
    assert scan.ranges.dtype == np.float32
    assert lidar.elevations.tolist() == [0.0]
    assert lidar.directions[1375] == pytest.approx([1, 0, 0], abs=1e-12)
    assert lidar.directions[2750][1] == pytest.approx(math.sin(math.radians(137.5)))


@either_rays
def test_beams_of_a_3d_lidar_come_ring_after_ring_and_measure_the_walls_too(rays: RaysChoice) -> None:
    elevations = tuple(map(math.radians, (-70.0, -15.0, 0.0, 2.5, 40.0)))
    lidar = room(rays=rays, beams=100, elevations=elevations)
    scan = scan_at(lidar, 1)
    assert lidar.elevations.tolist() == list(elevations)
    assert lidar.directions.shape == (500, 3)
    first, _, increment = lidar.angles
    for ring, beam in ((0, 0), (1, 99), (2, 17), (4, 50)):
        azimuth, elevation = first + beam * increment, elevations[ring]
        level = math.cos(elevation)
        expected = (level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation))
        assert lidar.directions[100 * ring + beam] == pytest.approx(expected)
    np.testing.assert_allclose(scan.ranges, walls_along(lidar.directions), atol=1e-6, rtol=0)


def test_surfaces_that_are_too_near_or_too_far_give_no_return() -> None:
    scan, true = scan_at(room(ranges=(4.0, 6.0), noise_std=0.5), 1), room().scan().ranges
    returned = np.isfinite(scan.ranges)
    np.testing.assert_array_equal(returned, (true >= 4.0) & (true <= 6.0))
    assert min(scan.ranges[returned]) == 4.0  # noise stays within what the sensor reports
    assert max(scan.ranges[returned]) == 6.0
    np.testing.assert_array_equal(scan.intensities > 0, returned)


@settings(max_examples=60)
@given(
    st.decimals("0.5", "120", places=2), st.decimals("1", "240", places=2), st.integers(1, 400), st.integers(1, 10**6)
)
def test_sample_n_is_cast_at_the_first_tick_at_or_after_its_time(
    rate: object, tick_rate: object, ticks: int, late: int
) -> None:
    lidar = room(float(str(rate)), Fraction(str(tick_rate)), beams=3)
    lidar_rate, period = Fraction(str(rate)), 1 / Fraction(str(tick_rate))
    for start in (1, late):
        for tick in range(start, start + ticks):
            lidar._simulation.begin_tick(tick)
            newest = math.floor(tick * period * lidar_rate)  # of the samples n with n / rate <= t
            fresh = tick == 1 or math.floor((tick - 1) * period * lidar_rate) < newest
            assert lidar.due == fresh
            if fresh and tick < start + 5:
                scan = lidar.scan()
                assert scan.index == newest
                assert scan.time == pytest.approx(float(tick * period), rel=1e-14)


def test_20_hz_at_60_ticks_is_the_first_tick_and_then_every_third() -> None:
    lidar = room(20.0, beams=3)
    due = []
    for tick in range(13):
        lidar._simulation.begin_tick(tick)
        if lidar.due:
            due.append((tick, lidar.scan().index))
    assert due == [(1, 0), (3, 1), (6, 2), (9, 3), (12, 4)]


def test_a_sample_is_cast_once_shared_by_all_readers_and_never_overwritten() -> None:
    one = room(20.0)
    assert isinstance(one._simulation, Simulation)
    other = one._simulation.device(RayLidar, one._simulation.stage.find("/Lidar"))
    first = scan_at(one, 3)
    assert other.scan() is first
    assert scan_at(one, 4) is first
    assert scan_at(one, 6).ranges is not first.ranges


def test_a_late_scan_shows_the_present_tick_and_is_not_kept() -> None:
    lidar = room(20.0)
    late = scan_at(lidar, 4)
    assert late.index == 1
    assert late.time == pytest.approx(4 / 60)
    assert scan_at(lidar, 5).time == pytest.approx(5 / 60)


def test_noise_depends_on_seed_prim_and_sample_and_on_nothing_else() -> None:
    def scans(seed: int, ticks: list[int], path: str = "/Lidar") -> dict[int, bytes]:
        noisy = room(noise_std=0.01, seed=seed, path=path)
        return {tick: scan_at(noisy, tick).ranges.tobytes() for tick in ticks}

    every = scans(7, [1, 3, 6, 9])
    assert scans(7, [9])[9] == every[9]  # whether the earlier ones were cast or not
    assert len(set(every.values())) == 4
    assert scans(8, [9])[9] != every[9]
    assert scans(7, [9], "/Other")[9] != every[9]


def test_noise_has_the_standard_deviation_it_is_given() -> None:
    error = scan_at(room(noise_std=0.02), 1).ranges - scan_at(room(), 1).ranges
    assert error.std() == pytest.approx(0.02, rel=0.05)
    assert error.mean() == pytest.approx(0.0, abs=0.002)


def test_distances_are_multiples_of_the_resolution_the_nearest_ones() -> None:
    coarse, fine = room(resolution=0.25).scan().ranges, room().scan().ranges
    assert np.all(coarse % 0.25 == 0)
    assert np.abs(coarse - fine).max() <= 0.125 + 1e-6
    assert np.all(room(resolution=0.25, noise_std=0.1).scan().ranges % 0.25 == 0)


EYE = "sensors:\n  eye: {type: lidar, profile: lidar_360, parent: "


def test_a_lidar_sees_other_robots_and_not_its_own(project: Project) -> None:
    """Two carts 2 m apart, a lidar inside each: it looks through its own box and meets the other's 0.2 m before its middle."""
    project.scene("  other: {use: bot.yaml, position: [2, 0, 0.1]}\n")
    world = project.robot(EYE + "base_link}").load()
    ahead, behind = 180, 0
    ranges = look(world, "/bot/base_link/eye/Lidar")
    assert ranges[ahead] == pytest.approx(1.8, abs=1e-6)
    assert math.isinf(ranges[behind])
    ranges = look(world, "/other/base_link/eye/Lidar")
    assert ranges[behind] == pytest.approx(1.8, abs=1e-6)
    assert math.isinf(ranges[ahead])


def test_visuals_are_seen_only_where_a_body_has_no_collider(project: Project) -> None:
    visual = 'contype="0" conaffinity="0" type="box"'
    project.world(
        f'<body pos="2 0 0"><geom type="box" size=".1 .1 1"/><geom {visual} size=".5 .5 1"/></body>',
        f'<body pos="-2 0 0"><geom {visual} size=".5 .5 1"/></body>',
    )
    ranges = look(project.robot(EYE + "arm}").load(), "/bot/base_link/arm/eye/Lidar")
    assert ranges[180] == pytest.approx(1.8, abs=1e-6)  # 2 m less the arm's 0.1 m and the collider's 0.1 m
    assert ranges[0] == pytest.approx(1.6, abs=1e-6)  # 2 m and 0.1 m less the visual's 0.5 m


@either_rays
def test_in_an_empty_world_no_ray_returns(rays: RaysChoice) -> None:
    model, stage = mujoco.MjModel.from_xml_string("<mujoco/>"), room(beams=5)._simulation.stage
    scan = Simulation(model, stage, Fraction(60), 1, rays=rays).device(RayLidar, stage.find("/Lidar")).scan()
    assert np.isinf(scan.ranges).all()
    assert scan.intensities.tolist() == [0.0] * 5


def test_brighter_surfaces_return_more(project: Project) -> None:
    project.world(
        '<geom type="box" size=".1 9 1" pos="2 0 0" material="white"/>',
        '<geom type="box" size=".1 9 1" pos="-2 0 0" rgba="0 1 0 1"/>',
        before='<asset><material name="white" rgba="1 1 1 1"/></asset>',
    )
    world = project.robot(EYE + "arm}").load()
    world.simulation.begin_tick(1)
    scan = world.simulation.device(RayLidar, world.stage.find("/bot/base_link/arm/eye/Lidar")).scan()
    assert scan.intensities[180] == pytest.approx(255)
    assert scan.intensities[0] == pytest.approx(255 * 0.7152)


HALF = np.array([0.4, 0.3, 0.6])
"""m, half the sides of a box, which is turned and stands ahead of the robot."""
BOX = ((1.6, 0.3, 0.5), from_rpy(0.3, 0.2, 0.5))
BESIDE = """<mujoco><compiler angle="radian" eulerseq="XYZ"/><worldbody>
  <body pos="1.6 0.3 0.5" euler="0.3 0.2 0.5"><geom type="box" size=".4 .3 .6"/></body>
</worldbody></mujoco>"""


@either_rays
@pytest.mark.parametrize("profile", ["lidar_360", "lidar_3d_32"])
def test_the_points_of_a_turned_and_tilted_lidar_lie_on_the_surface_of_a_box(
    project: Project, profile: str, rays: RaysChoice
) -> None:
    pose = "position: [0.1, -0.05, 0.4], orientation: {rpy_deg: [20, 15, 130]}"
    eye = f"{{type: lidar, profile: {profile}, noise_std: 0.0, parent: arm, {pose}}}"
    project.write("world.xml", BESIDE).robot(f"sensors: {{eye: {eye}}}")
    world = project.write("scene.yaml", SCENE.replace("0.1]", "0.1], orientation: {rpy_deg: [5, -10, 25]}")).load()
    simulation = Simulation(world.simulation.model, world.stage, Fraction(60), 4, rays=rays)
    simulation.begin_tick(1)
    prim = world.stage.find("/bot/base_link/arm/eye/Lidar")
    lidar, frame = simulation.device(RayLidar, prim), simulation.frame(prim).pose()
    scan = lidar.scan()
    hit = np.isfinite(scan.ranges)
    for point in (lidar.directions[hit] * scan.ranges[hit, None]).tolist():
        place, _ = relative(BOX, compose(frame, (tuple(point), (0.0, 0.0, 0.0, 1.0))))
        assert np.max(np.abs(place) - HALF) == pytest.approx(0.0, abs=1e-6)
    assert hit.sum() > 10


def look(world: LoadedWorld, path: str) -> np.ndarray:
    world.simulation.begin_tick(1)
    return world.simulation.device(RayLidar, world.stage.find(path)).scan().ranges


def test_the_level_robot_has_no_phantom_returns_from_the_floor(ship: Ship) -> None:
    ranges = look(ship("dd100_flat.yaml"), "/dd100/base_link/chassis_link/sim_lidar/Lidar")
    assert np.isinf(ranges).all()
    tilted = look(ship("tutorial/flat_grid.yaml"), "/dd100/base_link/chassis_link/sim_lidar/Lidar")
    assert 20 < tilted[1375] < 30
