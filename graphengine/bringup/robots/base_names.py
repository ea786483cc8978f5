"""The names of a base's joints, dimensions and limits in controllers of ros2_control and in drive plugins of Gazebo."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

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


_LIMITS = {
    "speed": "linear.x.max_velocity",
    "turn": "angular.z.max_velocity",
    "acceleration": "linear.x.max_acceleration",
}
_MORE_LIMITS = {
    "deceleration": "linear.x.max_deceleration linear.x.max_acceleration",
    "turn_acceleration": "angular.z.max_acceleration",
}
_WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
_STEERED = BaseNames(
    "ackermann",
    driven=("traction_joints_names", "rear_wheels_names"),
    steering=("steering_joints_names", "front_wheels_names"),
    radius="traction_wheels_radius rear_wheels_radius",
    track="traction_track_width rear_wheel_track wheel_track",
    wheelbase="wheelbase",
    parameters={"timeout": "reference_timeout"},
)
REAR_STEERED = {"rear_wheels_names": "front_wheels_names", "front_wheels_names": "rear_wheels_names"}
"""Names that a controller exchanges if its parameter `front_steering` is false."""
MILLISECONDS = "TricycleController"
"""The controller that has its timeout in ms, not in s."""
CONTROLLERS = {
    "DiffDriveController": BaseNames(
        "differential",
        driven=("left_wheel_names right_wheel_names", "left_wheel right_wheel"),
        factor="left_wheel_radius_multiplier",
        track="wheel_separation",
        multiplier="wheel_separation_multiplier",
        parameters=_LIMITS | _MORE_LIMITS,
    ),
    "MecanumDriveController": BaseNames(
        "mecanum",
        driven=(
            " ".join(f"{wheel}_wheel_{kind}" for kind in ("command_joint_name", "name", "joint") for wheel in _WHEELS),
            "command_joint_names wheel_names",
        ),
        radius="kinematics.wheels_radius wheel_radius wheels_radius",
        factor="wheel_radius_multiplier",
        parameters=_LIMITS,
    ),
    "OmniWheelDriveController": BaseNames("omni", driven=("wheel_names",)),
    "AckermannSteeringController": _STEERED,
    "BicycleSteeringController": _STEERED,
    "TricycleSteeringController": _STEERED,
    MILLISECONDS: BaseNames(
        "ackermann",
        driven=("traction_joint_name",),
        steering=("steering_joint_name",),
        wheelbase="wheelbase",
        parameters={
            "steering_limit": "steering.max_position",
            "steering_speed": "steering.max_velocity",
            "wheel_speed": "traction.max_velocity",
        },
    ),
}
"""Names of parameters by the last part of a controller's type."""
_RADIUS, _DIAMETER = "wheel_radius wheelRadius", "wheel_diameter wheelDiameter"
_ACCELERATION = "max_linear_acceleration max_acceleration max_wheel_acceleration wheelAcceleration"
"""Tags of the acceleration, m/s2; the last two are those of Gazebo classic, where it is that of the rim of a wheel."""
PLUGINS = {
    "diff[-_]?drive|skid_steer_drive|skidsteerdrive": BaseNames(
        "differential",
        driven=(
            "left_joint leftJoint right_joint rightJoint",
            "leftFrontJoint rightFrontJoint leftRearJoint rightRearJoint left_front right_front left_rear right_rear",
        ),
        radius=_RADIUS,
        diameter=_DIAMETER,
        track="wheel_separation wheelSeparation",
        parameters={
            "speed": "max_linear_velocity max_velocity",
            "turn": "max_angular_velocity",
            "acceleration": _ACCELERATION,
            "deceleration": _ACCELERATION,
            "turn_acceleration": "max_angular_acceleration",
        },
    ),
    "mecanum-?drive": BaseNames(
        "mecanum",
        driven=("front_left_joint front_right_joint back_left_joint back_right_joint",),
        radius=_RADIUS,
        diameter=_DIAMETER,
        parameters={"speed": "max_velocity", "acceleration": "max_acceleration"},
    ),
    "ackermann": BaseNames(
        "ackermann",
        driven=("left_joint right_joint", "rear_left_joint rear_right_joint"),
        steering=("left_steering_joint right_steering_joint",),
        radius=_RADIUS,
        diameter=_DIAMETER,
        track="wheel_separation",
        wheelbase="wheel_base",
        parameters={"steering_limit": "steering_limit max_steer", "acceleration": "max_acceleration"},
    ),
}
"""Names of tags, by a pattern of a plugin's file name or name in lower case."""
