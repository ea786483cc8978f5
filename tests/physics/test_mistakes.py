"""Mistakes in scenes, worlds, robot files and descriptions: each is told where it stands, none shows a traceback."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics.harness import CART, SCENE, Project, steps


def test_missing_files_are_reported_with_the_nearest_names(project: Project) -> None:
    project.write("scene.yaml", SCENE.replace("world.xml", "word.xml"))
    assert "scene.yaml:2:8: error S101: no file 'word.xml'" in project.error()
    assert "did you mean 'world.xml'?" in project.error()
    project.write("scene.yaml", SCENE.replace("bot.yaml", "bott.yaml"))
    assert "scene.yaml:4:14: error S101: no file 'bott.yaml'" in project.error()
    project.write("scene.yaml", SCENE).write("bot.yaml", "robot: bot\nurdf: cart.urdf\n")
    assert "bot.yaml:2:7: error S101: no file 'cart.urdf'" in project.error()
    assert "bot.yaml:1:1: error G107: missing key 'urdf'" in project.write("bot.yaml", "robot: bot\n").error()
    project.write("bot.yaml", "robot: bot\nextends: cart.yaml\n")
    assert "bot.yaml:2:10: error S101: no file 'cart.yaml'" in project.error()


def test_all_mistakes_of_a_scene_are_reported_at_once(project: Project) -> None:
    project.write("world.xml", "<mujoco>").cart('"plate_joint"', '"arm_joint"')
    codes = [line.split("error ")[1][:4] for line in project.errors()]
    assert codes == ["S102", "S105"]


CUBE = '<mujoco>\n\n  <worldbody><geom type="cube"/></worldbody></mujoco>'
FLAT = '<mujoco>\n <worldbody>\n  <body><geom name="g" type="box" size="1 1"/></body></worldbody></mujoco>'
ENTITIES = '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>\n<mujoco model="&b;"/>'


@pytest.mark.parametrize(
    ("world", "told"),
    [
        ("", "world.xml:1:1: error S102: XML syntax: no element found"),
        ("<mujoco>\n  <worldbody></mujoco>", "world.xml:2:16: error S102: XML syntax: mismatched tag"),
        ("<robot/>", "world.xml:1:1: error S102: a MuJoCo model begins with <mujoco>, not <robot>"),
        ('<mujoco>\n  <option timestp="1"/></mujoco>', "world.xml:2:3: error S102: MuJoCo: Schema violation"),
        (CUBE, "world.xml:3:14: error S102: MuJoCo: invalid"),
        (FLAT, "world.xml:3:9: error S106: MuJoCo: size 2 must be positive in geom"),
        (ENTITIES, "world.xml:1:13: error S102: a document type is not allowed"),
        ("<mujoco>" + "<worldbody>" * 300, "error S102: nested more than 200 levels deep"),
        ("<mujoco>" + f"<a/>{'t' * 80}" * 100_000, "error S102: XML syntax: no element found"),
        ('<?xml version="1.0" encoding="klingon"?><mujoco/>', "error S102: XML syntax: unknown encoding"),
    ],
)
def test_a_world_that_cannot_be_loaded(project: Project, world: str, told: str) -> None:
    assert told in project.write("world.xml", world).error()


def test_warnings_of_mujoco_are_reported_and_do_not_count_as_divergence(project: Project) -> None:
    hinges = '<joint axis="0 0 1"/><joint axis="0 0 1"/>'
    body = f'<body name="door">{hinges}<geom type="box" size="1 1 1"/></body>'
    world, findings = project.write("world.xml", f"<mujoco><worldbody>{body}</worldbody></mujoco>").load_with_findings()
    (lint,) = (finding for finding in findings.warnings if finding.code == "W205")
    assert (lint.code, lint.help) == ("W205", ("degree of freedom 0 belongs to 'door'",))
    assert lint.message.startswith("MuJoCo: Inertia matrix is too close to singular")
    assert "Time" not in lint.message
    steps(world.simulation, 10)
    assert np.isfinite(world.simulation.data.qpos).all()


def test_a_world_that_is_too_large_is_not_read(project: Project) -> None:
    assert "is larger than 16 MB" in project.write("world.xml", "<mujoco>" + " " * 16_000_001 + "</mujoco>").error()


@pytest.mark.parametrize(
    "element",
    [
        '<asset><mesh file="../secret.stl"/></asset>',
        '<asset><mesh file="{outside}/secret.stl"/></asset>',
        '<asset><mesh file="link.stl"/></asset>',
        '<compiler meshdir=".."/><asset><mesh file="secret.stl"/></asset>',
        '<compiler assetdir="{outside}"/><asset><hfield name="h" size="1 1 1 1" file="secret.stl"/></asset>',
        '<compiler texturedir=".."/><asset><texture type="2d" file="secret.stl"/></asset>',
        '<asset><texture type="cube" fileup="../secret.stl"/></asset>',
        '<asset><model name="m" file="../secret.xml"/></asset>',
        '<include file="../secret.xml"/>',
        '<worldbody><include file="{outside}/secret.xml"/></worldbody>',
        '<include file="inner.xml"/>',
    ],
)
def test_a_world_names_no_file_outside_its_folder(project: Project, element: str) -> None:
    outside = project.folder.parent / f"{project.folder.name}_outside"
    outside.mkdir()
    for name in ("secret.stl", "secret.xml"):
        (outside / name).write_text("<mujoco/>", encoding="utf-8")
    (project.folder / "link.stl").symlink_to(outside / "secret.stl")
    text = element.replace("..", f"../{outside.name}").format(outside=outside)
    project.write("inner.xml", f'<mujoco><include file="../{outside.name}/secret.xml"/></mujoco>').world(before=text)
    error = project.error()
    assert "error S102" in error
    assert "lies outside the folder of the file you gave" in error
    assert "allow it with --allow" in error


@pytest.mark.parametrize("mesh", ["../x.stl", "/etc/passwd", "file:///etc/passwd", "package://../../etc/passwd"])
def test_a_description_names_no_file_outside_its_folder(project: Project, mesh: str) -> None:
    error = project.cart('<box size=".4 .3 .1"/>', f'<mesh filename="{mesh}"/>').error()
    assert "bot.urdf:4:42: error S10" in error
    assert "lies outside" in error or "no file" in error


def test_a_file_included_twice_or_by_itself_is_reported(project: Project) -> None:
    project.world(before='<include file="a.xml"/>').write("a.xml", '<mujoco><include file="world.xml"/></mujoco>')
    assert "a.xml:1:24: error S102: 'world.xml' is included twice" in project.error()


def test_a_model_that_attaches_itself_is_an_error_at_its_file_name(project: Project) -> None:
    project.world(before='<asset><model name="a" file="a.xml"/></asset>')
    project.write("a.xml", '<mujoco><asset><model name="a" file="a.xml"/></asset></mujoco>')
    assert "a.xml:1:38: error S102: 'a.xml': the model contains itself" in project.error()


PLATE, PARENT = '<link name="plate"/>', '<parent link="arm"/>'
BALL, SIZE, MASS = '<sphere radius=".05"/>', 'size=".4 .3 .1"', '<mass value="5"/>'


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("<robot", "<mujoco", "bot.urdf:1:1: error S103: a robot description begins with <robot>, not <mujoco>"),
        (PLATE, "<link/>", "bot.urdf:10:3: error S103: a link without a name"),
        (PLATE, '<link name="arm"/>', "bot.urdf:10:15: error S105: two links named 'arm'"),
        (PARENT, '<parent link="amr"/>', "error S103: joint 'plate_joint': no parent link 'amr'"),
        (PARENT, '<parent link="amr"/>', "did you mean 'arm'?"),
        (PARENT, '<parent link="plate"/>', "error S103: the links do not form one tree"),
        ('<parent link="base_link"/>', '<parent link="plate"/>', "error S103: the links do not form one tree"),
        ('type="fixed"', 'type="floating"', "joint 'plate_joint': type 'floating' is not supported"),
        ('type="revolute"', 'type="revolut"', "did you mean 'revolute'?"),
        ('type="fixed"', 'type="planar"', "write two prismatic joints and a continuous one"),
        (MASS, '<mass value="heavy"/>', "bot.urdf:3:28: error S103: mass 'heavy' is not a number of at least 0 (kg)"),
        (MASS, '<mass value="-5"/>', "bot.urdf:3:28: error S103: mass '-5' is not a number of at least 0 (kg)"),
        ('xyz=".1 0 .1"', 'xyz=".1 0"', "joint 'arm_joint': origin xyz must be three numbers, not '.1 0'"),
        (
            '<axis xyz="0 1 0"/>',
            '<axis xyz="0 0 0"/>',
            "axis xyz must be three numbers, not all of them zero, not '0 0 0'",
        ),
        (
            "<limit",
            '<mimic joint="plate_joint"/><limit',
            "'arm_joint' mimics 'plate_joint', which is not a moving joint",
        ),
        ("<limit", '<mimic joint="arm_jont"/><limit', "did you mean 'arm_joint'?"),
        ("<limit", '<mimic joint="arm_joint"/><limit', "bot.urdf:13:19: error S103: joint 'arm_joint' mimics itself"),
        ('<child link="plate"/>', '<child link="arm"/>', "link 'arm' has two parents"),
        (
            SIZE,
            'size=".4 .3"',
            "bot.urdf:4:37: error S103: link 'base_link': box size must be three numbers, not '.4 .3'",
        ),
        (SIZE, "", "bot.urdf:4:26: error S103: link 'base_link': <box> has no attribute 'size'"),
        (
            'radius=".05"',
            'radius="nan"',
            "bot.urdf:8:64: error S103: link 'arm': sphere radius must be a number, not 'nan'",
        ),
        ('xyz="0 0 .2"', 'xyz="0 0 inf"', "link 'arm': origin xyz must be three numbers, not '0 0 inf'"),
        ('effort="40"', 'effort="1e999"', "joint 'arm_joint': limit effort must be a number, not '1e999'"),
        ('lower="-1"', 'lower=""', "joint 'arm_joint': limit lower must be a number, not ''"),
        ("<limit", '<dynamics damping="-1"/><limit', "dynamics damping must be a number of at least 0, not '-1'"),
        (PLATE, '<link name="plate"><visual/></link>', "link 'plate': a visual without a shape in its"),
        ("<sphere", "<spehre", "did you mean 'sphere'?"),
        (BALL, '<mesh filename="http://a.b/c.stl"/>', "refer to a mesh by its path, or with package"),
        (BALL, '<mesh filename="package://"/>', "error S101: no file 'package://'"),
        (BALL, '<mesh filename="file:///%00.stl"/>', "error S103: cannot look up 'file:///%00.stl'"),
        (BALL, '<mesh filename="missing.stl"/>', "bot.urdf:8:64: error S101: no file 'missing.stl'"),
        (
            'ixx=".01"',
            'ixx="1 2"',
            "bot.urdf:7:32: error S103: link 'arm': the inertia must have six numbers, in kg m2",
        ),
    ],
)
def test_a_description_that_cannot_be_loaded(project: Project, old: str, new: str, told: str) -> None:
    assert old in CART
    description = CART.replace(old, new, 1)
    if new == "<mujoco":
        description = description.replace("</robot>", "</mujoco>")
    project.write("bot.urdf", description)
    assert told in "\n".join(project.errors())


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ("joints: {arm_jont: {}}", "bot.yaml:3:10: error S104: the robot has no joint 'arm_jont'\n"),
        ("joints: {arm_jont: {}}", "did you mean 'arm_joint'?"),
        ("keep_only_joints: [arm]", "bot.yaml:3:20: error S104: the robot has no joint 'arm'"),
        ("articulation_root: plat", "bot.yaml:3:20: error S104: the robot has no link 'plat'"),
        ("base_link: arm", "bot.yaml:3:12: error S104: 'arm' is not the root link of the description"),
        ("wheel_colliders: {amr: ellipsoid}", "bot.yaml:3:19: error S104: the robot has no link 'amr'"),
        (
            "wheel_colliders: {arm: ellipsoid}",
            "link 'arm' cannot become an ellipsoid, because its collision geometry is not a single cylinder",
        ),
        ("materials: {M: {bind: [arm, wheel]}}", "bot.yaml:3:29: error S104: the robot has no link 'wheel'"),
        ("materials: {M: {bind: [plate]}}", "link 'plate' has no collider to bind a material to"),
        ("materials: {M: {bind: [arm]}, N: {bind: [arm]}}", "bot.yaml:3:42: error S105: link 'arm' has two materials"),
        ("joints: {plate_joint: {drive: {damping: 1}}}", "joint 'plate_joint' is fixed: a drive cannot move it"),
        ("frames: {f: {parent: arrm}}", "bot.yaml:3:22: error S104: the robot has no prim 'arrm'"),
        ("frames: {f: {parent: arrm}}", "did you mean 'arm'?"),
        (
            "frames: {f: {parent: /bot/Geometry/base_link/arm}}",
            "paths in a robot file start below the robot: Geometry/base_link/arm",
        ),
        ("namespaces: {/bot/base_link: x}", "paths in a robot file start below the robot: base_link"),
        ("frames: {arm: {parent: base_link}}", "bot.yaml:3:10: error S105: two prims at /bot/Geometry/base_link/arm"),
        ("frames: {arm: {parent: plate}, f: {parent: arm}}", "'arm' could mean 2 prims"),
        ("namespaces: {amr: x}", "bot.yaml:3:14: error S104: the robot has no prim 'amr'"),
        ("name_overrides: {amr: x}", "bot.yaml:3:18: error S104: the robot has no prim 'amr'"),
        ("sensors: {s: {type: lidar, parent: arm}}", "bot.yaml:3:11: error G107: sensor 's': a lidar needs a profile"),
        (
            "sensors: {s: {type: lidar, profile: lidar_350, parent: arm}}",
            "bot.yaml:3:37: error S101: no sensor profile 'lidar_350'",
        ),
        ("sensors: {s: {type: lidar, profile: lidar_350, parent: arm}}", "did you mean 'lidar_360'?"),
        ("sensors: {s: {type: lidar, profile: realsense_d455, parent: arm}}", "'realsense_d455' is not for a lidar"),
        (
            "frames: {f: {parent: arm, orientation: {quaternion_xyzw: [0, 0, 0, 0]}}}",
            "error G109: orientation: the quaternion of a rotation must have length 1",
        ),
    ],
)
def test_a_robot_file_that_does_not_fit_its_description(project: Project, keys: str, told: str) -> None:
    assert told in "\n".join(project.robot(keys).errors())


SINGULAR = (
    '<body pos="3 3 3"><joint/><geom size="1e308" mass="1"/></body>'
    '<body pos="1 3 9"><freejoint/><geom type="ellipsoid" size="1 1 1"/></body>'
)
SETTLING, FALLING = SCENE + "settle: true\n", '<option gravity="0 0 -1e30"/>'


@pytest.mark.parametrize(
    ("scene", "option", "bodies", "told"),
    [
        (
            SCENE + "physics: {tick_rate: 1e-320}\n",
            "",
            "",
            "5:22: error G109: tick_rate: physics needs at least 0.1 ticks a second",
        ),
        (SCENE.replace("bot:", "World:"), "", "", "4:3: error S105: a robot cannot be named 'World'"),
        (SETTLING, FALLING, "", "5:1: error S106: the simulation diverged at t = "),
        (SCENE, "", SINGULAR, "2:1: error S106: at t = 0.0000 s MuJoCo gave up: "),
    ],
    ids=["too slow", "named as the world", "diverges while it settles", "MuJoCo gives up"],
)
def test_a_scene_that_cannot_be(project: Project, scene: str, option: str, bodies: str, told: str) -> None:
    assert f"scene.yaml:{told}" in project.write("scene.yaml", scene).world(bodies, before=option).error()


def test_includes_meshes_and_models_of_a_world_are_found(project: Project) -> None:
    """A tetrahedron, by `meshdir`, from an included file in a folder of its own and from an attached model."""
    tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    shelf = '<asset><mesh file="tetra.obj"/></asset><include file="body.xml"/>'
    body = '<worldbody><body name="one"><geom type="mesh" mesh="tetra"/></body></worldbody>'
    part = '<worldbody><body name="b"><geom type="mesh" mesh="m"/></body></worldbody>'
    project.write("meshes/tetra.obj", tetrahedron)
    project.write("parts/shelf.xml", f"<mujoco>{shelf}</mujoco>").write("parts/body.xml", f"<mujoco>{body}</mujoco>")
    project.write("sub.xml", f'<mujoco><asset><mesh name="m" file="meshes/tetra.obj"/></asset>{part}</mujoco>')
    project.world(
        '<attach model="sub" body="b" prefix="two_"/>',
        before='<compiler meshdir="meshes"/><include file="parts/shelf.xml"/><asset><model name="sub" file="sub.xml"/></asset>',
    )
    world = project.load()
    assert sorted(world.stage.find("/World").children) == ["one", "two_b"]
    assert world.simulation.model.nmesh == 2
