"""Converts the actuators of a MuJoCo model to drives: the kind of command that each takes, and its gains and limits.

An actuator of MuJoCo exerts the force gain * control + bias. The bias, not the tag in MJCF, determines the kind of an actuator:
a bias against position makes a position servo, a bias against velocity alone a velocity servo, and no bias a motor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from graphengine.descriptions.actuators.drives import KINDS, Drive, Servo
from graphengine.descriptions.engine import mujoco
from graphengine.devices.motion import CommandKind

_TYPE, _GAIN, _BIAS, _DYNAMICS = mujoco.mjtTrn, mujoco.mjtGain, mujoco.mjtBias, mujoco.mjtDyn
_ON_JOINTS = (_TYPE.mjTRN_JOINT.value, _TYPE.mjTRN_JOINTINPARENT.value)
_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value)
_LINEAR = [_DYNAMICS.mjDYN_NONE, _DYNAMICS.mjDYN_FILTER, _DYNAMICS.mjDYN_FILTEREXACT, _DYNAMICS.mjDYN_INTEGRATOR]
"""Actuator dynamics after which the steady-state activation equals the control signal or its integral."""


@dataclass(frozen=True, slots=True)
class Actuator:
    """An actuator of a MuJoCo model.

    Attributes:
        name: name of the actuator.
        joint: name of the hinge or slide joint that it drives; empty for an actuator with another target (ball or free joint,
            tendon, site or body).
        drive: the equivalent drive; its gains include the gear, in units of the joint (rad and N m, or m and N).
    """

    name: str
    joint: str
    drive: Drive

    @property
    def kind(self) -> CommandKind:
        """Kind of command that the actuator takes: position, velocity or effort."""
        assert self.drive.servos is not None
        return self.drive.servos[0].kind


def read_actuators(model: mujoco.MjModel) -> list[Actuator]:
    """Return the actuators of a compiled model of one robot, in order of the model; each must have a name."""
    return [_actuator(model, index) for index in range(model.nu)]


def drives_by_joint(actuators: Sequence[Actuator]) -> dict[str, Drive]:
    """Return a dict from the names of joints that have actuators to their drives.

    A joint with several actuators has one servo per kind of command; of two actuators of the same kind, the first is used.
    """
    found: dict[str, Drive] = {}
    for actuator in actuators:
        if not actuator.joint:
            continue
        before = found.get(actuator.joint, Drive(servos=()))
        servos = {servo.kind: servo for servo in (*(actuator.drive.servos or ()), *(before.servos or ()))}
        found[actuator.joint] = Drive(
            stiffness=before.stiffness or actuator.drive.stiffness,
            damping=before.damping or actuator.drive.damping,
            servos=tuple(servos[kind] for kind in KINDS if kind in servos),
        )
    return found


def _actuator(model: mujoco.MjModel, index: int) -> Actuator:
    target, joint = int(model.actuator_trnid[index, 0]), ""
    if model.actuator_trntype[index] in _ON_JOINTS and model.jnt_type[target] in _SCALAR:
        joint = model.joint(target).name
    gear = float(model.actuator_gear[index, 0])
    return Actuator(model.actuator(index).name, joint, _drive(model, index, gear))


def _drive(model: mujoco.MjModel, index: int, gear: float) -> Drive:
    """Return the drive of an actuator. If it is neither servo nor motor, its control signal is treated as an effort."""
    name, gain, (constant, position, velocity) = model.actuator(index).name, *_law(model, index)
    integrates = model.actuator_dyntype[index] == _DYNAMICS.mjDYN_INTEGRATOR
    if not gain or not gear or (integrates and position * gain >= 0):
        return Drive(servos=(_ranged(Servo("effort", name), model, index),))
    if integrates:
        servo = Servo("velocity", name, -position * gear / gain)
        return Drive(damping=gear * gear * abs(position), servos=(_ranged(servo, model, index),))
    if position * gain < 0:
        servo = Servo("position", name, -position * gear / gain, -constant / gain)
        return Drive(stiffness=gear * gear * abs(position), servos=(_ranged(servo, model, index),))
    if velocity * gain < 0:
        servo = Servo("velocity", name, -velocity * gear / gain, -constant / gain)
        return Drive(damping=gear * gear * abs(velocity), servos=(_ranged(servo, model, index),))
    servo = _ranged(Servo("effort", name, 1.0 / (gear * gain), -constant / gain), model, index)
    if model.actuator_forcelimited[index]:
        low, high = sorted(gear * float(force) for force in model.actuator_forcerange[index])
        servo = Servo("effort", name, servo.scale, servo.offset, max(servo.lowest, low), min(servo.highest, high))
    return Drive(servos=(servo,))


def _law(model: mujoco.MjModel, index: int) -> tuple[float, tuple[float, float, float]]:
    """Return gain and bias (constant, per position, per velocity) of an actuator; all 0 if its force law is not affine."""
    gains, biases = model.actuator_gainprm[index].tolist(), model.actuator_biasprm[index].tolist()
    plain = model.actuator_gaintype[index] == _GAIN.mjGAIN_FIXED or (
        model.actuator_gaintype[index] == _GAIN.mjGAIN_AFFINE and not any(gains[1:3])
    )
    affine = model.actuator_biastype[index] == _BIAS.mjBIAS_AFFINE
    known = affine or model.actuator_biastype[index] == _BIAS.mjBIAS_NONE
    if not (plain and known) or model.actuator_dyntype[index] not in [dynamics.value for dynamics in _LINEAR]:
        return 0.0, (0.0, 0.0, 0.0)
    return gains[0], (biases[0], biases[1], biases[2]) if affine else (0.0, 0.0, 0.0)


def _ranged(servo: Servo, model: mujoco.MjModel, index: int) -> Servo:
    """Return the servo; if the actuator has a `ctrlrange`, the range of its commands is limited accordingly."""
    if not model.actuator_ctrllimited[index]:
        return servo
    ends = [(float(end) - servo.offset) / servo.scale for end in model.actuator_ctrlrange[index]]
    return Servo(servo.kind, servo.name, servo.scale, servo.offset, min(ends), max(ends))


def strongest(model: mujoco.MjModel) -> dict[str, float]:
    """Return a dict from joint names to effort limits, N m or N; it lacks joints without a limit.

    The limit is the largest limit of the joint's actuators, but at most the joint's own limit (`actuatorfrcrange`).
    """
    found: dict[str, float] = {}
    for index, actuator in enumerate(read_actuators(model)):
        limits = [force for force in _forces(model, index, actuator) if math.isfinite(force)]
        if actuator.joint and limits:
            found[actuator.joint] = max(found.get(actuator.joint, 0.0), max(limits))
    for index in range(model.njnt):
        if model.jnt_actfrclimited[index]:
            name, most = model.joint(index).name, float(abs(model.jnt_actfrcrange[index]).max())
            found[name] = min(found.get(name, most), most)
    return {joint: force for joint, force in found.items() if force > 0}


def _forces(model: mujoco.MjModel, index: int, actuator: Actuator) -> Iterator[float]:
    if model.actuator_forcelimited[index]:
        yield float(abs(model.actuator_forcerange[index] * model.actuator_gear[index, 0]).max())
    elif actuator.kind == "effort":
        for servo in actuator.drive.servos or ():
            yield max(abs(servo.lowest), abs(servo.highest))
