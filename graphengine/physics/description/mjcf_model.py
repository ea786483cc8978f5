"""A robot's MuJoCo model: its actuators and keyframes, which links and joints of a description do not contain."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from graphengine.physics.description.mjcf_actuators import Actuator
from graphengine.physics.engine import mujoco
from graphengine.physics.files.xml import Element


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A state in which a robot can start.

    Attributes:
        coordinates: of each joint, by name: rad or m, a quaternion (w, x, y, z), or a position (m) and a quaternion in the
            model's frame.
        controls: control signals by actuator; empty if the keyframe has none.
    """

    coordinates: Mapping[str, tuple[float, ...]]
    controls: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class MjcfModel:
    """A MuJoCo model that is a robot's description.

    Attributes:
        spec: the model, in which all bodies, joints and actuators have names; a world attaches copies of it.
        element: root of its XML, with includes inserted.
        free: whether its root link moves freely.
        floating: joints of several coordinates, which graphs cannot read or command.
        actuators: in order of the model.
        keyframes: by name.
    """

    spec: mujoco.MjSpec
    element: Element
    free: bool
    floating: Sequence[str]
    actuators: Sequence[Actuator]
    keyframes: Mapping[str, Keyframe]


def read_keyframes(spec: mujoco.MjSpec, model: mujoco.MjModel) -> dict[str, Keyframe]:
    """Return the keyframes of a model by name, as it was compiled."""
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
