"""Writes the start of a robot to a state: keyframe, positions of joints, and servos that hold the joints there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from graphengine.descriptions.actuators.drives import KINDS, Servo
from graphengine.descriptions.actuators.mjcf_model import Keyframe
from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import Pose, compose
from graphengine.devices.stage import Prim

_INTEGRATOR = mujoco.mjtDyn.mjDYN_INTEGRATOR


def start_robot(
    robot: Prim,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    positions: Mapping[str, float],
    keyframe: Keyframe | None,
    *,
    others: bool = True,
) -> None:
    """Write the start of a robot to a state: a keyframe, then positions of joints, where the servos of their drives hold them.

    Args:
        robot: prim of the robot.
        model: compiled model.
        data: state that is changed.
        positions: a dict from joint name to position, rad or m.
        keyframe: keyframe of the robot's own model, or None.
        others: whether servos also hold the joints without a position in `positions`, where they are.
    """
    prefix = f"{robot.entity_name}/"
    place = robot.position, robot.orientation
    given = begin_in(keyframe, prefix, place, model, data) if keyframe is not None else set()
    for prim in robot.descendants():
        drive, start = prim.facts.get("drive"), positions.get(prim.facts.get("joint", ""))
        if prim.kind != "joint" or (start is None and (drive is None or not others)):
            continue
        name = f"{prefix}{prim.facts['joint']}"
        place_of_joint = model.jnt_qposadr[model.joint(name).id]
        moved = start is not None and start != data.qpos[place_of_joint]
        if moved:
            data.qpos[place_of_joint] = start
        for servo in filter(None, (drive.servo(name, kind) for kind in KINDS) if drive is not None else ()):
            hold(servo, float(data.qpos[place_of_joint]), model, data, controlled=servo.name in given and not moved)


def with_followers(model: mujoco.MjModel, prefix: str, positions: Mapping[str, float]) -> dict[str, float]:
    """Return a dict from joint name to position (rad or m), with the positions that follow for mimic joints.

    Args:
        model: compiled model.
        prefix: prefix of the robot's names in the model.
        positions: positions of joints that do not mimic others.
    """
    found = {model.joint(f"{prefix}{name}").id: position for name, position in positions.items()}
    laws = np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT).tolist()
    start = model.qpos0[model.jnt_qposadr]
    while new := [law for law in laws if model.eq_obj2id[law] in found and model.eq_obj1id[law] not in found]:
        for law in new:
            leader, follower = int(model.eq_obj2id[law]), int(model.eq_obj1id[law])
            way = np.polynomial.polynomial.polyval(found[leader] - start[leader], model.eq_data[law, :5])
            found[follower] = float(start[follower] + way)
    return {model.joint(joint).name.removeprefix(prefix): position for joint, position in found.items()}


def begin_in(keyframe: Keyframe, prefix: str, place: Pose, model: mujoco.MjModel, data: mujoco.MjData) -> set[str]:
    """Write a robot's keyframe to the state of a compiled model.

    Args:
        keyframe: keyframe of the robot's own model.
        prefix: prefix of the robot's names in the compiled model.
        place: pose of the robot in the world; the keyframe's poses of free bodies are relative to it.
        model: compiled model.
        data: state that is changed.

    Returns:
        Names in the compiled model of the actuators whose control signals the keyframe sets.
    """
    for joint, values in keyframe.coordinates.items():
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{prefix}{joint}")
        if index < 0:  # a free joint in place of which the base is fixed
            continue
        if model.jnt_type[index] == mujoco.mjtJoint.mjJNT_FREE:
            x, y, z, d, a, b, c = values
            position, (a, b, c, d) = compose(place, ((x, y, z), (a, b, c, d)))
            values = (*position, d, a, b, c)
        data.joint(index).qpos[:] = values
    given: set[str] = set()
    for actuator, control in keyframe.controls.items():
        name = f"{prefix}{actuator}"
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if index >= 0:
            data.ctrl[index] = control
            given.add(name)
    return given


def hold(servo: Servo, position: float, model: mujoco.MjModel, data: mujoco.MjData, *, controlled: bool) -> None:
    """Set the control signal and the activation with which a servo holds its joint from the first step on.

    Velocity and effort servos keep their control signals, but a velocity servo that integrates its command gets the activation.

    Args:
        servo: actuator of the compiled model.
        position: position of the joint, rad or m.
        model: compiled model.
        data: state that is changed.
        controlled: whether the control signal is already set.
    """
    actuator = model.actuator(servo.name).id
    activation = int(model.actuator_actadr[actuator])
    if servo.kind == "position":
        if not controlled:
            data.ctrl[actuator] = servo.control(min(max(position, servo.lowest), servo.highest))
        if activation >= 0:
            data.act[activation] = data.ctrl[actuator]
    elif servo.kind == "velocity" and activation >= 0 and model.actuator_dyntype[actuator] == _INTEGRATOR:
        data.act[activation] = servo.scale * position
