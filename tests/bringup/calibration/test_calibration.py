"""Calibrations of whole robots: test drives in MuJoCo over the robot's own topics."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import pytest

import graphengine as ge
from graphengine import bringup
from graphengine.bringup.calibration.figures import Calibration, Motion, Slope, Stop, Twist
from tests.bringup.calibration import bases
from tests.bringup.robots.imported_bases import imported, scene
from tests.bringup.robots.roller_bases import PLAIN
from tests.other_process import in_another_process


def calibrate(base: bases.Base, **arguments: object) -> Calibration:
    return bringup.calibrate(ge.load(base.write().scene), **arguments)  # type: ignore[arg-type]


ARCS = ["slow_arc_left", "slow_arc_right", "full_arc_left", "full_arc_right"]
AT_LIMITS = [*ARCS, "uphill", "downhill"]


@pytest.fixture(scope="module")
def dingo() -> Calibration:
    return bringup.calibrate(ge.load("dd100_flat"))


def test_the_dingo_moves_as_commanded(dingo: Calibration) -> None:
    assert dingo.moves
    assert dingo.kinematics == "differential"
    assert [motion.name for motion in dingo.motions] == ["forward", "backward", "turn_left", "turn_right", *AT_LIMITS]
    assert dingo.outside(0.02) == ()
    assert dingo.wheel_radius == pytest.approx(0.049, rel=1e-3)  # of the description
    assert dingo.track == pytest.approx(0.4523232, rel=1e-3)
    assert dingo.turning_centre == pytest.approx((0.0989838, 0.0), abs=1e-3)  # of the axle in the description


def test_the_dingo_stops_within_its_limit_and_parks_on_a_slope(dingo: Calibration) -> None:
    """Its controller allows 1.3 m/s and 1 m/s2: v^2 / 2a is 0.845 m."""
    assert dingo.stop is not None
    assert dingo.slope is not None
    assert dingo.stop.speed == pytest.approx(1.3, rel=0.01)
    assert dingo.stop.deceleration == 1.0
    assert 0.84 <= dingo.stop.distance <= 1.2 * 0.845
    assert dingo.stop.is_within()
    assert dingo.slope.is_within()
    assert [one.commanded.x for one in dingo.motions if one.name in ARCS] == pytest.approx([0.39, 0.39, 1.3, 1.3])
    assert all(abs(one.speed_share - 1.0) < 0.01 for one in dingo.motions if one.speed_share is not None)


def test_a_stop_without_a_deceleration_limit_has_no_ratio() -> None:
    result = bringup.calibrate(ge.load("dd100_flat", set={"DiffController.maxDeceleration": 0.0}))
    assert result.stop is not None
    assert (result.stop.deceleration, result.stop.ratio) == (None, None)


def test_the_settle_time_of_a_ramp_follows_from_the_acceleration_limit(dingo: Calibration) -> None:
    """The controller's limit is 1 m/s2: 95 % of 0.3 m/s after 0.285 s; smoothing adds at most 0.1 s."""
    forward = dingo.motions[0]
    assert forward.settle_time is not None
    assert 0.28 <= forward.settle_time <= 0.42


def test_the_true_odometry_has_no_error(dingo: Calibration) -> None:
    (odometry,) = dingo.odometry
    assert odometry.topic == "/dd100_0000/odom"
    figures = (
        odometry.distance_error,
        odometry.turn_error,
        odometry.turn_position_error,
        odometry.square_position_error,
    )
    assert figures == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-6)


def calibrated(scene: str) -> str:
    return json.dumps(bringup.calibrate(ge.load(scene)).to_data())


def test_the_same_files_give_the_same_bytes_in_another_process(dingo: Calibration) -> None:
    assert in_another_process(calibrated, "dd100_flat") == json.dumps(dingo.to_data())


def test_the_data_is_json_without_the_paths(dingo: Calibration) -> None:
    data = json.loads(json.dumps(dingo.to_data(), allow_nan=False))
    assert set(data) == {field.name for field in dataclasses.fields(Calibration)}
    assert set(data["squares"][0]) == {"direction", "side", "position_error", "heading_error"}


def test_a_robot_is_calibrated_alone_and_outside_of_its_hall() -> None:
    result = bringup.calibrate(ge.load("dd100_fleet"))  # racks would be in its way
    assert result.outside(0.02) == ()


def test_a_wrong_wheel_radius_shows_in_the_speed_and_the_right_one_is_measured(tmp_path: Path) -> None:
    base = bases.differential(tmp_path, radius=1.1 * bases.RADIUS)
    base.odometry(1.02)
    result = calibrate(base)
    assert result.motions[0].share == pytest.approx(1.0 / 1.1, rel=0.01)
    assert result.wheel_radius == pytest.approx(bases.RADIUS, rel=0.01)
    assert [wheel.side for wheel in result.wheels] == ["left", "right"]
    assert {motion.name for motion in result.outside(0.02)} == {motion.name for motion in result.motions}
    (odometry,) = result.odometry
    assert odometry.distance_error == pytest.approx(0.02, rel=0.01)
    assert odometry.alphas.alpha3 == pytest.approx(0.0004, rel=0.02)


def test_odometry_at_a_lower_rate_is_compared_with_the_truth_of_its_ticks(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.odometry(1.02)
    path = tmp_path / "odom.yaml"
    text = path.read_text(encoding="utf-8").replace("Tick.tick -> Odometry", "Gate.execOut -> Odometry")
    text = text.replace("nodes:\n", "nodes:\n  Gate: {type: IsaacSimulationGate, inputs: {step: 5}}\n")
    path.write_text(text + "  - Tick.tick -> Gate.execIn\n", encoding="utf-8")
    (odometry,) = calibrate(base).odometry
    assert odometry.distance_error == pytest.approx(0.02, rel=0.01)
    assert odometry.alphas.alpha3 == pytest.approx(0.0004, rel=0.02)


def test_a_wrong_track_shows_in_turns_only(tmp_path: Path) -> None:
    result = calibrate(bases.differential(tmp_path, track=0.9 * bases.TRACK))
    assert {motion.name for motion in result.outside(0.02)} == {"turn_left", "turn_right", *ARCS}
    assert result.track == pytest.approx(bases.TRACK, rel=0.01)


def test_a_skid_steered_base_turns_by_its_effective_track(tmp_path: Path) -> None:
    """T (1 + (B/T)^2) for a track T and a wheel base B, here of 0.3 m both."""
    result = calibrate(bases.skid_steered(tmp_path))
    assert result.track == pytest.approx(0.6, rel=0.02)
    turn = result.motions[2]
    assert turn.share == pytest.approx(0.5, rel=0.02)
    assert turn.slip == pytest.approx(0.5, rel=0.02)


def test_steered_wheels_turn_in_arcs_by_a_steering_angle(tmp_path: Path) -> None:
    result = calibrate(bases.ackermann(tmp_path))
    assert result.kinematics == "ackermann"
    assert [motion.name for motion in result.motions[2:4]] == ["arc_left", "arc_right"]
    assert result.outside(0.02) == ()
    assert result.wheel_base == pytest.approx(0.3, rel=0.01)
    assert result.track == pytest.approx(0.3, rel=0.01)


def test_a_mecanum_base_drives_sideways_in_the_calibration(tmp_path: Path) -> None:
    result = calibrate(bases.mecanum(tmp_path))
    assert result.kinematics == "mecanum"
    assert [motion.name for motion in result.motions[4:]] == ["sideways_left", "sideways_right", *AT_LIMITS]
    assert result.outside(0.02) == ()
    assert result.track == pytest.approx(0.6, rel=0.03)  # track and wheel base together
    assert all(one.sideways_error == pytest.approx(0.0, abs=1e-3) for one in result.odometry)


def test_an_imu_has_the_noise_of_its_profile_and_rests_on_gravity(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    profile = "sensor: noisy\nimu: {rate: 100, acceleration_noise: 0.02, angular_velocity_noise: 0.003}\n"
    (tmp_path / "sensors").mkdir()
    (tmp_path / "sensors" / "noisy.yaml").write_text(profile, encoding="utf-8")
    base.keys += "sensors: {imu: {type: imu, profile: noisy, parent: base_link}}\n"
    base.graphs["imu"] = "{use: graphs/imu.yaml, parameters: {imu: base_link/imu, parent: base_link}}"
    (imu,) = calibrate(base).imus
    assert imu.rate == pytest.approx(100.0, rel=0.005)
    assert imu.gyro_noise == pytest.approx(0.003, rel=0.2)
    assert imu.accelerometer_noise == pytest.approx(0.02, rel=0.2)
    assert imu.gravity == pytest.approx(9.81, rel=0.01)


def test_the_speed_is_at_most_that_of_the_controller() -> None:
    scene = ge.load("dd100_flat", set={"DiffController.maxLinearSpeed": 0.2, "DiffController.maxAngularSpeed": 0.4})
    result = bringup.calibrate(scene, speed=0.5)
    assert (result.speed, result.turn_speed) == (0.2, 0.4)
    assert result.outside(0.02) == ()


def test_the_speed_is_at_most_that_of_the_wheels() -> None:
    scene = ge.load("dd100_flat", set={"DiffController.maxWheelSpeed": 4.0})
    result = bringup.calibrate(scene)
    assert result.speed == pytest.approx(4.0 * 0.049)  # at the rim
    assert result.motions[0].share == pytest.approx(1.0, abs=0.001)


@pytest.mark.parametrize(
    "arguments", [{"speed": 0.0}, {"turn_speed": float("nan")}, {"robot": "dd10"}, {"command_topic": "odom"}]
)
def test_an_illegal_argument_is_a_usage_error(arguments: dict[str, float | str]) -> None:
    with pytest.raises(ge.UsageError):
        bringup.calibrate(ge.load("dd100_flat"), **arguments)  # type: ignore[arg-type]


def test_calibration_chooses_one_of_two_command_topics(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.graphs["second"] = "{use: drive.yaml, parameters: {wheels: [left_joint, right_joint], topic: other/cmd_vel}}"
    with pytest.raises(ge.UsageError, match="--command-topic\n  command topics: /cmd_vel, /other/cmd_vel"):
        calibrate(base)
    assert bringup.calibrate(ge.load(base.scene), command_topic="other/cmd_vel").command_topic == "/other/cmd_vel"


def test_bounds_of_turns_and_sideways_are_wider() -> None:
    def off(kind: str, share: float) -> bool:
        return not Motion("", kind, Twist(), Twist(), share).is_within(0.02)  # type: ignore[arg-type]

    assert [off("straight", 0.975), off("turn", 0.975), off("sideways", 1.025)] == [True, False, False]
    assert [off("straight", 1.015), off("turn", 0.965), off("sideways", 1.035)] == [False, True, True]
    arc = Motion("", "turn", Twist(1.0), Twist(), 1.06, speed_share=0.97)
    assert [arc.is_within(0.02), dataclasses.replace(arc, skids=True).is_within(0.02)] == [False, True]
    assert not dataclasses.replace(arc, share=1.0, speed_share=0.96).is_within(0.02)
    assert [Stop(1.0, distance, 1.0).is_within() for distance in (0.59, 0.61)] == [True, False]
    assert [Slope(0.0, creep).is_within() for creep in (0.9e-3, 1.1e-3)] == [True, False]


# Robots that do not move


def reason(base: bases.Base) -> str:
    result = calibrate(base)
    assert not result.moves
    return result.notes[0]


def test_a_robot_without_graphs_has_no_command_topic(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.graphs.clear()
    assert reason(base).startswith("no command topic")
    assert reason(base).endswith("the robot file has no graphs")


def test_a_robot_driven_by_a_graph_of_the_scene_is_refused_with_a_remedy(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    use = base.graphs.pop("drive").replace("{wheels", "{robot: /bot, wheels")
    base.write()
    base.scene.write_text(base.scene.read_text(encoding="utf-8") + f"graphs:\n  drive: {use}\n", encoding="utf-8")
    result = bringup.calibrate(ge.load(base.scene))
    assert result.notes[0].endswith("list the graph below `graphs:` of the robot file")


def test_wheels_in_the_air_turn_and_the_load_is_on_the_chassis(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.urdf = base.urdf.replace('size="0.2 0.2 0.06"', 'size="0.2 0.2 0.16"')
    text = reason(base)
    assert text.startswith("the wheels turn, but the robot does not move: left_joint (6.00 rad/s)")
    assert "the floor carries" in text
    assert "N: base_link" in text


def only_listening(folder: Path) -> bases.Base:
    """A base whose graph subscribes to the command topic and commands no joint."""
    base = bases.differential(folder)
    base.graphs.clear()
    nodes = "  Tick: OnPlaybackTick\n  Command: {type: ROS2SubscribeTwist, inputs: {topicName: cmd_vel}}\n"
    base.graph("drive", nodes, "  - Tick.tick -> Command.execIn\n")
    return base


def test_a_robot_without_drives_is_reported(tmp_path: Path) -> None:
    base = only_listening(tmp_path)
    base.drives.clear()
    assert reason(base).startswith("no joint of the robot has a drive")


def test_joints_without_commands_are_reported_with_a_hint_on_wires(tmp_path: Path) -> None:
    assert reason(only_listening(tmp_path)).startswith("no joint gets a velocity command")


def test_drives_that_are_too_weak_are_reported(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.drives = dict.fromkeys(base.drives, "{drive: {damping: 50.0, max_force: 0.0001}, armature: 5.0}")
    assert "do not turn" in reason(base)


@pytest.mark.parametrize(("stiffness", "moves"), [(1000.0, False), (50.0, False), (1.0, True)])
def test_wheels_held_still_by_stiffness_are_reported(tmp_path: Path, stiffness: float, moves: bool) -> None:
    base = bases.differential(tmp_path)
    base.drives = dict.fromkeys(base.drives, f"{{drive: {{damping: 50.0, stiffness: {stiffness}}}}}")
    base.odometry()
    result = calibrate(base)
    assert result.moves is moves
    held = "stiffness pulls joints with velocity commands back to their positions (joints: left_joint, right_joint)"
    assert sum(note.startswith(held) for note in result.notes) == 1
    assert result.notes[0].startswith(held) or moves
    assert not moves or all(
        motion in result.outside(0.02) for motion in result.motions[:4]
    )  # straight, and on the spot


def test_a_robot_that_falls_over_has_no_figures_to_write(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.urdf = base.urdf.replace(
        '<inertial><mass value="5.0"/>', '<inertial><origin xyz="0.2 0 0.5"/><mass value="5.0"/>'
    )
    assert reason(base).startswith("the robot falls over: its base link tilts by more than 45 deg")


def test_a_robot_without_colliders_falls_through_the_floor(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.urdf = re.sub("<collision>.*?</collision>", "", base.urdf)
    base.wheels, base.keys = [], ""
    assert reason(base).startswith("the robot falls through the floor")


def test_wheels_on_springs_are_not_taken_for_steered_ones(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    drop = '<joint name="drop" type="prismatic"><limit lower="-0.001" upper="0.001" effort="1" velocity="1"/>'
    ends = '<parent link="base_link"/><child link="axle"/><axis xyz="0 0 1"/></joint>'
    base.urdf = base.urdf.replace(
        '<parent link="base_link"/><child link="left"/>', '<parent link="axle"/><child link="left"/>'
    )
    base.urdf += bases.link("axle", 0.1) + drop + ends
    base.drives["drop"] = "{spring: {stiffness: 20000.0}}"
    assert calibrate(base).track == pytest.approx(bases.TRACK, rel=0.01)


def test_three_omni_wheels_have_the_radius_that_rolls_and_no_slip(tmp_path: Path) -> None:
    """Not 2 / sqrt(3) times the radius, as two of the wheels turn that much slower in a straight drive."""
    result = bringup.calibrate(ge.load(scene(tmp_path, imported(tmp_path, PLAIN.urdf()))), speed=0.3, turn_speed=0.6)
    assert result.kinematics == "omni"
    assert [wheel.radius for wheel in result.wheels] == pytest.approx([0.05] * 3, rel=1e-3)
    assert [motion.slip for motion in result.motions[:4]] == pytest.approx([0.0] * 4, abs=1e-3)
    assert result.track is None
    assert not [note for note in result.notes if "track" in note or "radius" in note]
