"""What Isaac Sim's own tests assert about these nodes, and what follows from its formulae: case by case, from cases.json.

A case either runs, in a function below `@runs`, or differs, in a function below `@differs` that gives our value; the values, and
why they differ, are in isaac_differs.yaml. Where a case drives physics, it runs in MuJoCo.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest
import yaml

from graphengine.diagnostics import TopicError
from graphengine.ros import messages, names
from graphengine.ros.qos import PRESETS, parse_qos
from graphengine.testing import RecordingContext, RecordingWorld
from nodes.core import (
    IsaacArticulationController,
    IsaacComputeOdometry,
    IsaacComputeTransformTree,
    IsaacReadSimulationTime,
)
from nodes.ros2.lidar import ROS2RtxLidarHelper
from nodes.ros2.state import ROS2PublishClock, ROS2PublishJointState, ROS2PublishOdometry
from nodes.ros2.subscribers import ROS2SubscribeTwist
from nodes.ros2.transforms import ROS2PublishRawTransformTree, ROS2PublishTransformTree
from nodes.wheeled_robots import DifferentialController
from tests.nodes import scenes
from tests.nodes.harness import HERE, Player, facts, quaternion, ready, twist, vector, yaw

Case = dict[str, Any]
CASES: dict[str, Case] = {f"{case['node']}: {case['case']}": case for case in facts("cases.json")["cases"]}
DIFFERS: dict[str, Case] = {
    f"{entry['node']}: {entry['case']}": entry
    for entry in yaml.safe_load((HERE.parent / "isaac_differs.yaml").read_text("utf-8"))
}
RUN: dict[str, Callable[[Case, Player], None]] = {}
OURS: dict[str, Callable[[Case, Player], Any]] = {}

WHEELS = "isaacsim.robot.wheeled_robots.DifferentialController"
CLASS = "DifferentialController (python class)"
ODOMETRY = "isaacsim.core.nodes.IsaacComputeOdometry"
PUBLISH_ODOMETRY = "isaacsim.ros2.bridge.ROS2PublishOdometry"
TREE = "isaacsim.core.nodes.IsaacComputeTransformTree"
PUBLISH_TREE = "isaacsim.ros2.bridge.ROS2PublishTransformTree"
JOINT_STATE = "isaacsim.ros2.bridge.ROS2PublishJointState"
CONTROLLER = "isaacsim.core.nodes.IsaacArticulationController"
PROFILE = "isaacsim.ros2.bridge.ROS2QoSProfile"
NAMESPACE = "namespace collection"
CLOCK = "isaacsim.ros2.bridge.ROS2PublishClock"
SCAN = "isaacsim.ros2.bridge.ROS2PublishLaserScan"


def runs(node: str, *cases: str) -> Callable[[Callable[[Case, Player], None]], Callable[[Case, Player], None]]:
    """The function asserts what these cases expect."""

    def register(function: Callable[[Case, Player], None]) -> Callable[[Case, Player], None]:
        RUN.update(dict.fromkeys((f"{node}: {case}" for case in cases), function))
        return function

    return register


def differs(node: str, case: str) -> Callable[[Callable[[Case, Player], Any]], Callable[[Case, Player], Any]]:
    """The function gives our value of a case that differs on purpose."""

    def register(function: Callable[[Case, Player], Any]) -> Callable[[Case, Player], Any]:
        OURS[f"{node}: {case}"] = function
        return function

    return register


def test_every_case_either_runs_or_differs() -> None:
    assert set(RUN) | set(OURS) == set(CASES)
    assert set(RUN) & set(OURS) == set()


def test_every_case_that_differs_has_a_value_and_a_reason() -> None:
    assert set(DIFFERS) == set(OURS)
    assert all(set(entry) == {"node", "case", "our_value", "reason"} for entry in DIFFERS.values())


# DifferentialController


def controller(case: Case) -> DifferentialController:
    given = case["inputs"]
    ports = {port.name: port.field for port in DifferentialController.fields.values()}
    return DifferentialController(**{ports[name]: value for name, value in given.items() if name in ports})


@runs(
    WHEELS,
    "basic",
    "only maxAcceleration set (no maxDeceleration): linear NOT limited, dt still required",
    "clamping (dd100 tutorial params)",
    "tutorial cmd_vel 1.0/1.0",
)
def wheel_speeds_are_those_of_the_case(case: Case, play: Player) -> None:
    node = controller(case)
    node.compute()
    expected = case["expect"]["outputs:velocityCommand"]
    assert node.velocity_command.tolist() == pytest.approx(expected, abs=case["tolerance"], rel=0.0)


@runs(WHEELS, "accel limits ramp")
def after_four_updates_the_ramp_is_not_through(case: Case, play: Player) -> None:
    node = controller(case)
    for _ in range(4):
        node.compute()
    left, right = node.velocity_command.tolist()
    assert 0.0 < left < case["expect"]["outputs:velocityCommand[0]"]["lt"]
    assert 0.0 < right < case["expect"]["outputs:velocityCommand[1]"]["lt"]


@runs(CLASS, "class basic", "class max wheel speed")
def the_nodes_wheel_speeds_are_those_of_the_class(case: Case, play: Player) -> None:
    given = case["inputs"]
    node = DifferentialController(
        wheel_radius=given["wheel_radius"],
        wheel_distance=given["wheel_base"],
        max_wheel_speed=float(given.get("max_wheel_speed", 0.0)),
        linear_velocity=given["command"][0],
        angular_velocity=given["command"][1],
    )
    node.compute()
    assert node.velocity_command.tolist() == case["expect"]["result"]


@differs(WHEELS, "dt<=0 with any accel limit -> compute fails")
def a_ramp_without_dt(case: Case, play: Player) -> Any:
    node = controller(case)
    before = node.velocity_command
    with pytest.raises(ValueError, match="dt > 0") as caught:
        node.compute()
    return {
        "compute": caught.type.__name__,
        "velocityCommand": "unchanged" if node.velocity_command is before else "changed",
    }


@differs(WHEELS, "play-stop-play with jetbot: wheels at rest afterwards")
def wheel_targets_of_the_second_play(case: Case, play: Player) -> Any:
    world = RecordingWorld()
    robot = world.add_robot("/jetbot", ["left", "right"])
    inputs = {
        name: case["inputs"][name] for name in ("wheelRadius", "wheelDistance", "linearVelocity", "angularVelocity")
    }
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Diff: {{type: DifferentialController, inputs: {json.dumps(inputs)}}}
          Art: {{type: ArticulationController, inputs: {{targetPrim: /jetbot}}}}
        connections:
          - Tick.tick -> Diff.execIn
          - Tick.tick -> Art.execIn
          - Diff.velocityCommand -> Art.velocityCommand
        """,
        world,
    )
    playing.tick(10)
    playing.session.stop()
    playing.tick(120)
    return robot.targets["velocity"]


# IsaacComputeOdometry


def moved(position: Any = (0.0, 0.0, 0.0), orientation: Any = (0.0, 0.0, 0.0, 1.0)) -> Any:
    """A context, a body there, and a node that has seen it there."""
    context = RecordingContext()
    body = context.world.add_body("/cube", tuple(position), tuple(orientation))
    node = ready(IsaacComputeOdometry, context, chassis_prim="/cube")
    return context, body, node


def seen(context: RecordingContext, node: IsaacComputeOdometry) -> None:
    context.tick()
    node.compute()


@runs(ODOMETRY, "defaults before play")
def before_play_odometry_is_at_rest(case: Case, play: Player) -> None:
    _, _, node = moved()
    for port in IsaacComputeOdometry.fields.values():
        if port.side == "outputs" and not port.is_exec:
            kind = "orientation" if port.field == "orientation" else "vectors"
            assert list(getattr(node, port.field)) == case["expect"][kind]


@runs(ODOMETRY, "cube at rest 180 frames")
def a_cube_at_rest_has_neither_velocity_nor_acceleration(case: Case, play: Player) -> None:
    playing = play.scene(scenes.cube_on_the_floor(height=0.25))
    playing.tick(180)
    node, tolerance = playing.node("Compute"), case["tolerance"]
    for port in IsaacComputeOdometry.fields.values():
        if port.side == "outputs" and str(port.type) == "vectord[3]":
            assert np.allclose(getattr(node, port.field), 0.0, atol=tolerance), port.name


@runs(ODOMETRY, "position relative to start")
def the_first_position_is_the_origin(case: Case, play: Player) -> None:
    context, _, node = moved(map(float, case["inputs"]["start"]))
    for _ in range(case["inputs"]["frames"]):
        seen(context, node)
    assert node.position == pytest.approx(case["expect"]["position"], abs=case["tolerance"])


@runs(ODOMETRY, "body moves down 1.5 m/s for 30 frames")
def a_fall_is_a_way_down_from_the_start(case: Case, play: Player) -> None:
    x, y, z = map(float, case["inputs"]["start"])
    context, body, node = moved((x, y, z))
    for frame in range(30):
        body.position = (x, y, z - 1.5 * frame / 60)
        seen(context, node)
    assert node.position[2] < case["expect"]["position.z"]["lt"]
    assert node.position[:2] == pytest.approx((case["expect"]["position.x"], case["expect"]["position.y"]))


@runs(ODOMETRY, "body yawed +90deg moving world +x: local = (0,-1,0)")
def velocity_in_the_bodys_frame(case: Case, play: Player) -> None:
    context, body, node = moved()
    w, x, y, z = case["inputs"]["orientation_wxyz"]
    body.orientation = (x, y, z, w)
    body.linear = tuple(map(float, case["inputs"]["linear_velocity_world"]))
    body.angular = tuple(case["inputs"]["angular_velocity_world"])
    seen(context, node)
    found = {
        "linearVelocity": node.linear_velocity,
        "globalLinearVelocity": node.global_linear_velocity,
        "angularVelocity": node.angular_velocity,
    }
    for name, expected in case["expect"].items():
        assert found[name] == pytest.approx(expected, abs=case["tolerance"])


@runs(ODOMETRY, "pose in start frame: start yaw 90, world displacement +y 2 -> position (2,0,0)")
def pose_in_the_start_frame(case: Case, play: Player) -> None:
    start, now = case["inputs"]["start_pose"], case["inputs"]["current_pose"]
    context, body, node = moved(*start)
    seen(context, node)
    body.position, body.orientation = tuple(map(float, now[0])), tuple(map(float, now[1]))
    seen(context, node)
    assert node.position == pytest.approx(case["expect"]["position"], abs=case["tolerance"])
    assert node.orientation == pytest.approx(case["expect"]["orientation(xyzw)"], abs=case["tolerance"])


# IsaacComputeTransformTree


def tree_of(context: RecordingContext, *targets: str, parent: str = "") -> IsaacComputeTransformTree:
    node = ready(IsaacComputeTransformTree, context, target_prims=targets, parent_prim=parent)
    node.compute()
    return node


def at(numbers: Any) -> Any:
    """A position of a case, as floats."""
    x, y, z = map(float, numbers)
    return x, y, z


def translation(node: IsaacComputeTransformTree) -> Any:
    """Of the last child."""
    return node.translations[-1].tolist()


@runs(TREE, "single rigid prim")
def a_single_body(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body(case["inputs"]["prim"], at(case["inputs"]["pos"]))
    node, expected = tree_of(context, case["inputs"]["prim"]), case["expect"]
    assert list(node.parent_frames) == expected["parentFrames"]
    assert list(node.child_frames) == expected["childFrames"]
    assert node.translations.tolist() == expected["translations"]
    assert node.orientations.tolist() == expected["orientations"]


@runs(TREE, "relative to parentPrim")
def a_body_relative_to_another(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body("/Parent", at(case["inputs"]["parent"]))
    context.world.add_body("/Child", at(case["inputs"]["child"]))
    assert tree_of(context, "/Child", parent="/Parent").translations.tolist() == case["expect"]["translations"]


def carried(body: Any, sensor: Any, kind: Any = "frame", turn: Any = (0.0, 0.0, 0.0, 1.0)) -> RecordingContext:
    """A body, and a prim on it that physics does not know."""
    context = RecordingContext()
    context.world.add_body("/Body", at(body), turn)
    context.world.stage.add("/Body/Sensor", kind, position=at(sensor))
    return context


@runs(TREE, "rigid body + Xform sensor child, both vs world")
def a_body_and_its_sensor_below_the_world(case: Case, play: Player) -> None:
    context = carried(case["inputs"]["body"], case["inputs"]["sensor_local"])
    assert translation(tree_of(context, "/Body", "/Body/Sensor")) == case["expect"]["sensor translation"]


@runs(TREE, "non-physics parentPrim")
def a_body_below_a_prim_that_physics_does_not_know(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.stage.add("/Parent", "frame", position=at(case["inputs"]["parent"]))
    context.world.add_body("/Body", at(case["inputs"]["body_world"]))
    assert tree_of(context, "/Body", parent="/Parent").translations.tolist() == case["expect"]["translations"]


@runs(TREE, "camera gets 180deg about x")
def a_camera_looks_along_z(case: Case, play: Player) -> None:
    x, _, _, w = tree_of(carried((0, 0, 0), (0, 0, 0), "camera"), "/Body/Sensor").orientations[0]
    assert (abs(x), w) == (case["expect"]["orientation xyzw"]["|x|"], case["expect"]["orientation xyzw"]["w"])


@runs(TREE, "OmniLidar prim: no 180deg rotation")
def a_lidar_does_not_turn(case: Case, play: Player) -> None:
    node = tree_of(carried((0, 0, 0), case["inputs"]["local"], "lidar"), "/Body/Sensor")
    assert node.orientations[0].tolist() == case["expect"]["orientation"]
    assert translation(node)[2] == case["expect"]["z"]


@runs(TREE, "sensor relative to physics parent")
def a_sensor_relative_to_its_body(case: Case, play: Player) -> None:
    context = carried(case["inputs"]["body"], case["inputs"]["sensor_local"])
    assert tree_of(context, "/Body/Sensor", parent="/Body").translations.tolist() == case["expect"]["translations"]


@runs(TREE, "undiscovered physics ancestor")
def a_sensor_whose_body_is_no_target(case: Case, play: Player) -> None:
    context = carried(case["inputs"]["body"], case["inputs"]["sensor_local"])
    assert translation(tree_of(context, "/Body/Sensor")) == case["expect"]["translation"]


@runs(TREE, "isaac:nameOverride honoured for parent and child")
def overrides_name_both_ends(case: Case, play: Player) -> None:
    context = carried((0, 0, 0), (0, 0, 0))
    context.world.stage.find("/Body").name_override = case["inputs"]["parent_override"]
    context.world.stage.find("/Body/Sensor").name_override = case["inputs"]["child_override"]
    node = tree_of(context, "/Body/Sensor", parent="/Body")
    assert list(node.parent_frames) == case["expect"]["parentFrames"]
    assert list(node.child_frames) == case["expect"]["childFrames"]


@runs(TREE, "rotated ancestor")
def a_turned_body_turns_its_sensor(case: Case, play: Player) -> None:
    context = carried((0, 0, 0), case["inputs"]["sensor_local"], turn=yaw(math.radians(case["inputs"]["yaw_deg"])))
    assert translation(tree_of(context, "/Body/Sensor")) == pytest.approx(case["expect"]["translation"], abs=1e-9)


@runs(TREE, "parent rotated 90deg")
def a_turned_parent_turns_what_is_below_it(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body("/Parent", orientation=yaw(math.radians(case["inputs"]["parent_yaw_deg"])))
    context.world.add_body("/Child", at(case["inputs"]["child_world"]))
    assert translation(tree_of(context, "/Child", parent="/Parent")) == pytest.approx(
        case["expect"]["translation"], abs=1e-9
    )


@runs(TREE, "duplicate nameOverride: deepest wins")
def of_two_that_share_a_name_the_deepest_has_it(case: Case, play: Player) -> None:
    context, paths = RecordingContext(), case["inputs"]["paths"]
    for path in paths:
        context.world.stage.add(path, "frame", name_override=case["inputs"]["override"])
    children = tree_of(context, *paths).child_frames
    assert children.count(case["inputs"]["override"]) == case["expect"]["childFrames count of shared_frame"]
    assert children[-1] == case["inputs"]["override"]


@runs(TREE, "parentPrim reauthored at run time")
def a_parent_that_is_moved_or_replaced_during_play(case: Case, play: Player) -> None:
    given, expect = case["inputs"], case["expect"]
    world = RecordingWorld()
    world.add_body("/Body", at(given["body"]))
    parent = world.add_body("/Parent", at(given["parent_from"]))
    world.add_body("/Other", at(given["parent_to"]))
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Tree: {type: ComputeTransformTree, inputs: {targetPrims: /Body, parentPrim: /Parent}}
        connections: [Tick.tick -> Tree.execIn]
        """,
        world,
    )
    playing.tick()
    assert translation(playing.node("Tree"))[0] == expect["x before"]
    playing.set("Tree", "parent_prim", ("/Other",))
    playing.tick()
    assert translation(playing.node("Tree"))[0] == expect["x after"]
    playing.set("Tree", "parent_prim", ("/Parent",))
    parent.position = at(given["parent_to"])
    playing.tick()
    assert translation(playing.node("Tree"))[0] == expect["x after"]


@differs(TREE, "scaled ancestor scales offset")
def a_sensor_below_a_prim_that_would_be_scaled(case: Case, play: Player) -> Any:
    return translation(tree_of(carried((0, 0, 0), case["inputs"]["sensor_local"]), "/Body/Sensor"))


@differs(TREE, "resetXformStack on middle")
def a_sensor_below_a_prim_that_would_not_move_with_its_parent(case: Case, play: Player) -> Any:
    context = RecordingContext()
    for path, part in (("/outer", "outer"), ("/outer/mid", "mid"), ("/outer/mid/sensor", "sensor")):
        context.world.stage.add(path, "frame", position=at(case["inputs"][part]))
    return translation(tree_of(context, "/outer/mid/sensor"))


@differs(TREE, "camera under 2x scaled mount")
def a_camera_below_a_mount_that_would_be_scaled(case: Case, play: Player) -> Any:
    node = tree_of(carried((0, 0, 0), case["inputs"]["local"], "camera"), "/Body/Sensor")
    return {"z": translation(node)[2], "orientation": node.orientations[0].tolist()}


PANDA = [*(f"panda_link{i}" for i in range(8)), "panda_hand", "panda_leftfinger", "panda_rightfinger"]


def add_panda(world: RecordingWorld, path: str) -> None:
    """Franka's arm: a chain of links, the hand on the last, two fingers on the hand."""
    base = f"{path}/Geometry/{PANDA[0]}"
    world.stage.add(path, "robot", body=base, facts={"base_link": base})
    above = f"{path}/Geometry"
    for link in PANDA:
        made = world.stage.add(f"{above}/{link}", "link", body=f"{above}/{link}")
        above = above if link.endswith("finger") else made.path


@runs(f"{TREE} + ROS2PublishTransformTree", "franka articulation")
def a_robot_gives_all_of_its_links(case: Case, play: Player) -> None:
    world = RecordingWorld()
    add_panda(world, "/panda")
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Tree: {{type: ComputeTransformTree, inputs: {{targetPrims: {json.dumps(case["inputs"]["targetPrims"])}}}}}
          Publish: PublishTransformTree
        connections:
          - Tick.tick -> Tree.execIn
          - Tree.execOut -> Publish.execIn
          - Tree.parentFrames -> Publish.parentFrames
          - Tree.childFrames -> Publish.childFrames
          - Tree.translations -> Publish.translations
          - Tree.orientations -> Publish.orientations
        """,
        world,
    )
    playing.tick()
    (message,) = playing.published("/tf")
    assert len(message.transforms) == case["expect"]["number of transforms"]
    assert case["expect"]["some frame_id"] in [t.header.frame_id for t in message.transforms]


@runs(TREE, "IsaacRobotAPI expansion: joint topology parents")
def a_robots_links_hang_on_the_links_that_carry_them(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_robot("/robot")
    for wheel in ("wheel_left", "wheel_right"):
        context.world.stage.add(f"/robot/Geometry/base_link/{wheel}", "link")
    node = tree_of(context, "/robot", parent=f"/robot/{case['inputs']['parentPrim']}")
    assert [list(pair) for pair in zip(node.parent_frames, node.child_frames, strict=True)] == case["expect"]["pairs"]


# ROS2PublishTransformTree


def legacy(context: RecordingContext, **inputs: Any) -> Any:
    """Transforms of a node that expands its targets itself."""
    return ready(ROS2PublishTransformTree, context, **inputs).message().transforms


@runs(PUBLISH_TREE, "legacy: parentPrim panda_link0")
def the_first_transform_is_below_the_parent(case: Case, play: Player) -> None:
    context = RecordingContext()
    add_panda(context.world, "/panda")
    first = legacy(context, target_prims="/panda", parent_prim=case["inputs"]["parentPrim"])[0]
    assert first.header.frame_id == case["expect"]["transforms[0].frame_id"]
    assert first.child_frame_id == case["expect"]["transforms[0].child"]


@differs(PUBLISH_TREE, "legacy targetPrims path: franka+cube+Xform child")
def a_target_that_was_already_expanded(case: Case, play: Player) -> Any:
    context = RecordingContext()
    add_panda(context.world, "/panda")
    context.world.add_body("/cube")
    hand = next(prim for prim in context.world.stage.prims("link") if prim.name == "panda_hand")
    context.world.stage.add(f"{hand.path}/geometry", "frame")
    paths = {path: path.replace("/panda/panda_hand", hand.path) for path in case["inputs"]["targetPrims"]}
    transforms = legacy(context, target_prims=list(paths.values()))
    assert len({t.child_frame_id for t in transforms}) == len(transforms)
    return {"transforms": len(transforms), "transforms[12].header.frame_id": transforms[12].header.frame_id}


@differs(PUBLISH_TREE, "legacy: two identical robots")
def frames_of_the_second_robot(case: Case, play: Player) -> Any:
    context = RecordingContext()
    for path in case["inputs"]["targets"]:
        add_panda(context.world, path)
    frames = [t.child_frame_id for t in legacy(context, target_prims=case["inputs"]["targets"])]
    assert frames[:11] == PANDA
    (prefix,) = {frame.removesuffix(link) for frame, link in zip(frames[11:], PANDA, strict=True)}
    return f"{prefix}<link>"


# Joints


@runs(JOINT_STATE, "positions rad/m")
def positions_are_published_in_rad_and_m(case: Case, play: Player) -> None:
    given = case["inputs"]
    playing = play.scene(scenes.arm(given["joints"], stiffness=2000.0, damping=200.0, positionCommand=given["target"]))
    playing.tick(120)
    newest = playing.published("/joint_states")[-1]
    assert newest.name == given["joints"]
    assert newest.position.tolist() == pytest.approx(case["expect"]["position"], abs=case["tolerance"])


@runs(JOINT_STATE, "velocities rad/s, m/s")
def velocities_are_published_in_rad_s_and_m_s(case: Case, play: Player) -> None:
    given, joints = case["inputs"], CASES[f"{JOINT_STATE}: positions rad/m"]["inputs"]["joints"]
    playing = play.scene(scenes.arm(joints, given["stiffness"], given["damping"], velocityCommand=given["target"]))
    playing.tick(60)
    newest = playing.published("/joint_states")[-1]
    assert newest.velocity.tolist() == pytest.approx(case["expect"]["velocity"], abs=case["tolerance"])


@runs(JOINT_STATE, "unit scaling prismatic/effort")
def a_sliding_joint_is_scaled(case: Case, play: Player) -> None:
    given = case["inputs"]
    message = ready(
        ROS2PublishJointState,
        RecordingContext(),
        joint_names=["slider"],
        joint_positions=given["jointPositions"],
        joint_velocities=[0.0],
        joint_efforts=given["jointEfforts"],
        joint_dof_types=given["jointDofTypes"],
        stage_meters_per_unit=given["stageMetersPerUnit"],
    ).message()
    assert message.position.tolist() == pytest.approx(case["expect"]["position"], abs=case["tolerance"])
    assert message.effort.tolist() == pytest.approx(case["expect"]["effort"], abs=case["tolerance"])


@runs(CONTROLLER, "by name", "by index")
def the_selected_joints_go_where_they_are_told(case: Case, play: Player) -> None:
    joints = [f"panda_joint{number}" for number in range(1, 5)]
    playing = play.scene(scenes.arm(joints, stiffness=2000.0, damping=200.0, **case["inputs"]))
    playing.tick(120)
    position = playing.published("/joint_states")[-1].position
    tolerance = case["tolerance"] if isinstance(case["tolerance"], float) else min(case["tolerance"].values())
    assert position[1] == pytest.approx(case["expect"]["q[1]"], abs=tolerance)
    assert position[2] == pytest.approx(case["expect"]["q[2]"], abs=tolerance)
    assert [position[0], position[3]] == pytest.approx([0.0, 0.0], abs=0.01)


@runs(CONTROLLER, "width mismatch rejects the whole command")
def a_wrong_width_applies_nothing(case: Case, play: Player) -> None:
    context = RecordingContext()
    robot = context.world.add_robot("/Robot", ["a", "b", "c"])
    node = ready(
        IsaacArticulationController,
        context,
        target_prim="/Robot",
        joint_indices=case["inputs"]["jointIndices"],
        position_command=case["inputs"]["positionCommand"],
        effort_command=case["inputs"]["effortCommand"],
    )
    with pytest.raises(ValueError, match="nothing was applied") as caught:
        node.compute()
    assert all(word in str(caught.value) for word in case["expect"]["one error mentioning"])
    assert robot.commands == 0


@runs(CONTROLLER, "NaN filtered")
def nan_is_skipped(case: Case, play: Player) -> None:
    context = RecordingContext()
    robot = context.world.add_robot("/Robot", ["a", "b", "c", "d"])
    command, indices = [float(value) for value in case["inputs"]["command"]], case["inputs"]["dof_indices"]
    ready(
        IsaacArticulationController, context, target_prim="/Robot", joint_indices=indices, effort_command=command
    ).compute()
    applied = {joint: value for joint, value in enumerate(robot.targets["effort"]) if not math.isnan(value)}
    assert applied == dict(zip(case["expect"]["indices"], case["expect"]["applied"], strict=True))


# Subscribers and time


@differs(
    "ROS2Subscribe{JointState,Clock,Twist,AckermannDrive}", "queue: N newest kept, one consumed per tick, oldest first"
)
def what_a_subscriber_delivers_of_a_burst(case: Case, play: Player) -> Any:
    context = RecordingContext()
    node = ready(ROS2SubscribeTwist, context, queue_size=3)
    for speed in range(1, 10):
        context.transport.inject("/cmd_vel", twist(float(speed), 0.0))
    delivered = []
    for _ in range(5):
        context.tick()
        if node.compute():
            delivered.append(node.linear_velocity[0])
    return "the newest, once" if delivered == [9.0] else delivered


@differs("SimulationManager", "step counter with warm-up")
def ticks_after_play(case: Case, play: Player) -> Any:
    playing = play.graph("nodes: {T: OnPlaybackTick, C: PublishClock}\nconnections: [T.tick -> C.execIn]")
    ticks = []
    for _ in case["inputs"]["updates_after_play"]:
        playing.tick()
        ticks.append(playing.session.clock.frame)
    playing.session.stop()
    return {"ticks": ticks, "after stop": playing.session.clock.frame}


@runs("simulation time", "no drift: time = stepCount/stepsPerSecond")
def time_does_not_drift(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(IsaacReadSimulationTime, context)
    context.tick(case["inputs"]["steps"])
    node.compute()
    limit = case["expect"]["|simTime - steps/60|"]["lt"]
    assert abs(node.simulation_time - case["inputs"]["steps"] / 60) < limit


@runs("simulation time", "resets on stop")
def time_is_0_after_a_stop(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(IsaacReadSimulationTime, context)
    context.tick(case["inputs"]["steps"])
    context.stop()
    node.compute()
    assert node.simulation_time == case["expect"]["simulation_time"]


@runs("simulation time monotonic", "persists over stop/start")
def monotonic_time_only_grows(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(IsaacReadSimulationTime, context, reset_on_stop=False)
    times, ends = [0.0], []
    for _ in range(case["inputs"]["runs"]):
        for _ in range(10):
            context.tick()
            node.compute()
            times.append(node.simulation_time)
        ends.append(times[-1])
        context.stop()
        node.compute()
        times.append(node.simulation_time)
    assert times == sorted(times)
    assert ends[0] < ends[1]


@runs("timestamps", "seconds->sec/nanosec truncation")
def stamps_are_truncated_to_nanoseconds(case: Case, play: Player) -> None:
    stamps = [messages.stamp(seconds) for seconds in case["inputs"]["t"]]
    assert [[stamp.sec, stamp.nanosec] for stamp in stamps] == case["expect"]["sec,nanosec"]


@runs(CLOCK, "sim clock from OnTick exceeds 2 s within 150 frames")
def the_clock_is_beyond_two_seconds_after_150_frames(case: Case, play: Player) -> None:
    playing = play.shipped("clock", RecordingWorld((1, 60)))
    playing.tick(150)
    assert playing.published("/clock")[-1].clock.sec >= case["expect"]["clock"]["gt"]


@differs(CLOCK, "impulse: first impulse only creates the publisher, second publishes")
def clocks_after_each_execution(case: Case, play: Player) -> Any:
    context = RecordingContext()
    node, sent = ready(ROS2PublishClock, context, time_stamp=0.5), []
    for _ in range(case["inputs"]["impulses"]):
        node.compute()
        sent.append(len(context.transport.raw("/clock")))
    return {"messages after 1st": sent[0], "messages after 2nd": sent[1]}


# Quality of service, names


def profile(qos: Any) -> Case:
    """A profile under the reference's names."""
    found = asdict(qos)
    return {"leaseDuration": found.pop("lease_duration"), **found}


@runs(PROFILE, "default")
def the_default_profile(case: Case, play: Player) -> None:
    assert profile(parse_qos("")) == profile(PRESETS["Default for publishers/subscribers"]) == case["expect"]


@runs(PROFILE, "Services", "System Default")
def the_profile_of_a_preset(case: Case, play: Player) -> None:
    assert profile(PRESETS[case["inputs"]["createProfile"]]) == case["expect"]


@runs(PROFILE, "Custom passthrough")
def a_profile_of_ones_own(case: Case, play: Player) -> None:
    given = {key: value for key, value in case["inputs"].items() if key != "createProfile"}
    assert profile(parse_qos(json.dumps(given))) == case["expect"]


def with_namespaces(case: Case, prim_path: str) -> RecordingContext:
    context = RecordingContext(prim_path)
    for path, namespace in case["inputs"].get("prims", {}).items():
        context.world.stage.add(path, "frame", namespace=namespace)
    return context


@runs(NAMESPACE, "helper nodes, from camera prim upwards", "both inputs empty")
def a_collected_namespace(case: Case, play: Player) -> None:
    start = case["inputs"].get("start", "/World/graph/node")
    collected = with_namespaces(case, start).world.stage.namespaces(start)
    assert names.join_namespaces(collected) == case["expect"]["namespace"]


@runs(NAMESPACE, "tutorial: scan")
def the_tutorials_scan(case: Case, play: Player) -> None:
    context = with_namespaces(case, "/World/scan/LidarHelper")
    lidar = f"{list(case['inputs']['prims'])[1]}/Lidar"
    context.world.add_lidar(lidar)
    ready(ROS2RtxLidarHelper, context, render_product_path=lidar, topic_name=case["inputs"]["topicName"])
    assert context.services.claims[0].topic == case["expect"]["topic"]


@runs(NAMESPACE, "tutorial: TF nodes use only the outermost namespace")
def the_tutorials_tf(case: Case, play: Player) -> None:
    context = with_namespaces(case, f"{list(case['inputs']['prims'])[1]}/graph/PublishTF")
    for topic in case["inputs"]["topicName"]:
        ready(ROS2PublishRawTransformTree, context, topic_name=topic)
    assert [claim.topic for claim in context.services.claims] == case["expect"]["topics"]


@runs(NAMESPACE, "explicit nodeNamespace wins")
def a_namespace_that_is_given(case: Case, play: Player) -> None:
    context = with_namespaces(case, f"{list(case['inputs']['prims'])[1]}/graph/Publish")
    given = case["inputs"]
    ready(ROS2PublishClock, context, node_namespace=given["nodeNamespace"], topic_name=given["topicName"])
    assert context.services.claims[0].topic == case["expect"]["topic"]


@runs("node name", "prim path sanitised")
def the_ros_name_of_a_prim(case: Case, play: Player) -> None:
    assert names.node_name(case["inputs"]["primPath"]) == case["expect"]["ros node name"]


@runs("name validation", "rcl rules")
def names_that_rcl_takes_and_refuses(case: Case, play: Player) -> None:
    for kind, check in (("nodes", names.check_node_name), ("ns", names.check_namespace)):
        for name in case["inputs"][f"valid_{kind}"]:
            check(name)
        for name in case["inputs"][f"invalid_{kind}"]:
            with pytest.raises(TopicError):
                check(name)


# Odometry that is published


@runs(PUBLISH_ODOMETRY, "cube dropped 1.0 -> rest 0.25")
def a_cube_that_falls_and_comes_to_rest(case: Case, play: Player) -> None:
    playing = play.scene(scenes.cube_on_the_floor(case["inputs"]["start_z"], case["inputs"]["cube_scale"]))
    playing.tick(150)
    newest = playing.published("/odom")[-1]
    assert vector(newest.pose.pose.position) == pytest.approx(
        case["expect"]["pose.position"], abs=case["tolerance"]["z"]
    )
    for part in (newest.twist.twist.linear, newest.twist.twist.angular):
        assert vector(part) == pytest.approx((case["expect"]["twist"],) * 3, abs=case["tolerance"]["twist"])


@runs(PUBLISH_ODOMETRY, "world velocity commands")
def velocities_of_the_world_stay_those_of_the_world(case: Case, play: Player) -> None:
    world = RecordingWorld()
    body = world.add_body("/cube", orientation=yaw(1.0))
    body.linear = at(case["inputs"]["lin_world"])
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Compute: {{type: ComputeOdometry, inputs: {{chassisPrim: /cube}}}}
          Publish: {{type: PublishOdometry, inputs: {{robotFront: {case["inputs"]["robotFront"]}}}}}
        connections:
          - Tick.tick -> Compute.execIn
          - Compute.execOut -> Publish.execIn
          - Compute.{case["inputs"]["connected"]} -> Publish.linearVelocity
        """,
        world,
    )
    playing.tick(2)
    newest = playing.published("/odom")[-1]
    assert vector(newest.twist.twist.linear) == pytest.approx(case["expect"]["twist.linear"], abs=case["tolerance"])


@runs(PUBLISH_ODOMETRY, "robotFront (0,1,0), raw=False", "raw=True ignores robotFront")
def the_front_turns_the_twist_unless_it_is_raw(case: Case, play: Player) -> None:
    given = case["inputs"]
    message = ROS2PublishOdometry(
        linear_velocity=at(given["linearVelocity"]),
        robot_front=at(given["robotFront"]),
        publish_raw_velocities=given["publishRawVelocities"],
    ).message()
    assert vector(message.twist.twist.linear) == pytest.approx(case["expect"]["twist.linear"], abs=case["tolerance"])


@runs("diff drive closed loop", "carter 0.1 m/s 3 s")
def a_drive_straight_ahead(case: Case, play: Player) -> None:
    given, places = case["inputs"], 0.5 * 10.0 ** -case["tolerance"]["places"]
    # It falls 0.25 m and lands, which is a part of the pose that the case expects; then it drives.
    geometry = {"wheelRadius": scenes.CARTER_WHEEL_RADIUS, "wheelDistance": scenes.CARTER_WHEEL_DISTANCE}
    playing = play.scene(scenes.carter(given["start"], given["yaw_deg"], geometry))
    playing.tick(120)
    playing.transport.inject("/cmd_vel", twist(*map(float, given["cmd"])))
    playing.tick(given["seconds"] * 60)
    odom = playing.published("/odom")[-1].pose.pose
    (edge,) = playing.published("/tf")[-1].transforms
    found = [*vector(odom.position), *quaternion(odom.orientation)]
    assert found == pytest.approx(case["expect"]["odom"], abs=places)
    found = [*vector(edge.transform.translation), *quaternion(edge.transform.rotation)]
    assert found == pytest.approx(case["expect"]["tf"], abs=places)


@runs("diff drive closed loop", "spin 0.2 rad/s 2 s, wheelRadius 0.1 wheelDistance 0.5")
def a_turn_on_the_spot_with_wheels_of_other_sizes_than_the_robots(case: Case, play: Player) -> None:
    given, places = case["inputs"], 0.5 * 10.0 ** -case["tolerance"]["places"]
    playing = play.scene(scenes.carter((0.0, 0.0, 0.0), 0.0, {"wheelRadius": 0.1, "wheelDistance": 0.5}))
    playing.transport.inject("/cmd_vel", twist(*map(float, given["cmd"])))
    playing.tick(given["seconds"] * 60)
    orientation = playing.published("/odom")[-1].pose.pose.orientation
    assert orientation.z == pytest.approx(case["expect"]["odom.orientation.z"], abs=places)
    assert orientation.w == pytest.approx(case["expect"]["w"], abs=places)


@runs("leatherback odometry", "straight 1 m/s 2 s", "circle")
def a_car_on_a_circle_or_straight_ahead(case: Case, play: Player) -> None:
    given, expect = case["inputs"], case["expect"]
    speed, rate = given["speed"], given["speed"] * math.tan(given["steer"]) / given.get("wheelbase", 0.37)
    world = RecordingWorld()
    car = world.add_body("/car")
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Compute: {type: ComputeOdometry, inputs: {chassisPrim: /car}}
          Publish: PublishOdometry
        connections:
          - Tick.tick -> Compute.execIn
          - Compute.execOut -> Publish.execIn
          - Compute.position -> Publish.position
          - Compute.linearVelocity -> Publish.linearVelocity
          - Compute.angularVelocity -> Publish.angularVelocity
        """,
        world,
    )
    ticks = given.get("seconds", 2) * 60
    for tick in range(ticks + 1):
        turned = rate * tick / 60
        radius = speed / rate if rate else 0.0
        way = (radius * math.sin(turned), radius * (1 - math.cos(turned))) if rate else (speed * tick / 60, 0.0)
        car.position, car.orientation = (*way, 0.0), yaw(turned)
        car.linear, car.angular = (speed * math.cos(turned), speed * math.sin(turned), 0.0), (0.0, 0.0, rate)
        playing.tick()
    newest = playing.published("/odom")[-1]
    assert newest.twist.twist.linear.x == pytest.approx(speed)
    if "twist.angular.z" in expect:
        assert newest.twist.twist.angular.z == pytest.approx(expect["twist.angular.z"], abs=case["tolerance"])
    else:
        assert newest.twist.twist.linear.x == pytest.approx(expect["twist.linear.x"], abs=case["tolerance"]["v"])
        away = math.hypot(*vector(newest.pose.pose.position)[:2])
        assert away == pytest.approx(expect["xy displacement"], abs=case["tolerance"]["d"])


# LaserScan


def scan_of(
    angles: Any, ranges: Any = (0.05, 30.0), rate: float = 10.0, seen: Any = None, intensities: Any = 0.0
) -> Any:
    """The message of a lidar that sees that, or something everywhere."""
    context = RecordingContext()
    lidar = context.world.add_lidar("/Lidar", angles=angles, ranges=ranges, rate=rate)
    beams = round((angles[1] - angles[0]) / angles[2]) + 1
    lidar.see(np.ones(beams) if seen is None else seen, intensities)
    node = ready(ROS2RtxLidarHelper, context, render_product_path="/Lidar")
    return node.laser_scan(lidar.scan())


@runs(SCAN, "rotationRate 0 -> scan_time 0, time_increment 0")
def all_beams_are_of_one_instant_and_have_range_and_intensity(case: Case, play: Player) -> None:
    # A lidar here has a rate, so scan_time is not 0; what the case asserts holds at any rate.
    rays, (near, far) = 360, case["inputs"]["depthRange"]
    first, last = map(math.radians, case["inputs"]["azimuthRange"])
    scan = scan_of((first, last - math.radians(1.0), math.radians(1.0)), (near, float(far)))
    assert scan.time_increment == case["expect"]["time_increment"]
    assert len(scan.ranges) == len(scan.intensities) == rays


@differs(SCAN, "time_increment decreases with rotationRate")
def time_increments_at_two_rates(case: Case, play: Player) -> Any:
    return [scan_of((-1.0, 1.0, 0.5), rate=float(rate)).time_increment for rate in case["inputs"]["rotationRate"]]


@differs(SCAN, "GMO binning")
def a_miss_and_a_bright_hit(case: Case, play: Player) -> Any:
    scan = scan_of((0.0, 1.0, 1.0), seen=[math.inf, 1.0], intensities=[0.0, 255.0])
    return {"miss": float(scan.ranges[0]), "intensity of full brightness": float(scan.intensities[1])}


@differs(SCAN, "fields formula")
def fields_of_a_full_turn(case: Case, play: Player) -> Any:
    given = case["inputs"]
    step = math.radians(given["horizontalResolution"])
    first = math.radians(given["azimuthRange"][0])
    last = first + (given["n"] - 1) * step
    near, far = map(float, given["depthRange"])
    scan = scan_of((first, last, step), (near, far), float(given["rotationRate"]))
    assert len(scan.ranges) == given["n"]
    return {name: getattr(scan, name) for name in case["expect"]}


# All of them


@pytest.mark.parametrize("name", RUN)
def test_a_case_that_runs(play: Player, name: str) -> None:
    RUN[name](CASES[name], play)


def near(value: Any, expected: Any) -> bool:
    """Equal, floats to 1e-9."""
    if isinstance(expected, dict):
        return set(value) == set(expected) and all(near(value[key], expected[key]) for key in expected)
    if isinstance(expected, list):
        return len(value) == len(expected) and all(near(*pair) for pair in zip(value, expected, strict=True))
    return bool(value == (pytest.approx(expected, rel=0.0, abs=1e-9) if isinstance(expected, float) else expected))


@pytest.mark.parametrize("name", OURS)
def test_a_case_that_differs_has_our_value(play: Player, name: str) -> None:
    value = OURS[name](CASES[name], play)
    assert near(value, DIFFERS[name]["our_value"]), value
