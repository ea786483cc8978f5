"""The state in which a model starts, and the drives of its joints."""

from __future__ import annotations

from collections.abc import Iterator

from graphengine.descriptions.actuators.drives import KINDS, Drive
from graphengine.descriptions.engine import data_at_start, mujoco
from graphengine.devices.stage import Stage
from graphengine.physics.dynamics.keyframes import begin_in, hold


def initial_data(model: mujoco.MjModel, stage: Stage) -> mujoco.MjData:
    """Return the initial state of a model: robots in keyframes, joints at their start positions and held there."""
    data = data_at_start(model)
    given: set[str] = set()
    for prim in stage.prims("robot"):
        if "keyframe" in prim.facts:
            place = (prim.position, prim.orientation)
            given |= begin_in(prim.facts["keyframe"], f"{prim.entity_name}/", place, model, data)
    for prim in stage.prims("joint"):
        robot, start, drive = stage.robot_of(prim), prim.facts.get("start"), prim.facts["drive"]
        if robot is None or (start is None and drive is None):
            continue
        name = f"{robot.entity_name}/{prim.facts['joint']}"
        place = model.jnt_qposadr[model.joint(name).id]
        moved = start is not None and start != data.qpos[place]
        if moved:
            data.qpos[place] = start
        for servo in filter(None, (drive.servo(name, kind) for kind in KINDS) if drive is not None else ()):
            hold(servo, float(data.qpos[place]), model, data, controlled=servo.name in given and not moved)
    return data


def drives_of(stage: Stage) -> Iterator[tuple[str, Drive]]:
    """Yield pairs of a joint's name in the model and the joint's drive.

    Drives that do not move exactly one joint come last, with their robot's prefix in place of a joint name.
    """
    for prim in stage.prims("joint"):
        robot, drive = stage.robot_of(prim), prim.facts["drive"]
        if robot is not None and drive is not None:
            yield f"{robot.entity_name}/{prim.facts['joint']}", drive
    for robot in stage.prims("robot"):
        for drive in robot.facts.get("other_actuators", {}).values():
            yield f"{robot.entity_name}/", drive
