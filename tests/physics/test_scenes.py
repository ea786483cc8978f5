"""The scenes, robots and sensor profiles that ship."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image

from graphengine.devices.stage import Prim
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.occupancy.flood_fill import reached
from graphengine.physics.occupancy.occupancy_map import FREE, OCCUPIED, MapRequest, OccupancyMap, Point, make_map
from tests.physics.conftest import Ship
from tests.physics.harness import SHIPPED, Project, steps, try_load
from tests.physics.make_worlds import write_worlds

SCENES = sorted(
    str(path.relative_to(SHIPPED)) for path in SHIPPED.rglob("*.yaml") if "\nworld:" in path.read_text(encoding="utf-8")
)
CHASSIS = "/dd100/Geometry/base_link/chassis_link"


def test_the_scenes_that_ship_are_these() -> None:
    assert SCENES == [
        "dd100_flat.yaml",
        "dd100_fleet.yaml",
        "dd100_hall.yaml",
        "dd100_hall_pair.yaml",
        "dd100_hall_workers.yaml",
        "dd100_warehouse.yaml",
        "demo.yaml",
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


def test_the_worlds_equal_the_output_of_their_program(tmp_path: Path) -> None:
    write_worlds(tmp_path)
    written = sorted(path.name for path in tmp_path.glob("*.xml"))
    assert written == sorted(path.name for path in (SHIPPED / "worlds").glob("*.xml"))
    for name in written:
        assert (tmp_path / name).read_bytes() == (SHIPPED / "worlds" / name).read_bytes()
    prints = sorted((tmp_path / "prints").iterdir())
    assert [path.name for path in prints] == sorted(path.name for path in (SHIPPED / "worlds/prints").iterdir())
    for path in prints:
        with Image.open(path) as made, Image.open(SHIPPED / "worlds/prints" / path.name) as shipped:
            assert made.tobytes() == shipped.tobytes()


@pytest.mark.parametrize("name", SCENES)
def test_the_prims_are_where_the_tutorial_has_them(ship: Ship, name: str) -> None:
    world = ship(name)
    stage, robot = world.stage, next(iter(world.robots))
    chassis = f"/{robot}/Geometry/base_link/chassis_link"
    kinds = {
        f"/{robot}": "robot",
        f"/{robot}/Geometry/base_link": "link",
        chassis: "link",
        f"{chassis}/base_link": "frame",
        f"{chassis}/front_left_wheel_link": "link",
        f"{chassis}/rear_caster": "link",
        f"{chassis}/front_0_mount/default_mount": "link",
        f"{chassis}/sim_lidar": "sensor",
        f"{chassis}/sim_lidar/Lidar": "lidar",
        f"{chassis}/sim_camera/RSD455": "sensor",
        f"{chassis}/sim_camera/RSD455/Camera_OmniVision_OV9782_Color": "camera",
        f"{chassis}/sim_camera/RSD455/Camera_OmniVision_OV9782_Left": "camera",
        f"{chassis}/sim_camera/RSD455/Camera_OmniVision_OV9782_Right": "camera",
        f"{chassis}/sim_camera/RSD455/Camera_Pseudo_Depth": "camera",
        f"{chassis}/sim_camera/RSD455/Imu_Sensor": "imu",
        f"/{robot}/Physics/front_left_wheel_joint": "joint",
        f"/{robot}/Physics/rear_caster_joint": "joint",
        f"/{robot}/Materials/WheelMaterial": "material",
        f"/{robot}/Materials/CasterMaterial": "material",
    }
    assert {path: stage.find(path).kind for path in kinds} == kinds
    facts = stage.find(f"/{robot}").facts
    assert facts["base_link"] == f"/{robot}/Geometry/base_link"
    assert facts["articulation_root"] == chassis
    assert facts["joints"] == ("front_left_wheel_joint", "front_right_wheel_joint")
    assert facts["moving_links"] == (f"{chassis}/front_left_wheel_link", f"{chassis}/front_right_wheel_link")
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
        ("dd100_hall.yaml", (-3.0, 6.0), 90),
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


def test_fixed_transforms_equal_the_transforms_of_robot_state_publisher(ship: Ship) -> None:
    robot = ship("dd100_flat.yaml").robots["dd100"]
    transforms = {child: (parent, position, rotation) for parent, child, position, rotation in robot.fixed_transforms}
    assert len(transforms) == 12
    assert transforms["rear_caster"][:2] == ("chassis_link", (-0.244, 0.0, -0.0045))  # levelled, in the text too
    assert 'xyz="-0.244 0.0 -0.0045"' in robot.urdf_text
    parent, position, rotation = transforms["rear_bumper_mount"]
    assert (parent, position) == ("chassis_link", (-0.274, 0.0, 0.0345125))
    assert rotation == pytest.approx((0, 0, 1, 0), abs=1e-9)


@pytest.mark.parametrize("name", ["dd100_warehouse.yaml", "tutorial/simple_warehouse.yaml"])
def test_every_wide_obstacle_meets_the_lidars_plane_and_the_maps_window(ship: Ship, name: str) -> None:
    """What a robot could hit and a lidar at 0.165 m or a map could not see would be a trap."""
    world = ship(name)
    model, data = world.simulation.model, world.simulation.data
    plane = world.simulation.frame(world.stage.find(f"{CHASSIS}/sim_lidar/Lidar")).pose()[0][2]
    assert plane == pytest.approx(0.165, abs=1e-3)
    obstacles = [
        p for p in world.stage.find("/World").children.values() if p.body and model.body(p.body).dofnum[0] == 0
    ]
    assert len(obstacles) > 14
    for prim in obstacles:
        low, high, wide = extent(model, data, prim)
        if wide > 0.3:
            assert low < plane < high, prim.path
            assert low < 0.2 < 0.62 < high, prim.path


def extent(model: mujoco.MjModel, data: mujoco.MjData, prim: Prim) -> tuple[float, float, float]:
    """Lowest point, highest point and greatest width of a body's colliders that begin below 1 m."""
    low, high, wide = math.inf, -math.inf, 0.0
    for geom in np.flatnonzero((model.geom_bodyid == model.body(prim.body).id) & (model.geom_contype != 0)):
        half = np.abs(data.geom_xmat[geom].reshape(3, 3)) @ model.geom_aabb[geom, 3:]
        bottom, top = data.geom_xpos[geom][2] - half[2], data.geom_xpos[geom][2] + half[2]
        if bottom < 1.0:
            low, high, wide = min(low, bottom), max(high, top), max(wide, 2 * max(half[:2]))
    return low, high, wide


# Room to drive, and things to push


def obstacles(world: LoadedWorld, low: tuple[float, float], high: tuple[float, float], start: Point) -> OccupancyMap:
    """A map of a rectangle in cells of 0.05 m, loose things included; free is what can be reached from a start."""
    loose = [prim.path for prim in loose_things(world)]
    request = MapRequest(window=(0.05, 0.62), cell=0.05, bounds=(low, high), seeds=[start], include=loose)
    return make_map(world, request)


def loose_things(world: LoadedWorld) -> list[Prim]:
    model = world.simulation.model
    return [p for p in world.stage.find("/World").children.values() if p.body and model.body(p.body).dofnum[0] == 6]


@pytest.mark.parametrize("name", ["dd100_warehouse.yaml", "tutorial/navigation.yaml", "tutorial/simple_warehouse.yaml"])
@pytest.mark.parametrize(("x", "y"), [(-3.0, 6.0), (-5.0, 10.0)])
def test_around_the_tutorials_poses_80_cm_are_free_in_both_halls(ship: Ship, name: str, x: float, y: float) -> None:
    chart = obstacles(ship(name), (x - 1, y - 1), (x + 1, y + 1), (x, y))
    rows, columns = np.nonzero(chart.cells != FREE)
    centres = [chart.grid.centre(row, column) for row, column in zip(rows.tolist(), columns.tolist(), strict=True)]
    assert min((math.dist((x, y), centre) for centre in centres), default=math.inf) > 0.8 + 0.05


def test_equipment_blocks_the_straight_way_to_the_goal_and_leaves_one_of_120_cm(ship: Ship) -> None:
    """The main aisle between the racks: nobody may leave it to get around the forklift."""
    start, goal, wide = (-3.0, 6.0), (-3.0, 14.5), 1.2
    chart = obstacles(ship("dd100_warehouse.yaml"), (-7.3, 5.0), (0.8, 15.5), start)
    straight = [chart.grid.locate(start[0], y) for y in np.arange(start[1], goal[1], 0.02)]
    assert any(chart.cells[cell] == OCCUPIED for cell in straight if cell is not None)
    reach = math.ceil(wide / 2 / 0.05)
    rows, columns = chart.cells.shape
    walled = np.pad(chart.cells != FREE, reach, constant_values=True)
    too_near = np.zeros(chart.cells.shape, np.bool_)
    for i, j in np.ndindex(2 * reach + 1, 2 * reach + 1):
        if math.hypot(i - reach, j - reach) <= reach:
            too_near |= walled[i : i + rows, j : j + columns]
    way, end = chart.grid.locate(*start), chart.grid.locate(*goal)
    assert way is not None
    assert end is not None
    assert reached(~too_near, [way])[end]


@pytest.mark.parametrize("name", ["dd100_warehouse.yaml", "tutorial/simple_warehouse.yaml"])
def test_loose_bodies_lie_on_the_floor_and_sleep(ship: Ship, name: str) -> None:
    world = ship(name)
    model, data = world.simulation.model, world.simulation.data
    things = loose_things(world)
    assert {"box", "cone", "barrel"} == {prim.name.partition("_")[0] for prim in things}
    before = data.qpos.copy()
    steps(world.simulation, 240)
    for prim in things:
        body = model.body(prim.body)
        assert 2.0 <= body.mass[0] <= 10.0
        assert data.tree_asleep[model.body_treeid[body.id]] >= 0
        joint = model.jnt_qposadr[body.jntadr[0]]
        assert data.qpos[joint : joint + 7].tolist() == before[joint : joint + 7].tolist()


@pytest.mark.parametrize("world", ["full_warehouse", "simple_warehouse"])
@pytest.mark.parametrize("thing", ["box_02", "cone_01", "barrel"])
def test_the_dd100_pushes_loose_bodies(project: Project, world: str, thing: str) -> None:
    world_file = mujoco.MjSpec.from_file(str(SHIPPED / f"worlds/{world}.xml"))
    bodies = {body.name: body for body in world_file.bodies if body.joints}
    name = max(body for body in bodies if body.startswith(thing))
    x, y, _ = bodies[name].pos
    place = f"position: [{x}, {y - 1.0}, 0.025], orientation: {{rpy_deg: [0, 0, 90]}}"
    scene = (
        f"scene: push\nworld: worlds/{world}.xml\nsettle: true\nrobots:\n  dd100: {{use: robots/dd100.yaml, {place}}}\n"
    )
    loaded = project.write("scene.yaml", scene).load()
    body = loaded.simulation.body(loaded.stage.find(f"/World/{name}"))
    wheels = loaded.simulation.articulation(loaded.stage.find("/dd100")).select(
        ("front_left_wheel_joint", "front_right_wheel_joint")
    )
    wheels.command(velocities=[0.5 / 0.049] * 2)
    steps(loaded.simulation, 4 * 240)
    (east, north, up), _ = body.pose()
    assert north - y > 0.5
    assert abs(east - x) < 0.3
    assert abs(up) < 0.02


def scans(world: str) -> tuple[np.ndarray, np.ndarray]:
    """Places (m) along the aisles of a hall, and what a lidar of 9 m sees there, a beam a degree."""
    model = mujoco.MjModel.from_xml_path(str(SHIPPED / f"worlds/{world}.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    angles = np.radians(np.arange(360.0))
    beams = np.stack([np.cos(angles), np.sin(angles), np.zeros(360)], 1).ravel()
    places, seen = [], []
    for x in (-22.0, -18.0, -14.0, -10.0, -3.0):
        for y in np.arange(-3.0, 27.0, 0.5):
            ranges, geoms = np.zeros(360), np.zeros(360, np.int32)
            mujoco.mj_multiRay(model, data, np.array([x, y, 0.165]), beams, None, 1, -1, geoms, ranges, None, 360, 9.0)
            ranges[ranges < 0] = 9.0
            if ranges.min() > 0.4:
                places.append((x, y))
                seen.append(ranges)
    return np.array(places), np.array(seen)


def test_a_lidar_tells_the_places_of_the_hall_with_features_apart() -> None:
    least = {}
    for world in ("full_warehouse", "warehouse_features"):
        places, seen = scans(world)
        assert len(places) > 250
        differing = []
        for place, ranges in zip(places, seen, strict=True):
            elsewhere = np.hypot(*(places - place).T) > 1.0
            both = [(np.abs(np.roll(seen[elsewhere], turn, 1) - ranges) > 0.2).mean(1) for turn in (0, 180)]
            differing.append(np.minimum(*both).min())
        least[world] = min(differing)
    assert least["full_warehouse"] < 0.01
    assert least["warehouse_features"] > 0.3
