"""The spec of a robot file: a description, changes to its joints and links, materials, frames, sensors and graphs."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from graphengine.format.kinds import DEVICES
from graphengine.format.legal_names import Name, Namespace
from graphengine.format.spec import (
    UPRIGHT,
    Direction,
    FileSpec,
    Format,
    Gain,
    GraphUse,
    NotNegative,
    Orientation,
    Pair,
    Positive,
    Speed,
    Vector,
)
from graphengine.format.wording import shown


class DriveSpec(FileSpec):
    """A joint's drive in SI units."""

    damping: Gain = 0.0
    """Damping of the drive, N m s/rad, or N s/m."""
    stiffness: Gain = 0.0
    """Stiffness of the drive, N m/rad, or N/m."""
    target_velocity: Speed = 0.0
    """Target velocity until the first command to the joint, rad/s or m/s."""
    max_force: Positive | None = None
    """Limit of the drive's torque or force, N m or N; default: the description's effort."""
    max_acceleration: Positive | None = None
    """Maximum rate of change of the velocity set point, rad/s2 or m/s2."""
    max_velocity: Positive | None = None
    """Maximum of the velocity set point, and maximum rate of change of the position set point, rad/s or m/s."""
    interpolate: bool = False
    """Move the set points evenly to new targets over a tick, as servo drives do; default: at the tick's beginning."""
    gravity_compensation: bool = False
    """Carry the weight of all links beyond the joint, as part of the drive's effort."""


class UsdDriveSpec(FileSpec):
    """A joint's drive in USD's units: angles in degrees."""

    damping: Gain = 0.0
    """Damping of the drive, N m s/deg."""
    stiffness: Gain = 0.0
    """Stiffness of the drive, N m/deg."""
    target_velocity: Speed = 0.0
    """Target velocity until the first command to the joint, deg/s or m/s."""
    max_force: Positive | None = None
    """Limit of the drive's torque or force, N m or N; default: the description's effort."""


class SpringSpec(FileSpec):
    """A passive spring at a joint."""

    stiffness: Gain
    """Stiffness of the spring, N m/rad, or N/m."""
    rest: Speed = 0.0
    """Position of the joint at which the spring exerts no force, rad or m."""


class JointSpec(FileSpec):
    """Changes to a joint of the robot description."""

    enabled: bool = True
    weld: bool = False
    """Weld the child link of a disabled joint to the parent link, so that it does not fall off."""
    position: Vector | None = None
    """Origin of the joint in its parent link, m; overrides the description."""
    drive: DriveSpec | None = None
    usd_drive: UsdDriveSpec | None = None
    armature: NotNegative = 0.0
    """Rotor inertia as it acts at the joint, kg m2, or kg."""
    start: Speed | None = None
    """Position at the start and after a reset, rad or m, and first target of a position drive."""
    limits: Pair | None = None
    """Lowest and highest position, rad or m, instead of the description's."""
    spring: SpringSpec | None = None

    @model_validator(mode="after")
    def _one_drive(self) -> JointSpec:
        if self.drive and self.usd_drive:
            raise ValueError("a joint has a `drive` or a `usd_drive`, not both")
        if self.limits and self.limits[0] >= self.limits[1]:
            raise ValueError("limits must be [lowest, highest], with the lowest below the highest")
        return self


Share = Annotated[float, Field(ge=0.0, le=1.0)]


class LinkSpec(FileSpec):
    """Changes to a link of the robot description."""

    gravity: bool = True
    """Whether gravity acts on the link's mass."""
    colour: Annotated[tuple[Share, Share, Share], Field(strict=False)] | None = None
    """Red, green and blue, 0 to 1, of visuals whose colour neither the description nor their mesh gives."""


class WheelColliderSpec(FileSpec):
    """A collider about the axis of a wheel's joint, in place of all colliders of its link."""

    shape: Literal["ellipsoid", "cylinder"] = "ellipsoid"
    """An ellipsoid touches the floor at one point, a cylinder along its width."""
    radius: Positive
    """Radius of the wheel, m."""
    width: Positive
    """Width of the wheel, m."""
    offset: float = 0.0
    """Distance of the wheel's middle from the joint along the joint's axis, m."""


class MaterialSpec(FileSpec):
    """A physics material."""

    static_friction: NotNegative = 0.5
    """No effect: MuJoCo has one friction coefficient, which is `dynamic_friction`."""
    dynamic_friction: NotNegative = 0.5
    restitution: float = Field(default=0.0, ge=0, le=1)
    """No effect: MuJoCo's contacts have no restitution."""
    combine: Literal["average", "min", "multiply", "max"] = "average"
    """How this friction is combined with the floor's, at build and whenever a graph writes the friction."""
    across: NotNegative | None = None
    """Friction across `direction`, where `dynamic_friction` acts along it; default: the same in all directions."""
    direction: Direction | None = None
    """Direction of `dynamic_friction` at the point of contact, in the frame of `expressed_in`."""
    expressed_in: str = ""
    """Link whose frame `direction` is given in; default: the link that the wheel turns in."""
    bind: tuple[str, ...] = Field(default=(), strict=False)
    """Links whose colliders have this material."""

    @model_validator(mode="after")
    def _two_directions(self) -> MaterialSpec:
        if (self.across is None) != (self.direction is None):
            raise ValueError("friction in two directions needs both `across` and `direction`")
        if self.expressed_in and self.direction is None:
            raise ValueError("`expressed_in` needs a `direction`, whose frame it names")
        return self


class FrameSpec(FileSpec):
    """A frame: an Xform prim without geometry."""

    parent: str
    """Path of the parent prim, relative to the robot."""
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT


class _TypeOfSensor:
    """A value of `type` in `sensors`: a kind of device, or a rig of several devices."""

    @staticmethod
    def __get_pydantic_core_schema__(_: Any, handler: Any) -> Any:
        return handler(Literal[(*DEVICES.all, "realsense_d455", "rig")])


def _name_or_figures(value: Any) -> Any:
    if not isinstance(value, str | dict):
        raise ValueError(f"expected the name of a profile, or a mapping with its values, got {shown(value)}")
    return value


class SensorSpec(FrameSpec, defer_build=True):
    """A sensor on a link."""

    type: Annotated[str, _TypeOfSensor]
    profile: Annotated[str | dict[str, Any], BeforeValidator(_name_or_figures)] = ""
    """Name of a sensor profile, such as microscan3_9m_20hz, or its figures, such as {rate: 10.0, …} of an imu."""
    noise_std: NotNegative | None = None
    """Standard deviation of measured distances, m; default: that of the profile."""


class RobotSpec(FileSpec, defer_build=True):
    """A robot file: a description, changes to it, mounted sensors, and graphs."""

    format: Format = 1
    robot: Name
    doc: str = ""
    extends: str = ""
    """Robot file that this file extends."""
    urdf: str = ""
    """URDF file, or a .xacro or .sdf file that becomes one."""
    mjcf: str = ""
    """MuJoCo model of the robot, in place of `urdf`: attached as it is, with its actuators as drives."""
    start: str = ""
    """Keyframe of the MuJoCo model in which the robot starts."""
    xacro_arguments: dict[str, str | bool | int | float] = {}
    """Values of the xacro file's arguments, as in `xacro file name:=value`."""
    package_paths: tuple[str, ...] = Field(default=(), strict=False)
    """ROS packages, or folders that contain them, for package:// and $(find …)."""
    base_link: str = "base_link"
    """Root link; the free joint moves it."""
    fixed_base: bool = False
    """Fix the root link to the world, as for an arm; a root link named `world` is always fixed."""
    articulation_root: str = ""
    """Link that graphs can use for the robot, besides its prim and base link; empty: the freely moving link."""
    self_collision: bool = False
    """Let the robot's links collide with each other, except those connected by a joint."""
    links: dict[str, LinkSpec] = {}
    joints: dict[str, JointSpec] = {}
    keep_only_joints: tuple[str, ...] = Field(default=(), strict=False)
    """Joints to keep; every other joint of the description is disabled."""
    wheel_colliders: dict[str, Literal["as_urdf", "ellipsoid"] | WheelColliderSpec] = {}
    """Colliders of wheels, by link name: `ellipsoid` in place of a cylinder, or {radius: …, width: …} in place of any other."""
    materials: dict[Name, MaterialSpec] = {}
    frames: dict[Name, FrameSpec] = {}
    sensors: dict[Name, SensorSpec] = {}
    namespaces: dict[str, Namespace] = {}
    """`isaac:namespace` of prims, by path relative to the robot."""
    name_overrides: dict[str, str] = {}
    """`isaac:nameOverride` of prims, by path relative to the robot."""
    graphs: dict[Name, GraphUse] = {}
