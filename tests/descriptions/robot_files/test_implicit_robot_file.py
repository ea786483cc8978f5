"""Descriptions that a scene, or whoever spawns, uses without a robot file."""

from __future__ import annotations

import pytest

from graphengine.devices.entity import Move
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import UsageError
from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from tests.physics.dynamics.things import bounds
from tests.physics.harness import CART, Project, steps

BOX = """<robot name="crate">
  <link name="crate">
    <inertial><mass value="3"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".4 .4 .4"/></geometry></collision>
  </link>
</robot>
"""
TABLE = BOX.replace('<robot name="crate">', '<robot name="table"><link name="world"/>').replace(
    "</robot>", '<joint name="fixed" type="fixed"><parent link="world"/><child link="crate"/></joint></robot>'
)


def spawn(loaded: LoadedWorld, name: str, use: str) -> None:
    loaded.add(name, RobotUse(use=use, position=(3.0, 0.0, 1.0)))


@pytest.mark.parametrize(("text", "kind"), [(CART, "robot"), (BOX, "object"), (TABLE, "static")])
@pytest.mark.parametrize("from_file", [True, False])
def test_a_scene_can_use_a_description_without_a_robot_file(
    project: Project, text: str, kind: str, from_file: bool
) -> None:
    loaded = project.write("thing.urdf", text).load()
    spawn(loaded, "thing", "thing.urdf" if from_file else text)
    simulation = loaded.simulation
    assert {entity.name: entity.kind for entity in simulation.entities.all()} == {"bot": "robot", "thing": kind}
    assert simulation.entities.state("thing").position == pytest.approx((3, 0, 1))
    low, _, _, high, _, _ = bounds(simulation, "thing")
    assert (low + high) / 2 == pytest.approx(3.0, abs=0.05)
    steps(simulation, 24)
    fallen = simulation.entities.state("thing").position[2] < 0.99
    assert fallen == (kind != "static")


def test_bodies_fixed_to_the_world_stay_in_place(project: Project) -> None:
    loaded = project.load()
    spawn(loaded, "table", TABLE)
    with pytest.raises(UsageError, match="its root link is the world itself"):
        loaded.simulation.entities.place("table", Move((0, 0, 0)))


def test_a_scene_file_names_a_description_too(project: Project) -> None:
    project.write("scene.yaml", "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.urdf, position: [0, 0, 1]}\n")
    loaded = project.load()
    assert loaded.simulation.articulation(loaded.stage.find("/bot")).joint_names == ("arm_joint",)


def test_a_note_says_that_a_description_has_no_joint_that_moves(project: Project) -> None:
    project.write("scene.yaml", "scene: test\nworld: world.xml\nrobots:\n  box: {use: box.urdf}\n").write(
        "box.urdf", BOX
    )
    _, findings = project.load_with_findings()
    (note,) = (finding for finding in findings.items if finding.code == "N104")
    assert note.message == "the description, used without a robot file, has no joint that moves"


def test_a_xacro_file_is_expanded(project: Project) -> None:
    text = BOX.replace('<robot name="crate">', '<robot name="crate" xmlns:xacro="http://www.ros.org/wiki/xacro">')
    loaded = project.write("box.urdf.xacro", text.replace('value="3"', 'value="${1 + 2}"')).load()
    spawn(loaded, "crate", "box.urdf.xacro")
    assert loaded.simulation.model.body("crate/crate").mass[0] == pytest.approx(3.0)


def test_an_error_in_a_text_has_its_position_and_leaves_no_robot(project: Project) -> None:
    loaded = project.load()
    with pytest.raises(CheckError, match=r"description:4:.* error S103: link 'crate': unknown shape 'blob'"):
        spawn(loaded, "crate", BOX.replace("<box ", "<blob "))
    assert [entity.name for entity in loaded.simulation.entities.all()] == ["bot"]
    spawn(loaded, "crate", BOX)


@pytest.mark.parametrize("text", ["<robot", "<", "<robot/>", "<!DOCTYPE x [<!ENTITY a 'b'>]><robot/>"])
def test_a_text_that_is_no_description_is_an_error(project: Project, text: str) -> None:
    with pytest.raises(CheckError, match="S103"):
        spawn(project.load(), "thing", text)


def test_a_text_reads_no_file_that_the_scene_may_not(project: Project) -> None:
    outside = project.folder.parent / "secret.stl"
    outside.write_bytes(b"solid secret\nendsolid\n")
    for reference in (f"file://{outside}", "../secret.stl", str(outside)):
        text = BOX.replace('<box size=".4 .4 .4"/>', f'<mesh filename="{reference}"/>')
        with pytest.raises(CheckError, match="lies outside the folder of the file you gave"):
            spawn(project.load(), "thing", text)


def test_texts_of_removed_robots_are_not_kept(project: Project) -> None:
    loaded = project.load()
    for mass in range(3, 6):
        spawn(loaded, "crate", BOX.replace('mass value="3"', f'mass value="{mass}"'))
        loaded.remove("crate")
    spawn(loaded, "crate", BOX)
    assert len(loaded.scenery._kinds) == 2


# MuJoCo models

CAN = """<mujoco model="can">
  <option gravity="0 0 5" timestep="0.1"/>
  <asset><mesh name="cone" vertex="0 0 0  .1 0 0  0 .1 0  0 0 .1"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="can"><freejoint/><geom type="cylinder" size=".05 .1" mass="1"/>
      <body pos="0 0 .2"><joint axis="0 1 0"/><geom type="mesh" mesh="cone" mass=".1"/></body>
    </body>
  </worldbody>
  <keyframe><key qpos="0 0 9 1 0 0 0 0"/></keyframe>
</mujoco>
"""


@pytest.mark.parametrize("from_file", [True, False])
def test_a_scene_can_use_a_mujoco_model_without_a_robot_file(project: Project, from_file: bool) -> None:
    loaded = project.write("can.xml", CAN).load()
    simulation = loaded.simulation
    timestep = simulation.model.opt.timestep
    spawn(loaded, "can", "can.xml" if from_file else CAN)
    spawn(loaded, "other", "can.xml" if from_file else CAN)
    assert [(entity.name, entity.kind) for entity in simulation.entities.all()][1:] == [
        ("can", "robot"),
        ("other", "robot"),
    ]
    assert simulation.entities.state("can").position == pytest.approx((3, 0, 1))
    assert (simulation.model.opt.timestep, simulation.model.opt.gravity[2]) == (timestep, -9.81)
    simulation.entities.place("other", Move((0, 3, 1)))
    steps(simulation, 24)
    assert simulation.entities.state("can").linear_velocity[2] == pytest.approx(-0.981)
    loaded.remove("can")
    assert simulation.entities.state("other").linear_velocity[2] == pytest.approx(-0.981)
    assert bounds(simulation, "other", own=True)[2::3] == pytest.approx((-0.1, 0.3), abs=1e-3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<mujoco><worldbody/></mujoco>", "must contain a body\n  it contains: none"),
        ("<mujoco><worldbody><geom name='a' size='1'/></worldbody></mujoco>", "it contains: a"),
        (
            "<mujoco><worldbody><geom name='a' type='plane' size='1 1 1'/><body/></worldbody></mujoco>",
            "contains a floor (plane or height field); floors belong to the scene's world\n  it contains: a",
        ),
        (
            "<mujoco>\n<extension><plugin plugin='mujoco.pid'/></extension></mujoco>",
            "<extension>: MuJoCo plugins are not supported",
        ),
        ("<mujoco><worldbody><body><geom size='-1'/></body></worldbody></mujoco>", "MuJoCo: size"),
        ("<mujoco><worldbody><blob/></worldbody></mujoco>", "MuJoCo: Schema violation"),
        ("<mujoco><include file='/etc/passwd'/></mujoco>", "lies outside the folder of the file you gave"),
        ("<mujoco><asset><mesh file='../a.stl'/></asset></mujoco>", "lies outside the folder of the file you gave"),
    ],
)
def test_a_mujoco_model_that_is_no_robot_is_refused_with_the_reason(project: Project, text: str, words: str) -> None:
    loaded = project.load()
    with pytest.raises(CheckError) as caught:
        spawn(loaded, "thing", text)
    assert words in "\n".join("\n  ".join((finding.message, *finding.help)) for finding in caught.value.findings)
    assert [entity.name for entity in loaded.simulation.entities.all()] == ["bot"]


def test_the_first_of_several_shapes_in_one_geometry_counts(project: Project) -> None:
    two = BOX.replace("</geometry>", '<mesh filename="absent.stl" scale=""/></geometry>')
    loaded = project.write("thing.urdf", two).load()
    spawn(loaded, "thing", "thing.urdf")
    low, _, _, high, _, _ = bounds(loaded.simulation, "thing")
    assert high - low == pytest.approx(0.4)
