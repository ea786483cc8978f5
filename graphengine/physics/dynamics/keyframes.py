"""Puts a robot in a keyframe of its MuJoCo model."""

from __future__ import annotations

from graphengine.devices.rotation import compose
from graphengine.devices.stage import Prim
from graphengine.physics.description.mjcf_model import Keyframe
from graphengine.physics.engine import mujoco


def begin_in(keyframe: Keyframe, robot: Prim, model: mujoco.MjModel, data: mujoco.MjData) -> set[str]:
    """Write a keyframe to a state, with free bodies relative to where the robot was placed.

    Returns:
        names of the actuators whose control signals the keyframe gives.
    """
    for joint, values in keyframe.coordinates.items():
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{robot.entity_name}/{joint}")
        if index < 0:  # a free joint in place of which the base is fixed
            continue
        if model.jnt_type[index] == mujoco.mjtJoint.mjJNT_FREE:
            x, y, z, d, a, b, c = values
            position, (a, b, c, d) = compose((robot.position, robot.orientation), ((x, y, z), (a, b, c, d)))
            values = (*position, d, a, b, c)
        begin = model.jnt_qposadr[index]
        data.qpos[begin : begin + len(values)] = values
    given: set[str] = set()
    for actuator, control in keyframe.controls.items():
        name = f"{robot.entity_name}/{actuator}"
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if index >= 0:
            data.ctrl[index] = control
            given.add(name)
    return given
