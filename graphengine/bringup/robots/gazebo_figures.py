"""Result type of sensor conversions from Gazebo, and functions that read rates and noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graphengine.bringup.robots.gazebo_values import Subject, Values
from graphengine.format.wording import printable


@dataclass(frozen=True, slots=True)
class Figures:
    """The conversion of a Gazebo sensor for a robot file.

    Attributes:
        type: type of the sensor in the robot file, such as `lidar`.
        graph: name of the graph in `graphs/publishers` that publishes the sensor.
        profile: profile of the sensor in the robot file.
        told: short summary of the profile, for remarks.
        turned: whether the orientation of the sensor has an effect; otherwise it becomes that of its link.
    """

    type: str
    graph: str
    profile: dict[str, Any]
    told: str
    turned: bool = True


def rate(values: Values, default: float, sensor: Subject) -> float:
    """Return the rate (Hz) of a sensor; if the description gives no rate, return `default` and add a remark."""
    rate = values.number("update_rate") or values.number("plugin", "updateRate|update_rate")
    if rate > 0.0:
        return rate
    sensor.guessed(f"no update_rate: {default:g} Hz")
    return default


def noise(values: Values, sensor: Subject, *paths: tuple[str, ...]) -> float:
    """Return the standard deviation of the noise at the first of these paths that exists, in units of the measured value.

    Without noise, return that of a ROS 1 plugin, or 0. Noise that a profile cannot express is reported as lost.
    """
    for path in paths:
        if (found := values.find(*path)) is None:
            continue
        kind = found.get("type") or values.text(*path, "type") or "none"
        mean, deviation = values.number(*path, "mean"), values.number(*path, "stddev")
        if kind == "none" or not (mean or deviation):
            return 0.0
        if not kind.startswith("gaussian"):
            sensor.lost(f"noise of type {printable(kind[:40])!r}", found.span)
            return 0.0
        if mean:
            sensor.lost(f"mean {mean:g} of its noise; the profile has the standard deviation alone", found.span)
        return deviation
    return values.number("plugin", "gaussianNoise")
