"""Data model of a robot's base: kinematics, joints, dimensions and topics.

The source is a parameter file of ros2_control, else a plugin of Gazebo, else the wheels on the floor. Values that the source
lacks are measured on the description.
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
    """A base, described by one source.

    Attributes:
        kinematics: selects the graph that drives the base; skid-steer is differential.
        source: description of the source, for messages.
        span: location of the source.
        driven: joints of wheels that take velocity commands.
        steering: joints that take steering commands.
        radius: radius of a driven wheel, m; None if the source gives none.
        track: distance between left and right wheels, m.
        wheelbase: distance between front and back axles, m.
        multiplier: factor of the track, which makes up for the slip of a skid-steered base.
        parameters: further parameters of the graph: limits, topics and frames.
        guessed: whether the wheels on the floor are the only source.
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
        """Return a copy with further parameters; they replace those of the same name."""
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
    """Return the parameters without those that are None."""
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
