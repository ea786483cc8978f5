# mypy: ignore-errors
"""What users of the Python API write, and what mypy and pyright tell them; the first line is left out when they look.

Where an error is to be told, the line ends in a comment: mypy's code, then pyright's rule. Every other line must be clean.
"""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

import numpy as np
from numpy.typing import NDArray

import graphengine as ge
from graphengine import CheckError, Scene, Session, Subscription, load
from graphengine.devices.lidar import Scan
from graphengine.messages.messages import LaserScan, Odometry, Twist, Vector3
from graphengine.testing import session, session_fixture

try:
    scene: Scene = load("dd100_flat", set={"DiffController.maxLinearSpeed": 0.8}, rays="mujoco", allow=["."])
except CheckError as error:
    raise SystemExit("\n".join(finding.render() for finding in error.findings)) from None
names: list[str] = [*scene.graphs, *scene.robots, *(claim.topic for claim in scene.topics)]


def drive(sim: Session) -> float:
    """Distance in five seconds, m."""
    odom: Subscription[Odometry] = sim.subscribe("/dd100_0000/odom", Odometry, keep=100)
    scan = sim.subscribe("/dd100_0000/scan", LaserScan)
    anything = sim.subscribe("/dd100_0000/tf")
    twist = Twist(Vector3(0.5, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    publication = sim.publish("/dd100_0000/cmd_vel", twist, every=0.1)
    reached: bool = sim.run(5.0, until=lambda s: s.robots["dd100"].pose.position[0] > 2.0)
    publication.close()
    frames: list[str] = [message.header.frame_id for message in odom.messages]
    ranges = scan.latest.ranges if scan.latest is not None else None
    pixels: NDArray[np.uint8] = sim.picture("top", size=(320, 180))
    done: Future[Any] = sim.submit("push", {"entity": "dd100", "impulse": [0, 1, 0]})
    sim.set("DiffController.maxLinearSpeed", 1.0)
    sim.move("box", position=(1, 2, 0), orientation=(0, 0, 0, 1))
    sim.reset("state", "time")
    sim.mujoco.data.qvel[:] = 0.0 * sim.mujoco.model.opt.timestep
    sim.mujoco.data = None  # error: misc reportAttributeAccessIssue
    robot = sim.robots["dd100"]
    robot.command(positions={"shoulder": 0.5}, efforts=np.zeros(2))
    robot.command(velocities=[5.0, 5.0], joints=["left", "right"])
    robot.reset(joints={"shoulder": 0.0}, position=(1.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0), keyframe="home")
    robot.reset(position=(1.0, 0.0))  # error: arg-type reportArgumentType
    lidar: ge.RobotSensor = robot.sensors["sim_lidar"]
    sample: Scan | None = lidar.sample()
    nearest = float(sample.points[:, 0].min()) if sample is not None else sim.time
    kinds: list[str] = [sensor.kind + sensor.prim_path for sensor in robot.sensors.values()]
    lidar.smaple()  # error: attr-defined reportAttributeAccessIssue
    _ = (nearest, kinds)
    robot.command(velocities=5.0)  # error: arg-type reportArgumentType
    robot.command(torques={"shoulder": 0.5})  # error: call-arg reportCallIssue
    x: float = sim.robots["dd100"].joints["front_left_wheel_joint"].position
    _ = (reached, frames, ranges, pixels.shape, done, anything.messages[-1].whatever, sim.time, sim.tick, sim.state)
    sim.run("5 s")  # error: arg-type reportArgumentType
    sim.reset("velocity")  # error: arg-type reportArgumentType
    sim.push("dd100", force=(0, 80))  # error: arg-type reportArgumentType
    sim.rum(5.0)  # error: attr-defined reportAttributeAccessIssue
    sim.time = 3.0  # error: misc reportAttributeAccessIssue
    _ = odom.latest.twist  # error: union-attr reportOptionalMemberAccess
    wrong: Subscription[Odometry] = sim.subscribe("/clock", Twist)  # error: arg-type reportAssignmentType
    return x + wrong.dropped


with scene.session(seed=3, record="out.mcap", force=True) as started, session("dd100_flat") as other:
    drive(started if started.time else other)
robots = {"arm": {"use": "arm.yaml", "position": [0, 0, 0]}}
scenes: list[Scene] = [load({"scene": "s", "world": "w.xml", "robots": robots}, folder="."), load(text="graph: g")]
load(3)  # error: arg-type reportArgumentType
fixture = session_fixture("dd100_flat", scope="module")


def make() -> ge.gym.SceneEnv:
    """An environment whose reward is the distance, m."""
    return ge.gym.SceneEnv(
        scene,
        action=[ge.gym.BaseVelocity("/dd100_0000/cmd_vel"), ge.gym.JointTargets("dd100", "velocities", ["left"])],
        observation={"pose": ge.gym.Observation("/dd100_0000/odom.pose", low=[-1.0], high=5)},
        reward=lambda env: env.sim.robots["dd100"].pose.position[0],
        at_reset=lambda env: env.sim.move("dd100", position=(1, 2)),
    )


observation, reward, terminated, truncated, info = make().step(np.zeros(3, np.float32))
total: float = reward
ended: bool = terminated or truncated
envs = ge.gym.make_vec(make, 2)
ge.gym.make_vec(make(), 2)  # error: arg-type reportArgumentType
ge.gym.SceneEnv(scene, reward=lambda env: 0.0)  # error: call-arg reportCallIssue
ge.gym.JointTargets("dd100", "torques")  # error: arg-type reportArgumentType
_ = ge.gym.SceneEnvironment  # error: attr-defined reportAttributeAccessIssue
scene.session(transprot="dds")  # error: call-arg reportCallIssue
scene.session(bad_values="keep")  # error: arg-type reportArgumentType
_ = ge.laod  # error: attr-defined reportAttributeAccessIssue
