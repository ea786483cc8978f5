"""Converts Gazebo receivers for satellite navigation to sensor profiles."""

from __future__ import annotations

from typing import Any

from graphengine.bringup.robots.gazebo_values import Figures, Subject, Values, noise, rate


def navsat(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a receiver for satellite navigation."""
    profile: dict[str, Any] = {"rate": rate(values, 5.0, sensor)}
    for axis in ("horizontal", "vertical"):
        if deviation := noise(values, sensor, ("navsat|gps", "position_sensing", axis, "noise")):
            profile[f"{axis}_noise"] = deviation
    return Figures("navsat", "navsat", profile, "navsat receiver")
