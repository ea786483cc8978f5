"""A scene with the arm, its controllers and its joint states, and a trajectory of fifty points for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests import arm_robot
from tests.trajectories import point, trajectory

RATE, DURATION, POINTS = 60, 4.0, 50
"""Ticks a second, and length (s) and number of points of the trajectory."""
_SCENE = f"""
    format: 1
    scene: arm
    world: worlds/flat_grid.xml
    physics: {{tick_rate: {RATE}, substeps: 4}}
    robots: {{arm: {{use: arm.yaml}}}}
    graphs:
      trajectory:
        use: graphs/arm/trajectory.yaml
        parameters: {{robot: /arm, joints: [{", ".join(arm_robot.JOINTS)}], goal_tolerances: [0.001]}}
      gripper:
        use: graphs/arm/gripper.yaml
        parameters: {{robot: /arm, joint: {arm_robot.FINGER}, goal_tolerance: 0.0005}}
      states: {{use: states.yaml}}
"""
_STATES = """
    format: 1
    graph: states
    at: /World/states
    nodes:
      Tick: omni.graph.action.OnPlaybackTick
      States: {type: isaacsim.ros2.bridge.ROS2PublishJointState, inputs: {targetPrim: /arm, resolution: 0.0}}
      Time: isaacsim.core.nodes.IsaacReadSimulationTime
    connections: [Tick.tick -> States.execIn, Time.simulationTime -> States.timeStamp]
"""
Floats = NDArray[np.float64]


def files() -> Mapping[str, str]:
    """The files of the scene by name; `scene.yaml` is the one to run. The arm starts where the trajectory does."""
    start = dict(zip(arm_robot.JOINTS, motion(0.0)[0].tolist(), strict=True))
    robot = {"arm.urdf": arm_robot.urdf(), "arm.yaml": arm_robot.robot_file(start)}
    return {**robot, "states.yaml": _STATES, "scene.yaml": _SCENE}


def motion(time: float) -> tuple[Floats, Floats]:
    """Positions and velocities that begin and end at rest, at half of each joint's speed limit in the middle."""
    share = 2.0 * math.pi * time / DURATION
    most = np.array([arm_robot.SPEEDS[name] for name in arm_robot.JOINTS]) / 2.0
    turned = most * DURATION / (4.0 * math.pi) * (share - math.sin(share))
    return np.array(arm_robot.BENT) + turned - most * DURATION / 4.0, most * (1.0 - math.cos(share)) / 2.0


def fifty() -> Any:
    """The trajectory message."""
    return trajectory(arm_robot.JOINTS, *(point(time, *motion(time)) for time in np.linspace(0.0, DURATION, POINTS)))
