"""Raycast sensors and light beams. Depths are compared with geometry; cases of Isaac Sim's tests have its numbers."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.devices.light_beam import BeamReading
from graphengine.devices.raycast import RaycastReading
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.devices.stage import Stage
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.physics.sensors.light_beam import LightBeamProfile, LightCurtain
from graphengine.physics.sensors.raycast import RaycastProfile, RaySet
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project
from tests.physics.ray_casting.casters import either_rays

BOX = '<geom type="box" size=".5 .5 .5" pos="{}"/>'
SHAPES = {
    "plane": '<geom type="plane" size="0 0 1" pos="2 0 0" zaxis="-1 0 0"/>',
    "box": '<geom type="box" size="1 2 3" pos="3 0 0"/>',
    "sphere": '<geom size="1" pos="3 0 0"/>',
    "capsule": '<geom type="capsule" size="1 2" pos="3 0 0"/>',
    "cylinder": '<geom type="cylinder" size="1 2" pos="3 0 0"/>',
    "ellipsoid": '<geom type="ellipsoid" size="1 2 3" pos="3 0 0"/>',
    "mesh": '<geom type="mesh" mesh="cube" pos="3 0 0"/>',
    "hfield": '<geom type="hfield" hfield="flat" pos="2 0 0" zaxis="-1 0 0"/>',
}
ASSETS = """<asset>
  <mesh name="cube" vertex="-1 -1 -1 1 -1 -1 -1 1 -1 -1 -1 1 1 1 1 1 1 -1 1 -1 1 -1 1 1"/>
  <hfield name="flat" nrow="2" ncol="2" size="2 2 .5 .1" elevation="1 1 1 1"/>
</asset>"""


def simulation_of(world: str, rays: RaysChoice, path: str, kind: str, facts: dict[str, Any], **pose: Any) -> Simulation:
    stage = Stage()
    stage.add("/World/thing", "body", body="thing")
    stage.add(path, kind, facts=facts, **pose)
    thing = f'<body name="thing">{world}</body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{ASSETS}<worldbody>{thing}</worldbody></mujoco>")
    simulation = Simulation(model, stage, Fraction(60), 1, rays=rays)
    simulation.begin_tick(3)
    return simulation


def cast(
    world: str, rays: RaysChoice = "auto", *, at: Vector3 = (0, 0, 0), turned: Quaternion = (0, 0, 0, 1), **profile: Any
) -> RaycastReading:
    facts = RaycastProfile(**profile).facts()
    simulation = simulation_of(world, rays, "/Rays", "raycast", facts, position=at, orientation=turned)
    return simulation.device(RaySet, simulation.stage.find("/Rays")).reading()


def beams(
    world: str, rays: RaysChoice = "auto", *, at: Vector3 = (0, 0, 0), turned: Quaternion = (0, 0, 0, 1), **profile: Any
) -> BeamReading:
    facts = LightBeamProfile(**profile).facts()
    simulation = simulation_of(world, rays, "/Beam", "light_beam", facts, position=at, orientation=turned)
    return simulation.device(LightCurtain, simulation.stage.find("/Beam")).reading()


QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


@either_rays
@pytest.mark.parametrize("shape", SHAPES)
def test_a_ray_measures_the_distance_and_the_normal_of_each_shape(rays: RaysChoice, shape: str) -> None:
    reading = cast(SHAPES[shape], rays)
    assert reading.time == 3 / 60
    assert reading.depths == pytest.approx([2.0], abs=1e-6)
    np.testing.assert_allclose(reading.hit_positions, [(2.0, 0.0, 0.0)], atol=1e-6)
    np.testing.assert_allclose(reading.hit_normals, [(-1.0, 0.0, 0.0)], atol=1e-6)


@either_rays
def test_each_ray_has_its_own_origin_and_direction(rays: RaysChoice) -> None:
    origins, directions = [(0, 0, 0), (0, 0.25, 0), (0, 0, 0), (6, 0, 0)], [(2, 0, 0), (1, 0, 0), (0, 0, 1), (-1, 0, 0)]
    reading = cast(BOX.format("3 0 0"), rays, ray_origins=origins, ray_directions=directions, max_range=10.0)
    assert reading.depths == pytest.approx([2.5, 2.5, 10.0, 2.5])
    np.testing.assert_allclose(reading.hit_positions, [(2.5, 0, 0), (2.5, 0.25, 0), (0, 0, 0), (3.5, 0, 0)], atol=1e-9)
    np.testing.assert_allclose(reading.hit_normals, [(-1, 0, 0), (-1, 0, 0), (0, 0, 0), (1, 0, 0)], atol=1e-9)
    np.testing.assert_allclose(reading.origins, origins)
    np.testing.assert_allclose(reading.ends, [(2.5, 0, 0), (2.5, 0.25, 0), (0, 0, 10), (3.5, 0, 0)], atol=1e-9)


@pytest.mark.parametrize(
    ("frame", "hit", "normal"), [("SENSOR", (2.5, 0, 0), (-1, 0, 0)), ("WORLD", (1, 4.5, 0), (0, -1, 0))]
)
def test_hits_are_in_the_frame_that_the_profile_names(frame: str, hit: Vector3, normal: Vector3) -> None:
    reading = cast(BOX.format("1 5 0"), at=(1, 2, 0), turned=QUARTER, output_frame=frame)
    np.testing.assert_allclose(reading.hit_positions, [hit], atol=1e-9)
    np.testing.assert_allclose(reading.hit_normals, [normal], atol=1e-9)
    np.testing.assert_allclose(reading.ends, [(1, 4.5, 0)], atol=1e-9)


def test_a_ray_turns_with_its_sensor() -> None:
    """Isaac Sim's test: a wall 4.9 m ahead is seen, and after a quarter turn the ray misses it, with the depth of the range."""
    wall = '<geom type="box" size=".1 5 5" pos="5 0 0"/>'
    assert cast(wall, min_range=0.1, max_range=20.0).depths == pytest.approx([4.9])
    assert cast(wall, turned=QUARTER, min_range=0.1, max_range=20.0).depths == pytest.approx([20.0])


def test_paths_of_bodies_are_reported_if_asked_for() -> None:
    ways = [(1, 0, 0), (-1, 0, 0)]
    assert cast(BOX.format("3 0 0"), ray_directions=ways).hit_prims == ("", "")
    assert cast(BOX.format("3 0 0"), report_hit_prim_paths=True, ray_directions=ways).hit_prims == ("/World/thing", "")


@either_rays
def test_objects_nearer_than_the_minimum_range_are_not_seen(rays: RaysChoice) -> None:
    near = '<geom type="box" size=".1 .1 .1" pos=".2 0 0"/>'
    assert cast(near + BOX.format("3 0 0"), rays).depths == pytest.approx([2.5])
    assert cast(near, rays).depths == pytest.approx([100.0])


@either_rays
@pytest.mark.parametrize("depth", [0.3, 0.1, -0.05])
def test_a_ray_that_starts_inside_a_body_hits_it_at_the_minimum_range(rays: RaysChoice, depth: float) -> None:
    """The front is nearer than the least range, or behind the sensor."""
    reading = cast(BOX.format(f"{0.5 + depth} 0 0"), rays)
    assert reading.depths == pytest.approx([0.4])
    np.testing.assert_allclose(reading.hit_positions, [(0.4, 0, 0)], atol=1e-9)
    np.testing.assert_allclose(reading.hit_normals, [(-1, 0, 0)])


def test_a_beam_that_begins_within_a_cube_is_broken_there() -> None:
    """Isaac Sim's test: a cube from 0.3 m on, and a beam from 0.4 m on."""
    reading = beams(BOX.format("0.8 -.5 .0001"), min_range=0.4, max_range=100.0)
    assert reading.hits.tolist() == [True]
    assert reading.depths == pytest.approx([0.4])


@either_rays
def test_all_beams_of_a_curtain_are_broken_by_a_cube(rays: RaysChoice) -> None:
    """Isaac Sim's test: five beams over half a metre, and a cube at 1 m."""
    reading = beams(BOX.format("1.5 -.4 0"), rays, num_rays=5, curtain_length=0.5)
    assert reading.hits.tolist() == [True] * 5
    assert reading.depths == pytest.approx([1.0] * 5)
    heights = [0.0, 0.1, 0.2, 0.3, 0.4]
    np.testing.assert_allclose(reading.hit_positions, [(1, 0, z) for z in heights], atol=1e-9)
    np.testing.assert_allclose(reading.origins, [(0.4, 0, z) for z in heights], atol=1e-9)
    np.testing.assert_allclose(reading.ends, [(1, 0, z) for z in heights], atol=1e-9)


def test_a_low_box_breaks_the_lower_beams() -> None:
    reading = beams('<geom type="box" size=".1 .1 .25" pos="1 0 0"/>', num_rays=5, curtain_length=0.5, max_range=3.0)
    assert reading.hits.tolist() == [True, True, True, False, False]
    assert reading.depths == pytest.approx([0.9, 0.9, 0.9, 3.0, 3.0])


def test_beams_go_along_the_axes_of_the_profile_and_turn_with_the_sensor() -> None:
    axes: dict[str, Any] = {
        "forward_axis": (0, 0, 2),
        "curtain_axis": (1, 0, 0),
        "num_rays": 2,
        "curtain_length": 1.0,
        "max_range": 5.0,
    }
    reading = beams("<geom size='.1' pos='9 9 9'/>", at=(1, 1, 1), turned=QUARTER, **axes)
    np.testing.assert_allclose(reading.origins, [(1, 1, 1.4), (1, 1.5, 1.4)], atol=1e-9)
    np.testing.assert_allclose(reading.ends, [(1, 1, 6), (1, 1.5, 6)], atol=1e-9)
    np.testing.assert_allclose(reading.hit_positions, [(0, 0, 5), (0.5, 0, 5)], atol=1e-9)
    assert not reading.hits.any()


@either_rays
def test_rays_and_beams_pass_through_the_sensors_own_robot(project: Project, rays: RaysChoice) -> None:
    sensors = "".join(f"  {kind}: {{type: {kind}, parent: base_link}}\n" for kind in ("raycast", "light_beam"))
    project.robot(f"sensors:\n{sensors}").world('<geom type="box" size=".1 9 9" pos="1.6 0 0"/>')
    world = project.load()
    simulation = Simulation(world.simulation.model, world.stage, Fraction(60), 4, rays=rays)
    stage = world.stage
    assert simulation.device(RaySet, stage.find("/bot/base_link/raycast")).reading().depths == pytest.approx([1.5])
    assert simulation.device(LightCurtain, stage.find("/bot/base_link/light_beam")).reading().hits.all()


@pytest.mark.parametrize(
    ("kind", "profile", "error"),
    [
        ("raycast", "{min_range: 5.0, max_range: 4.0}", "min_range must be less than max_range"),
        ("raycast", "{ray_origins: [[0, 0, 0], [0, 0, 1]]}", "2 ray_origins do not fit 1 ray_directions"),
        ("raycast", "{ray_directions: [[0, 0, 0]]}", "(0, 0, 0) is not a direction"),
        ("raycast", "{ray_directions: []}", "ray_directions"),
        ("light_beam", "{num_rays: 2}", "several beams need a curtain_length greater than 0"),
        ("light_beam", "{forward_axis: [0, 0, 0]}", "forward_axis: (0, 0, 0) is not a direction"),
        ("light_beam", "{num_rays: 0}", "num_rays"),
    ],
)
def test_a_bad_profile_is_an_error_at_its_place(project: Project, kind: str, profile: str, error: str) -> None:
    project.robot(f"sensors: {{eye: {{type: {kind}, parent: base_link, profile: {profile}}}}}")
    assert error in project.error()
