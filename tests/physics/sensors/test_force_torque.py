"""What a force-torque sensor measures: weights at lever arms, accelerated links, contacts, and its noise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.rotation import Vector3, from_rpy, unrotate, vector
from graphengine.format.errors import ContextError
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.sensors.force_torque import JointWrenchSensor
from tests.physics.harness import Project, ticks

G = 9.81
MASS, ARM = 2.0, (0.1, 0.2, 0.3)
"""Mass of the tool (kg) and its centre of mass in the frame of its link, m."""
INERTIA = '<inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/>'


def link(name: str, mass: float = 0.0, at: Vector3 = (0.0, 0.0, 0.0), inside: str = "") -> str:
    """A link with a point mass (kg) at a position, m."""
    place = " ".join(map(str, at))
    inertial = f'<inertial><origin xyz="{place}"/><mass value="{mass}"/>{INERTIA}</inertial>' if mass else ""
    return f'<link name="{name}">{inertial}{inside}</link>'


def joint(kind: str, parent: str, child: str, origin: str = "", axis: str = "0 0 1") -> str:
    """A joint whose name is that of its child link, with `_joint`."""
    limit = '<limit lower="-9" upper="9" effort="0" velocity="0"/>' if kind in ("revolute", "prismatic") else ""
    return (
        f'<joint name="{child}_joint" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin {origin}/><axis xyz="{axis}"/>{limit}</joint>'
    )


def sensor(project: Project, *parts: str, keys: str = "", parent: str = "tool", **profile: Any) -> JointWrenchSensor:
    """A sensor in the joint above the tool of a robot with a fixed base, without other bodies around."""
    project.write("world.xml", "<mujoco/>").write("bot.urdf", f"<robot name='bot'>{''.join(parts)}</robot>")
    entry = f"{{type: force_torque, parent: {parent}, profile: {profile}}}"
    project.write("bot.yaml", f"robot: bot\nurdf: bot.urdf\nsensors:\n  ft: {entry}\n{keys or 'fixed_base: true'}\n")
    world = project.load()
    (prim,) = world.stage.prims("force_torque")
    return world.simulation.device(JointWrenchSensor, prim)


def measured(sensor: JointWrenchSensor, count: int = 1) -> tuple[list[float], list[float]]:
    """Force and torque after some ticks."""
    ticks(sensor._simulation, count)
    reading = sensor.reading()
    return list(reading.force), list(reading.torque)


def joints(sensor: JointWrenchSensor) -> Joints:
    """The joints of the robot that carries the sensor."""
    return sensor._simulation.handles.find(Joints, sensor._simulation.stage.find("/bot"))


def moment(arm: Vector3, force: Vector3) -> list[float]:
    """The torque r x F of a force (N) at an arm, m."""
    return [float(part) for part in np.cross(arm, force)]


FIXED = link("base_link", 1.0), link("tool", MASS, ARM)
WEIGHT = (0.0, 0.0, -MASS * G)


def test_a_fixed_joint_bears_the_weight_at_its_lever_arm(project: Project) -> None:
    force, torque = measured(sensor(project, *FIXED, joint("fixed", "base_link", "tool", 'xyz="1 2 3"')))
    assert force == pytest.approx(WEIGHT, abs=1e-9)
    assert torque == pytest.approx(moment(ARM, WEIGHT), abs=1e-9)


def test_the_parent_exerts_the_opposite_wrench(project: Project) -> None:
    fixed = joint("fixed", "base_link", "tool")
    force, torque = measured(sensor(project, *FIXED, fixed, measure_direction="parent_to_child"))
    assert force == pytest.approx([-part for part in WEIGHT], abs=1e-9)
    assert torque == pytest.approx([-part for part in moment(ARM, WEIGHT)], abs=1e-9)


@pytest.mark.parametrize("axes", ["sensor", "parent"])
def test_a_wrench_has_the_axes_of_the_sensor_or_of_the_parent_link(project: Project, axes: str) -> None:
    """The tool is turned on the base, and the base in the world."""
    turn, tilt = (0.3, -0.4, 0.5), (0.0, math.radians(25.0), 0.0)
    project.write(
        "scene.yaml", "scene: s\nworld: world.xml\nrobots: {bot: {use: bot.yaml, orientation: {rpy_deg: [0, 25, 0]}}}\n"
    )
    fixed = joint("fixed", "base_link", "tool", f'rpy="{" ".join(map(str, turn))}"')
    force, torque = measured(sensor(project, *FIXED, fixed, axes=axes))
    in_parent = unrotate(from_rpy(*tilt), WEIGHT)
    in_tool = unrotate(from_rpy(*turn), in_parent)
    about = moment(ARM, in_tool)
    if axes == "sensor":
        assert [*force, *torque] == pytest.approx([*in_tool, *about], abs=1e-9)
    else:
        assert force == pytest.approx(in_parent, abs=1e-9)
        assert unrotate(from_rpy(*turn), vector(np.array(torque))) == pytest.approx(about, abs=1e-9)


def test_the_torque_is_about_the_origin_of_the_sensor(project: Project) -> None:
    entry = "tool, position: [0.1, 0.0, 0.0], orientation: {rpy_deg: [0, 0, 90]}"
    force, torque = measured(sensor(project, *FIXED, joint("fixed", "base_link", "tool"), parent=entry))
    arm = unrotate(from_rpy(0.0, 0.0, math.pi / 2), (0.0, ARM[1], ARM[2]))
    assert force == pytest.approx(WEIGHT, abs=1e-9)
    assert torque == pytest.approx(moment(arm, WEIGHT), abs=1e-9)


def test_a_frame_without_mass_bears_the_weight_of_links_fixed_to_it(project: Project) -> None:
    parts = link("base_link", 1.0), link("flange"), link("tool", MASS, ARM)
    chain = joint("fixed", "base_link", "flange"), joint("fixed", "flange", "tool", 'xyz="0 0 .5"')
    force, torque = measured(sensor(project, *parts, *chain, parent="flange"))
    assert force == pytest.approx(WEIGHT, abs=1e-9)
    assert torque == pytest.approx(moment((ARM[0], ARM[1], ARM[2] + 0.5), WEIGHT), abs=1e-9)


def test_a_frame_with_nothing_beyond_it_bears_nothing(project: Project) -> None:
    parts = link("base_link", 1.0), link("tool"), joint("fixed", "base_link", "tool")
    assert measured(sensor(project, *parts)) == ([0.0] * 3, [0.0] * 3)


def test_a_link_without_gravity_weighs_nothing(project: Project) -> None:
    fixed, keys = joint("fixed", "base_link", "tool"), "fixed_base: true\nlinks: {tool: {gravity: false}}"
    force, torque = measured(sensor(project, *FIXED, fixed, keys=keys))
    assert [*force, *torque] == pytest.approx([0.0] * 6, abs=1e-9)


def test_a_turning_link_pulls_with_its_centrifugal_force(project: Project) -> None:
    """A point mass at radius r that turns at a constant rate w pulls outwards with m w² r, about which the torque is 0."""
    parts = link("base_link", 1.0), link("tool", MASS, (0.5, 0.0, 0.0)), joint("continuous", "base_link", "tool")
    keys = "fixed_base: true\njoints: {tool_joint: {drive: {damping: 1000}}}"
    found = sensor(project, *parts, keys=keys)
    joints(found).select().command(velocities=[3.0])
    force, torque = measured(found, 60)
    assert force == pytest.approx((MASS * 9.0 * 0.5, 0.0, -MASS * G), abs=1e-3)
    assert torque == pytest.approx(moment((0.5, 0.0, 0.0), WEIGHT), abs=1e-3)


def test_an_accelerated_link_pushes_back_from_the_first_tick(project: Project) -> None:
    """An effort F accelerates a carriage and its tool, m1 + m2, by a = F / (m1 + m2); the tool pushes back with m2 a."""
    parts = link("base_link", 1.0), link("carriage", 3.0), link("tool", MASS)
    chain = joint("prismatic", "base_link", "carriage", axis="1 0 0"), joint("fixed", "carriage", "tool")
    found = sensor(project, *parts, *chain)
    joints(found).select().command(efforts=[10.0])
    for _ in range(3):
        force, _ = measured(found)
        assert force == pytest.approx((-MASS * 10.0 / (3.0 + MASS), 0.0, -MASS * G), rel=1e-6)


def test_a_swinging_arm_has_the_forces_of_a_pendulum(project: Project) -> None:
    """From rest at the level, a point mass falls with g, so that nothing holds it; the joint bears no force and no torque."""
    parts = link("base_link", 1.0), link("tool", MASS, (0.5, 0.0, 0.0))
    found = sensor(project, *parts, joint("continuous", "base_link", "tool", axis="0 1 0"))
    force, torque = measured(found)
    assert force == pytest.approx((0.0, 0.0, 0.0), abs=0.2)  # within the tick, it turns by 0.0027 rad
    assert torque == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_a_foot_on_the_floor_carries_the_body_above_it(project: Project) -> None:
    """A vertical slider bears no weight: the floor pushes the foot up with (m1 + m2) g, and the foot carries m1 g."""
    sphere = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    parts = link("base_link", 1.0), link("body", 3.0), link("tool", MASS, inside=sphere)
    chain = joint("prismatic", "base_link", "body"), joint("fixed", "body", "tool", 'xyz="0 0 -.5"')
    found = sensor(project, *parts, *chain)
    floor = '<mujoco><worldbody><geom type="plane" size="0 0 1" pos="0 0 -.5"/></worldbody></mujoco>'
    project.write("world.xml", floor)
    world = project.load()
    found = world.simulation.device(JointWrenchSensor, world.stage.find(found.prim_path))
    force, _ = measured(found, 120)
    assert force == pytest.approx((0.0, 0.0, 3.0 * G), abs=0.01)


def test_a_robot_that_falls_freely_bears_nothing(project: Project) -> None:
    found = sensor(project, *FIXED, joint("fixed", "base_link", "tool"), keys="doc: it falls")
    force, torque = measured(found, 5)
    assert [*force, *torque] == pytest.approx([0.0] * 6, abs=1e-9)


def test_a_push_on_the_tool_is_felt(project: Project) -> None:
    found = sensor(project, *FIXED, joint("fixed", "base_link", "tool"))
    found._simulation.data.xfrc_applied[found.body, :3] = (1.0, 2.0, 3.0)
    force, _ = measured(found)
    assert force == pytest.approx((1.0, 2.0, 3.0 - MASS * G), abs=1e-9)


def test_noise_has_the_deviations_of_the_profile_and_depends_on_seed_and_sample(project: Project) -> None:
    found = sensor(project, *FIXED, joint("fixed", "base_link", "tool"), force_noise=2.0, torque_noise=0.5)
    wrenches = np.array([np.concatenate(measured(found)) for _ in range(1000)])
    np.testing.assert_allclose(wrenches.std(axis=0), (2.0,) * 3 + (0.5,) * 3, rtol=0.1)
    np.testing.assert_allclose(wrenches.mean(axis=0), (*WEIGHT, *moment(ARM, WEIGHT)), atol=0.3)
    found._simulation.reset()
    again = np.array([np.concatenate(measured(found)) for _ in range(3)])
    np.testing.assert_array_equal(again, wrenches[:3])


def test_a_checkpoint_within_a_tick_continues_with_the_same_wrench(project: Project) -> None:
    parts = link("base_link", 1.0), link("tool", MASS, ARM), joint("continuous", "base_link", "tool", axis="0 1 0")
    found = sensor(project, *parts)
    simulation = found._simulation
    ticks(simulation, 3)
    simulation.step()
    saved = simulation.save()

    def rest() -> list[float]:
        for _ in range(simulation.substeps - 1):
            simulation.step()
        simulation.begin_tick(4)
        return list(found.reading().force)

    first = rest()
    simulation.restore(saved)
    assert rest() == first


def test_a_sensor_on_the_root_link_has_no_joint(project: Project) -> None:
    with pytest.raises(ContextError, match="has no joint above it: it is on the root link") as caught:
        sensor(project, *FIXED, joint("fixed", "base_link", "tool"), parent="base_link")
    assert caught.value.help == ("mount it on the child link of the joint at which it measures",)


def test_a_link_of_a_mujoco_model_is_measured_like_any_other(project: Project) -> None:
    tool = '<body name="tool" pos="0 0 1"><joint name="turn" axis="0 0 1"/><geom size=".1" mass="2" pos=".1 .2 .3"/></body>'
    base = f'<body name="base"><geom size=".1" mass="1"/>{tool}</body>'
    project.write("bot.xml", f"<mujoco><worldbody>{base}</worldbody></mujoco>").write("world.xml", "<mujoco/>")
    project.write(
        "bot.yaml", "robot: bot\nmjcf: bot.xml\nbase_link: base\nsensors: {ft: {type: force_torque, parent: tool}}\n"
    )
    world = project.load()
    (prim,) = world.stage.prims("force_torque")
    force, torque = measured(world.simulation.device(JointWrenchSensor, prim))
    assert force == pytest.approx(WEIGHT, abs=1e-9)
    assert torque == pytest.approx(moment(ARM, WEIGHT), abs=1e-9)
