"""An arm in a process of its own follows the trajectory of a client over a network."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.messages import goals, messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.select import open_transport
from tests import arm_robot, arm_scene
from tests.cli.harness import live
from tests.nodes.harness import write
from tests.ros import needs
from tests.trajectories import FOLLOW, goal, trajectory
from tests.waiting import PATIENCE, eventually

ACTION = "/joint_trajectory_controller/follow_joint_trajectory"


@pytest.mark.parametrize("kind", ["dds", pytest.param("rclpy", marks=pytest.mark.ros(needs.carried("control_msgs")))])
def test_fifty_points_are_followed_by_a_run_of_another_process(tmp_path: Path, domain_id: int, kind: str) -> None:
    write(tmp_path, arm_scene.files())
    around = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    if kind == "rclpy":
        around |= {name: os.environ[name] for name in ("PYTHONPATH", "RMW_IMPLEMENTATION") if name in os.environ}
    with live("run", str(tmp_path / "scene.yaml"), "--transport", kind, "--no-control", env=around):
        client = open_transport(kind, JoinOptions(Domain(domain_id, "LOCALHOST"), "client"))
        try:
            caller, states, feedback = ActionCaller(client, ACTION, FOLLOW), list[Any](), list[Any]()
            client.reader("/joint_states", "sensor_msgs/msg/JointState", QoS(), states.append)
            assert eventually(lambda: caller.ready and states)
            wrong = caller.send(goal(trajectory(["tail"])))
            answer = caller.send(goal(trajectory(["tail"], *arm_scene.fifty().points)))
            assert wrong.result.result(PATIENCE).status == goals.SUCCEEDED  # without points, joints hold
            assert (answer.accepted.result(PATIENCE), answer.result.result(PATIENCE).result.error_code) == (True, -2)
            call = caller.send(goal(arm_scene.fifty()), feedback.append)
            response = call.result.result(PATIENCE)
            assert (response.status, response.result.error_code) == (goals.SUCCEEDED, 0)
            assert len(feedback) > 20
            state = messages.decode(states[-1], "sensor_msgs/msg/JointState")
            there = dict(zip(state.name, state.position, strict=True))
            at = np.array([there[name] for name in arm_robot.JOINTS])
            assert np.abs(at - arm_scene.motion(arm_scene.DURATION)[0]).max() < 1e-3
        finally:
            client.close()
