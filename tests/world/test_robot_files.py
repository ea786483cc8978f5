"""What a robot file changes about a description: `extends`, joints, materials, prims."""

from __future__ import annotations

import pytest

from graphengine.world.engine import mujoco
from tests.world.conftest import Ship
from tests.world.harness import CART, FLOOR, ROBOT, SCENE, SHIPPED, Project, try_load


def test_a_file_that_extends_another_merges_mappings_and_replaces_the_rest(project: Project) -> None:
    project.write("base/bot.urdf", CART).write(
        "base/base.yaml",
        "robot: base\nurdf: bot.urdf\ndoc: base\n"
        "joints: {arm_joint: {usd_drive: {damping: 1}, armature: 0.5}}\n"
        "frames: {tip: {parent: arm, position: [0, 0, 1]}}\n"
        "graphs: {one: {use: one.yaml}}\n",
    ).write(
        "bot.yaml",
        "robot: bot\nextends: base/base.yaml\njoints: {arm_joint: {drive: {damping: 2}}}\n"
        "frames: {tip: {position: [0, 0, 2]}}\n",
    )
    # a frame's parent is a required key: what is required of the whole is not required of each part
    assert "missing key 'parent'" in project.error()
    project.write(
        "bot.yaml",
        "robot: bot\nextends: base/base.yaml\njoints: {arm_joint: {drive: {damping: 2}}}\n"
        "frames: {tip: {parent: plate}}\ngraphs: {two: {use: two.yaml}}\n",
    )
    world = project.load()
    robot = world.robots["bot"]
    assert robot.spec.robot == "bot"
    assert robot.spec.doc == "base"
    joint = robot.spec.joints["arm_joint"]
    assert (joint.drive and joint.drive.damping, joint.usd_drive, joint.armature) == (2.0, None, 0.5)
    assert world.stage.find("/bot/base_link/arm/plate/tip").position == (0, 0, 1)
    assert [robot.file.folder("graphs", name, "use").name for name in ("one", "two")] == ["base", project.folder.name]
    assert robot.file.span("graphs", "one", "use").source.path.endswith("base.yaml")
    assert robot.file.span("graphs", "two", "use").source.path.endswith("bot.yaml")


def test_files_that_extend_each_other_are_told(project: Project) -> None:
    project.write("bot.yaml", "robot: bot\nextends: b.yaml\n").write("b.yaml", "robot: b\nextends: bot.yaml\n")
    assert "bot.yaml extends b.yaml extends bot.yaml" in project.error()


def test_the_scenes_namespace_replaces_the_one_on_the_base_link(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "namespaces: {base_link: one, arm: two}\n")
    assert project.load().stage.namespaces("/bot/base_link/arm/graph") == ["one", "two"]
    project.write("scene.yaml", SCENE.replace("0.1]}", "0.1], namespace: three}"))
    assert project.load().stage.namespaces("/bot/base_link/arm/graph") == ["three", "two"]


def test_one_robot_file_makes_several_robots(project: Project) -> None:
    project.write("scene.yaml", SCENE + "  other: {use: bot.yaml, position: [3, 0, 0.1], namespace: b}\n")
    world = project.load()
    assert list(world.robots) == ["bot", "other"]
    poses = [world.simulation.body(world.stage.find(path)).pose()[0] for path in ("/bot/base_link", "/other/base_link")]
    assert poses == [(0, 0, 0.1), (3, 0, 0.1)]


def test_a_name_override_is_the_frames_name(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "name_overrides: {arm: the arm}\n")
    assert project.load().stage.find("/bot/base_link/arm").frame_name == "the arm"


def test_a_link_whose_name_usd_does_not_allow_keeps_it_as_its_frames_name(project: Project) -> None:
    project.write("bot.urdf", CART.replace('"arm"', '"arm-1"').replace('"plate"', '"1.plate"'))
    stage = project.load().stage
    assert stage.find("/bot/base_link/arm_1").frame_name == "arm-1"
    assert stage.find("/bot/base_link/arm_1/_1_plate").frame_name == "1.plate"


def test_a_joint_can_be_put_elsewhere(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {position: [0, 0, 0.5]}}\n")
    world = project.load()
    assert world.simulation.body(world.stage.find("/bot/base_link/arm")).pose()[0] == pytest.approx((0, 0, 0.6))


def test_keep_only_joints_keeps_frames_and_welds_what_weighs_next_to_nothing(ship: Ship) -> None:
    world = ship("tutorial/flat_grid.yaml")
    joints = world.stage.find("/dd100/Physics").children
    enabled = [name for name, prim in joints.items() if prim.facts["enabled"]]
    assert enabled == ["front_left_wheel_joint", "front_right_wheel_joint", "rear_caster_joint"]
    assert len(joints) == 14
    assert world.stage.find("/dd100/base_link/chassis_link/front_0_mount").body is None
    assert world.simulation.model.body_subtreemass[1] == pytest.approx(10.323)


@pytest.mark.parametrize(
    ("joint", "told"),
    [
        ("arm_joint", "joint 'arm_joint' cannot be disabled: it moves: without it a link would fall off"),
        (
            "fixed",
            "joint 'arm_joint' cannot be disabled: it holds 'arm', which has mass or a collider and would fall off",
        ),
    ],
)
def test_a_joint_that_holds_something_cannot_be_disabled(project: Project, joint: str, told: str) -> None:
    project.write("bot.urdf", CART.replace('type="revolute"', 'type="fixed"') if joint == "fixed" else CART)
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {enabled: false}}\n")
    assert told in project.error()
    project.write("bot.yaml", ROBOT + "keep_only_joints: [plate_joint]\n")
    assert "bot.yaml:3:19" in project.error()


@pytest.mark.parametrize(
    ("combine", "friction", "condim", "priority"),
    [("average", 0.5, 3, 1), ("min", 0.2, 3, 1), ("multiply", 0.16, 3, 1), ("max", 0.8, 3, 1)],
)
def test_a_material_is_mixed_with_the_floor_as_physx_would(
    project: Project, combine: str, friction: float, condim: int, priority: int
) -> None:
    """The floor has 0.8."""
    material = f"{{static_friction: 0.3, dynamic_friction: 0.2, combine: {combine}, bind: [base_link]}}"
    project.write("bot.yaml", ROBOT + f"materials: {{Rubber: {material}}}\n")
    world, findings = project.try_load()
    assert world is not None
    geom = collider(world.simulation.model, "bot/base_link")
    assert geom.friction[0] == pytest.approx(friction)
    assert (geom.condim[0], geom.priority[0]) == (condim, priority)
    (note,) = [finding.message for finding in findings.items]
    assert f"{combine} of 0.2, its dynamic friction" in note
    assert f"the floor's 0.8: friction {friction:g}" in note


def test_a_material_without_friction_wins_over_every_other(project: Project) -> None:
    material = "{static_friction: 0, dynamic_friction: 0, combine: multiply, bind: [base_link]}"
    project.write("bot.yaml", ROBOT + f"materials: {{Ice: {material}}}\n")
    world = project.load()
    geom = collider(world.simulation.model, "bot/base_link")
    assert (geom.condim[0], geom.priority[0]) == (1, 2)


def test_a_restitution_is_told_to_have_no_effect(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "materials: {Rubber: {restitution: 0.5, bind: [base_link]}}\n")
    _, findings = project.try_load()
    assert findings.items[0].message.endswith("restitution is not simulated")


def collider(model: mujoco.MjModel, body: str) -> mujoco._structs._MjModelGeomViews:
    return model.geom(int(model.body(body).geomadr[0]))


def test_wheels_are_ellipsoids_where_the_file_says_so(ship: Ship) -> None:
    model = ship("dd100_flat.yaml").simulation.model
    wheel = collider(model, "dd100/front_left_wheel_link")
    assert wheel.type[0] == mujoco.mjtGeom.mjGEOM_ELLIPSOID
    assert wheel.size == pytest.approx([0.049, 0.049, 0.01016])
    assert wheel.solref == pytest.approx([0.004, 1.0])


def test_an_effort_limit_that_a_stiff_drive_would_rattle_at_is_taken_off_and_told(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 1000}}}\n")
    world, findings = project.try_load()
    assert world is not None
    assert "its effort limit is not enforced" in findings.items[0].message
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 0.5}}}\n")
    world, findings = project.try_load()
    assert world is not None
    assert findings.items == []
    joints = world.simulation.articulation(world.stage.find("/bot"))
    joints.select().command(velocities=[1000.0])
    world.simulation.step()
    assert joints.efforts()[0] == 40.0


def test_the_worlds_timestep_and_integrator_are_overruled_and_told(project: Project) -> None:
    option = '<mujoco>\n  <option timestep="0.002"\n    integrator="RK4"/>'
    project.write("world.xml", FLOOR.replace("<mujoco>", option)).write(
        "scene.yaml", SCENE + "physics: {tick_rate: 50, substeps: 2}\n"
    )
    loaded, findings = project.try_load()
    assert loaded is not None
    assert loaded.simulation.model.opt.timestep == 0.01
    lint, note = findings.items
    assert lint.code == "W204"
    assert "timestep 0.002 s is overruled by the scene's 0.01 s: 50 ticks a second of 2 substeps" in lint.message
    assert lint.span is not None
    assert (lint.span.line, lint.span.column) == (2, 21)
    assert note.code == "N103"
    assert note.span is not None
    assert note.span.line == 3


def test_the_tutorials_robot_tells_what_its_settings_mean() -> None:
    _, findings = try_load(SHIPPED / "tutorial/flat_grid.yaml")
    notes = [finding.message for finding in findings.items]
    assert any("damping 572958 N m s/rad" in note for note in notes)
    assert any("average of 0 and the floor's" in note for note in notes)
    assert any("disabled joints stay welded" in note for note in notes)


def test_what_others_keep_in_a_description_stays_in_its_text(project: Project) -> None:
    plugin = "<gazebo><plugin name='a &amp; b'>\n  x &lt; 1\n<mode>slow</mode></plugin></gazebo>"
    project.write("bot.urdf", CART.replace("</robot>", f"{plugin}</robot>"))
    text = project.load().robots["bot"].urdf_text
    assert '<gazebo>\n<plugin name="a &amp; b">x &lt; 1\n<mode>slow</mode>\n</plugin>\n</gazebo>' in text


def test_links_of_one_robot_do_not_collide_and_those_of_two_do(project: Project) -> None:
    """The arm's ball, moved into the cart's box, stays in peace; the other cart in the same place does not."""
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {position: [0, 0, -0.2]}}\n")
    assert project.load().simulation.data.ncon == 0
    project.write("scene.yaml", SCENE + "  other: {use: bot.yaml, position: [0.1, 0, 0.1]}\n")
    assert project.load().simulation.data.ncon > 0


def test_a_joint_that_mimics_another_is_told_to_move_freely(project: Project) -> None:
    project.write("bot.urdf", CART.replace("<limit", '<mimic joint="other"/><limit'))
    _, findings = project.try_load()
    assert [finding.message for finding in findings.items] == ["<mimic> is not simulated: these joints move freely"]
