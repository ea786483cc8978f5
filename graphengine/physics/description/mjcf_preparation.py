"""Prepares a MuJoCo model for being compiled as a robot: names for its parts, and options as those of a scene."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.physics.engine import mujoco


def prepare(spec: mujoco.MjSpec) -> None:
    """Make a model ready to be compiled as a robot: all bodies, joints and actuators have names, and no body vanishes.

    A joint is named after the body that it moves, an actuator after what it acts on. Options are those of a scene with the
    default rates, as the compiler simulates muscles by them.
    """
    name_bodies(spec)
    _name(spec.joints, [f"{joint.parent.name}_joint" for joint in spec.joints])
    _name(spec.actuators, [f"{actuator.target}_actuator" for actuator in spec.actuators])
    spec.compiler.fusestatic = False  # links without a joint are links, too
    spec.option = mujoco.MjSpec().option
    spec.option.timestep, spec.option.integrator = 1 / 240, mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.compiler.usethread = False  # a thread of the compiler that fails never ends


def name_bodies(spec: mujoco.MjSpec) -> None:
    """Name bodies that have no name by their numbers."""
    for index, body in enumerate(spec.bodies):
        if not body.name:
            body.name = f"body_{index}"


def _name(parts: Iterable[mujoco.MjsJoint | mujoco.MjsActuator], names: Iterable[str]) -> None:
    parts = list(parts)
    taken = {part.name for part in parts}
    for part, name in zip(parts, names, strict=True):
        if not part.name:
            number, free = 2, name
            while free in taken:
                number, free = number + 1, f"{name}_{number}"
            taken.add(free)
            part.name = free
