"""What decides the drives of an imported robot and the graph of its base, in which order, and what an import says of it."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from graphengine.bringup.robots.resting import MOST_JOINTS
from tests.bringup.robots.arms import limb, robot
from tests.bringup.robots.descriptions import INERTIA
from tests.bringup.robots.imported_bases import (
    CAR,
    CONTROLLERS,
    DIFFERENTIAL,
    PLUGIN,
    attempt,
    description,
    imported,
    interfaces,
    remarks,
    robot_file,
    slow,
)
from tests.physics.bases import FOUR, MECANUM, SKID, Base, Wheel


def parameters(folder: Path, text: str, controllers: str = "") -> dict[str, Any]:
    """The parameters of the base's graph."""
    found = robot_file(imported(folder, text, controllers))["graphs"]["base"]["parameters"]
    assert isinstance(found, dict)
    return found


NESTED = CONTROLLERS + "    linear: {x: {max_velocity: 0.7, max_acceleration: 0.9}}\n"
DOTTED = CONTROLLERS + "    linear.x.max_velocity: 0.7\n    linear.x.max_acceleration: 0.9\n"


ROS_1 = """bot:
  base:
    type: diff_drive_controller/DiffDriveController
    left_wheel: left_joint
    right_wheel: [right_joint]
    linear: {x: {has_velocity_limits: true, max_velocity: 0.7, max_acceleration: 0.9}}
"""


@pytest.mark.parametrize(
    "text",
    [
        NESTED,
        DOTTED,
        DOTTED.replace("controller_manager:", "/**/controller_manager:").replace("\nbase_con", "\n/robot/base_con"),
        "/**:\n" + "".join(f"  {line}\n" for line in NESTED.splitlines()),
        DOTTED.replace("base_controller: {type: diff", "base_controller.type: {x: diff")
        .replace("{x: ", "")
        .replace("DiffDriveController}", "DiffDriveController"),
        DOTTED.replace("wheel_names: [left_joint]", "wheel_names: left_joint"),
        ROS_1,
    ],
)
def test_controllers_are_read_from_nested_and_dotted_parameter_files(tmp_path: Path, text: str) -> None:
    found = parameters(tmp_path, description(DIFFERENTIAL), text)
    assert {key: found[key] for key in ("left", "right", "speed", "acceleration", "deceleration")} == {
        "left": ["left_joint"],
        "right": ["right_joint"],
        "speed": 0.7,
        "acceleration": 0.9,
        "deceleration": 0.9,
    }


def test_a_disabled_limit_does_not_count(tmp_path: Path) -> None:
    text = (
        f"{DOTTED}    linear.x.has_velocity_limits: false\n    cmd_vel_timeout: 0.25\n    odom_frame_id: world_frame\n"
    )
    found = parameters(tmp_path, description(DIFFERENTIAL), text)
    assert "speed" not in found
    assert (found["timeout"], found["odom_frame"]) == (0.25, "world_frame")


def test_a_controller_of_unknown_joints_is_reported_and_the_wheels_define_the_base(tmp_path: Path) -> None:
    found = imported(tmp_path, description(DIFFERENTIAL), CONTROLLERS.replace("[left_joint]", "[lft_joint]"))
    said = remarks(found)
    assert "lost: DiffDriveController base_controller: the description has no joint 'lft_joint'; did you mean" in said
    assert "guessed: base: differential with 2 driven wheels, radius 0.05 m, track 0.3 m" in said


def test_measurements_from_the_description_are_used_and_differing_values_are_reported(tmp_path: Path) -> None:
    text = CONTROLLERS.replace("wheel_radius: 0.05", "wheel_radius: 0.06")
    found = imported(tmp_path, description(DIFFERENTIAL), text)
    assert robot_file(found)["graphs"]["base"]["parameters"]["radius"] == 0.05
    assert "noticed: the radius of the wheels is 0.05 m as in the description; DiffDriveController" in remarks(found)


@pytest.mark.parametrize(
    "plugin",
    [
        PLUGIN.replace("</plugin>", "<topic>go</topic><odom_topic>here</odom_topic></plugin>"),
        PLUGIN.replace("gz-sim-diff-drive-system", "libignition-gazebo-diff-drive-system.so").replace(
            "</plugin>", "<topic>/go</topic><odom_topic>/here</odom_topic></plugin>"
        ),
        """<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
          <ros><remapping>cmd_vel:=go</remapping><remapping>odom:=here</remapping></ros>
          <left_joint>left_joint</left_joint><right_joint>right_joint</right_joint><wheel_diameter>0.1</wheel_diameter>
        </plugin></gazebo>""",
        """<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so"><commandTopic>go</commandTopic>
          <odometryTopic>here</odometryTopic><leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint>
        </plugin></gazebo>""",
        """<gazebo><plugin name="SkidSteerDrivePlugin" filename="libSkidSteerDrivePlugin.so">
          <topic>go</topic><odom_topic>here</odom_topic>
          <left_front>left_joint</left_front><right_front>right_joint</right_front><MaxForce>5.0</MaxForce>
        </plugin></gazebo>""",
    ],
)
def test_plugins_of_gazebo_give_joints_and_topics(tmp_path: Path, plugin: str) -> None:
    found = imported(tmp_path, description(DIFFERENTIAL, plugin))
    known = robot_file(found)["graphs"]["base"]["parameters"]
    assert (known["cmd_vel"], known["odom"], known["left"]) == ("go", "here", ["left_joint"])
    assert "carried: base: differential with 2 driven wheels" in remarks(found)
    assert "lost: gazebo plugin" not in remarks(found)


def test_topics_of_publisher_plugins_replace_those_of_the_drive_plugin(tmp_path: Path) -> None:
    more = """<gazebo>
      <plugin filename="gz-sim-joint-state-publisher-system" name="gz::sim::systems::JointStatePublisher">
        <topic>states</topic>
      </plugin>
      <plugin filename="gz-sim-odometry-publisher-system" name="gz::sim::systems::OdometryPublisher">
        <odom_topic>way</odom_topic><odom_frame>start</odom_frame>
      </plugin></gazebo>"""
    known = parameters(tmp_path, description(DIFFERENTIAL, PLUGIN, more))
    assert (known["joint_states"], known["odom"], known["odom_frame"]) == ("states", "way", "start")


def test_fixed_wheels_of_a_base_are_reported(tmp_path: Path) -> None:
    plugin = '<gazebo><plugin name="move" filename="libgazebo_ros_planar_move.so"/></gazebo>'
    still = description(DIFFERENTIAL, plugin).replace('type="continuous"', 'type="fixed"')
    said = remarks(imported(tmp_path, still))
    assert (
        "noticed: nothing moves or holds the robot: none of its joints moves, and no wheels that drive a base" in said
    )
    assert "nothing moves" not in remarks(imported(tmp_path, description(DIFFERENTIAL, plugin)))


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        (
            "effort",
            "noticed: nothing moves or holds the robot's joints: they have no drives; --position-drives holds joints",
        ),
        ("position", ""),
    ],
)
def test_a_fixed_arm_without_drives_is_reported(tmp_path: Path, kind: str, told: str) -> None:
    """Upright, such an arm need not fall in the first seconds."""
    commands = interfaces(j1=kind, j2=kind)
    said = remarks(imported(tmp_path, robot(limb("j", 2, base="world"), commands, base="world")))
    assert told in said
    assert ("nothing moves" in said) is bool(told)


@pytest.mark.parametrize("type_name", ["joint_state_broadcaster/JointStateBroadcaster", "vendor/JointController"])
def test_a_controller_that_commands_no_joint_leaves_the_joints_their_drives(tmp_path: Path, type_name: str) -> None:
    other = f"controller_manager: {{ros__parameters: {{other: {{type: {type_name}}}}}}}\n"
    other += "other: {ros__parameters: {joints: [j1, j2, j3]}}\n"
    found = imported(tmp_path, robot(limb("j", 3)), other)
    assert all(robot_file(found)["joints"][name]["drive"]["stiffness"] > 0 for name in ("j1", "j2", "j3"))
    assert "no controller commands them" not in remarks(found)


def test_a_base_pushed_by_a_plugin_is_driven_by_its_wheels_with_a_remark(tmp_path: Path) -> None:
    plugin = '<gazebo><plugin name="move" filename="libgazebo_ros_planar_move.so"/></gazebo>'
    said = remarks(imported(tmp_path, description(DIFFERENTIAL, plugin)))
    assert "lost: plugin planar_move: it pushes the base without turning its wheels" in said
    assert "guessed: base: differential" in said


@pytest.mark.parametrize(
    ("name", "kinematics"),
    [("left", "differential"), ("mecanum_left", "mecanum"), ("omni_wheel_left", "mecanum")],
)
def test_the_names_of_wheels_distinguish_mecanum_from_skid_steered_bases(
    tmp_path: Path, name: str, kinematics: str
) -> None:
    places = [(x, y) for x in (0.2, -0.2) for y in (0.2, -0.2)]
    base = Base("cart", tuple(Wheel(f"{name}{n}", x, y) for n, (x, y) in enumerate(places)), 0.05, 0.03, 5.0)
    assert (
        robot_file(imported(tmp_path, description(base)))["graphs"]["base"]["use"] == f"graphs/base/{kinematics}.yaml"
    )


def test_parallel_wheels_across_the_x_axis_are_no_omni_base(tmp_path: Path) -> None:
    turned = """<link name="frame"/><joint name="turn" type="fixed">
      <parent link="frame"/><child link="base_link"/><origin rpy="0 0 1.5707963"/></joint>"""
    found = imported(tmp_path, description(SKID, turned))
    assert "base" not in robot_file(found).get("graphs", {})
    assert "lost: wheels that do not roll along the x axis of the root link: no graph drives them; turn the" in remarks(
        found
    )


def test_the_direction_of_friction_gives_the_angle_of_the_rollers(tmp_path: Path) -> None:
    """Those of this base lie the other way round: it goes left when its front left wheel turns forward."""
    tags = [
        f"""<gazebo reference="{wheel}" xmlns:gz="g"><mu1>1</mu1><mu2>0</mu2>
            <fdir1 gz:expressed_in="base_link">1 {side} 0</fdir1></gazebo>"""
        for wheel, side in zip(FOUR, (1, -1, -1, 1), strict=True)
    ]
    base = Base("cart", MECANUM.wheels, 0.05, 0.04, 13.0)
    found = robot_file(imported(tmp_path, description(base, *tags)))
    assert found["graphs"]["base"]["parameters"]["rollers"] == [-45.0, 45.0, 45.0, -45.0]
    grips = {tuple(material["bind"]): material["direction"] for material in found["materials"].values()}
    assert grips == {("front_left", "rear_right"): [1.0, 1.0, 0.0], ("front_right", "rear_left"): [1.0, -1.0, 0.0]}


def test_skid_steered_wheels_slide_sideways_and_their_drives_are_as_stiff_as_the_robot_is_heavy(tmp_path: Path) -> None:
    """55.2 kg by 9.81 m/s2 on four wheels of 0.1651 m are 22.3 N m a wheel, which may cost 0.01 rad/s."""
    found = robot_file(imported(tmp_path, description(SKID)))
    assert found["joints"]["front_left_joint"]["drive"]["damping"] == 2240.0
    assert found["materials"]["wheels"]["across"] == pytest.approx(0.25 * 0.5708 / 0.512, abs=1e-3)
    assert sorted(found["materials"]["wheels"]["bind"]) == sorted(FOUR)


def test_command_interfaces_select_the_drives(tmp_path: Path) -> None:
    arm = "".join(
        f"""<link name="{name}"><inertial><mass value="0.1"/>
          <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="{name}_joint" type="revolute"><parent link="base_link"/><child link="{name}"/><axis xyz="0 0 1"/>
          <limit lower="-2" upper="2" effort="5" velocity="3"/></joint>"""
        for name in ("held", "spun", "pushed", "loose")
    )
    control = """<ros2_control name="arm" type="system">
      <joint name="held_joint"><command_interface name="position"><param name="min">-1</param>
        <param name="max">1.5</param></command_interface>
        <state_interface name="position"><param name="initial_value">0.5</param></state_interface></joint>
      <joint name="spun_joint"><command_interface name="velocity"><param name="max">2</param></command_interface></joint>
      <joint name="pushed_joint"><command_interface name="effort"/></joint>
      <joint name="loose_joint"><state_interface name="position"/></joint></ros2_control>"""
    wheels = interfaces(left_joint="velocity", right_joint="velocity")
    found = imported(tmp_path, description(DIFFERENTIAL, arm, control, wheels))
    joints = robot_file(found)["joints"]
    drive = joints["held_joint"].pop("drive")
    assert joints["held_joint"] == {"start": 0.5, "limits": [-1.0, 1.5]}
    assert (drive["stiffness"], drive["max_velocity"], drive["gravity_compensation"]) == (500.0, 3.0, True)
    assert joints["spun_joint"]["drive"]["max_velocity"] == 2.0
    assert "stiffness" not in joints["spun_joint"]["drive"]
    assert joints["pushed_joint"] == joints["loose_joint"] == {}
    assert "carried: no drive, takes efforts: pushed_joint; effort command of ros2_control" in remarks(found)
    assert "carried: no drive, turns freely: loose_joint; no controller commands them" in remarks(found)


def test_transmissions_select_drives_without_other_interfaces(tmp_path: Path) -> None:
    text = "".join(
        f"""<transmission name="{joint}"><type>transmission_interface/SimpleTransmission</type>
        <joint name="{joint}"><hardwareInterface>hardware_interface/{kind}JointInterface</hardwareInterface></joint>
        </transmission>"""
        for joint, kind in (
            ("rear_left_joint", "Velocity"),
            ("rear_right_joint", "Velocity"),
            ("front_left_steer", "Position"),
        )
    )
    found = imported(tmp_path, description(CAR, text))
    joints = robot_file(found)["joints"]
    assert "drive" not in joints["front_left_joint"]
    assert "carried: velocity drive: rear_left_joint, rear_right_joint" in remarks(found)
    assert "carried: position drive: front_left_steer" in remarks(found)
    assert "guessed: position drive: front_right_steer" in remarks(found)


def test_a_missing_joint_is_reported(tmp_path: Path) -> None:
    found = interfaces(left_joint="velocity", right_jont="velocity", lost="velocity")
    said = remarks(imported(tmp_path, description(DIFFERENTIAL, found))).splitlines()
    assert "lost: ros2_control hardware: the description has no joint 'lost'" in said
    assert "lost: ros2_control hardware: the description has no joint 'right_jont'; did you mean 'right_joint'?" in said


def test_a_caster_swivels_freely(tmp_path: Path) -> None:
    wheel = Base("x", (Wheel("trail", 0.0, 0.0),), 0.05, 0.02, 0.2).urdf()
    inside = wheel.partition("</link>")[2].removesuffix("</robot>").replace('"base_link"', '"fork"')
    inside = inside.replace('xyz="0.0 0.0 0"', 'xyz="-0.06 0 0"')
    fork = """<link name="fork"><inertial><mass value="0.1"/>
      <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="fork_joint" type="continuous"><parent link="base_link"/><child link="fork"/>
      <origin xyz="-0.3 0 0"/><axis xyz="0 0 1"/></joint>"""
    text = DIFFERENTIAL.urdf().replace("</robot>", f"{fork}{inside}</robot>")
    found = imported(tmp_path, text)
    assert robot_file(found)["graphs"]["base"]["use"] == "graphs/base/differential.yaml"
    said = remarks(found)
    assert "guessed: no drive, turns freely: fork_joint; swivels of casters" in said
    assert "guessed: no drive, turns freely: trail_joint; wheels that drive nothing" in said


def test_wheels_that_hold_still_without_a_command_are_reported(tmp_path: Path) -> None:
    """A plugin drives the front wheels; the rear wheels take velocities, too, which no controller sends."""
    front = [wheel.name for wheel in SKID.wheels if wheel.x > 0]
    rear = [wheel.name for wheel in SKID.wheels if wheel.x < 0]
    plugin = PLUGIN
    for side in ("left", "right"):
        (name,) = (name for name in front if side in name)
        plugin = plugin.replace(f">{side}_joint<", f">{name}_joint<")
    commands = interfaces(**{f"{name}_joint": "velocity" for name in (*front, *rear)})
    said = remarks(imported(tmp_path, description(SKID, plugin, commands)))
    names = ", ".join(f"{name}_joint" for name in rear)
    told = "no graph commands these wheels on the floor, whose velocity drives hold them and brake the base"
    assert f"noticed: {names}: {told}" in said
    assert told not in remarks(imported(tmp_path, description(SKID, plugin)))


def control_plugin(file: str) -> str:
    return f"""<gazebo><plugin filename="gz_ros2_control-system" name="gz_ros2_control::GazeboSimROS2ControlPlugin">
      <parameters>{file}</parameters><ros><remapping>~/cmd_vel:=platform/cmd_vel</remapping></ros></plugin></gazebo>"""


def test_repeated_sections_of_a_node_are_merged_and_the_last_value_counts(tmp_path: Path) -> None:
    more = """
/**:
  ros__parameters:
    linear.x.max_velocity: 0.3
    linear.x.max_acceleration: 0.6
/**:
  ros__parameters:
    linear.x.max_velocity: 0.4
"""
    known = parameters(tmp_path, description(DIFFERENTIAL), CONTROLLERS + more)
    assert (known["speed"], known["acceleration"]) == (0.4, 0.6)


@pytest.mark.parametrize("reference", ["config/bot.yaml", "$(find bot_package)/config/bot.yaml"])
def test_the_parameter_file_of_a_control_plugin_is_read_without_an_option(tmp_path: Path, reference: str) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config/bot.yaml").write_text(DOTTED, encoding="utf-8")
    (tmp_path / "package.xml").write_text("<package><name>bot_package</name></package>", encoding="utf-8")
    known = parameters(tmp_path, description(DIFFERENTIAL, control_plugin(reference)))
    assert (known["speed"], known["cmd_vel"]) == (0.7, "platform/cmd_vel")


@pytest.mark.parametrize(
    ("reference", "reason"),
    [
        ("/etc/passwd", "name the file with --controllers FILE"),
        ("../../../../etc/passwd", "name the file with --controllers FILE"),
        ("$(find nowhere)/x.yaml", "no package 'nowhere'"),
        ("absent.yaml", "cannot read"),
        ("broken.yaml", "YAML syntax"),
        (".", "cannot read"),
        ("a" * 5000, "File name too long"),
    ],
)
def test_an_illegal_or_broken_parameter_file_is_reported_and_the_import_continues(
    tmp_path: Path, reference: str, reason: str
) -> None:
    (tmp_path / "broken.yaml").write_text("a: [1, 2", encoding="utf-8")
    said = remarks(imported(tmp_path, description(DIFFERENTIAL, control_plugin(reference))))
    assert "lost: the controllers of " in said
    assert reason in said
    assert "guessed: base: differential" in said


@pytest.mark.parametrize(
    "text",
    [
        "a: !!python/object/apply:os.system [ls]",
        "a: &x [*x]",
        "a: 1\na: 2",
        "- 1",
        "x",
        "a: {<<: {b: 1}}",
        "[" * 100,
        "---\na: 1\n---\nb: 2",
    ],
)
def test_a_file_of_controllers_with_mistakes_is_an_error_with_its_place(tmp_path: Path, text: str) -> None:
    found, findings = attempt(tmp_path, description(DIFFERENTIAL), text)
    assert (found is None) == bool(findings.errors)
    assert all(error.span is not None and error.span.source.path == "controllers.yaml" for error in findings.errors)


@pytest.mark.parametrize(
    "value",
    ["nan", ".nan", ".inf", "-1", "0", "1e300", "[1]", "{a: 1}", "true", "'0.05'", "null", "99999999999999999999999"],
)
@pytest.mark.parametrize("key", ["wheel_radius", "wheel_separation", "left_wheel_names", "cmd_vel_timeout", "type"])
def test_illegal_values_of_a_controller_do_not_reach_the_graph(tmp_path: Path, key: str, value: str) -> None:
    lines = [line for line in CONTROLLERS.splitlines() if f"    {key}:" not in line]
    found = imported(tmp_path, description(DIFFERENTIAL), "\n".join([*lines, f"    {key}: {value}", ""]))
    known = robot_file(found)["graphs"]["base"]["parameters"]
    assert (known["radius"], known["track"]) == (0.05, 0.3)
    assert 0 < known.get("timeout", 0.5) < 1e6


def test_topics_of_a_stranger_are_names_of_topics(tmp_path: Path) -> None:
    for odd in ("a b", "x; rm", "$(robot)", "a//b", "", "x" * 199 + "/y", "9"):
        plugin = PLUGIN.replace("</plugin>", f"<topic>{odd}</topic><odom_topic>{odd}</odom_topic></plugin>")
        found = parameters(tmp_path, description(DIFFERENTIAL, plugin))
        for name in {"cmd_vel", "odom"} & found.keys():
            assert re.fullmatch(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", found[name])


def test_virtual_wheels_of_a_bicycle_stand_for_the_real_ones(tmp_path: Path) -> None:
    virtual = "".join(
        f"""<link name="{name}"><inertial><mass value="0.1"/>
          <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="{name}_joint" type="continuous"><parent link="base_link"/><child link="{name}"/>
          <axis xyz="{axis}"/></joint>"""
        for name, axis in (("virtual_front", "0 0 1"), ("virtual_rear", "0 1 0"))
    )
    control = interfaces(virtual_front_joint="position", virtual_rear_joint="velocity")
    yaml = """bicycle:
  ros__parameters:
    type: bicycle_steering_controller/BicycleSteeringController
    wheelbase: 0.4
    rear_wheels_names: [virtual_rear_joint]
    front_wheels_names: [virtual_front_joint]
"""
    found = imported(tmp_path, description(CAR, virtual, control), yaml)
    known = robot_file(found)["graphs"]["base"]["parameters"]
    assert known["wheels"] == ["rear_left_joint", "rear_right_joint"]
    assert known["steering"] == ["front_left_steer", "front_right_steer"]
    assert known["steering_multiplier"] == -1.0
    assert "commands joints without wheels" in remarks(found)


@pytest.mark.parametrize(
    ("key", "told"),
    [
        ("wheelbase", "the wheelbase is 0.4 m"),
        ("rear_wheel_track", "the track is 0.3 m"),
        ("rear_wheels_radius", "the radius of the wheels is 0.05 m"),
    ],
)
def test_measurements_of_a_car_that_differ_from_the_description_are_reported(
    tmp_path: Path, key: str, told: str
) -> None:
    yaml = f"""car:
  ros__parameters:
    type: ackermann_steering_controller/AckermannSteeringController
    rear_wheels_names: [rear_left_joint, rear_right_joint]
    front_wheels_names: [front_left_steer, front_right_steer]
    {key}: 0.7
"""
    said = remarks(imported(tmp_path, description(CAR), yaml))
    (line,) = (line for line in said.splitlines() if "as in the description" in line)
    assert line.startswith(f"noticed: {told} as in the description; AckermannSteeringController car has 0.7 m")


def test_ranges_of_wheels_are_reported_and_do_not_slow_a_base_down(tmp_path: Path) -> None:
    """Vendors write 1 rad/s for wheels that turn faster, as no controller manager enforces it by default."""
    control = interfaces(left_joint="velocity", right_joint="velocity")
    interface = '<command_interface name="velocity">'
    control = control.replace(f"{interface[:-1]}/>", f'{interface}<param name="max">1</param></command_interface>')
    found = imported(tmp_path, description(DIFFERENTIAL, control))
    assert robot_file(found)["joints"]["left_joint"]["drive"].keys() == {"damping"}
    assert (
        "lost: velocity ranges of left_joint, right_joint: by default, ros2_control does not enforce them"
        in remarks(found)
    )


def test_the_limits_of_a_base_follow_from_the_velocity_limits_of_its_wheels(tmp_path: Path) -> None:
    """Wheels of 0.05 m at 0.15 m from the middle that turn at 3.5 rad/s."""
    found = imported(tmp_path, slow(description(DIFFERENTIAL), 3.5))
    known = robot_file(found)["graphs"]["base"]["parameters"]
    assert (known["wheel_speed"], known["speed"], known["turn"]) == pytest.approx((3.5, 0.175, 0.175 / 0.15))
    assert "carried: wheels that turn at 3.5 rad/s at most: the base drives straight at up to 0.175 m/s" in remarks(
        found
    )
    assert "guessed: limits of the base: acceleration 1 m/s2, turn_acceleration 2 rad/s2" in remarks(found)


def test_fast_wheels_do_not_change_the_limits_of_a_base(tmp_path: Path) -> None:
    known = parameters(tmp_path, slow(description(DIFFERENTIAL), 27.0))  # 1.35 m/s; 1 m/s and 2 rad/s need 1.3
    assert known.keys().isdisjoint({"wheel_speed", "speed", "turn"})


def test_limits_of_a_plugin_stay_and_slower_wheels_bound_the_commands_of_the_graph(tmp_path: Path) -> None:
    plugin = PLUGIN.replace("</plugin>", "<max_linear_velocity>0.8</max_linear_velocity></plugin>")
    known = parameters(tmp_path, slow(description(DIFFERENTIAL, plugin), 8.0))
    assert (known["speed"], known["wheel_speed"], known["turn"]) == pytest.approx((0.8, 8.0, 2.0))


def test_the_turn_rate_of_a_mecanum_base_is_bounded_by_its_track_and_wheelbase(tmp_path: Path) -> None:
    known = parameters(tmp_path, slow(description(MECANUM), 2.0))
    lever = (known["track"] + known["wheelbase"]) / 2
    assert (known["wheel_speed"], known["turn"]) == pytest.approx((2.0, 2.0 * MECANUM.radius / lever), rel=1e-5)


def test_an_effort_limit_below_the_joints_own_friction_is_reported(tmp_path: Path) -> None:
    text = description(DIFFERENTIAL).replace(
        '<axis xyz="0 1 0"/>',
        '<axis xyz="0 1 0"/><limit effort="6" velocity="100"/><dynamics damping="1" friction="2"/>',
    )
    told = remarks(imported(tmp_path, text))
    assert (
        "noticed: wheel joints left_joint, right_joint: the effort limit of 6 N m, less its friction of 2 N m" in told
    )
    assert "and damping of 1 N m s/rad, is enough for at most 0.2 m/s" in told
    assert "effort limit" not in remarks(imported(tmp_path, description(DIFFERENTIAL)))


def test_topics_are_below_the_namespace_of_a_plugin_but_for_absolute_ones(tmp_path: Path) -> None:
    ros = "<ros><namespace>/demo</namespace><remapping>odom:=/odometry</remapping></ros>"
    found = parameters(tmp_path, description(DIFFERENTIAL, PLUGIN.replace("</plugin>", f"{ros}</plugin>")))
    assert (found["cmd_vel"], found["odom"]) == ("demo/cmd_vel", "odometry")


def test_a_wheel_that_is_named_twice_counts_once(tmp_path: Path) -> None:
    twice = PLUGIN.replace("<left_joint>", "<left_joint>left_joint</left_joint><left_joint>")
    assert parameters(tmp_path, description(DIFFERENTIAL, twice)) == parameters(tmp_path, description(DIFFERENTIAL))


def test_left_and_right_are_measured_from_the_middle_of_the_wheels(tmp_path: Path) -> None:
    beside = Base("beside", (Wheel("a", 0.0, 0.5), Wheel("b", 0.0, 0.2)), 0.05, 0.03, 5.0)
    found = parameters(tmp_path, description(beside))
    assert (found["left"], found["right"], found["center"]) == (["a_joint"], ["b_joint"], [0.0, 0.35])


@pytest.mark.parametrize(
    ("middle", "told"), [(False, "whose 4 wheels are all steered"), (True, "of whose 6 wheels 4 are steered")]
)
def test_a_base_with_more_than_two_steered_wheels_is_reported(tmp_path: Path, middle: bool, told: str) -> None:
    wheels = [*(replace(wheel, steering=-1) for wheel in CAR.wheels)]
    if middle:
        wheels += [Wheel("middle_left", 0.0, 0.15), Wheel("middle_right", 0.0, -0.15)]
    rover = replace(CAR, name="rover", wheels=tuple(wheels))
    commands = interfaces(**{f"{wheel.name}_joint": "velocity" for wheel in wheels})
    assert f"a base {told}: no graph drives it" in remarks(imported(tmp_path, description(rover, commands)))


@pytest.mark.parametrize(("kind", "told"), [("fixed", True), ("prismatic", False)])
def test_a_base_fixed_to_the_world_is_reported(tmp_path: Path, kind: str, told: bool) -> None:
    limit = '<limit lower="-5" upper="5" effort="100" velocity="1"/>' if kind == "prismatic" else ""
    weld = f'<joint name="weld" type="{kind}"><parent link="world"/><child link="base_link"/>{limit}</joint>'
    found = imported(tmp_path, description(DIFFERENTIAL, PLUGIN, '<link name="world"/>', weld))
    text = "noticed: joint weld fixes the base to the link 'world', so its wheels do not move it; without this link it is free"
    assert (text in remarks(found)) is told


def test_steering_axes_of_opposite_directions_are_reported(tmp_path: Path) -> None:
    before, name, after = description(CAR).partition('"front_right_steer"')
    found = imported(tmp_path, before + name + after.replace('"0 0 -1"', '"0 0 1"', 1))
    assert "graphs" not in robot_file(found)
    assert "its steering joints turn about opposite axes: no graph drives them" in remarks(found)


def test_a_fixed_joint_drives_no_base(tmp_path: Path) -> None:
    text = description(DIFFERENTIAL, PLUGIN.replace(">left_joint<", ">front_ball_joint<"))
    assert "lost: Gazebo's plugin DiffDrive: joint 'front_ball_joint' is fixed" in remarks(imported(tmp_path, text))


def test_a_transform_that_a_controller_does_not_publish_is_reported(tmp_path: Path) -> None:
    silent = CONTROLLERS + "    enable_odom_tf: false\n"
    assert "enable_odom_tf is false" in remarks(imported(tmp_path, description(DIFFERENTIAL), silent))


def test_a_static_robot_has_no_graph_of_a_base(tmp_path: Path) -> None:
    found = robot_file(imported(tmp_path, description(DIFFERENTIAL, "<gazebo><static>true</static></gazebo>")))
    assert found["fixed_base"] is True
    assert "graphs" not in found


def test_a_start_outside_of_limits_becomes_the_nearest_legal_one(tmp_path: Path) -> None:
    arm = f"""<link name="arm"><inertial><mass value="0.1"/>{INERTIA}</inertial></link>
<joint name="arm_joint" type="revolute">
  <parent link="base_link"/><child link="arm"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
</joint>"""
    start = '<state_interface name="position"><param name="initial_value">5</param></state_interface>'
    hardware = interfaces(arm_joint="position").replace("</joint>", f"{start}</joint>")
    found = imported(tmp_path, description(DIFFERENTIAL, arm, hardware))
    assert robot_file(found)["joints"]["arm_joint"]["start"] == 1.0
    assert "guessed: joint arm_joint starts at 1, the legal position nearest to 5" in remarks(found)


def test_a_long_chain_of_wheels_is_not_tried_on_a_floor(tmp_path: Path) -> None:
    wheels = tuple(Wheel(f"w{number}", 0.3 * number, 0.2) for number in range(MOST_JOINTS + 1))
    found = imported(tmp_path, description(Base("train", wheels, 0.05, 0.03, 5.0)))
    assert f"noticed: with more than {MOST_JOINTS} moving joints the robot is not simulated on a floor" in remarks(
        found
    )


def test_joints_of_a_caster_turn_freely_though_they_have_effort_limits(tmp_path: Path) -> None:
    """A ball on three joints, as some descriptions build a caster; the joints are no arm."""
    limit = '<limit effort="1000" velocity="100"/>'
    ball = '<collision><geometry><sphere radius="0.02"/></geometry></collision>'
    parts, carrier = [], "base_link"
    for name, axis, place in (
        ("roll", "1 0 0", "0.12 0 -0.03"),
        ("pitch", "0 1 0", "0 0 0"),
        ("yaw", "0 0 1", "0 0 0"),
    ):
        inertial = f'<inertial><mass value="0.01"/>{INERTIA}</inertial>'
        parts.append(
            f'<link name="{name}_ball">{inertial}{ball if name == "yaw" else ""}</link><joint name="{name}" type="continuous">'
            f'<parent link="{carrier}"/><child link="{name}_ball"/><origin xyz="{place}"/><axis xyz="{axis}"/>{limit}</joint>'
        )
        carrier = f"{name}_ball"
    found = imported(tmp_path, description(DIFFERENTIAL, PLUGIN, *parts))
    joints = robot_file(found)["joints"]
    assert [name for name, value in joints.items() if value and "drive" in value] == ["left_joint", "right_joint"]
    assert joints["yaw"]["armature"] == pytest.approx(0.005 * found.robot.description.mass * 0.02**2, rel=0.01)
    assert (
        "guessed: no drive, turns freely: roll, pitch, yaw; joints of casters, which carry links on the floor"
        in remarks(found)
    )
