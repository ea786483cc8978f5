"""How an arm holds a pose, follows a trajectory and answers goals: `python -m tests.bench.arm_figures SCENE [--flange LINK]`.

SCENE has one robot with a graph `arm/trajectory`, which starts in the pose to measure. The trajectory has 50 points with
positions and velocities; each joint swings about its start at half its speed limit. Errors are those at the time of a point, of
the joint with the largest. The payload is a point of 1 kg at the flange, unknown to the arm's gravity compensation. Prints JSON.
"""

from __future__ import annotations

import argparse
import json
import math
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

import graphengine as ge
from graphengine.api.pictures import simulated
from graphengine.api.scene import loaded_of
from graphengine.devices.rotation import NOWHERE, compose

Floats = NDArray[np.float64]
POINTS = 50
STEP = 6 / 60
"""Time from one point to the next, s: six ticks."""
SWING = 0.4
"""Largest way of a joint to either side, rad or m."""
SPEED = 1.5
"""Limit of a joint whose description has none, rad/s or m/s."""
HOLD = 5.0
"""Time that a pose is held, s."""
TYPE = "control_msgs/action/FollowJointTrajectory"


@dataclass(frozen=True)
class Points:
    """A trajectory: a row of positions (rad, m) and one of velocities for each point, and the joints' names."""

    joints: tuple[str, ...]
    positions: Floats
    velocities: Floats

    def message(self, start: float = 0.0) -> dict[str, Any]:
        """The trajectory that begins at a time, or at once."""
        rows = enumerate(zip(self.positions.tolist(), self.velocities.tolist(), strict=True), 1)
        points = [{"positions": p, "velocities": v, "time_from_start": _time(n * STEP)} for n, (p, v) in rows]
        return {"header": {"stamp": _time(start)}, "joint_names": [*self.joints], "points": points}


class Arm:
    """The arm of a running scene."""

    def __init__(self, scene: ge.Scene, sim: ge.Session, flange: str, payload: float) -> None:
        self.sim = sim
        (self.robot,) = sim.robots.values()
        self.world = simulated(sim._runner.session.services.world)
        world = loaded_of(scene).world
        assert world is not None
        description = world.robots[self.robot.name]
        arms = [each for each in description.spec.graphs.values() if each.use.endswith("arm/trajectory.yaml")]
        assert arms, "no graph moves the arm along trajectories"
        graph = max(arms, key=lambda each: len(each.parameters["joints"]))  # a gripper may have such a graph, too
        self.joints = tuple(graph.parameters["joints"])
        self.controller = f"/{graph.parameters.get('controller', 'joint_trajectory_controller')}"
        self.action = f"{self.controller}/follow_joint_trajectory/_action"
        self.handle = self.world.articulation(self.world.stage.find(description.prim_path))
        if payload:
            link, pose = flange, NOWHERE
            while mujoco.mj_name2id(self.world.model, mujoco.mjtObj.mjOBJ_BODY, f"{self.robot.name}/{link}") < 0:
                carrier = description.description.links[link].carrier
                assert carrier is not None, f"no body carries {flange}"
                link, pose = carrier.parent, compose(carrier.pose, pose)
            _add_mass(self.world.model, f"{self.robot.name}/{link}", np.array(pose[0]), payload)

    def positions(self) -> Floats:
        """Positions of the arm's joints, rad or m."""
        joints = self.robot.joints
        return np.array([joints[name].position for name in self.joints])

    def swings(self) -> Points:
        """A trajectory about where the joints are, which begins and ends with neither speed nor acceleration."""
        names = self.handle.joint_names
        span, times = POINTS * STEP, np.arange(1, POINTS + 1) * STEP
        positions, velocities = [], []
        for name, start in zip(self.joints, self.positions(), strict=True):
            low, high = self.handle.ranges[names.index(name)]
            limit = self.handle.max_velocities[names.index(name)]
            speed = 0.5 * (limit if math.isfinite(limit) else SPEED)
            room = min(SWING, 0.9 * (high - start), 0.9 * (start - low))
            assert room > 0, f"{name} starts at a limit"
            swings = max(1, math.ceil(speed * span / (2 * math.pi * room)))
            rate, slow = 2 * math.pi * swings / span, math.pi / span
            wave, window = np.sin(rate * times), np.sin(slow * times) ** 2
            change = rate * np.cos(rate * times) * window + wave * slow * np.sin(2 * slow * times)
            reach = speed / np.abs(change).max()
            positions.append(start + reach * wave * window)
            velocities.append(reach * change)
        return Points(self.joints, np.array(positions).T, np.array(velocities).T)

    def follow(self, points: Points) -> tuple[Floats, int]:
        """Send a goal; return the error of each joint at each point, and the error code of the result."""
        begin = self.sim.time + 0.5
        goal = self.send(points.message(begin))
        errors = []
        for number, position in enumerate(points.positions, 1):
            self.sim.run(begin + number * STEP - self.sim.time)
            errors.append(self.positions() - position)
        return np.array(errors), self.result(goal).result.error_code

    def send(self, trajectory: dict[str, Any]) -> list[int]:
        """Send a goal, and return its id."""
        goal = [*uuid.uuid4().bytes]
        request = {"goal_id": {"uuid": goal}, "goal": {"trajectory": trajectory}}
        assert self.sim.call(f"{self.action}/send_goal", request, type=f"{TYPE}_SendGoal").accepted
        return goal

    def cancel(self, goal: list[int]) -> None:
        """Cancel a goal."""
        self.sim.call(f"{self.action}/cancel_goal", {"goal_info": {"goal_id": {"uuid": goal}}})

    def result(self, goal: list[int]) -> Any:
        """Wait for the end of a goal; return its status and result."""
        return self.sim.call(f"{self.action}/get_result", {"goal_id": {"uuid": goal}}, 60.0, f"{TYPE}_GetResult")


@contextmanager
def started(scene: ge.Scene, flange: str = "", payload: float = 0.0) -> Iterator[Arm]:
    """Run a scene, with a payload (kg) at the flange."""
    with scene.session() as sim:
        yield Arm(scene, sim, flange, payload)


def _time(seconds: float) -> dict[str, int]:
    nanoseconds = round(seconds * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def _add_mass(model: mujoco.MjModel, body: str, place: Floats, mass: float) -> None:
    """Add a point mass (kg) to a body of the model, at a place in its frame (m)."""
    number = model.body(body).id
    own, centre = model.body_mass[number], model.body_ipos[number].copy()
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[number])
    axes = rotation.reshape(3, 3)
    total, new = own + mass, (own * centre + mass * place) / (own + mass)
    inertia = axes @ np.diag(model.body_inertia[number]) @ axes.T
    for part, way in ((own, centre - new), (mass, place - new)):
        inertia += part * (way @ way * np.eye(3) - np.outer(way, way))
    moments, vectors = np.linalg.eigh(inertia)
    vectors[:, 2] *= np.sign(np.linalg.det(vectors))
    model.body_mass[number], model.body_ipos[number], model.body_inertia[number] = total, new, moments
    mujoco.mju_mat2Quat(model.body_iquat[number], vectors.ravel())
    mujoco.mj_setConst(model, mujoco.MjData(model))


def answers(arm: Arm) -> dict[str, bool]:
    """Whether goals end as the action says: 2 accepted, 4 succeeded, 5 canceled, 6 aborted, and the error codes."""
    points = arm.swings()
    canceled = arm.send(points.message())
    arm.sim.run(1.0)
    arm.cancel(canceled)
    found = {"canceled": arm.result(canceled).status == 5}
    arm.sim.run(1.0)
    first = arm.send(arm.swings().message())
    arm.sim.run(1.0)
    arm.send(arm.swings().message())
    found["preempted"] = arm.result(first).status == 6
    unknown = arm.result(arm.send(points.message() | {"joint_names": ["no_joint", *points.joints[1:]]})).result
    found["unknown joint"] = unknown.error_code == unknown.INVALID_JOINTS
    beyond = points.message()
    bounded = [arm.handle.ranges[arm.handle.joint_names.index(name)][1] for name in points.joints]
    joint = next((number for number, high in enumerate(bounded) if math.isfinite(high)), None)
    if joint is not None:
        beyond["points"][-1]["positions"][joint] = bounded[joint] + 0.1
        refused = arm.result(arm.send(beyond)).result
        found["beyond a limit"] = refused.error_code == refused.INVALID_GOAL
    return found


def figures(path: Path, flange: str) -> dict[str, Any]:
    """Measure the arm of a scene: errors in mrad (mm for joints that slide), and whether goals end as they should."""
    scene = ge.load(path)
    found: dict[str, Any] = {}
    for kind, payload in (("", 0.0), ("_payload", 1.0)):
        with started(scene, flange, payload) as arm:
            start = np.array([arm.handle.set_points()[0][arm.handle.joint_names.index(name)] for name in arm.joints])
            arm.sim.run(HOLD)
            found["joints"] = len(arm.joints)
            found[f"hold{kind}"] = float(np.abs(arm.positions() - start).max() * 1000)
            errors, code = arm.follow(arm.swings())
            found |= {f"points{kind}": float(np.abs(errors).max() * 1000), f"code{kind}": code}
            worst = [
                f"{name} {value:.2f}" for name, value in zip(arm.joints, np.abs(errors).max(0) * 1000, strict=True)
            ]
            found[f"worst{kind}"] = worst
            found[f"end{kind}"] = float(np.abs(errors[-1]).max() * 1000)
    with started(scene) as arm:
        found["goals"] = answers(arm)
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--flange", default="", help="link that carries the payload")
    given = parser.parse_args()
    print(json.dumps(figures(given.scene, given.flange)))
