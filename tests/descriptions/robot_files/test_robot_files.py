"""What a robot file changes about a description: `extends`, joints, materials, prims."""

from __future__ import annotations

import pytest

from graphengine.descriptions.engine import mujoco
from tests.physics.conftest import Ship
from tests.physics.harness import CART, ROBOT, SCENE, SHIPPED, Project, steps, try_load


def test_a_file_that_extends_another_merges_mappings_and_replaces_the_rest(project: Project) -> None:
    base = "joints: {arm_joint: {usd_drive: {damping: 1}, armature: 0.5}}\n"
    base += "frames: {tip: {parent: arm, position: [0, 0, 1]}}\ngraphs: {one: {use: one.yaml}}\n"
    own = "robot: bot\nextends: base/base.yaml\njoints: {arm_joint: {drive: {damping: 2}}}\n"
    project.write("base/bot.urdf", CART).write("base/base.yaml", f"robot: base\nurdf: bot.urdf\ndoc: base\n{base}")
    # a frame's parent is a required key: what is required of the whole is not required of each part
    assert "missing key 'parent'" in project.write("bot.yaml", own + "frames: {tip: {position: [0, 0, 2]}}\n").error()
    world = project.write(
        "bot.yaml", f"{own}frames: {{tip: {{parent: plate}}}}\ngraphs: {{two: {{use: two.yaml}}}}\n"
    ).load()
    robot = world.robots["bot"]
    assert robot.spec.robot == "bot"
    assert robot.spec.doc == "base"
    joint = robot.spec.joints["arm_joint"]
    assert (joint.drive and joint.drive.damping, joint.usd_drive, joint.armature) == (2.0, None, 0.5)
    assert world.stage.find("/bot/base_link/arm/plate/tip").position == (0, 0, 1)
    assert [robot.file.folder("graphs", name, "use").name for name in ("one", "two")] == ["base", project.folder.name]
    assert robot.file.span("graphs", "one", "use").source.path.endswith("base.yaml")
    assert robot.file.span("graphs", "two", "use").source.path.endswith("bot.yaml")


def test_null_removes_an_entry_of_the_file_that_is_extended(project: Project) -> None:
    base = "frames: {tip: {parent: arm}, tail: {parent: arm}}\nnamespaces: {arm: one, plate: two}\n"
    base += "graphs: {one: {use: one.yaml}, two: {use: two.yaml}}\n"
    project.write("base.yaml", f"robot: base\nurdf: bot.urdf\n{base}")
    project.write("middle.yaml", "robot: m\nextends: base.yaml\nframes: {tip: null}\ngraphs: {one: null, two: null}\n")
    own = "robot: bot\nextends: middle.yaml\nnamespaces: {arm: null}\ngraphs: {two: {use: other.yaml}}\n"
    spec = project.write("bot.yaml", own).load().robots["bot"].spec
    assert list(spec.frames) == ["tail"]
    assert spec.namespaces == {"plate": "two"}
    assert {name: use.use for name, use in spec.graphs.items()} == {"two": "other.yaml"}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("graphs: {tow: null}", "graphs: null removes an entry of the file that this file extends, which has no 'tow'"),
        ("graphs: {tow: null}", "did you mean 'two'?"),
        ("frames: {tip: null}", "entries: none"),
        ("doc: null", "doc: expected text"),
        ("graphs: null", "graphs: expected a mapping"),
        ("graphs: {two: {use: null}}", "use: expected text"),
        ("sensors: {eye: {type: contact, parent: null}}", "parent: expected text"),
    ],
)
def test_null_for_a_key_that_cannot_be_removed_is_an_error_at_its_position(
    project: Project, keys: str, message: str
) -> None:
    project.write("base.yaml", "robot: base\nurdf: bot.urdf\ngraphs: {two: {use: two.yaml}}\n")
    error = project.write("bot.yaml", f"robot: bot\nextends: base.yaml\n{keys}\n").error()
    assert message in error
    assert "bot.yaml:3:" in error


def test_null_removes_nothing_from_a_file_that_extends_no_other(project: Project) -> None:
    assert "one: expected a mapping, got nothing" in project.robot("graphs: {one: null}").error()


def test_files_that_extend_each_other_are_reported(project: Project) -> None:
    project.write("bot.yaml", "robot: bot\nextends: b.yaml\n").write("b.yaml", "robot: b\nextends: bot.yaml\n")
    assert "bot.yaml extends b.yaml extends bot.yaml" in project.error()


def test_the_scenes_namespace_replaces_the_one_on_the_base_link(project: Project) -> None:
    project.robot("namespaces: {base_link: one, arm: two}")
    assert project.load().stage.namespaces("/bot/base_link/arm/graph") == ["one", "two"]
    project.write("scene.yaml", SCENE.replace("0.1]}", "0.1], namespace: three}"))
    assert project.load().stage.namespaces("/bot/base_link/arm/graph") == ["three", "two"]


def test_one_robot_file_makes_several_robots(project: Project) -> None:
    world = project.scene("  other: {use: bot.yaml, position: [3, 0, 0.1], namespace: b}\n").load()
    assert list(world.robots) == ["bot", "other"]
    poses = [world.simulation.body(world.stage.find(path)).pose()[0] for path in ("/bot/base_link", "/other/base_link")]
    assert poses == [(0, 0, 0.1), (3, 0, 0.1)]


def test_a_name_override_is_the_frames_name(project: Project) -> None:
    project.robot("name_overrides: {arm: the arm}")
    assert project.load().stage.find("/bot/base_link/arm").frame_name == "the arm"


def test_a_link_whose_name_usd_does_not_allow_keeps_it_as_its_frames_name(project: Project) -> None:
    stage = project.write("bot.urdf", CART.replace('"arm"', '"arm-1"').replace('"plate"', '"1.plate"')).load().stage
    assert stage.find("/bot/base_link/arm_1").frame_name == "arm-1"
    assert stage.find("/bot/base_link/arm_1/_1_plate").frame_name == "1.plate"


@pytest.mark.parametrize("name", ["root", "a.b", "1", "arm joint", "Ärm"])
def test_a_joint_can_have_any_name(project: Project, name: str) -> None:
    project.cart('"arm_joint"', f'"{name}"').robot(f'joints: {{"{name}": {{drive: {{stiffness: 100, damping: 10}}}}}}')
    simulation, joints = project.load_joints()
    joints.select([name]).command(positions=[0.5])
    steps(simulation, 240)
    assert joints.positions()[0] == pytest.approx(0.5, abs=1e-3)


def test_a_robot_file_can_move_a_joint(project: Project) -> None:
    world = project.robot("joints: {arm_joint: {position: [0, 0, 0.5]}}").load()
    assert world.simulation.body(world.stage.find("/bot/base_link/arm")).pose()[0] == pytest.approx((0, 0, 0.6))


def collider(model: mujoco.MjModel, body: str) -> mujoco._structs._MjModelGeomViews:
    return model.geom(int(model.body(body).geomadr[0]))


def test_wheel_colliders_are_ellipsoids_if_the_file_sets_this(ship: Ship) -> None:
    model = ship("dd100_flat.yaml").simulation.model
    wheel = collider(model, "dd100/front_left_wheel_link")
    assert wheel.type[0] == mujoco.mjtGeom.mjGEOM_ELLIPSOID
    assert wheel.size == pytest.approx([0.049, 0.049, 0.01016])
    assert wheel.solref == pytest.approx([0.004, 1.0])


def test_the_worlds_timestep_and_integrator_are_overridden_with_a_note(project: Project) -> None:
    project.world(before='\n  <option timestep="0.002"\n    integrator="RK4"/>')
    loaded, findings = project.scene("physics: {tick_rate: 50, substeps: 2}\n").load_with_findings()
    assert loaded.simulation.model.opt.timestep == 0.01
    lint, note = findings.items
    assert lint.code == "W204"
    assert "timestep 0.002 s is overridden by the scene's 0.01 s: 50 ticks a second of 2 substeps" in lint.message
    assert lint.span is not None
    assert (lint.span.line, lint.span.column) == (2, 21)
    assert note.code == "N103"
    assert note.span is not None
    assert note.span.line == 3


def test_the_findings_on_the_tutorials_robot_explain_its_settings() -> None:
    _, findings = try_load(SHIPPED / "tutorial/flat_grid.yaml")
    assert [finding.message for finding in findings.items] == [
        "joint 'base_link_joint' is disabled: 'chassis_link' moves freely, and 'base_link' becomes a frame on it",
        "disabled joints stay welded, as one side of each has no collider and less than 1 % of the mass",
        "joint 'front_left_wheel_joint': usd_drive is given per degree; in SI units it is damping 572958 N m s/rad",
        "joint 'front_right_wheel_joint': usd_drive is given per degree; in SI units it is damping 572958 N m s/rad",
        "material 'CasterMaterial': friction 0.4 on the floor, the average of its 0 and the floor's 0.8",
        "material 'WheelMaterial': friction 0.9 on the floor, the average of its 1 and the floor's 0.8",
    ]


def test_elements_of_other_programs_stay_in_the_text_of_the_description(project: Project) -> None:
    plugin = "<gazebo><plugin name='a &amp; b'>\n  x &lt; 1\n<mode>slow</mode></plugin></gazebo>"
    text = project.cart("</robot>", f"{plugin}</robot>").load().robots["bot"].urdf_text
    assert '<gazebo>\n<plugin name="a &amp; b">x &lt; 1\n<mode>slow</mode>\n</plugin>\n</gazebo>' in text


def test_links_of_one_robot_do_not_collide_and_links_of_two_robots_do(project: Project) -> None:
    """The arm's ball, moved into the cart's box, stays in peace; the other cart in the same place does not."""
    project.robot("joints: {arm_joint: {position: [0, 0, -0.2]}}")
    assert project.load().simulation.data.ncon == 0
    project.scene("  other: {use: bot.yaml, position: [0.1, 0, 0.1]}\n")
    assert project.load().simulation.data.ncon > 0


CROSSING = """<robot name="crossing">
  <link name="base_link">{box}</link><link name="plinth">{box}</link>
  <link name="upper">{box}</link><link name="lower">{box}</link>
  <joint name="one" type="fixed"><parent link="base_link"/><child link="plinth"/></joint>
  <joint name="two" type="continuous"><parent link="plinth"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <joint name="three" type="continuous"><parent link="upper"/><child link="lower"/><axis xyz="0 0 1"/></joint>
</robot>
"""


@pytest.mark.parametrize("base", ["", "fixed_base: true\n"])
def test_links_of_one_robot_collide_if_its_file_says_so_unless_a_joint_connects_them(
    project: Project, base: str
) -> None:
    # four boxes in one place, of which the first two are one rigid body
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    box = f'{inertial}<collision><geometry><box size=".1 .1 .1"/></geometry></collision>'
    project.write("bot.urdf", CROSSING.format(box=box)).write("scene.yaml", SCENE.replace("0, 0, 0.1]", "0, 0, 2]"))
    crossing = {("base_link", "lower"), ("lower", "plinth")}
    for key, expected in (("", set()), ("self_collision: true\n", crossing)):
        simulation = project.write("bot.yaml", ROBOT + base + key).load().simulation
        model, contacts = simulation.model, simulation.data.contact.geom
        touching = [
            [model.body(int(model.geom_bodyid[geom])).name.removeprefix("bot/") for geom in pair] for pair in contacts
        ]
        assert {tuple(sorted(pair)) for pair in touching} == expected


def test_a_world_cannot_disable_the_parts_of_drives(project: Project) -> None:
    project.world(before='<option><flag spring="disable" damper="disable" actuation="disable"/></option>')
    world, findings = project.robot("joints: {arm_joint: {drive: {stiffness: 100, damping: 10}}}").load_with_findings()
    assert [note.message.partition(" ")[0] for note in findings.items] == ["spring", "damper", "actuation"]
    joints = world.simulation.articulation(world.stage.find("/bot"))
    joints.select().command(positions=[0.5])
    steps(world.simulation, 240)
    assert joints.positions()[0] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("joint", "told"),
    [
        ("drive: {damping: -1}", "error G109: damping: expected a value ≥ 0, got -1"),
        ("drive: {stiffness: -1}", "error G109: stiffness: expected a value ≥ 0, got -1"),
        ("drive: {max_force: 0}", "error G109: max_force: expected a value > 0, got 0"),
        ("drive: {max_acceleration: -2}", "error G109: max_acceleration: expected a value > 0, got -2"),
        ("usd_drive: {damping: -1}", "error G109: damping: expected a value ≥ 0, got -1"),
        ("usd_drive: {max_force: -1}", "error G109: max_force: expected a value > 0, got -1"),
        ("drive: {damping: 1e13}", "error G109: damping: expected a value ≤ 1e+12, got 10000000000000.0"),
        (
            "usd_drive: {damping: 1, target_velocity: 1e11}",
            "target_velocity: expected a value ≤ 1e+10, got 100000000000.0",
        ),
        ("armature: -0.1", "error G109: armature: expected a value ≥ 0, got -0.1"),
        ("drive: {damping: 1}, usd_drive: {damping: 1}", "a joint has a `drive` or a `usd_drive`, not both"),
        ("drive: {dampng: 1}", "unknown key 'dampng'"),
    ],
)
def test_settings_that_no_joint_has_are_errors_at_their_place(project: Project, joint: str, told: str) -> None:
    assert told in project.robot(f"joints: {{arm_joint: {{{joint}}}}}").error()
    assert project.error().startswith("bot.yaml:3:")


def test_a_drive_replaces_the_descriptions_effort_and_adds_to_its_damping(
    project: Project,
) -> None:
    project.cart("<limit", '<dynamics damping="0.25" friction="0.5"/><limit')
    world = project.robot("joints: {arm_joint: {drive: {damping: 2, stiffness: 3, max_force: 7}}}").load()
    model = world.simulation.model
    joint = model.joint("bot/arm_joint")
    assert (joint.damping[0], joint.stiffness[0], joint.frictionloss[0]) == (2.25, 3.0, 0.5)
    assert not model.jnt_actfrclimited[joint.id]
    drive = world.robots["bot"].drives["arm_joint"]
    assert (drive.damping, drive.stiffness, drive.max_force, drive.carries) == (2.0, 3.0, 7.0, 0.0)
