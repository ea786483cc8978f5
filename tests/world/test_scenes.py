"""The scenes, robots and sensor profiles that ship."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from graphengine.diagnostics import Findings
from graphengine.spec import read
from graphengine.stage import Prim
from graphengine.world.sensors.profiles import SensorProfile
from tests.world.conftest import Ship
from tests.world.harness import SHIPPED, try_load

SCENES = sorted(
    str(path.relative_to(SHIPPED)) for path in SHIPPED.rglob("*.yaml") if "\nscene:" in path.read_text(encoding="utf-8")
)
PROFILES = sorted(path.stem for path in (SHIPPED / "sensors").glob("*.yaml"))
CHASSIS = "/dd100/Geometry/base_link/chassis_link"


def test_the_scenes_that_ship_are_these() -> None:
    assert SCENES == [
        "dd100_flat.yaml",
        "dd100_warehouse.yaml",
        "tutorial/flat_grid.yaml",
        "tutorial/navigation.yaml",
        "tutorial/simple_warehouse.yaml",
    ]


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_that_ships_loads_with_notes_at_most(name: str) -> None:
    loaded, findings = try_load(SHIPPED / name)
    assert loaded is not None
    assert {finding.severity for finding in findings.items} <= {"note"}
    assert loaded.simulation.settled_after is not None


@pytest.mark.parametrize("name", PROFILES)
def test_a_sensor_profile_is_named_as_its_file(name: str) -> None:
    findings = Findings()
    profile = read(SensorProfile, SHIPPED / "sensors" / f"{name}.yaml", findings)
    assert profile is not None
    assert profile.spec.sensor == name


@pytest.mark.parametrize("name", SCENES)
def test_the_prims_are_where_the_tutorial_has_them(ship: Ship, name: str) -> None:
    stage = ship(name).stage
    kinds = {
        "/dd100": "robot",
        "/dd100/Geometry/base_link": "link",
        CHASSIS: "link",
        f"{CHASSIS}/base_link": "frame",
        f"{CHASSIS}/front_left_wheel_link": "link",
        f"{CHASSIS}/rear_caster": "link",
        f"{CHASSIS}/front_0_mount/default_mount": "link",
        f"{CHASSIS}/sim_lidar": "sensor",
        f"{CHASSIS}/sim_lidar/Lidar": "lidar",
        f"{CHASSIS}/sim_camera/RSD455": "sensor",
        f"{CHASSIS}/sim_camera/RSD455/Camera_OmniVision_OV9782_Color": "camera",
        f"{CHASSIS}/sim_camera/RSD455/Camera_OmniVision_OV9782_Left": "camera",
        f"{CHASSIS}/sim_camera/RSD455/Camera_OmniVision_OV9782_Right": "camera",
        f"{CHASSIS}/sim_camera/RSD455/Camera_Pseudo_Depth": "camera",
        f"{CHASSIS}/sim_camera/RSD455/Imu_Sensor": "imu",
        "/dd100/Physics/front_left_wheel_joint": "joint",
        "/dd100/Physics/rear_caster_joint": "joint",
        "/dd100/Materials/WheelMaterial": "material",
        "/dd100/Materials/CasterMaterial": "material",
    }
    assert {path: stage.find(path).kind for path in kinds} == kinds
    facts = stage.find("/dd100").facts
    assert facts["base_link"] == "/dd100/Geometry/base_link"
    assert facts["articulation_root"] == CHASSIS
    assert facts["joints"] == ("front_left_wheel_joint", "front_right_wheel_joint")
    assert facts["moving_links"] == (f"{CHASSIS}/front_left_wheel_link", f"{CHASSIS}/front_right_wheel_link")
    assert facts["wheel_radii"] == dict.fromkeys(facts["joints"], 0.049)
    assert facts["wheel_distance"] == pytest.approx(0.4523232)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("dd100_warehouse.yaml", ["dd100_0000", "sim_lidar"]),
        ("dd100_flat.yaml", ["dd100_0000", "sim_lidar"]),
        ("tutorial/navigation.yaml", ["dd100_0000", "sim_lidar"]),
        ("tutorial/flat_grid.yaml", []),
        ("tutorial/simple_warehouse.yaml", []),
    ],
)
def test_namespaces_come_with_the_tutorials_third_stage(ship: Ship, name: str, expected: list[str]) -> None:
    assert ship(name).stage.namespaces(f"{CHASSIS}/sim_lidar/scan") == expected


@pytest.mark.parametrize(
    ("name", "position", "yaw"),
    [
        ("dd100_warehouse.yaml", (-3.0, 6.0), 90),
        ("tutorial/navigation.yaml", (-3.0, 6.0), 90),
        ("tutorial/simple_warehouse.yaml", (-5.0, 10.0), 135),
        ("tutorial/flat_grid.yaml", (0.0, 0.0), 0),
    ],
)
def test_the_robot_stands_where_the_tutorial_puts_it(
    ship: Ship, name: str, position: tuple[float, float], yaw: float
) -> None:
    world = ship(name)
    place, (x, y, z, w) = world.simulation.body(world.stage.find("/dd100")).pose()
    assert place[:2] == pytest.approx(position, abs=0.005)
    assert math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))) == pytest.approx(yaw, abs=0.1)


def test_the_cameras_look_ahead_with_the_sky_up(ship: Ship) -> None:
    """A camera looks along -z and has +y up."""
    world = ship("dd100_flat.yaml")
    camera = world.stage.find(f"{CHASSIS}/sim_camera/RSD455/Camera_OmniVision_OV9782_Color")
    position, (x, y, z, w) = world.simulation.frame(camera).pose()
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.array([w, x, y, z]))
    _, up, back = matrix.reshape(3, 3).T
    assert -back == pytest.approx([1, 0, 0], abs=1e-3)
    assert up == pytest.approx([0, 0, 1], abs=1e-3)
    assert position == pytest.approx((0.3, -0.0115, 0.05 + 0.0145), abs=1e-3)


def test_fixed_transforms_are_those_that_robot_state_publisher_sends(ship: Ship) -> None:
    robot = ship("dd100_flat.yaml").robots["dd100"]
    transforms = {child: (parent, position, rotation) for parent, child, position, rotation in robot.fixed_transforms}
    assert len(transforms) == 12
    assert transforms["rear_caster"][:2] == ("chassis_link", (-0.244, 0.0, -0.0045))  # levelled, in the text too
    assert 'xyz="-0.244 0.0 -0.0045"' in robot.urdf_text
    parent, position, rotation = transforms["rear_bumper_mount"]
    assert (parent, position) == ("chassis_link", (-0.274, 0.0, 0.0345125))
    assert rotation == pytest.approx((0, 0, 1, 0), abs=1e-9)


def test_every_wide_obstacle_of_the_full_warehouse_meets_the_lidars_plane(ship: Ship) -> None:
    """What a robot could hit and a lidar at 0.165 m could not see would be a trap."""
    world = ship("dd100_warehouse.yaml")
    model, data = world.simulation.model, world.simulation.data
    plane = world.simulation.frame(world.stage.find(f"{CHASSIS}/sim_lidar/Lidar")).pose()[0][2]
    assert plane == pytest.approx(0.165, abs=1e-3)
    obstacles = [p for p in world.stage.find("/World").children.values() if model.body(p.body).dofnum[0] == 0]
    assert len(obstacles) > 40
    for prim in obstacles:
        low, high, wide = extent(model, data, prim)
        if wide > 0.3:
            assert low < plane < high, prim.path


def extent(model: mujoco.MjModel, data: mujoco.MjData, prim: Prim) -> tuple[float, float, float]:
    """Lowest point, highest point and greatest width of a body's colliders that begin below 1 m."""
    low, high, wide = math.inf, -math.inf, 0.0
    for geom in np.flatnonzero((model.geom_bodyid == model.body(prim.body).id) & (model.geom_contype != 0)):
        half = np.abs(data.geom_xmat[geom].reshape(3, 3)) @ model.geom_aabb[geom, 3:]
        bottom, top = data.geom_xpos[geom][2] - half[2], data.geom_xpos[geom][2] + half[2]
        if bottom < 1.0:
            low, high, wide = min(low, bottom), max(high, top), max(wide, 2 * max(half[:2]))
    return low, high, wide
