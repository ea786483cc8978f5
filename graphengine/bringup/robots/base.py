"""Data model of a mobile base: kinematics, joints, dimensions and topics.

A base comes from a ros2_control parameter file, else from a Gazebo plugin, else from a guess by the wheels on the floor. Values
that the source does not give are measured on the description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import RobotWheel
from graphengine.devices.rotation import Vector3
from graphengine.format.diagnostics import Span

Kinematics = Literal["differential", "mecanum", "omni", "ackermann"]


@dataclass(frozen=True, slots=True)
class Base:
    """A mobile base, as a single source describes it.

    Attributes:
        kinematics: kinematics, which selects the graph that drives the base; a skid-steered base is differential.
        driven: joints of wheels that take velocity commands.
        steering: joints that take steering commands.
        source: name of the source, for messages.
        span: location of the source.
        radius: radius of the driven wheels, m; None if the source does not give it.
        track: distance between left and right wheels, m; None if the source does not give it.
        wheelbase: distance between front and rear axle, m; None if the source does not give it.
        multiplier: factor of the track with which controllers compensate for the slip of a skid-steered base.
        parameters: further parameters of the graph: limits, topics and frames.
        guessed: whether the base was guessed from the wheels on the floor.
    """

    kinematics: Kinematics
    driven: tuple[str, ...]
    steering: tuple[str, ...] = ()
    source: str = ""
    span: Span | None = None
    radius: float | None = None
    track: float | None = None
    wheelbase: float | None = None
    multiplier: float = 1.0
    parameters: dict[str, float | str] = field(default_factory=dict)
    guessed: bool = False

    def with_parameters(self, parameters: dict[str, float | str]) -> Base:
        """Return a copy with further parameters; they replace parameters of the same name."""
        return replace(self, parameters=self.parameters | parameters)

    def of_source(self, source: str, span: Span, general: dict[str, float | str]) -> Base:
        """Return a copy with a source, and with general parameters for which the base has none of the same name."""
        return replace(self, source=source, span=span, parameters=general | self.parameters)


def given(**parameters: float | str | None) -> dict[str, float | str]:
    """Return the parameters whose value is not None."""
    return {name: value for name, value in parameters.items() if value is not None}


@dataclass(frozen=True, slots=True)
class Grip:
    """The friction of skid-steered wheels.

    Attributes:
        along: friction coefficient along the rolling direction.
        across: friction coefficient across the rolling direction.
        reason: source of the values, as a comment for the robot file.
        described: whether the description gives the values.
        replaces_track: whether the values need another track than that of the base's controller.
    """

    along: float
    across: float
    reason: str
    described: bool = False
    replaces_track: bool = False


@dataclass(frozen=True, slots=True)
class Drivetrain:
    """A mobile base with dimensions measured on the description, for its graph.

    Attributes:
        base: the base as its source describes it.
        wheels: driven wheels, in the order of the joints in the graph.
        steering: joints that take steering commands, from left to right.
        parameters: parameters of the graph.
        grip: a dict from the links of wheels that slide in one direction to the direction of grip in the root link's frame;
            without `skid`, the friction across this direction is 0.
        skid: friction of the wheels of a skid-steered base; None for other bases.
    """

    base: Base
    wheels: tuple[RobotWheel, ...]
    steering: tuple[Joint, ...]
    parameters: dict[str, Any]
    grip: Mapping[str, Vector3] = field(default_factory=dict)
    skid: Grip | None = None

    @property
    def joints(self) -> set[str]:
        """Names of all joints of the base that take commands."""
        return {*(wheel.joint for wheel in self.wheels), *(joint.name for joint in self.steering)}
