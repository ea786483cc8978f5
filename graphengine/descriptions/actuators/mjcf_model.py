"""The MuJoCo model of a robot, with the actuators and keyframes that a URDF description cannot contain."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from graphengine.descriptions.actuators.mjcf_actuators import Actuator
from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files.xml import Element


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A state in which a robot can start.

    Attributes:
        coordinates: coordinates of each joint, by joint name: one value (rad or m); for a ball joint, a quaternion
            (w, x, y, z); for a free joint, position (x, y, z in m) and quaternion in the model's frame.
        controls: control signals by actuator name; empty if the keyframe has none.
    """

    coordinates: Mapping[str, tuple[float, ...]]
    controls: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class MjcfModel:
    """The MuJoCo model of a robot that MJCF describes.

    Attributes:
        spec: the model; all its bodies, joints and actuators have names. A world attaches copies of it.
        element: root element of the model's XML, with includes inserted.
        free: whether the root link moves freely.
        actuators: actuators in order of the model.
        keyframes: keyframes by name.
    """

    spec: mujoco.MjSpec
    element: Element
    free: bool
    actuators: Sequence[Actuator]
    keyframes: Mapping[str, Keyframe]


def read_keyframes(spec: mujoco.MjSpec, model: mujoco.MjModel) -> dict[str, Keyframe]:
    """Return a dict from names to the keyframes of a model; a keyframe without a name gets the name `key_INDEX`.

    Args:
        spec: model that contains the keyframes.
        model: the same model, compiled.
    """
    found: dict[str, Keyframe] = {}
    for index, key in enumerate(spec.keys):
        ends = [*model.jnt_qposadr.tolist(), model.nq]
        coordinates = {
            model.joint(joint).name: tuple(model.key_qpos[index, begin:end].tolist())
            for joint, (begin, end) in enumerate(itertools.pairwise(ends))
        }
        given = len(key.ctrl) > 0
        controls = {model.actuator(i).name: float(model.key_ctrl[index, i]) for i in range(model.nu)} if given else {}
        found[key.name or f"key_{index}"] = Keyframe(coordinates, controls)
    return found
