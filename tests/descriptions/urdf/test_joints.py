"""Joints of all types: what mimics, what is bolted down, what moves freely."""

from __future__ import annotations

import pytest

from graphengine.descriptions.engine import mujoco
from tests.physics.harness import CART, ROBOT, Project, steps

INERTIA = '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>'
LINK = f'<link name="{{}}"><inertial><mass value="{{}}"/>{INERTIA}</inertial></link>'

_HEAVY = (("base", 9), ("arm", 3))
_LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


def joint(name: str, kind: str, parent: str, child: str, more: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}<axis xyz="0 0 1"/>{more}</joint>'


def robot(root: str, *parts: str) -> str:
    return f'<robot name="r">{root}{"".join(parts)}</robot>'


def mimicking(project: Project) -> Project:
    """A lift, a wrist that follows it, and a hook that carries 3 kg and follows the wrist."""
    limit = '<limit lower="-2" upper="2" effort="0" velocity="1"/>'
    parts = [
        *(LINK.format(name, mass) for name, mass in (("base", 9), ("lift", 1), ("wrist", 1), ("hook", 3))),
        joint("lift_joint", "prismatic", "base", "lift", limit),
        joint("wrist_joint", "continuous", "base", "wrist", '<mimic joint="lift_joint" multiplier="-2" offset="0.5"/>'),
        joint("hook_joint", "prismatic", "base", "hook", f'{limit}<mimic joint="wrist_joint" multiplier="0.5"/>'),
    ]
    project.write("bot.urdf", robot("", *parts))
    drive = "joints: {lift_joint: {drive: {damping: 400, stiffness: 40000}}}"
    return project.robot(f"base_link: base\nfixed_base: true\n{drive}")


def test_a_joint_follows_the_joint_that_it_mimics(project: Project) -> None:
    world, findings = mimicking(project).load_with_findings()
    assert findings.items == []
    simulation = world.simulation
    joints = simulation.articulation(world.stage.find("/bot"))
    joints.select(["lift_joint"]).command(positions=[0.3])
    steps(simulation, 120)
    lift, wrist, hook = joints.positions()
    assert lift == pytest.approx(0.3, abs=1e-2)
    assert wrist == pytest.approx(0.5 - 2 * lift, abs=1e-4)
    assert hook == pytest.approx(0.5 * wrist, abs=1e-4)


def test_the_centre_of_mass_covers_all_links_in_the_frame_of_the_root(project: Project) -> None:
    """9 kg at x = 0.1, and 3 kg at 0.4 along the x axis of a link that stands at (1, 0, 0) and is turned to the left."""
    base, arm = (LINK.format(*each).replace("<inertial>", "<inertial><origin xyz='{} 0 0'/>") for each in _HEAVY)
    turned = joint(
        "arm_joint", "revolute", "base", "arm", '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>' + _LIMIT
    )
    project.write("bot.urdf", robot(base.format(0.1), arm.format(0.4), turned))
    world, findings = project.robot("base_link: base\nfixed_base: true").load_with_findings()
    assert findings.errors == []
    assert world.robots["bot"].description.centre_of_mass() == pytest.approx(
        ((9 * 0.1 + 3 * 1.0) / 12, 3 * 0.4 / 12, 0.0)
    )


def test_joints_that_mimic_each_other_in_a_ring_are_reported(project: Project) -> None:
    mimicking(project)
    text = (project.folder / "bot.urdf").read_text(encoding="utf-8")
    project.write("bot.urdf", text.replace("<limit", '<mimic joint="hook_joint"/><limit', 1))
    assert any("joint 'lift_joint' mimics itself" in error for error in project.errors())


def test_of_repeated_elements_the_first_counts_as_in_ros(project: Project) -> None:
    twice = '<origin xyz="0 0 .5"/><origin xyz="0 0 9"/>'
    shape = f'<collision>{twice}<geometry><sphere radius=".1"/></geometry></collision>'
    arm = f'<link name="arm">{shape}<inertial><mass value="2"/><mass value="7"/>{INERTIA}</inertial></link>'
    limit = '<limit lower="-1" upper="1" effort="5" velocity="1"/>'
    more = f'{twice}{limit}<limit lower="-9" upper="9" effort="5" velocity="1"/><axis xyz="1 0 0"/>'
    project.write("bot.urdf", robot(LINK.format("base", 9), arm, joint("arm_joint", "revolute", "base", "arm", more)))
    world, findings = project.robot("base_link: base\nfixed_base: true").load_with_findings()
    model = world.simulation.model
    assert model.joint("bot/arm_joint").axis.tolist() == [0, 0, 1]
    assert model.joint("bot/arm_joint").range.tolist() == [-1, 1]
    assert model.body("bot/arm").pos.tolist() == [0, 0, 0.5]
    assert model.body("bot/arm").mass == 2
    assert [item.message for item in findings.items if item.code == "N103"] == [
        "link 'arm': only the first of 2 <origin> in <collision> counts",
        "link 'arm': only the first of 2 <mass> in <inertial> counts",
        "joint 'arm_joint': only the first of 2 <origin> counts",
        "joint 'arm_joint': only the first of 2 <axis> counts",
        "joint 'arm_joint': only the first of 2 <limit> counts",
    ]


@pytest.mark.parametrize("limit", ["", '<limit effort="40" velocity="1"/>', '<limit lower="1" upper="1"/>'])
def test_a_joint_with_an_empty_range_moves_freely_and_is_reported(project: Project, limit: str) -> None:
    world, findings = project.cart('<limit lower="-1" upper="1" effort="40" velocity="1"/>', limit).load_with_findings()
    assert not world.simulation.model.joint("bot/arm_joint").limited[0]
    (note,) = findings.items
    assert (note.message, note.help) == (
        "joints without limits, or with equal limits, move freely",
        ("joints: arm_joint",),
    )


def test_swapped_limits_leave_a_joint_free_and_are_a_warning(project: Project) -> None:
    limit = '<limit lower="1" upper="-1"/>'
    world, findings = project.cart('<limit lower="-1" upper="1" effort="40" velocity="1"/>', limit).load_with_findings()
    assert not world.simulation.model.joint("bot/arm_joint").limited[0]
    (warning,) = findings.items
    assert warning.code == "W217"
    assert warning.help == ('the limits are probably swapped: write lower="-1" upper="1"',)


@pytest.mark.parametrize(
    ("lower", "upper", "suggested"),
    [
        ("-180", "180", 'if they are in degrees, write lower="-3.14159" upper="3.14159"'),
        ("0", "90", 'if they are in degrees, write lower="0" upper="1.5708"'),
        ("-6.283", "6.283", ""),  # two turns are usual
        ("-100.5", "100.5", ""),  # a range that stands for none
        ("-10000", "10000", ""),
    ],
)
def test_limits_that_are_probably_in_degrees_are_a_warning(
    project: Project, lower: str, upper: str, suggested: str
) -> None:
    limit = f'<limit lower="{lower}" upper="{upper}" effort="40" velocity="1"/>'
    _, findings = project.cart('<limit lower="-1" upper="1" effort="40" velocity="1"/>', limit).load_with_findings()
    assert [each.help for each in findings.items if each.code == "W217"] == ([(suggested,)] if suggested else [])


@pytest.mark.parametrize("fixed", [True, False])
def test_a_base_is_bolted_to_the_world_where_the_robot_file_says_so(project: Project, fixed: bool) -> None:
    world = project.write("bot.yaml", ROBOT + ("fixed_base: true\n" if fixed else "")).load()
    assert world.simulation.model.nv == (1 if fixed else 7)
    steps(world.simulation, 60)
    height = world.simulation.body(world.stage.find("/bot/base_link")).pose()[0][2]
    assert (height == 0.1) == fixed


def test_a_robot_whose_root_is_called_world_is_bolted_to_it(project: Project) -> None:
    bolt = joint("bolt", "fixed", "world", "base_link", '<origin xyz="0 0 2"/>')
    world = project.cart("</robot>", f'<link name="world"/>{bolt}</robot>').robot("base_link: world").load()
    assert world.simulation.model.nv == 1
    assert world.stage.find("/bot").facts["base_link"] == "/bot/Geometry/world"
    for path, height in (("/bot", 0.1), ("/bot/world", 0.1), ("/bot/world/base_link", 2.1)):
        assert world.simulation.body(world.stage.find(path)).pose()[0] == (0, 0, height)
    world.simulation.step()
    assert world.simulation.body(world.stage.find("/bot/world/base_link")).pose()[0] == (0, 0, 2.1)


def test_a_world_link_with_colliders_is_part_of_the_world(project: Project) -> None:
    table = '<link name="world"><collision><geometry><box size="1 1 1"/></geometry></collision></link>'
    bolt = joint("bolt", "fixed", "world", "base_link", '<origin xyz="0 0 2"/>')
    model = project.cart("</robot>", f"{table}{bolt}</robot>").robot("base_link: world").load().simulation.model
    boxes = [i for i in range(model.ngeom) if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_BOX]
    assert [int(model.geom_bodyid[i]) for i in boxes] == [0, model.body("bot/base_link").id]
    excluded = {(int(pair) >> 16, int(pair) & 0xFFFF) for pair in model.exclude_signature}
    assert excluded == {(model.body("bot/base_link").id, model.body("bot/arm").id)}


def test_a_floating_joint_below_an_empty_root_is_the_robots_own_freedom(project: Project) -> None:
    project.cart("</robot>", f'<link name="odom"/>{joint("odom_joint", "floating", "odom", "base_link")}</robot>')
    world, findings = project.load_with_findings()
    assert world.robots["bot"].description.root == "base_link"
    assert world.simulation.model.nv == 7
    (note,) = findings.items
    assert note.message.startswith(
        "joint 'odom_joint' and link 'odom' are left out: the robot moves freely without them"
    )


def test_a_floating_joint_below_the_root_is_reported(project: Project) -> None:
    solid = LINK.format("odom", 1) + joint("odom_joint", "floating", "odom", "base_link")
    error = project.cart("</robot>", f"{solid}</robot>").error()
    assert "joint 'odom_joint': type 'floating' is not supported" in error
    assert "only the joint between an empty root link and the rest of the robot can be floating" in error


def test_links_and_joints_keep_their_names_and_nothing_fuses(project: Project) -> None:
    plate = CART.replace(
        '<link name="plate"/>', '<link name="plate"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
    )
    model = project.write("bot.urdf", plate).load().simulation.model
    assert [model.body(i).name for i in range(1, model.nbody)] == ["bot/base_link", "bot/arm", "bot/plate"]
    assert [model.joint(i).name for i in range(model.njnt)] == ["bot/root", "bot/arm_joint"]


def test_a_massless_root_becomes_a_free_body(project: Project) -> None:
    foot = joint("foot", "fixed", "base_footprint", "base_link", '<origin xyz="0 0 0.05"/>')
    project.cart("</robot>", f'<link name="base_footprint"/>{foot}</robot>')
    model = project.robot("base_link: base_footprint").load().simulation.model
    assert model.body("bot/base_footprint").jntnum[0] == 1
    assert model.body_subtreemass[model.body("bot/base_footprint").id] == pytest.approx(6)
