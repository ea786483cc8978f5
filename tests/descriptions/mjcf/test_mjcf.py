"""MuJoCo models as robots: what the stage, graphs and messages know of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.mjcf import mjcf_trial
from graphengine.descriptions.mjcf.mjcf_preparation import prepare
from graphengine.descriptions.mjcf.mjcf_trial import reason_against
from graphengine.descriptions.urdf.link_parts import origin_of
from graphengine.devices.entity import Move
from graphengine.devices.rotation import Pose, compose, pose_of, relative
from graphengine.format.errors import JointError
from graphengine.format.spec import RobotUse
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project, steps
from tests.physics.mjcf_models import ARM, ARM_KEYS, ARM_URDF, KITCHEN_SINK, QUADRUPED

MODEL = "robot: bot\nmjcf: bot.xml\n"


def model(project: Project, text: str, keys: str = "", base: str = "trunk") -> Project:
    return project.write("bot.xml", text).write("bot.yaml", f"{MODEL}base_link: {base}\n{keys}")


def loaded(project: Project, text: str, keys: str = "", base: str = "trunk") -> tuple[Simulation, Joints]:
    return model(project, text, keys, base).load_joints()


def test_graphs_know_the_joints_of_a_model_by_their_names(project: Project) -> None:
    simulation, joints = loaded(project, KITCHEN_SINK)
    known = ("pan", "body_7_joint", "lift", "elbow", "left_slide", "right_slide")
    assert joints.joint_names == known
    assert joints.prismatic == (False, False, False, False, True, True)
    assert joints.positions().tolist() == pytest.approx([0.1, 0, 0, 0, 0, 0])
    names = {prim.name for prim in simulation.stage.find("/bot").descendants()}
    assert {"trunk", "forearm", "head", "pod", "imu", "tip", "eye", *known, "neck"} <= names


def test_prims_of_links_sites_and_cameras_lie_where_mujoco_has_them(project: Project) -> None:
    simulation, _ = loaded(project, KITCHEN_SINK, "start: home\n")
    steps(simulation, 20)
    model, data = simulation.model, simulation.data
    for kind, names in (("body", ("trunk", "forearm", "head", "pod")), ("site", ("tip", "imu")), ("camera", ("eye",))):
        for name in names:
            (prim,) = [p for p in simulation.stage.find("/bot").descendants() if p.name == name and p.kind == "link"]
            turn = np.zeros(4)
            own = {"body": data.body, "site": data.site, "camera": data.camera}[kind](f"bot/{name}")
            mujoco.mju_mat2Quat(turn, own.xmat)
            expected = pose_of(own.xpos, turn)
            found = simulation.frame(prim).pose()
            assert found[0] == pytest.approx(expected[0], abs=1e-9)
            assert abs(np.dot(found[1], expected[1])) == pytest.approx(1.0, abs=1e-9)
    assert model.nkey == 0


def test_the_chain_of_joints_leads_where_mujoco_puts_the_body(project: Project) -> None:
    """Forward kinematics of the published description, with several joints to a body, one beside its origin, one with a `ref`."""
    loaded_world = model(project, KITCHEN_SINK).load()
    robot, simulation = loaded_world.robots["bot"], loaded_world.simulation
    joints = simulation.articulation(simulation.stage.find("/bot"))
    angles = dict(zip(joints.joint_names, (0.7, 0.2, -0.4, 0.5, 0.01, 0.01), strict=True))
    data = simulation.data
    for name, angle in angles.items():
        data.qpos[simulation.model.joint(f"bot/{name}").qposadr[0]] = angle
    mujoco.mj_kinematics(simulation.model, data)
    pose, link = (pose_of(np.zeros(3), np.array([1.0, 0, 0, 0]))), "forearm"
    while (carrier := robot.description.links[link].carrier) is not None:
        x, y, z = carrier.axis
        half = angles.get(carrier.name, 0.0) / 2
        turn: Pose = ((0.0, 0.0, 0.0), (x * math.sin(half), y * math.sin(half), z * math.sin(half), math.cos(half)))
        pose = compose(compose(carrier.pose, turn), pose)
        link = carrier.parent
    ends = [pose_of(data.body(f"bot/{body}").xpos, data.body(f"bot/{body}").xquat) for body in ("trunk", "forearm")]
    expected = relative(*ends)
    assert pose[0] == pytest.approx(expected[0], abs=1e-9)
    assert abs(np.dot(pose[1], expected[1])) == pytest.approx(1.0)


def test_the_written_description_reads_back_as_the_same_poses(project: Project) -> None:
    urdf = model(project, KITCHEN_SINK).load().robots["bot"].description
    for joint in urdf.joints.values():
        written = origin_of(joint.element)
        assert written is not None
        assert written[0] == pytest.approx(joint.pose[0])
        assert abs(np.dot(written[1], joint.pose[1])) == pytest.approx(1.0, abs=1e-9)
    assert urdf.mass == pytest.approx(sum(link.mass for link in urdf.links.values()))
    assert urdf.joints["right_slide"].mimic is not None
    assert urdf.joints["neck"].type == "floating"


@pytest.mark.parametrize(
    ("names", "kind", "command", "actuator", "control"),
    [
        (["pan"], "positions", 0.5, "pan", 0.5),
        (["pan"], "positions", 9.0, "pan", 2.0),
        (["lift"], "efforts", 5.0, "lift_motor", 0.5),
        (["lift_motor"], "efforts", -50.0, "lift_motor", -1.0),
        (["elbow"], "velocities", 1.5, "elbow_velocity", 1.5),
        (["elbow_velocity"], "velocities", 1.5, "elbow_velocity", 1.5),
        (["gripper"], "positions", 0.02, "gripper", 0.02 * 100 / 0.0157),
        (["gripper"], "positions", 1.0, "gripper", 255.0),
        (["body_7_joint"], "velocities", 2.0, "wheel", 2.0),
        (["damper"], "efforts", 0.3, "damper", 0.3),
        (["pan"], "velocities", 1.0, "pan", 0.1),  # as at the start
        (["gripper"], "efforts", 1.0, "gripper", 0.0),
    ],
)
def test_a_command_becomes_the_control_signal_of_an_actuator(
    project: Project, names: Sequence[str], kind: str, command: float, actuator: str, control: float
) -> None:
    simulation, joints = loaded(project, KITCHEN_SINK)
    joints.select(names).command(**{kind: [command]})
    simulation.step()
    assert simulation.data.actuator(f"bot/{actuator}").ctrl[0] == pytest.approx(control, rel=1e-6)
    simulation.zero_commands()
    simulation.step()
    rests = {
        "pan": simulation.data.actuator("bot/pan").ctrl[0],
        "gripper": simulation.data.actuator("bot/gripper").ctrl[0],
    }
    assert simulation.data.actuator(f"bot/{actuator}").ctrl[0] == pytest.approx(rests.get(actuator, 0.0))


def test_an_effort_acts_on_a_joint_without_a_motor_too(project: Project) -> None:
    simulation, joints = loaded(project, KITCHEN_SINK)
    joints.select(["pan"]).command(efforts=[3.0])
    simulation.step()
    assert simulation.data.qfrc_applied[simulation.model.joint("bot/pan").dofadr[0]] == 3.0


def test_a_motor_exerts_the_commanded_torque_through_its_gear(project: Project) -> None:
    simulation, joints = loaded(project, QUADRUPED.replace("<motor ctrlrange", '<motor gear="5" ctrlrange'))
    joints.select(["FL_calf_joint"]).command(efforts=[7.0])
    simulation.step()
    calf = joints.joint_names.index("FL_calf_joint")
    assert simulation.data.actuator("bot/FL_calf").ctrl[0] == pytest.approx(1.4)
    assert simulation.data.qfrc_actuator[joints.dofs[calf]] == pytest.approx(7.0)
    assert joints.efforts()[calf] == pytest.approx(7.0)


def test_set_points_are_reported_in_the_units_of_commands(project: Project) -> None:
    _, joints = loaded(project, KITCHEN_SINK)
    joints.select(["pan"]).command(positions=[0.5])
    joints.select(["elbow"]).command(velocities=[0.25])
    positions, velocities = joints.set_points()
    assert positions[joints.joint_names.index("pan")] == 0.5
    assert velocities[joints.joint_names.index("elbow")] == 0.25
    assert math.isnan(positions[joints.joint_names.index("lift")])


def test_selecting_a_tendons_actuator_as_a_joint_is_an_error(project: Project) -> None:
    _, joints = loaded(project, KITCHEN_SINK)
    with pytest.raises(JointError, match="has no joint 'gripped'"):
        joints.select(["gripped"])


@pytest.mark.parametrize("where", ["robot file", "scene"])
def test_a_robot_starts_in_a_keyframe_where_it_is_placed(project: Project, where: str) -> None:
    keys = "start: home\n" if where == "robot file" else ""
    start = ", start: home" if where == "scene" else ""
    place = f"position: [1, 2, 0], orientation: {{rpy_deg: [0, 0, 90]}}{start}"
    project.write("scene.yaml", f"scene: test\nworld: world.xml\nrobots:\n  bot: {{use: bot.yaml, {place}}}\n")
    simulation, joints = loaded(project, QUADRUPED, keys)
    assert simulation.entities.state("bot").position == pytest.approx((1, 2, 0.27))
    assert simulation.entities.state("bot").orientation == pytest.approx(
        (0, 0, math.sin(math.pi / 4), math.cos(math.pi / 4))
    )
    pose = dict(zip(joints.joint_names, joints.positions().tolist(), strict=True))
    assert (pose["FL_hip_joint"], pose["RR_thigh_joint"], pose["FR_calf_joint"]) == (0.0, 0.9, -1.8)
    steps(simulation, 10)
    simulation.reset()
    assert simulation.entities.state("bot").position == pytest.approx((1, 2, 0.27))


def test_a_keyframe_gives_the_control_signals_and_position_servos_begin_at_their_joints(project: Project) -> None:
    simulation, _ = loaded(project, ARM, "start: home\n", base="base")
    assert simulation.data.ctrl.tolist() == [0.5, -1.0]
    without = ARM.replace(' ctrl="0.5 -1"', "")
    simulation, _ = loaded(project, without, "start: home\njoints: {elbow: {start: 0.25}}\n", base="base")
    assert simulation.data.ctrl.tolist() == [0.5, 0.25]
    assert simulation.data.qpos.tolist() == [0.5, 0.25]


def test_an_unknown_keyframe_is_an_error_that_lists_the_known_keyframes(project: Project) -> None:
    error = model(project, QUADRUPED, "start: hom\n").error()
    assert "S104: the robot has no keyframe 'hom'" in error
    assert "home" in error


def test_an_arm_moves_alike_as_mjcf_and_as_urdf(project: Project) -> None:
    paths = []
    project.write("scene.yaml", "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.yaml, position: [0, 0, 1]}\n")
    project.write("bot.urdf", ARM_URDF)
    for robot_file in (f"{MODEL}base_link: base\nstart: home\n", f"robot: bot\nurdf: bot.urdf\n{ARM_KEYS}"):
        project.write("bot.xml", ARM).write("bot.yaml", robot_file)
        simulation, joints = project.load_joints()
        path = []
        for step in range(480):
            target = 0.8 * math.sin(step / 60)
            joints.select(["shoulder", "elbow"]).command(positions=[0.5 + target, -1.0 - target])
            simulation.step()
            path.append(joints.positions())
        paths.append(np.array(path))
    reach = np.ptp(paths[1], axis=0)
    assert np.abs(paths[0] - paths[1]).max(axis=0) == pytest.approx(np.zeros(2), abs=0.01 * float(reach.min()))


def test_the_model_is_attached_unchanged(project: Project) -> None:
    """Masses, contacts, tendons and sensors of the compiled scene are those of the model alone."""
    simulation, _ = loaded(project, KITCHEN_SINK)
    spec = mujoco.MjSpec.from_string(KITCHEN_SINK)
    prepare(spec)
    alone, whole = spec.compile(), simulation.model
    assert (whole.nv, whole.nu, whole.ntendon, whole.neq, whole.nsensor, whole.nexclude) == (
        (alone.nv, alone.nu, alone.ntendon, alone.neq, alone.nsensor, alone.nexclude)
    )
    assert whole.body_mass[1:].tolist() == alone.body_mass[1:].tolist()
    assert whole.dof_damping.tolist() == alone.dof_damping.tolist()
    assert whole.geom_solref[1:].tolist() == alone.geom_solref.tolist()


def test_options_of_the_model_give_way_to_the_scene(project: Project) -> None:
    _, findings = model(project, KITCHEN_SINK).load_with_findings()
    told = {finding.code: finding for finding in findings.items}
    assert "timestep 0.001 s is overridden by the scene's" in told["W204"].message
    (options,) = [finding for finding in findings.items if "options of the model have no effect" in finding.message]
    assert options.help == ("options: integrator, cone, impratio, warmstart",)


def test_a_drive_of_the_robot_file_takes_the_place_of_an_actuator(project: Project) -> None:
    simulation, joints = loaded(project, QUADRUPED, "joints: {FL_calf_joint: {drive: {stiffness: 50, damping: 2}}}\n")
    names = [simulation.model.actuator(index).name for index in range(simulation.model.nu)]
    assert "bot/FL_calf" not in names
    assert {"bot/FL_calf_joint.position", "bot/FL_calf_joint.velocity", "bot/FR_calf"} <= set(names)
    joints.select(["FL_calf_joint"]).command(positions=[-1.5])
    simulation.step()
    assert simulation.data.actuator("bot/FL_calf_joint.position").ctrl[0] == -1.5


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ("keep_only_joints: [FL_calf_joint]\n", "G109: keep_only_joints: has no effect on a MuJoCo model"),
        ("joints: {FL_calf_joint: {enabled: false}}\n", "G109: enabled: has no effect on a MuJoCo model"),
        ("urdf: bot.urdf\n", "G109: urdf: not allowed beside `mjcf`, which names a MuJoCo model"),
        ("joints: {FL_claf_joint: {armature: 1}}\n", "S104: the robot has no joint 'FL_claf_joint'"),
    ],
)
def test_a_property_of_a_model_that_a_robot_file_cannot_hold_is_an_error(
    project: Project, keys: str, told: str
) -> None:
    assert told in model(project, QUADRUPED, keys).error()


def test_a_base_is_fixed_if_the_model_has_no_free_joint_or_the_robot_file_says_so(project: Project) -> None:
    simulation, _ = loaded(project, QUADRUPED, "fixed_base: true\nstart: home\n")
    steps(simulation, 50)
    assert simulation.entities.state("bot").position == pytest.approx((0, 0, 0.5))  # 0.1 of the scene, 0.4 of the model
    simulation, _ = loaded(project, ARM, base="base")
    steps(simulation, 50)
    assert simulation.entities.state("bot").position == pytest.approx((0, 0, 0.1))


def test_several_bodies_hang_on_the_world(project: Project) -> None:
    two = """<mujoco><worldbody><geom name="wall" type="box" size=".1 .1 .1" pos="0 0 2"/>
      <body name="a" pos="1 0 0"><joint axis="0 0 1"/><geom size=".1"/></body>
      <body name="b" pos="2 0 0"><freejoint/><geom size=".1"/></body></worldbody></mujoco>"""
    loaded_world = model(project, two, base="world").load()
    simulation = loaded_world.simulation
    joints = simulation.articulation(simulation.stage.find("/bot"))
    assert joints.joint_names == ("a_joint",)
    assert [joint.type for joint in loaded_world.robots["bot"].description.joints.values()] == [
        "continuous",
        "floating",
    ]
    steps(simulation, 20)
    assert simulation.data.body("bot/b").xpos[2] < 0.1


def test_a_robot_of_a_model_is_added_beside_others_which_go_on(project: Project) -> None:
    loaded_world = model(project, KITCHEN_SINK).load()
    simulation = loaded_world.simulation
    joints = simulation.articulation(simulation.stage.find("/bot"))
    joints.select(["body_7_joint"]).command(velocities=[2.0])
    steps(simulation, 10)
    before = simulation.data.act.copy(), joints.set_points()
    loaded_world.add("other", RobotUse(use="bot.yaml", position=(3, 0, 0)))
    assert simulation.data.act[: len(before[0])].tolist() == before[0].tolist()
    np.testing.assert_array_equal(joints.set_points(), before[1])
    simulation.entities.place("other", Move((0, 5, 1)))
    assert simulation.entities.state("other").position == pytest.approx((0, 5, 1))


def test_includes_and_meshes_are_read_within_the_folder(project: Project) -> None:
    legs = QUADRUPED.replace("<sensor>", '<include file="parts/sensors.xml"/><sensor>')
    project.write("parts/sensors.xml", '<mujoco><sensor><touch site="imu"/></sensor></mujoco>')
    simulation, _ = loaded(project, legs)
    assert simulation.model.nsensor == 4
    outside = project.folder.parent / "outside.xml"
    outside.write_text("<mujoco/>", encoding="utf-8")
    error = model(project, legs.replace("parts/sensors.xml", "../outside.xml")).error()
    assert "'../outside.xml' lies outside the folder of the file you gave" in error


def test_a_model_that_keeps_the_compiler_busy_without_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    endless = """<mujoco><worldbody><body pos="nan 0 0"><freejoint/><geom size=".1"/><site name="a"/>
      <body><joint/><geom size=".1"/><site name="b" pos="1 0 0"/></body></body></worldbody>
      <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
      <actuator><muscle tendon="t"/></actuator></mujoco>"""
    assert reason_against(QUADRUPED, {}, {}) == ""
    assert reason_against("<mujoco><worldbody><geom size='-1'/></worldbody></mujoco>", {}, {}) == ""
    monkeypatch.setattr(mjcf_trial, "MAX_SECONDS", 3.0)
    assert reason_against(endless, {}, {}) == "takes more than 3 s"


def test_the_project_of_a_model_is_not_changed_by_reading_it(project: Project, tmp_path: Path) -> None:
    model(project, KITCHEN_SINK)
    before = {path: path.read_bytes() for path in project.folder.rglob("*") if path.is_file()}
    project.load()
    assert {path: path.read_bytes() for path in project.folder.rglob("*") if path.is_file()} == before


def test_the_drive_of_a_robot_file_does_not_take_over_defaults_of_actuators(project: Project) -> None:
    drive = "drive: {stiffness: 5000, damping: 200, gravity_compensation: true, interpolate: true}"
    simulation, joints = loaded(project, ARM, f"start: home\njoints: {{shoulder: {{{drive}}}}}\n", "base")
    steps(simulation, 500)
    assert joints.positions()[0] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(
    ("key", "expected"),
    [
        ("drive: {stiffness: 300, damping: 30}", 100 * 0.5 / 400),
        ("spring: {stiffness: 300, rest: 0.1}", (100 * 0.5 + 300 * 0.1) / 400),
    ],
)
def test_the_springs_of_a_model_and_of_a_robot_file_act_together(project: Project, key: str, expected: float) -> None:
    sprung = """<mujoco><compiler angle="radian"/><worldbody><body name="base" pos="0 0 1"><geom size=".1"/><body name="arm">
      <joint name="turn" axis="0 0 1" stiffness="100" springref="0.5" damping="20"/><geom size=".05" mass="1" pos=".3 0 0"/>
      </body></body></worldbody></mujoco>"""
    simulation, joints = loaded(project, sprung, f"fixed_base: true\njoints: {{turn: {{{key}}}}}\n", "base")
    steps(simulation, 1000)
    assert joints.positions().tolist() == pytest.approx([expected], abs=1e-3)


def test_a_robot_file_may_name_links_that_stand_for_sites(project: Project) -> None:
    loaded(project, ARM, "links: {flange: {gravity: false}}\n", "base")
    error = model(project, ARM, "wheel_colliders: {flange: ellipsoid}\n", "base").error()
    assert "link 'flange' cannot become an ellipsoid" in error


def hinged(attributes: str) -> str:
    """Return a model whose only joint has the given attributes."""
    return f"""<mujoco><compiler angle="radian"/><worldbody><body name="base"><geom size=".1"/><body name="arm">
      <joint name="turn" {attributes}/><geom size=".05" mass="1" pos=".3 0 0"/></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("attributes", "told"),
    [
        ('damping="-1"', "joint 'turn': dynamics damping must be a number of at least 0, not '-1.0'"),
        ('frictionloss="-1"', "joint 'turn': dynamics friction must be a number of at least 0, not '-1.0'"),
        ('range="-1e305 1e305"', "joint 'turn': limit lower must be a number, not '-1e+305'"),
        ('axis="1e200 0 0"', "joint 'turn': axis xyz must be three numbers, not all of them zero"),
    ],
)
def test_numbers_that_no_joint_can_have_are_errors(project: Project, attributes: str, told: str) -> None:
    assert told in "\n".join(model(project, hinged(attributes), base="base").errors())


def test_limits_of_a_model_that_are_probably_in_degrees_are_a_warning(project: Project) -> None:
    _, findings = model(project, hinged('range="-180 180"'), base="base").load_with_findings()
    assert [each.code for each in findings.items if each.code == "W217"] == ["W217"]
