"""Joints that a robot file disables: what stays, what would fall, and which link then moves freely."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.rotation import Pose, relative
from graphengine.physics.loaded_world import LoadedWorld
from tests.physics.conftest import Ship
from tests.physics.harness import CART, SCENE, Project, steps

INERTIA = '<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'
BOX = (
    f'<inertial><mass value="5"/>{INERTIA}</inertial><collision><geometry><box size=".4 .3 .1"/></geometry></collision>'
)
RAISED = f"""<robot name="raised">
  <link name="footprint"/>
  <link name="base_link"/>
  <link name="chassis">{BOX}</link>
  <link name="mast"/>
  <link name="probe"><inertial><mass value="0.01"/>{INERTIA.replace(".1", "1e-5")}</inertial></link>
  <joint name="base_joint" type="fixed">
    <parent link="footprint"/><child link="base_link"/><origin xyz="0 0 .1" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="chassis_joint" type="fixed">
    <parent link="base_link"/><child link="chassis"/><origin xyz=".3 0 0" rpy="0 1.5707963267948966 0"/>
  </joint>
  <joint name="mast_joint" type="fixed"><parent link="base_link"/><child link="mast"/><origin xyz="0 0 1"/></joint>
  <joint name="probe_joint" type="fixed"><parent link="chassis"/><child link="probe"/><origin xyz="0 0 1"/></joint>
</robot>
"""
RAISED_ROBOT = "robot: bot\nurdf: bot.urdf\nbase_link: footprint\n"
DISABLED = RAISED_ROBOT + "joints: {chassis_joint: {enabled: false}}\n"
FRAMES = ("footprint", "footprint/base_link", "footprint/base_link/mast", "footprint/base_link/chassis")


@pytest.fixture
def raised(project: Project) -> Project:
    return project.write("bot.urdf", RAISED).write("bot.yaml", RAISED_ROBOT)


def poses(world: LoadedWorld) -> list[Pose]:
    return [world.simulation.frame(world.stage.find(f"/bot/{path}")).pose() for path in FRAMES]


def numbers(poses: list[Pose]) -> list[float]:
    return [number for position, orientation in poses for number in (*position, *orientation)]


def test_the_step_of_the_tutorial_makes_chassis_link_the_moving_link(ship: Ship) -> None:
    # "Disable all joints except front_left_wheel_joint, front_right_wheel_joint, and rear_caster_joint"
    world = ship("tutorial/flat_grid.yaml")
    robot, model = world.stage.find("/dd100"), world.simulation.model
    joints = world.stage.find("/dd100/Physics").children
    enabled = [name for name, prim in joints.items() if prim.facts["enabled"]]
    assert enabled == ["front_left_wheel_joint", "front_right_wheel_joint", "rear_caster_joint"]
    assert len(joints) == 14
    assert world.stage.find("/dd100/base_link/chassis_link/front_0_mount").body is None
    assert model.body(model.joint("dd100/root").bodyid[0]).name == "dd100/chassis_link"
    assert model.body_subtreemass[0] == pytest.approx(10.323)
    assert robot.facts["joints"] == ("front_left_wheel_joint", "front_right_wheel_joint")
    assert robot.facts["base_link"] == "/dd100/Geometry/base_link"
    assert robot.facts["articulation_root"] == "/dd100/Geometry/base_link/chassis_link"


def test_the_link_that_carries_all_mass_moves_freely_and_is_the_articulation_root(raised: Project) -> None:
    before = raised.load()
    assert before.stage.find("/bot").facts["articulation_root"] == "/bot/Geometry/footprint"
    world, findings = raised.write("bot.yaml", DISABLED).load_with_findings()
    model = world.simulation.model
    assert model.body(model.joint("bot/root").bodyid[0]).name == "bot/chassis"
    facts = world.stage.find("/bot").facts
    assert facts["articulation_root"] == "/bot/Geometry/footprint/base_link/chassis"
    assert facts["base_link"] == "/bot/Geometry/footprint"
    assert facts["fixed_transforms"] == before.stage.find("/bot").facts["fixed_transforms"]
    (note,) = findings.items
    assert note.message == (
        "joint 'chassis_joint' is disabled: 'chassis' moves freely, and 'footprint' becomes a frame on it"
    )
    assert note.help == ("it is the articulation root, as the robot file names none",)


def test_the_deepest_of_several_disabled_joints_decides_and_a_named_root_stays(raised: Project) -> None:
    raised.write("bot.yaml", RAISED_ROBOT + "articulation_root: base_link\nkeep_only_joints: [probe_joint]\n")
    world, findings = raised.load_with_findings()
    model = world.simulation.model
    assert model.body(model.joint("bot/root").bodyid[0]).name == "bot/chassis"
    assert world.stage.find("/bot").facts["articulation_root"] == "/bot/Geometry/footprint/base_link"
    assert [finding.help for finding in findings.items] == [(), (), ("joints: mast_joint",)]


def test_all_frames_are_where_they_would_be_with_the_joint_enabled_and_stay_together(raised: Project) -> None:
    # it falls from 0.3 m onto an edge and tips over; MuJoCo then integrates the motion of another point, some mm off the first
    raised.write("scene.yaml", SCENE.replace("0, 0, 0.1]", "1, 2, 0.3], orientation: {rpy_deg: [30, 20, 10]}"))
    enabled, disabled = raised.load(), raised.write("bot.yaml", DISABLED).load()
    assert numbers(poses(disabled)) == pytest.approx(numbers(poses(enabled)), abs=1e-12)
    assert poses(disabled)[0][0] == pytest.approx((1, 2, 0.3))
    before = poses(disabled)
    for world in (enabled, disabled):
        steps(world.simulation, 120)
    after = poses(disabled)
    assert math.dist(before[0][0], after[0][0]) > 0.1
    assert numbers(after) == pytest.approx(numbers(poses(enabled)), abs=0.01)
    for pose, earlier in zip(after, before, strict=True):
        rigid = relative(after[0], pose), relative(before[0], earlier)
        assert numbers([rigid[0]]) == pytest.approx(numbers([rigid[1]]), abs=1e-12)
    one, other = (world.simulation.body(world.stage.find("/bot/footprint")).velocity() for world in (enabled, disabled))
    assert one[0] == pytest.approx(other[0], abs=0.05)


def test_disabling_a_joint_that_a_fixed_base_holds_is_an_error(raised: Project) -> None:
    raised.write("bot.yaml", DISABLED + "fixed_base: true\n")
    assert (
        "joint 'chassis_joint' cannot be disabled: it holds 'chassis' (5.01 kg), which would fall off" in raised.error()
    )
    welded = DISABLED.replace("enabled: false", "enabled: false, weld: true") + "fixed_base: true\n"
    world = raised.write("bot.yaml", welded).load()
    assert world.simulation.model.nv == 0
    assert world.stage.find("/bot").facts["articulation_root"] == "/bot/Geometry/footprint"


def test_a_nearly_massless_link_stays_fixed_and_a_note_says_so(raised: Project) -> None:
    # the probe has 0.2 % of the mass; with 2 % it would fall off
    raised.write("bot.yaml", RAISED_ROBOT + "joints: {probe_joint: {enabled: false}}\n")
    world, findings = raised.load_with_findings()
    assert world.simulation.model.body("bot/chassis").subtreemass[0] == pytest.approx(5.01)
    (note,) = findings.items
    assert note.message.startswith("disabled joints stay welded, as one side of each has no collider")
    assert note.help == ("joints: probe_joint",)
    raised.write("bot.urdf", RAISED.replace('"0.01"', '"0.1"'))
    assert "joint 'probe_joint' cannot be disabled: it holds 'probe' (0.1 kg), which would fall off" in raised.error()


@pytest.mark.parametrize("kind", ["revolute", "fixed"])
def test_disabling_a_joint_that_carries_mass_is_an_error_unless_the_joint_is_welded(
    project: Project, kind: str
) -> None:
    project.cart('type="revolute"', f'type="{kind}"').robot("joints: {arm_joint: {enabled: false}}")
    verb = "moves" if kind == "revolute" else "holds"
    error = project.error()
    assert f"bot.yaml:3:31: error S106: joint 'arm_joint' cannot be disabled: it {verb} 'arm' (1 kg)" in error
    assert "arm_joint: {enabled: false, weld: true} below joints: keeps it in place" in error
    assert "bot.yaml:3:19" in project.robot("keep_only_joints: [plate_joint]").error()
    project.robot("keep_only_joints: [plate_joint]\njoints: {arm_joint: {weld: true}}")
    world, findings = project.load_with_findings()
    assert world.simulation.model.nv == 6
    robot = world.stage.find("/bot")
    assert robot.facts["joints"] == ()
    assert [edge[:2] for edge in robot.facts["fixed_transforms"]] == [("base_link", "arm"), ("arm", "plate")]
    assert world.simulation.body(world.stage.find("/bot/base_link/arm")).pose()[0] == pytest.approx((0.1, 0, 0.2))
    note = "joint 'arm_joint' is disabled and welded: 'arm' (1 kg) stays"
    assert findings.items[0].message.startswith(note)


def test_a_drive_on_a_welded_joint_is_left_out(project: Project) -> None:
    joint = "{enabled: false, weld: true, drive: {damping: 10, target_velocity: 5}, armature: 1}"
    world = project.robot(f"joints: {{arm_joint: {joint}}}").load()
    assert world.simulation.model.nu == 0


def test_a_joint_that_others_mimic_cannot_be_welded_without_them(project: Project) -> None:
    finger = CART.replace(
        "</robot>",
        f'<link name="finger">{BOX}</link><joint name="finger_joint" type="continuous"><parent link="arm"/>'
        '<child link="finger"/><axis xyz="0 1 0"/><mimic joint="arm_joint"/></joint></robot>',
    )
    project.write("bot.urdf", finger).robot("joints: {arm_joint: {enabled: false, weld: true}}")
    assert "joint 'arm_joint' cannot be welded, because other joints mimic it" in project.error()
    both = "arm_joint: {enabled: false, weld: true}, finger_joint: {enabled: false, weld: true}"
    project.robot(f"joints: {{{both}}}")
    assert project.load().simulation.model.neq == 0


def test_weld_on_a_joint_that_is_enabled_is_an_error(project: Project) -> None:
    project.robot("joints: {arm_joint: {weld: true}}")
    assert "error G109: joint 'arm_joint' is not disabled, and weld applies only to disabled joints" in project.error()
