"""The names of a base's joints, dimensions and limits in controllers of ros2_control and in drive plugins of Gazebo."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.bringup.robots.base import Base, Kinematics, given


@dataclass(frozen=True, slots=True)
class BaseNames:
    """The names under which one kind of controller or plugin gives the properties of a base.

    A text lists alternatives, separated by spaces; the first one with a value counts.

    Attributes:
        kinematics: kinematics of the base.
        driven: groups of names for the joints of driven wheels; all joints of the first group with any joint count.
        steering: groups of names for the joints that take steering commands.
        radius: names for the radius of the wheels.
        diameter: names for the diameter of the wheels, for sources without a radius.
        factor: names for a factor of the radius.
        track: names for the distance between left and right wheels.
        multiplier: names for a factor of the track.
        wheelbase: names for the distance between front and rear axle.
        parameters: names for each parameter of the base's graph.
    """

    kinematics: Kinematics
    driven: tuple[str, ...]
    steering: tuple[str, ...] = ()
    radius: str = "wheel_radius"
    diameter: str = ""
    factor: str = ""
    track: str = ""
    multiplier: str = ""
    wheelbase: str = ""
    parameters: Mapping[str, str] = field(default_factory=dict)

    def read(self, joints: Callable[..., tuple[str, ...]], positive: Callable[..., float | None]) -> Base:
        """Return the base.

        Args:
            joints: returns all joints under the given names.
            positive: returns the first positive number under the given names; None if there is none.
        """
        radius, diameter = positive(*self.radius.split()), positive(*self.diameter.split())
        radius = diameter / 2.0 if radius is None and diameter is not None else radius
        factor = positive(*self.factor.split()) or 1.0
        return Base(
            self.kinematics,
            next(filter(None, (joints(*names.split()) for names in self.driven)), ()),
            next(filter(None, (joints(*names.split()) for names in self.steering)), ()),
            radius=radius * factor if radius is not None else None,
            track=positive(*self.track.split()),
            wheelbase=positive(*self.wheelbase.split()),
            multiplier=positive(*self.multiplier.split()) or 1.0,
            parameters=given(**{name: positive(*names.split()) for name, names in self.parameters.items()}),
        )


_TABLES = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
CONTROLLERS = {kind: BaseNames(**names) for kind, names in _TABLES["controllers"].items()}
"""Names of parameters by the last part of a controller's type."""
PLUGINS = {pattern: BaseNames(**names) for pattern, names in _TABLES["plugins"].items()}
"""Names of tags, by a pattern of a plugin's file name or name in lower case.

The accelerations `max_wheel_acceleration` and `wheelAcceleration` of Gazebo classic are those of the rim of a wheel, in m/s2.
"""
REAR_STEERED = {"rear_wheels_names": "front_wheels_names", "front_wheels_names": "rear_wheels_names"}
"""Names that a controller exchanges if its parameter `front_steering` is false."""
MILLISECONDS = "TricycleController"
"""The controller that has its timeout in ms, not in s."""
