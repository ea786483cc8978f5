"""What ray sensors see of their own robot. Distances are compared with geometry, and one way to cast rays with the other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco, sort_geoms
from graphengine.devices.lidar import Lidar
from graphengine.devices.light_beam import LightBeam
from graphengine.devices.radar import Radar
from graphengine.devices.range import RangeSensor
from graphengine.devices.raycast import RaycastSensor
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.ray_casting.own_colliders import PASSED, VISIBLE, OwnColliders, contains
from graphengine.physics.ray_casting.rays import RaysChoice, select_rays
from tests.physics.harness import Project
from tests.physics.ray_casting.casters import either_rays, needs_numba, sphere

BASE = '<collision><origin xyz="0 0 0.1"/><geometry><box size="0.6 0.4 0.2"/></geometry></collision>'
MAST = '<collision><origin xyz="0 0 0.3"/><geometry><cylinder radius="0.02" length="0.6"/></geometry></collision>'
LIDAR = "{rate: 60.0, beams: {first_deg: -90, last_deg: 90, count: 3}, near: 0.1, far: 9.0}"
AHEAD = 1
"""The beam of the lidar that looks along x."""


def described(*, post: str = "", mast: str = MAST) -> str:
    """A robot with a mast 0.3 m before its centre, and a link for a sensor, which has no shape and is 0.3 m above the floor."""
    inertial = '<inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>'
    fixed = (
        '<joint name="{0}_joint" type="fixed"><parent link="base_link"/><child link="{0}"/><origin xyz="{1}"/></joint>'
    )
    return f"""<robot name="bot">
      <link name="base_link">{inertial}{BASE}{post}</link><link name="mast">{mast}</link><link name="laser"/>
      {fixed.format("mast", "0.3 0 0")}{fixed.format("laser", "0 0 0.3")}
    </robot>"""


def built(
    project: Project, sensor: str, world: str = '<geom type="box" size=".1 3 3" pos="3.1 0 0"/>', **shapes: str
) -> LoadedWorld:
    """A world with a wall 3 m ahead of the robot, and a sensor on the robot."""
    project.write("bot.urdf", described(**shapes)).robot(f"fixed_base: true\nsensors:\n  eye: {{{sensor}}}")
    project.write("scene.yaml", "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.yaml}\n")
    return project.write("world.xml", f"<mujoco><worldbody>{world}</worldbody></mujoco>").load()


def ahead(world: LoadedWorld) -> float:
    """The lidar's range straight ahead, m."""
    world.simulation.begin_tick(1)
    (prim,) = world.stage.prims("lidar")
    return float(world.simulation.device(Lidar, prim).scan().ranges[AHEAD])


@either_rays
@pytest.mark.parametrize(
    ("parent", "keys", "distance"),
    [
        ("laser", "", 0.28),
        ("laser", ", sees_own_robot: true", 0.28),
        ("laser", ", sees_own_robot: false", 3.0),
        ("laser", ", ignores: [mast]", 3.0),
        ("laser", ", ignores: [base_link]", 0.28),
        ("base_link", ", position: [0, 0, 0.3]", 0.28),
        ("mast", ", position: [-0.3, 0, 0.3]", 3.0),
    ],
)
def test_a_lidar_sees_its_own_mast_but_not_its_own_link_or_ignored_links(
    project: Project, rays: RaysChoice, parent: str, keys: str, distance: float
) -> None:
    world = built(project, f"type: lidar, profile: {LIDAR}, parent: {parent}{keys}")
    world.simulation._rays_choice = rays
    assert ahead(world) == pytest.approx(distance, abs=1e-6)


@either_rays
def test_a_sensor_on_a_link_without_shapes_sees_the_link_to_which_that_is_fixed(
    project: Project, rays: RaysChoice
) -> None:
    post = '<collision><origin xyz="0.2 0 0.3"/><geometry><box size="0.02 0.02 0.4"/></geometry></collision>'
    world = built(project, f"type: lidar, profile: {LIDAR}, parent: laser", post=post)
    world.simulation._rays_choice = rays
    assert ahead(world) == pytest.approx(0.19, abs=1e-6)


@either_rays
@pytest.mark.parametrize(("own", "distance"), [("0.05", 3.0), ("0.25", 0.23)])
def test_rays_pass_through_near_colliders_of_the_own_robot_but_hit_near_foreign_colliders(
    project: Project, rays: RaysChoice, own: str, distance: float
) -> None:
    mast = MAST.replace('xyz="0 0 0.3"', f'xyz="{float(own) - 0.3} 0 0.3"')
    sensor = f"type: lidar, profile: {LIDAR}, parent: laser"
    world = built(project, sensor, mast=mast)
    world.simulation._rays_choice = rays
    assert ahead(world) == pytest.approx(distance, abs=1e-6)
    foreign = '<geom type="cylinder" size="0.02 1" pos="0.05 0 0"/><geom type="box" size=".1 3 3" pos="3.1 0 0"/>'
    world = built(project, sensor, foreign, mast=mast)
    world.simulation._rays_choice = rays
    assert ahead(world) == math.inf


@either_rays
@pytest.mark.parametrize("least", ["0.02", "0.1"])
@pytest.mark.parametrize(
    "shape", ['<box size="0.2 0.2 0.3"/>', '<sphere radius="0.12"/>', '<cylinder radius="0.1" length="0.2"/>']
)
def test_a_ray_ignores_the_own_collider_in_which_it_starts_and_sees_the_next(
    project: Project, rays: RaysChoice, shape: str, least: str
) -> None:
    around = f'<collision><origin xyz="0 0 0.3"/><geometry>{shape}</geometry></collision>'
    profile = LIDAR.replace("near: 0.1", f"near: {least}")
    world = built(project, f"type: lidar, profile: {profile}, parent: laser", post=around)
    world.simulation._rays_choice = rays
    assert ahead(world) == pytest.approx(0.28, abs=1e-6)


@either_rays
def test_radars_range_sensors_beams_and_single_rays_see_the_mast_as_lidars_do(
    project: Project, rays: RaysChoice
) -> None:
    cases = {
        "radar": f"profile: {LIDAR}",
        "range": "profile: {rate: 60.0, field_of_view: 0.02, min_range: 0.1, max_range: 9.0}",
        "light_beam": "profile: {min_range: 0.1, max_range: 9.0}",
        "raycast": "profile: {min_range: 0.1, max_range: 9.0}",
    }
    for keys, distance in (("", 0.28), (", sees_own_robot: false", 3.0), (", ignores: [mast]", 3.0)):
        found = {}
        for kind, profile in cases.items():
            simulation = (world := built(project, f"type: {kind}, {profile}, parent: laser{keys}")).simulation
            simulation._rays_choice = rays
            simulation.begin_tick(1)
            (prim,) = world.stage.prims(kind)
            if kind == "radar":
                points = simulation.device(Radar, prim).detections().points
                found[kind] = float(points[np.abs(points[:, 1]) < 1e-3][0, 0])
            elif kind == "range":
                found[kind] = simulation.device(RangeSensor, prim).reading().range
            elif kind == "light_beam":
                found[kind] = float(simulation.device(LightBeam, prim).reading().depths[0])
            else:
                found[kind] = float(simulation.device(RaycastSensor, prim).reading().depths[0])
        assert found == pytest.approx(dict.fromkeys(cases, distance), abs=1e-5), keys


@either_rays
def test_a_bundle_ignores_the_own_collider_in_which_a_ray_starts_at_its_least_distance(
    project: Project, rays: RaysChoice
) -> None:
    post = '<collision><origin xyz="0.15 0 0.3"/><geometry><box size="0.1 0.1 0.3"/></geometry></collision>'
    world = built(project, "type: light_beam, profile: {min_range: 0.15, max_range: 9.0}, parent: laser", post=post)
    world.simulation._rays_choice = rays
    (prim,) = world.stage.prims("light_beam")
    assert world.simulation.device(LightBeam, prim).reading().depths[0] == pytest.approx(0.28, abs=1e-6)


def test_the_dingo_that_sees_itself_does_not_see_the_housing_of_its_lidar(project: Project) -> None:
    shipped = (
        "robot: dd100\nextends: robots/dd100.yaml\nsensors:\n  sim_lidar: {type: lidar, profile: microscan3_9m_20hz, "
        "parent: base_link/chassis_link, position: [0, 0, 0.15], sees_own_robot: SEES}\n"
    )
    found = []
    for sees in ("false", "true"):
        project.write("bot.yaml", shipped.replace("SEES", sees))
        project.write("world.xml", '<mujoco><worldbody><geom type="plane" size="0 0 1"/></worldbody></mujoco>')
        project.write(
            "scene.yaml", "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.yaml, position: [0, 0, 0.025]}\n"
        )
        simulation = (world := project.load()).simulation
        simulation.begin_tick(1)
        (prim,) = world.stage.prims("lidar")
        found.append(simulation.device(Lidar, prim).scan().ranges)
    assert np.isinf(found[0]).all()
    assert np.isfinite(found[1]).mean() < 0.2


def test_a_key_of_rays_on_an_imu_and_an_unknown_link_are_errors(project: Project) -> None:
    project.robot(
        "sensors:\n  eye: {type: imu, parent: base_link, profile: {rate: 60.0}, sees_own_robot: false}\n"
        f"  scan: {{type: lidar, parent: base_link, profile: {LIDAR}, ignores: [plate, plaet]}}"
    )
    _, findings = project.try_load()
    texts = [f"{finding.code} {finding.message}" for finding in findings.errors]
    assert texts == [
        "G109 sees_own_robot: has no effect, because a sensor of type imu casts no rays",
        "S104 the robot has no link 'plaet'",
    ]


SHAPES = {
    "sphere": 'type="sphere" size="0.3"',
    "capsule": 'type="capsule" size="0.1 0.2"',
    "ellipsoid": 'type="ellipsoid" size="0.3 0.2 0.1"',
    "cylinder": 'type="cylinder" size="0.2 0.3"',
    "box": 'type="box" size="0.1 0.2 0.3"',
    "mesh": 'type="mesh" mesh="wedge"',
}
WEDGE = '<mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>'


def robot_of(geoms: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A robot whose geoms are on a body that moves relative to its root, beside a foreign box."""
    text = f"""<mujoco><asset>{WEDGE}</asset><worldbody>
      <geom type="box" size="0.2 3 3" pos="2.5 0 0"/>
      <body name="root"><geom size="0.001" contype="0" conaffinity="0" rgba="0 0 0 0"/><body><joint/>{geoms}</body></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    sort_geoms(model)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("shape", SHAPES)
def test_a_point_is_within_a_shape_where_all_rays_from_it_hit_the_shape_from_inside(shape: str) -> None:
    model, data = robot_of(f'<geom {SHAPES[shape]} pos="0.1 0.2 0.3" euler="20 30 40"/>')
    geom, generator, directions = model.ngeom - 1, np.random.default_rng(0), sphere(6, 12)
    inside = 0
    for point in data.geom_xpos[geom] + generator.uniform(-0.4, 0.4, (200, 3)):
        met = np.zeros(1, np.int32)
        flags = np.array([1, 0, 0, 1, 0, 0], np.uint8)
        hits = [mujoco.mj_ray(model, data, point, ray, flags, False, -1, met, None) >= 0 for ray in directions]
        assert contains(model, data, geom, point) == all(hits)
        inside += all(hits)
    assert 0 < inside < 200


@needs_numba
def test_both_ways_to_cast_rays_pass_through_the_same_own_colliders() -> None:
    generator, directions = np.random.default_rng(3), sphere(12, 60)
    passed = near_hits = 0
    for _ in range(90):
        turned = [
            f'<geom {shape} pos="{x} {y} {z}" euler="{a} {b} {c}"/>'
            for shape in SHAPES.values()
            for x, y, z, a, b, c in [(*generator.uniform(-0.5, 0.5, 3), *generator.uniform(0, 360, 3))]
        ]
        model, data = robot_of("".join(turned))
        own = [OwnColliders(model, data, 1, body=1, passed=np.array([1]), near=0.2) for _ in range(2)]
        ways: tuple[RaysChoice, RaysChoice] = ("mujoco", "fast")
        casters = [
            select_rays(way, model, data).caster(directions, 9.0, each) for way, each in zip(ways, own, strict=True)
        ]
        (one, first), (two, second) = (caster.cast(np.zeros(3), np.eye(3)) for caster in casters)
        assert np.array_equal(own[0].roles, own[1].roles)
        assert one == pytest.approx(two, abs=1e-9)
        assert np.array_equal(first[one >= 0], second[two >= 0])
        roles = own[0].roles[first[one >= 0]]
        assert not (roles == PASSED).any()
        assert not ((roles == VISIBLE) & (one[one >= 0] < 0.2)).any()
        passed += int((own[0].roles == PASSED).sum()) - 1
        near_hits += int((one >= 0.2).sum())
    assert passed > 20
    assert near_hits > 1000
