"""The drives of a robot's joints."""

from __future__ import annotations

from graphengine.physics.description.urdf import UrdfJoint
from graphengine.physics.importing.draft import Draft

WHEEL_DAMPING = 50.0
"""Of the velocity drive that a wheel gets, N m s/rad: it keeps within 0.02 % of its target."""


def fill(draft: Draft) -> None:
    """Give wheels a velocity drive; other joints get none, and a comment on how to hold them."""
    moving = draft.urdf.moving()
    rolling = {wheel.joint: wheel.radius for wheel in draft.wheels.values() if not wheel.swivels}
    if not draft.wheels:
        rolling = {wheel.joint: wheel.radius for wheel in draft.urdf.wheels(moving)}
    for joint in moving:
        entry = draft.entry("joints", joint.name)
        if joint.name in rolling:
            radius = rolling[joint.name]
            entry.comments.append(
                f"a wheel of radius {radius:g} m; its velocity drive follows what a controller commands"
            )
            entry.value["drive"] = {"damping": WHEEL_DAMPING}
        elif joint.name in draft.wheels:
            entry.comments.append("a caster's wheel, which turns freely")
        elif joint.mimic is None:
            entry.hint = f"to hold it, e.g. {{drive: {_servo(joint)}}}"


def _servo(joint: UrdfJoint) -> str:
    """Gains by which the full effort answers to 0.1 rad, or 10 mm; critically damped they are not, but calm."""
    stiffness = (joint.effort or 10.0) / (0.01 if joint.type == "prismatic" else 0.1)
    return f"{{stiffness: {_rounded(stiffness)}, damping: {_rounded(stiffness / 10)}}}"


def _rounded(number: float) -> str:
    """A number with three digits."""
    return f"{float(f'{number:.3g}'):.10g}"
