"""The state in which a model starts, and the drives of its joints."""

from __future__ import annotations

from collections.abc import Iterator

from graphengine.descriptions.actuators.drives import Drive
from graphengine.descriptions.engine import data_at_start, mujoco
from graphengine.devices.stage import Stage
from graphengine.physics.dynamics.keyframes import start_robot


def initial_data(model: mujoco.MjModel, stage: Stage) -> mujoco.MjData:
    """Return the initial state of a model: robots in keyframes, joints at their start positions and held there."""
    data = data_at_start(model)
    for robot in stage.prims("robot"):
        joints = [prim.facts for prim in robot.descendants() if prim.kind == "joint"]
        starts = {facts["joint"]: facts["start"] for facts in joints if "start" in facts}
        start_robot(robot, model, data, starts, robot.facts.get("keyframe"))
    return data


def drives_of(stage: Stage) -> Iterator[tuple[str, Drive]]:
    """Yield each drive with the name of its joint in the model.

    Drives that move no joint or several joints come last, with their robot's prefix instead of a joint name.
    """
    for prim in stage.prims("joint"):
        robot, drive = stage.robot_of(prim), prim.facts["drive"]
        if robot is not None and drive is not None:
            yield f"{robot.entity_name}/{prim.facts['joint']}", drive
    for robot in stage.prims("robot"):
        for drive in robot.facts.get("other_actuators", {}).values():
            yield f"{robot.entity_name}/", drive
