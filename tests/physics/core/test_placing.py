"""Bodies that are put somewhere and held there."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import Pose, compose, from_rpy, multiply
from graphengine.devices.stage import Stage
from graphengine.format.errors import PhysicsError
from graphengine.format.spec import RobotUse
from graphengine.physics.handles.motion_handles import PlacedBody
from graphengine.physics.model.world_prims import add_world
from graphengine.physics.simulation import Simulation
from tests.physics.conftest import Ship
from tests.physics.harness import Project, yaw_of

IDENTITY = (0.0, 0.0, 0.0, 1.0)
WORLD = """<mujoco><compiler angle="radian"/><option timestep="{step}" integrator="discrete" cone="elliptic"/><worldbody>
  <geom name="floor" type="plane" size="0 0 1"/>
  <body name="table" pos="0 0 1"><freejoint/><geom type="box" size=".5 .5 .1" mass="1"/></body>
  <body name="weight" pos="0 0 1.31"><freejoint/><geom type="box" size=".2 .2 .2" mass="50"/></body>
  <body name="door" pos="3 0 1" quat="0.9238795325112867 0 0 0.3826834323650898">
    <joint name="hinge" axis="0 0 1" limited="true" range="-1 1"/><geom type="box" size=".4 .02 .9" pos=".4 0 0"/></body>
  <body name="wheel" pos="5 0 1"><joint axis="0 1 0"/><geom type="cylinder" size=".2 .02"/></body>
  <body name="lift" pos="7 0 1" euler="0 1.5707963267948966 0"><joint type="slide" axis="1 0 0"/><geom size=".1"/></body>
  <body name="ball" pos="9 0 1"><joint type="ball"/><geom type="sphere" size=".1"/></body>
  <body name="post" pos="11 0 1"><geom type="sphere" size=".1"/></body>
</worldbody></mujoco>"""


def simulate() -> Simulation:
    model = mujoco.MjModel.from_xml_string(WORLD.format(step=1 / 240))
    stage = Stage()
    add_world(stage, model, ())
    return Simulation(model, stage, Fraction(60), 4)


def placement(simulation: Simulation, path: str) -> PlacedBody:
    found = simulation.placement(simulation.stage.find(path))
    assert found is not None
    return found


def pose(simulation: Simulation, path: str) -> Pose:
    return simulation.frame(simulation.stage.find(path)).pose()


def steps(simulation: Simulation, count: int) -> list[bytes]:
    """Run; the state after each step."""
    found = []
    for _ in range(count):
        simulation.step()
        found.append(simulation.data.qpos.tobytes() + simulation.data.qvel.tobytes())
    return found


def test_a_body_is_where_it_was_put_at_once_and_stays_there_at_rest() -> None:
    simulation = simulate()
    there = ((1.0, 2.0, 3.0), from_rpy(0.1, 0.2, 0.3))
    placement(simulation, "/World/table").place(*there)
    for _ in range(3):
        assert pose(simulation, "/World/table") == there
        assert simulation.body(simulation.stage.find("/World/table")).velocity() == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        simulation.step()


def test_a_heavy_leaning_object_does_not_sink_into_a_held_body() -> None:
    simulation = simulate()
    placement(simulation, "/World/table").place((0.0, 0.0, 1.0), IDENTITY)
    steps(simulation, 480)
    # 1.3 m is where one lies on the other; MuJoCo's contacts give way by some tenths of a millimetre.
    assert pose(simulation, "/World/weight")[0] == pytest.approx((0.0, 0.0, 1.3), abs=5e-4)


def test_objects_on_a_body_move_along_when_it_is_moved_in_small_steps() -> None:
    simulation = simulate()
    table = placement(simulation, "/World/table")
    table.place((0.0, 0.0, 1.0), IDENTITY)
    steps(simulation, 60)
    for step in range(240):
        table.place((0.0, 0.0, 1.0 + step / 1000), IDENTITY)
        simulation.step()
    assert pose(simulation, "/World/weight")[0][2] == pytest.approx(1.54, abs=0.02)


def test_a_reset_releases_the_body_and_leaves_no_trace() -> None:
    fresh, held = simulate(), simulate()
    for name in ("table", "door", "lift"):
        placement(held, f"/World/{name}").place((2.0, 0.0, 2.0), IDENTITY)
    steps(held, 20)
    held.reset()
    assert steps(held, 60) == steps(fresh, 60)


def test_a_released_body_can_be_held_again() -> None:
    simulation = simulate()
    for height in (1.0, 2.0):
        placement(simulation, "/World/table").place((0.0, 0.0, height), IDENTITY)
        steps(simulation, 10)
        assert pose(simulation, "/World/table")[0] == (0.0, 0.0, height)
        simulation.reset()
    simulation.step()
    assert pose(simulation, "/World/table")[0][2] < 1.0


REST = from_rpy(0.0, 0.0, math.pi / 4)


@given(st.floats(-1.0, 1.0))
def test_a_link_that_turns_takes_the_angle_of_the_pose_and_keeps_its_place(angle: float) -> None:
    simulation = simulate()
    placement(simulation, "/World/door").place((0.0, 0.0, 0.0), multiply(REST, from_rpy(0.0, 0.0, angle)))
    position, orientation = pose(simulation, "/World/door")
    assert position == pytest.approx((3.0, 0.0, 1.0))
    assert yaw_of(orientation) == pytest.approx(math.pi / 4 + angle)


def test_a_link_goes_no_farther_than_its_joint_lets_it() -> None:
    simulation = simulate()
    placement(simulation, "/World/door").place((3.0, 0.0, 1.0), multiply(REST, from_rpy(0.0, 0.0, 1.5)))
    assert yaw_of(pose(simulation, "/World/door")[1]) == pytest.approx(math.pi / 4 + 1.0)


def test_a_wheel_goes_the_short_way_round() -> None:
    simulation = simulate()
    wheel = placement(simulation, "/World/wheel")
    for turn in range(1, 13):
        wheel.place((5.0, 0.0, 1.0), from_rpy(0.0, turn * 2.0, 0.0))
    assert simulation.data.joint(3).qpos[0] == pytest.approx(24.0)


def test_a_link_that_slides_goes_along_its_axis() -> None:
    simulation = simulate()
    placement(simulation, "/World/lift").place((7.5, 0.0, 1.3), from_rpy(0.0, math.pi / 2, 0.0))
    assert pose(simulation, "/World/lift")[0] == pytest.approx((7.0, 0.0, 1.3))  # its x points down
    steps(simulation, 10)
    assert pose(simulation, "/World/lift")[0] == pytest.approx((7.0, 0.0, 1.3))


@pytest.mark.parametrize("name", ["ball", "post"])
def test_fixed_bodies_and_bodies_on_ball_joints_cannot_be_placed(name: str) -> None:
    simulation = simulate()
    assert simulation.placement(simulation.stage.find(f"/World/{name}")) is None
    assert simulation.placement(simulation.stage.find("/World")) is None


@pytest.mark.parametrize("far", [1e11, math.inf, math.nan])
def test_a_place_that_mujoco_does_not_count_with_is_refused(far: float) -> None:
    simulation = simulate()
    before = pose(simulation, "/World/table")
    with pytest.raises(PhysicsError, match="/World/table cannot be put at"):
        placement(simulation, "/World/table").place((0.0, far, 0.0), IDENTITY)
    assert pose(simulation, "/World/table") == before
    simulation.step()
    assert pose(simulation, "/World/table") != before


# Robots


def test_a_robot_goes_with_its_base_and_its_links_keep_their_joints(project: Project) -> None:
    simulation = project.load().simulation
    plate = simulation.stage.find("/bot/base_link/arm/plate")
    there = ((4.0, 5.0, 1.0), from_rpy(0.0, 0.0, 1.0))
    placement(simulation, "/bot/base_link").place(*there)
    assert pose(simulation, "/bot/base_link") == there
    expected = compose(there, ((0.1, 0.0, 0.4), from_rpy(0.0, 0.0, math.pi / 2)))
    assert np.concatenate(simulation.frame(plate).pose()) == pytest.approx(np.concatenate(expected))
    assert simulation.placement(plate) is None


def test_a_robot_that_is_held_in_the_ground_does_not_shake(ship: Ship) -> None:
    simulation = ship("dd100_warehouse.yaml").simulation
    (x, y, z), orientation = pose(simulation, "/dd100")
    placement(simulation, "/dd100").place((x, y, z - 0.05), orientation)
    steps(simulation, 120)
    assert np.abs(simulation.data.qvel).max() < 0.01


def test_among_links_fixed_to_each_other_only_links_that_stand_for_the_robot_can_be_placed(ship: Ship) -> None:
    loaded = ship("dd100_warehouse.yaml")
    found = [
        prim for prim in loaded.stage.find("/dd100").descendants() if loaded.simulation.placement(prim) is not None
    ]
    wheels = ["front_left_wheel_link", "front_right_wheel_link"]
    assert [prim.name for prim in found] == ["dd100", "base_link", "chassis_link", *wheels]


@pytest.mark.parametrize(
    "prims", [("/bot", "/bot/base_link"), ("/bot/base_link/top", "/bot"), ("/bot", "/bot/base_link/top")]
)
def test_every_prim_that_stands_for_a_robot_moves_all_of_it(project: Project, prims: tuple[str, str]) -> None:
    top = '<link name="top"/><joint name="top_joint" type="fixed"><parent link="base_link"/><child link="top"/>'
    project.cart("</robot>", f'{top}<origin xyz="0 0 1"/></joint></robot>')
    simulation = project.robot("articulation_root: top").load().simulation
    fresh = steps(simulation, 20)
    simulation.reset()
    for height, path in zip((3.0, 4.0), prims, strict=True):
        there = ((1.0, 2.0, height), from_rpy(0.0, 0.0, 1.0))
        placement(simulation, path).place(*there)
        steps(simulation, 5)
        assert np.concatenate(pose(simulation, path)) == pytest.approx(np.concatenate(there))
    assert len(simulation.held) == 1
    simulation.reset()
    assert steps(simulation, 20) == fresh


def test_a_held_body_stays_held_when_robots_are_spawned_and_removed(project: Project) -> None:
    loaded = project.scene("  other: {use: bot.yaml, position: [9, 0, 0.1]}\n").load()
    simulation, there = loaded.simulation, ((4.0, 5.0, 1.0), IDENTITY)
    for name in ("bot", "other"):
        placement(simulation, f"/{name}/base_link").place(*there)
    loaded.remove("other")
    loaded.add("third", RobotUse(use="bot.yaml", position=(-4.0, 0.0, 0.1)))
    steps(simulation, 60)
    assert pose(simulation, "/bot/base_link") == there
    assert list(simulation.held) == ["/bot/Geometry/base_link"]
