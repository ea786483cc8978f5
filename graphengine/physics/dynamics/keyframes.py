"""Sets a robot's state to a keyframe of its MuJoCo model, and makes servos hold the joints where they start."""

from __future__ import annotations

from graphengine.descriptions.actuators.drives import Servo
from graphengine.descriptions.actuators.mjcf_model import Keyframe
from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import Pose, compose

_INTEGRATOR = mujoco.mjtDyn.mjDYN_INTEGRATOR


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
