"""Odometry from the encoders of a robot whose wheels MuJoCo rolls over a floor, against where it is."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import graphengine as ge
from graphengine.messages.messages import Odometry
from graphengine.nodes.wheeled_robots.wheel_odometry import ComputeWheelOdometry
from tests.jobs.harness import Job, assemble, yaw

SCENE = """
scene: encoders
world: worlds/flat_grid.xml
settle: true
robots:
  dd100: {use: robot.yaml, position: [0.0, 0.0, 0.02]}
"""
ROBOT = "robot: dd100\nextends: robots/dd100.yaml\ngraphs: {joint_states: {use: graphs/wheel_odometry.yaml}}\n"
ODOM, TRUTH, CMD_VEL = "/dd100_0000/odom", "/dd100_0000/ground_truth/odom", "/dd100_0000/cmd_vel"
EXACT = {"WheelOdometry.slip": 0.0}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "scene.yaml").write_text(SCENE, "utf-8")
    (tmp_path / "robot.yaml").write_text(ROBOT, "utf-8")
    return tmp_path / "scene.yaml"


def pose(job: Job, topic: str) -> tuple[float, float, float]:
    """x, y and yaw of the newest odometry."""
    newest = job.newest(topic).pose.pose
    return newest.position.x, newest.position.y, yaw(newest.orientation)


@pytest.mark.parametrize(("v", "w"), [(0.6, 0.0), (-0.6, 0.0), (0.0, 0.6), (0.5, 0.5), (-0.5, 0.7)])
def test_odometry_is_within_half_a_percent_of_the_way_and_the_turn(scene: Path, v: float, w: float) -> None:
    with Job(scene, EXACT) as job:
        job.drive(CMD_VEL, v, w, 8.0)
        (x, y, heading), (true_x, true_y, true_heading) = pose(job, ODOM), pose(job, TRUTH)
    way = 8.0 * (abs(v) + 0.1 * abs(w))  # base_link is 0.1 m behind the axle
    assert math.hypot(x - true_x, y - true_y) < 0.005 * way
    assert abs(math.remainder(heading - true_heading, math.tau)) < 0.005 * 8.0 * abs(w) + 1e-4


def test_the_error_of_a_square_with_slip_is_what_the_covariance_says(scene: Path) -> None:
    squared = list[float]()
    for seed in range(8):
        with Job(scene, seed=seed) as job:
            for _ in range(4):
                job.drive(CMD_VEL, 0.8, 0.0, 2.0)
                job.drive(CMD_VEL, 0.0, math.pi / 4, 2.0)
            covariance = job.newest(ODOM).pose.covariance.reshape(6, 6)
            (x, y, heading), (true_x, true_y, true_heading) = pose(job, ODOM), pose(job, TRUTH)
            squared.append(((x - true_x) ** 2 + (y - true_y) ** 2) / (covariance[0, 0] + covariance[1, 1]))
            squared.append(math.remainder(heading - true_heading, math.tau) ** 2 / covariance[5, 5])
    assert 0.2 < sum(squared) / len(squared) < 3.0  # 1 is expected


def test_geometry_that_is_not_the_robots_is_a_warning(scene: Path) -> None:
    assert not [f for f in assemble(scene).findings.items if f.code in ("W201", "W202")]
    wrong = {"WheelOdometry.wheelRadius": 0.098, "WheelOdometry.wheelDistance": 0.4}
    radius, distance = (f for f in assemble(scene, wrong).findings.items if f.code in ("W201", "W202"))
    assert radius.message == "wheelRadius is 0.098 m, but the wheels of /dd100 have 0.049 m"
    assert radius.help == ("odometry will report 2 of the true distance", "set the parameter radius to 0.049")
    assert distance.help[0] == "odometry will report 1.13 of the true turn"


def test_slip_goes_on_after_a_checkpoint_and_whoever_listens(scene: Path) -> None:
    with Job(scene, seed=3) as heard, Job(scene, seed=3, heard=False) as unheard:
        for job in (heard, unheard):
            job.drive(CMD_VEL, 0.5, 0.2, 1.0)
        mark = heard.session.checkpoint()
        for job in (heard, unheard):
            job.drive(CMD_VEL, 0.5, 0.2, 1.0)
        last = state(heard)
        assert last == state(unheard)
        heard.session.restore(mark)
        heard.drive(CMD_VEL, 0.5, 0.2, 1.0)
        assert last == state(heard)


def state(job: Job) -> tuple[bytes, ...]:
    """What the node of the encoders outputs."""
    nodes = (node for run in job.session.graphs for node in run.executor.nodes)
    (node,) = (node for node in nodes if isinstance(node, ComputeWheelOdometry))
    outputs = node.position, node.orientation, node.linear_velocity, node.pose_covariance, node.twist_covariance
    return tuple(np.array(output).tobytes() for output in outputs)


def test_a_reset_of_the_state_does_not_roll_the_wheels(scene: Path) -> None:
    with ge.load(scene, set=EXACT).session(transport="memory") as sim:
        odometry = sim.subscribe(ODOM, Odometry)
        sim.publish(CMD_VEL, {"linear": {"x": 0.5}}, every=0.1)
        sim.run(2.0)
        assert odometry.latest is not None
        before = odometry.latest.pose.pose.position.x
        sim.reset("state")
        sim.run(1.0)
        after = odometry.latest
    assert before > 0.5
    assert after is not None
    assert after.pose.pose.position.x >= before
    assert 0.0 <= after.twist.twist.linear.x <= 0.6
