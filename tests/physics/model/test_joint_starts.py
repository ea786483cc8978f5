"""Where joints start, which limits they have, and springs at them."""

from __future__ import annotations

import pytest

from graphengine.format.spec import RobotUse
from tests.physics.harness import CART, SCENE, Project, steps

HELD = "drive: {stiffness: 2000, damping: 100}"
FOLLOWER = """  <link name="hand">
    <inertial><mass value=".1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="hand_joint" type="revolute">
    <parent link="arm"/><child link="hand"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
    <mimic joint="arm_joint" multiplier="-2" offset="0.1"/>
  </joint>
</robot>"""


def positions(project: Project) -> list[float]:
    _, joints = project.load_joints()
    return list(map(float, joints.positions()))


def test_a_joint_starts_where_its_robot_file_says_and_its_drive_holds_it_there(project: Project) -> None:
    simulation, joints = project.robot(f"joints: {{arm_joint: {{start: 0.5, {HELD}}}}}").load_joints()
    assert joints.positions().tolist() == [0.5]
    assert joints.set_points()[0].tolist() == [0.5]
    steps(simulation, 240)
    assert joints.positions()[0] == pytest.approx(0.5, abs=0.01)


def test_a_reset_goes_back_to_the_start(project: Project) -> None:
    simulation, joints = project.robot(f"joints: {{arm_joint: {{start: 0.5, {HELD}}}}}").load_joints()
    joints.select().command(positions=[-0.5])
    steps(simulation, 240)
    assert joints.positions()[0] == pytest.approx(-0.5, abs=0.01)
    simulation.reset()
    assert joints.positions().tolist() == [0.5]
    assert joints.set_points()[0].tolist() == [0.5]


@pytest.mark.parametrize("keys", ["limits: [0.4, 1], ", "limits: [-1, -0.4], "])
def test_a_joint_whose_range_excludes_zero_is_held_at_the_limit_at_which_it_starts(project: Project, keys: str) -> None:
    drive = "drive: {stiffness: 2000, damping: 100, max_velocity: 0.5}"
    simulation, joints = project.robot(f"joints: {{arm_joint: {{{keys}{drive}}}}}\nfixed_base: true").load_joints()
    simulation.set_gravity((0.0, 0.0, 0.0))
    assert joints.set_points()[0].tolist() == joints.positions().tolist()
    assert abs(joints.positions()[0]) == 0.4
    steps(simulation, 120)
    assert abs(joints.efforts()[0]) < 0.1  # N m, of 40


SERVOS = """<mujoco><compiler angle="radian"/><worldbody><body name="arm">
<joint name="hinge" axis="0 0 1" ref="0.7" range="-2 2"/><geom size="0.1" pos="0.2 0 0" mass="0.5"/></body></worldbody>
<actuator>{}</actuator><keyframe><key name="home" qpos="0.9" ctrl="{}"/></keyframe></mujoco>"""
POSITION = '<position name="servo" joint="hinge" kp="20" kv="2"{}/>'
INTEGRATED = '<intvelocity name="servo" joint="hinge" kp="20" kv="2" actrange="-3 3"/>'


@pytest.mark.parametrize(
    ("servo", "control"),
    [(POSITION.format(""), 0.9), (POSITION.format(' timeconst="0.2"'), 0.9), (INTEGRATED, 0.0)],
    ids=["position servo", "with a filter", "that integrates velocities"],
)
@pytest.mark.parametrize(
    ("keys", "start"),
    [
        ("", 0.7),
        ("start: home", 0.9),
        ("joints: {hinge: {start: -0.4}}", -0.4),
        ("start: home\njoints: {hinge: {start: 1.3}}", 1.3),
    ],
)
def test_the_servo_of_a_model_holds_its_joint_where_it_starts_and_after_a_reset(
    project: Project, servo: str, control: float, keys: str, start: float
) -> None:
    keys = f"robot: bot\nmjcf: bot.xml\nbase_link: world\n{keys}\n"
    simulation, joints = project.write("bot.xml", SERVOS.format(servo, control)).write("bot.yaml", keys).load_joints()
    for _ in range(2):
        assert joints.positions()[0] == pytest.approx(start)
        steps(simulation, 480)
        assert joints.positions()[0] == pytest.approx(start, abs=1e-3)
        simulation.reset()


def test_the_scene_overrides_the_robot_file_for_one_robot(project: Project) -> None:
    project.robot("joints: {arm_joint: {start: 0.5}}")
    project.scene("  other: {use: bot.yaml, position: [0, 2, 0.1], joints: {arm_joint: {start: -0.25}}}\n")
    world = project.load()
    found = {name: world.stage.find(f"/{name}") for name in ("bot", "other")}
    starts = {name: world.simulation.articulation(prim).positions().tolist() for name, prim in found.items()}
    assert starts == {"bot": [0.5], "other": [-0.25]}


def test_a_robot_added_later_gets_its_start_positions_and_other_robots_do_not_move(project: Project) -> None:
    world = project.robot(f"joints: {{arm_joint: {{start: 0.5, {HELD}}}}}").load()
    joints = world.simulation.articulation(world.stage.find("/bot"))
    joints.select().command(positions=[-0.5])
    steps(world.simulation, 240)
    world.add("late", RobotUse(use="bot.yaml", position=(0, 2, 0.1)))
    late = world.simulation.articulation(world.stage.find("/late"))
    assert late.positions().tolist() == [0.5]
    assert joints.positions()[0] == pytest.approx(-0.5, abs=0.01)
    world.simulation.reset()
    assert joints.positions().tolist() == late.positions().tolist() == [0.5]


def test_a_follower_starts_where_its_leader_puts_it(project: Project) -> None:
    project.write("bot.urdf", CART.replace("</robot>", FOLLOWER)).robot("joints: {arm_joint: {start: 0.5}}")
    assert positions(project) == [0.5, -0.9]


@pytest.mark.parametrize(
    ("joint", "told"),
    [
        ("arm_joint: {start: 1.5}", "bot.yaml:3:29: error G109: joint 'arm_joint' cannot start at 1.5 rad"),
        ("arm_joint: {start: 1.5}", "legal: -1 to 1 rad"),
        ("arm_joint: {start: 0.9, limits: [-0.5, 0.5]}", "legal: -0.5 to 0.5 rad"),
        ("arm_joint: {limits: [0.5, -0.5]}", "limits must be [lowest, highest]"),
        ("plate_joint: {start: 0.1}", "joint 'plate_joint' does not move, so it cannot have a start position"),
        ("plate_joint: {spring: {stiffness: 1}}", "so a spring has no effect"),
        ("plate_joint: {limits: [0, 1]}", "joint 'plate_joint' is fixed and cannot have limits"),
    ],
)
def test_an_illegal_start_position_is_an_error_at_its_line(project: Project, joint: str, told: str) -> None:
    assert told in project.robot(f"joints: {{{joint}}}").error()


@pytest.mark.parametrize(
    ("joint", "told"),
    [
        ("arm_joint: {start: 2}", "scene.yaml:4:75: error G109: joint 'arm_joint' cannot start at 2 rad"),
        ("arm_joit: {start: 0}", "did you mean 'arm_joint'?"),
    ],
)
def test_the_same_holds_for_a_scene(project: Project, joint: str, told: str) -> None:
    entry = SCENE.replace("position: [0, 0, 0.1]", f"position: [0, 0, 0.1], joints: {{{joint}}}")
    assert told in project.write("scene.yaml", entry).error()


def test_a_start_of_a_follower_is_refused(project: Project) -> None:
    project.write("bot.urdf", CART.replace("</robot>", FOLLOWER)).robot("joints: {hand_joint: {start: 0.5}}")
    assert "joint 'hand_joint' mimics 'arm_joint', so its start position follows from that joint" in project.error()


@pytest.mark.parametrize(
    "drive", ["", ", drive: {stiffness: 300, damping: 20}"], ids=["alone", "beside a drive that pulls to zero"]
)
def test_a_spring_pulls_to_its_rest(project: Project, drive: str) -> None:
    keys = f"joints: {{arm_joint: {{spring: {{stiffness: 300, rest: 0.2}}{drive}}}}}\nfixed_base: true"
    damped = CART.replace("<limit lower", '<dynamics damping="20"/><limit lower')
    simulation, joints = project.write("bot.urdf", damped).robot(keys).load_joints()
    simulation.set_gravity((0.0, 0.0, 0.0))
    steps(simulation, 1000)
    assert joints.positions()[0] == pytest.approx(0.2 if not drive else 0.1, abs=1e-3)
