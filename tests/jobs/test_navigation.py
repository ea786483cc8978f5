"""The navigation sample of Isaac Sim, wired as it is there: plan a path, follow it, and stand at the target."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.jobs.harness import ROOT, Job, yaw

SCENE = """
format: 1
scene: navigation
world: worlds/$WORLD.xml
settle: true
robots:
  dd100: {use: robot.yaml, position: [-3.0, 0.0, 0.025], orientation: {rpy_deg: [0, 0, 90]}}
"""

GRAPH = """
format: 1
graph: navigate
at: /dd100/Geometry/base_link/chassis_link/navigate
parameters:
  position: {type: "vectord[3]"}
  yaw: {type: "quatd[4]"}
nodes:
  OnPlaybackTick: omni.graph.action.OnPlaybackTick
  ComputeOdom:
    type: isaacsim.core.nodes.IsaacComputeOdometry
    inputs: {chassisPrim: /dd100/Geometry/base_link/chassis_link}
  GetPrimLocalToWorldTransform:
    type: omni.graph.nodes.GetPrimLocalToWorldTransform
    inputs: {usePath: false, prim: /dd100/Geometry/base_link/chassis_link}
  GetRotationQuaternion: omni.graph.nodes.GetMatrix4Quaternion
  GetTranslation: omni.graph.nodes.GetMatrix4Translation
  QuinticPathPlanner:
    type: isaacsim.robot.wheeled_robots.QuinticPathPlanner
    inputs: {targetPosition: $(position), targetOrientation: $(yaw)}
  CheckGoal2D: isaacsim.robot.wheeled_robots.CheckGoal2D
  StanleyControlPID: isaacsim.robot.wheeled_robots.StanleyControlPID
  DifferentialController:
    type: isaacsim.robot.wheeled_robots.DifferentialController
    inputs: {wheelRadius: 0.049, wheelDistance: 0.4523232}
  ArticulationController:
    type: isaacsim.core.nodes.IsaacArticulationController
    inputs: {targetPrim: /dd100, jointNames: [front_left_wheel_joint, front_right_wheel_joint]}
connections:
  - OnPlaybackTick.tick -> ComputeOdom.execIn
  - OnPlaybackTick.tick -> QuinticPathPlanner.execIn
  - QuinticPathPlanner.execOut -> CheckGoal2D.execIn
  - CheckGoal2D.execOut -> StanleyControlPID.execIn
  - OnPlaybackTick.tick -> DifferentialController.execIn
  - OnPlaybackTick.tick -> ArticulationController.execIn
  - GetPrimLocalToWorldTransform.localToWorldTransform -> GetRotationQuaternion.matrix
  - GetPrimLocalToWorldTransform.localToWorldTransform -> GetTranslation.matrix
  - GetRotationQuaternion.quaternion -> QuinticPathPlanner.currentOrientation
  - GetRotationQuaternion.quaternion -> CheckGoal2D.currentOrientation
  - GetRotationQuaternion.quaternion -> StanleyControlPID.currentOrientation
  - GetTranslation.translation -> QuinticPathPlanner.currentPosition
  - GetTranslation.translation -> CheckGoal2D.currentPosition
  - GetTranslation.translation -> StanleyControlPID.currentPosition
  - QuinticPathPlanner.pathArrays -> StanleyControlPID.pathArrays
  - QuinticPathPlanner.target -> CheckGoal2D.target
  - QuinticPathPlanner.target -> StanleyControlPID.target
  - QuinticPathPlanner.targetChanged -> CheckGoal2D.targetChanged
  - QuinticPathPlanner.targetChanged -> StanleyControlPID.targetChanged
  - CheckGoal2D.reachedGoal -> StanleyControlPID.reachedGoal
  - ComputeOdom.linearVelocity -> StanleyControlPID.currentSpeed
  - StanleyControlPID.linearVelocity -> DifferentialController.linearVelocity
  - StanleyControlPID.angularVelocity -> DifferentialController.angularVelocity
  - DifferentialController.velocityCommand -> ArticulationController.velocityCommand
"""


def navigation(folder: Path, world: str, x: float, y: float, heading: float) -> Path:
    """Files of a scene whose robot drives to a target, in the place of following cmd_vel."""
    robot = (ROOT / "scenes/robots/dd100.yaml").read_text("utf-8")
    target = f"{{position: [{x}, {y}, 0], yaw: [0, 0, {math.sin(heading / 2)}, {math.cos(heading / 2)}]}}"
    drives = f"  navigate: {{use: navigate.yaml, parameters: {target}}}"
    told = "  cmd_vel: {use: graphs/dd100/cmd_vel.yaml}"
    assert told in robot
    robot = robot.replace(told, drives).replace("urdf: dd100/", "urdf: robots/dd100/")
    for name, text in {
        "scene.yaml": SCENE.replace("$WORLD", world),
        "robot.yaml": robot,
        "navigate.yaml": GRAPH,
    }.items():
        (folder / name).write_text(text, "utf-8")
    return folder / "scene.yaml"


@pytest.mark.parametrize(
    ("world", "x", "y", "heading", "seconds"),
    [
        pytest.param("full_warehouse", -3.0, 6.0, math.pi / 2, 10.0, id="ahead"),
        pytest.param("full_warehouse", -2.0, -5.0, -math.pi / 2, 20.0, id="behind, the other way round"),
        pytest.param("full_warehouse", -4.5, 2.0, math.pi, 40.0, id="beside, with a bend that is too tight"),
        pytest.param("flat_grid", 2.0, -5.0, math.pi / 2, 40.0, id="where the sample sends it: 5 m back, 5 m right"),
    ],
)
def test_the_robot_ends_at_the_target_and_stands(
    tmp_path: Path, world: str, x: float, y: float, heading: float, seconds: float
) -> None:
    with Job(navigation(tmp_path, world, x, y, heading)) as job:
        job.run(seconds)
        moved = job.newest("/dd100_0000/odom").pose.pose
        assert job.velocity("/dd100_0000/odom") == pytest.approx((0.0, 0.0), abs=0.01)
    at = -3.0 - moved.position.y, moved.position.x  # odometry begins at (-3, 0), looking along y
    assert math.dist(at, (x, y)) <= 0.11
    assert abs(math.remainder(yaw(moved.orientation) + math.pi / 2 - heading, math.tau)) <= 0.11
