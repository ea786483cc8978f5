"""What a robot does is the same, bit by bit, whoever else is there, as long as they do not meet."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.physics.loaded_world import LoadedWorld
from tests.physics.harness import CART, FLOOR, Project

BODIES = (
    '<geom type="box" size=".1 9 1" pos="3 0 1"/>'
    '<body name="crate" pos="1 .1 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="2"/></body></worldbody>'
)
KINDS = {"robots/dd100.yaml": (0.02, 40), "robots/tutorial_dd100.yaml": (0.0, 170), "arm.yaml": (0.3, 90)}
CROWD = "".join(
    f"  other_{row}{column}: {{use: {kind}, position: [{-4 - 2 * row}, {-2 * column}, {height}],"
    f" orientation: {{rpy_deg: [{5 * row}, 0, {yaw}]}}}}\n"
    for column, (kind, (height, yaw)) in enumerate(KINDS.items())
    for row in range(3)
)


@pytest.fixture
def scene(project: Project) -> Project:
    project.write("world.xml", FLOOR.replace("</worldbody>", BODIES)).write("arm.urdf", CART)
    return project.write(
        "arm.yaml",
        "robot: arm\nurdf: arm.urdf\njoints: {arm_joint: {drive: {stiffness: 20, damping: 0.5, overtravel: 2}}}\n",
    )


def write(scene: Project, main: str, others: str) -> LoadedWorld:
    first = f"  main: {{use: robots/{main}.yaml, position: [0, 0, 0.02]}}\n"
    scene.write("scene.yaml", f"scene: t\nworld: world.xml\nsettle: true\nrobots:\n{others}{first}")
    return scene.load()


def drive(world: LoadedWorld, seconds: float) -> NDArray[np.float64]:
    """Poses and velocities of the main robot, which drives in curves into the crate and the wall."""
    simulation, stage = world.simulation, world.stage
    base = simulation.body(stage.find("/main/base_link"))
    joints = {name: simulation.articulation(stage.find(f"/{name}")).select() for name in world.robots}
    seen = []
    for step in range(round(seconds * 240)):
        if step % 4 == 0:
            for index, (name, selected) in enumerate(joints.items()):
                if len(selected.names) == 1:
                    selected.command(positions=[math.sin(step / 100 + index)])
                else:
                    phase = step / 300 + (0 if name == "main" else index + 1)
                    selected.command(velocities=[15 + math.sin(phase), 15 - math.sin(phase)])
        simulation.step()
        seen.append([*base.pose()[0], *base.pose()[1], *base.velocity()[0], *base.velocity()[1]])
    return np.array(seen)


@pytest.mark.parametrize("main", ["dd100", "tutorial_dd100"])
def test_a_robot_moves_alone_exactly_as_among_other_robots(scene: Project, main: str) -> None:
    alone = write(scene, main, "")
    crowd = write(scene, main, CROWD)
    assert len(crowd.robots) == 10
    one, other = drive(alone, 5.0), drive(crowd, 5.0)
    crate = alone.simulation.body(alone.stage.find("/World/crate")).pose()[0]
    assert crate[0] > 1.5  # from 1 m: it was pushed, in the end against the wall
    np.testing.assert_array_equal(one, other)


def test_an_arm_that_pushes_against_its_stop_does_so_in_a_crowd_as_alone(scene: Project) -> None:
    first = "  main: {use: arm.yaml, position: [0, 0, 0.06]}\n"
    seen = []
    for others in ("", CROWD):
        world = scene.write("scene.yaml", f"scene: t\nworld: world.xml\nsettle: true\nrobots:\n{others}{first}").load()
        efforts = []
        for step in range(960):
            if step % 4 == 0:
                for index, name in enumerate(reversed(world.robots)):
                    joints = world.simulation.articulation(world.stage.find(f"/{name}")).select()
                    joints.command(positions=[3 * math.sin(step / 100 + index)] * len(joints.names))
            world.simulation.step()
            efforts.append(world.simulation.articulation(world.stage.find("/main")).efforts()[0])
        seen.append(efforts)
    assert max(seen[0]) > 35.0  # of the 40 N m that its description allows
    assert seen[0] == seen[1]
