"""Bodies of sensors: seen by cameras and by the rays of others, and of no effect on anything that moves."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.devices.stage import housing_of
from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.physics.sensors.contact import BodyContactSensor
from graphengine.physics.sensors.lidar import RayLidar
from graphengine.physics.simulation import Simulation
from tests.physics.harness import FLOOR, ROBOT, SCENE, Project, steps
from tests.physics.ray_casting.casters import either_rays

LIDAR = """sensor: mine
lidar: {rate: 10.0, beams: {first_deg: -180.0, last_deg: 179.0, count: 360}, near: 0.01, far: 12.0}
"""
APPEARANCE = """appearance:
  - {shape: box, size: [0.4, 0.2, 0.1], position: [0.1, 0.0, 0.0], colour: [1.0, 0.0, 0.0]}
"""
HEIGHT = 0.6
"""Of the sensor above its link, m: above all else of the robot."""
EYE = f"  eye: {{type: lidar, profile: mine, parent: base_link, position: [0, 0, {HEIGHT}]%s}}\n"
BOTH = SCENE + "  other: {use: bot.yaml, position: [3, 0, 0.1]}\n"
AHEAD, BEHIND = 180, 0


def two_carts(project: Project, turn: str = "", appearance: str = APPEARANCE) -> LoadedWorld:
    """Two carts, 3 m apart along x, each with a lidar."""
    project.write("scene.yaml", BOTH).write("bot.yaml", f"{ROBOT}sensors:\n{EYE % turn}")
    return project.write("sensors/mine.yaml", LIDAR + appearance).load()


def ranges(world: LoadedWorld, robot: str, rays: RaysChoice = "auto") -> NDArray[np.float32]:
    simulation = Simulation(world.simulation.model, world.stage, Fraction(60), 4, rays=rays)
    return simulation.device(RayLidar, world.stage.find(f"/{robot}/base_link/eye/Lidar")).scan().ranges


@either_rays
def test_rays_of_other_robots_hit_a_housing_and_the_own_rays_pass_through(project: Project, rays: RaysChoice) -> None:
    world = two_carts(project)
    seen, back = ranges(world, "bot", rays), ranges(world, "other", rays)
    assert seen[AHEAD] == pytest.approx(3.0 + 0.1 - 0.2, abs=1e-6)
    assert back[BEHIND] == pytest.approx(3.0 - 0.1 - 0.2, abs=1e-6)
    for found, distance in ((seen, 2.9), (back, 2.7)):  # it is 0.2 m wide, and a beam goes out at each degree
        assert np.isfinite(found).sum() == 2 * math.floor(math.degrees(math.atan(0.1 / distance))) + 1
    assert np.isinf(ranges(two_carts(project, appearance=""), "bot", rays)).all()


def test_its_name_is_the_robots_wherever_the_robots_prim_is(project: Project) -> None:
    two_carts(project)
    placed = BOTH.replace("use: bot.yaml, position: [3", "use: bot.yaml, at: /World/cart, position: [3")
    world = project.write("scene.yaml", placed).load()
    (mount,) = [prim for prim in world.stage.find("/World/cart").descendants() if prim.name == "eye"]
    assert housing_of(mount) == "other/Geometry/base_link/eye"
    assert world.simulation.model.body(housing_of(mount)).id > 0


def test_a_housing_has_the_pose_of_its_sensor(project: Project) -> None:
    world = two_carts(project, ", orientation: {rpy_deg: [0, 0, 90]}")
    left = ranges(world, "bot")[90]  # the beam to the sensor's right, which is ahead of the robot
    assert left == pytest.approx(3.0 - 0.1, abs=1e-6)  # what was its length is across now


def test_a_cylinder_has_its_stated_width_and_stands_upright(project: Project) -> None:
    cylinder = "appearance:\n  - {shape: cylinder, size: [0.3, 0.3, 0.02], colour: [0, 0, 0]}\n"
    world = two_carts(project, appearance=cylinder)
    assert ranges(world, "bot")[AHEAD] == pytest.approx(3.0 - 0.15, abs=1e-6)


WALL = '<geom type="box" size=".1 9 1" pos="1.2 0 1"/></worldbody>'
DD100 = f"""robot: dd100
extends: robots/dd100.yaml
sensors:
  sim_lidar: {{type: lidar, profile: mine, parent: base_link/chassis_link, position: [0, 0, {HEIGHT}]}}
"""


def crash(project: Project, appearance: str) -> tuple[Simulation, NDArray[np.float64]]:
    """A dd100 that drives into a wall, and its state all the way."""
    project.write("world.xml", FLOOR.replace("</worldbody>", WALL)).write("bot.yaml", DD100)
    simulation = project.write("sensors/mine.yaml", LIDAR + appearance).load().simulation
    simulation.articulation(simulation.stage.find("/bot")).select().command(velocities=[20.0, 19.0])
    states = []
    for _ in range(600):
        simulation.step()
        states.append(np.concatenate([simulation.data.qpos, simulation.data.qvel]))
    return simulation, np.array(states)


def test_a_housing_without_mass_and_collisions_does_not_change_the_motion_to_the_last_bit(project: Project) -> None:
    (bare, expected), (dressed, states) = crash(project, ""), crash(project, APPEARANCE)
    assert dressed.model.nbody == bare.model.nbody + 1
    assert dressed.model.body("bot/Geometry/base_link/chassis_link/sim_lidar").mass == 0.0
    assert dressed.model.body_mass.sum() == bare.model.body_mass.sum()
    place = dressed.model.body("bot/chassis_link").id
    assert dressed.data.xpos[place][0] > 0.5  # it has reached the wall
    assert expected.tobytes() == states.tobytes()


def test_lidars_see_an_added_robot_until_its_removal(project: Project) -> None:
    world = two_carts(project)
    guest = RobotUse.model_validate({"use": "bot.yaml", "position": [0.0, 3.0, 0.1]})
    left, lidar = 270, world.simulation.device(RayLidar, world.stage.find("/bot/base_link/eye/Lidar"))
    before = lidar.scan().ranges
    world.add("guest", guest)
    assert lidar.scan().ranges[left] == pytest.approx(3.0 - 0.1, abs=1e-6)
    world.remove("guest")
    assert np.array_equal(lidar.scan().ranges, before)
    assert math.isinf(before[left])


def test_a_sensor_that_is_mounted_on_another_hangs_on_the_link(project: Project) -> None:
    bumper = "  bumper: {type: contact, parent: eye}\n"
    project.write("bot.yaml", f"{ROBOT}sensors:\n{EYE % ''}{bumper}").write("sensors/mine.yaml", LIDAR + APPEARANCE)
    simulation = project.load().simulation
    sensor = simulation.device(BodyContactSensor, simulation.stage.find("/bot/base_link/eye/bumper"))
    steps(simulation, 400)
    assert sensor.reading().in_contact


@pytest.mark.parametrize(
    ("sensors", "bodies"),
    [
        ("  RSD455: {type: realsense_d455, parent: arm}\n", ["Geometry/base_link/arm/RSD455"]),
        ("  unit: {type: imu, profile: unit, parent: arm}\n", ["Geometry/base_link/arm/unit"]),
        (
            EYE % "" + "  top: {type: lidar, profile: mine, parent: eye}\n",
            ["Geometry/base_link/eye", "Geometry/base_link/eye/top"],
        ),
    ],
)
def test_every_kind_of_sensor_gets_a_housing_under_any_name_and_parent(
    project: Project, sensors: str, bodies: list[str]
) -> None:
    project.write("bot.yaml", f"{ROBOT}sensors:\n{sensors}").write("sensors/mine.yaml", LIDAR + APPEARANCE)
    project.write("sensors/unit.yaml", f"sensor: unit\nimu: {{rate: 50.0}}\n{APPEARANCE}")
    simulation = project.load().simulation
    names = {simulation.model.body(index).name for index in range(simulation.model.nbody)}
    assert names == {"world", "bot/base_link", "bot/arm", *(f"bot/{body}" for body in bodies)}
    for body in bodies:
        position, _ = simulation.frame(simulation.stage.find(f"/bot/{body}")).pose()
        assert simulation.data.body(f"bot/{body}").xpos == pytest.approx(position)


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("box", "ball", "4:13: error G109: shape: expected 'box' or 'cylinder', got 'ball'"),
        ("box", "cylinder", "4:5: error G109: appearance[0]: a cylinder is round: length and width must be equal"),
        ("0.4, ", "", "4:24: error G108: size: expected 3 values, got 2"),
        ("0.4, ", "0.0, ", "4:25: error G109: size[0]: expected a value > 0, got 0.0"),
        ("0.4, ", "1e300, ", "4:25: error G109: size[0]: expected a value ≤ 10, got 1e+300"),
        ("[1.0, 0.0, 0.0]", "[255, 0, 0]", "4:77: error G109: colour[0]: expected a value ≤ 1, got 255"),
        (", colour: [1.0, 0.0, 0.0]", "", "4:5: error G107: missing key 'colour'"),
    ],
)
def test_an_invalid_appearance_is_reported_at_its_place(project: Project, old: str, new: str, error: str) -> None:
    assert old in APPEARANCE
    project.write("bot.yaml", f"{ROBOT}sensors:\n{EYE % ''}")
    project.write("sensors/mine.yaml", LIDAR + APPEARANCE.replace(old, new, 1))
    assert project.error().startswith(f"sensors/mine.yaml:{error}")
