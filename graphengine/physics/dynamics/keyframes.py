"""Sets a robot's state to a keyframe of its MuJoCo model."""

from __future__ import annotations

from graphengine.devices.rotation import Pose, compose
from graphengine.physics.description.mjcf_model import Keyframe
from graphengine.physics.engine import mujoco


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
        begin = model.jnt_qposadr[index]
        data.qpos[begin : begin + len(values)] = values
    given: set[str] = set()
    for actuator, control in keyframe.controls.items():
        name = f"{prefix}{actuator}"
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if index >= 0:
            data.ctrl[index] = control
            given.add(name)
    return given
