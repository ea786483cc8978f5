"""What drives a robot's base: its kinematics, its joints, its measures and its topics.

A parameter file of ros2_control decides, else a plugin of Gazebo, else the wheels on the floor. What the first of these leaves
open is measured on the description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from graphengine.devices.rotation import Vector3
from graphengine.format.diagnostics import Span
from graphengine.format.wording import did_you_mean, printable
from graphengine.physics.description.urdf import UrdfJoint
from graphengine.physics.importing.base_wheels import BaseWheel
from graphengine.physics.importing.draft import Draft

Kinematics = Literal["differential", "mecanum", "omni", "ackermann"]


@dataclass(frozen=True, slots=True)
class Base:
    """A base as one source describes it.

    Attributes:
        kinematics: which graph drives it; skid-steer is differential.
        source: what says so, for people.
        span: its place.
        driven: joints of the wheels that are commanded.
        steering: joints that are commanded to steer.
        radius: of a driven wheel, m; None if the source does not say.
        track: between left and right wheels, m.
        wheelbase: between front and back wheels, m.
        multiplier: of the track, by which a skid-steered base counts as wider.
        parameters: further parameters of the graph: limits, topics and frames.
        guessed: whether nothing but the wheels says so.
    """

    kinematics: Kinematics
    source: str
    span: Span | None
    driven: tuple[str, ...]
    steering: tuple[str, ...] = ()
    radius: float | None = None
    track: float | None = None
    wheelbase: float | None = None
    multiplier: float = 1.0
    parameters: dict[str, float | str] = field(default_factory=dict)
    guessed: bool = False

    def with_parameters(self, parameters: dict[str, float | str]) -> Base:
        """Return the base with further parameters, which replace its own."""
        return replace(self, parameters=self.parameters | parameters)


def flaw(draft: Draft, base: Base) -> str:
    """Return why the joints that a source names cannot drive a base; empty if they can."""
    joints = draft.urdf.joints
    for name in (*base.driven, *base.steering):
        if name not in joints:
            near = did_you_mean(name, joints)
            return f"the description has no joint {printable(name)!r}" + (f"; {near}" if near else "")
        if not joints[name].moves:
            return f"joint {printable(name)!r} is fixed"
    return "" if base.driven else "it names no wheels"


def given(**parameters: float | str | None) -> dict[str, float | str]:
    """Return the parameters that are not None."""
    return {name: value for name, value in parameters.items() if value is not None}


@dataclass(frozen=True, slots=True)
class Drivetrain:
    """A base, measured on the description.

    Attributes:
        base: as its source describes it.
        wheels: that are driven, in the order of the graph's joints.
        steering: joints that are commanded to steer, left ones first.
        parameters: of its graph.
        grip: for the link of each wheel that slides sideways, the direction in the root link along which it grips.
        across: friction across that direction.
    """

    base: Base
    wheels: tuple[BaseWheel, ...]
    steering: tuple[UrdfJoint, ...]
    parameters: dict[str, Any]
    grip: Mapping[str, Vector3] = field(default_factory=dict)
    across: float = 0.0
