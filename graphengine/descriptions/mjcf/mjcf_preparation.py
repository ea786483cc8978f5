"""Prepares a MuJoCo model for compilation as a robot: names its parts and sets the options of a scene."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.descriptions.engine import all_bodies, mujoco


def prepare(spec: mujoco.MjSpec) -> None:
    """Prepare a model for compilation as a robot: name all bodies, joints and actuators, and keep MuJoCo from merging bodies.

    A joint is named after the body that it moves, an actuator after its joint, tendon, site or body. The model gets the options
    of a scene with the default rates, because the compiler simulates muscles with these options.
    """
    name_bodies(spec)
    _name(spec.joints, [f"{joint.parent.name}_joint" for joint in spec.joints])
    _name(spec.actuators, [f"{actuator.target}_actuator" for actuator in spec.actuators])
    spec.compiler.fusestatic = False  # keep bodies without a joint as links
    spec.option = mujoco.MjSpec().option
    spec.option.timestep, spec.option.integrator = 1 / 240, mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.compiler.usethread = False  # a compiler thread that fails never ends


def name_bodies(spec: mujoco.MjSpec) -> None:
    """Name each body without a name `body_INDEX`."""
    for index, body in enumerate(all_bodies(spec)):
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
