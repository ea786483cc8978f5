"""Adds the graph with which a legged robot with motors stands in the pose of its keyframe `home`."""

from __future__ import annotations

from graphengine.descriptions.robot_files.draft import Draft, Entry, Remark, in_path, rounded
from graphengine.descriptions.robot_files.mjcf_parts import KEYFRAME

GRAPH = "stand"
"""Name of the legs' graph in the robot file."""
_ANGLE = 0.4
"""Deviation of a joint at which the graph commands the joint's full torque, rad."""
_DAMPING = 0.05
"""Ratio of damping to stiffness, s."""


def fill(draft: Draft) -> None:
    """Add the graph if the robot can move freely, has the keyframe `home`, and has motors but no servos on its joints."""
    model = draft.description.mjcf
    joints = [joint for joint in draft.description.moving() if joint.mimic is None]
    if model is None or KEYFRAME not in model.keyframes or not model.free or draft.fixed_base:
        return
    motors = {actuator.joint for actuator in model.actuators if actuator.kind == "effort"}
    servos = {actuator.joint for actuator in model.actuators if actuator.kind != "effort"}
    held = [joint for joint in joints if joint.name in motors - servos]
    if not held or servos & {joint.name for joint in joints}:
        return
    coordinates = model.keyframes[KEYFRAME].coordinates
    torque = min((joint.effort for joint in held if joint.effort), default=10.0)
    stiffness = rounded(torque / _ANGLE, 2)
    parameters = {
        "base": in_path(draft.description.root),
        "joints": [joint.name for joint in held],
        "positions": [rounded(coordinates[joint.name][0]) for joint in held],
        "stiffness": stiffness,
        "damping": rounded(_DAMPING * stiffness, 2),
    }
    comment = f"torques that hold the joints where the keyframe {KEYFRAME} has them"
    draft.sections["graphs"][GRAPH] = Entry({"use": "graphs/legs/stand.yaml", "parameters": parameters}, [comment])
    text = f"gains of the graph stand: {stiffness:g} N m/rad and {parameters['damping']:g} N m s/rad"
    draft.guessed.append(Remark(text))
