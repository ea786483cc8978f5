"""Converts Gazebo force-torque sensors to sensor profiles."""

from __future__ import annotations

from typing import Any

from graphengine.bringup.robots.gazebo_values import Figures, Subject, UnusableError, Values, noise, rate
from graphengine.format.wording import printable

_AXES = ("x", "y", "z")
_FRAMES = ("child", "parent", "sensor")
_DIRECTIONS = ("child_to_parent", "parent_to_child")


def force_torque(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a force-torque sensor; one noise for all axes, the largest of Gazebo's values.

    In Gazebo, values have the axes of the child link by default; the sensor then has the orientation of its link.
    """
    profile: dict[str, Any] = {"rate": rate(values, 60.0, sensor)}
    frame = _word(values, "frame", _FRAMES)
    if (direction := _word(values, "measure_direction", _DIRECTIONS)) != _DIRECTIONS[0]:
        profile["measure_direction"] = direction
    if frame == "parent":
        profile["axes"] = "parent"
        sensor.guessed("force and torque have the axes of the parent link; the torque is about the sensor")
    for quantity in ("force", "torque"):
        deviations = [noise(values, sensor, ("force_torque", quantity, axis, "noise")) for axis in _AXES]
        if len(set(deviations)) > 1:
            sensor.guessed(f"noise of {quantity}: the profile has one for all axes, the greatest")
        if deviation := max(deviations):
            profile[f"{quantity}_noise"] = deviation
    return Figures("force_torque", "force_torque", profile, "force-torque sensor", turned=frame == "sensor")


def _word(values: Values, tag: str, legal: tuple[str, ...]) -> str:
    """Return the word at a tag; by default, the first of the legal words.

    Raises:
        UnusableError: the word is not legal.
    """
    text, found = values.text("force_torque", tag), values.find("force_torque", tag)
    if found is not None and text and text not in legal:
        raise UnusableError(f"{tag} must be one of {', '.join(legal)}, not {printable(text[:40])!r}", found.span)
    return text or legal[0]
