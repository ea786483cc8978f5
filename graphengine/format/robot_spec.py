"""The pydantic models of a robot file: description, changes to its joints and links, materials, frames, sensors, graphs."""

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
    """A joint's drive with gains in SI units, in which angles are radians."""

    damping: Gain = 0.0
    """Damping of the drive, N m s/rad or N s/m."""
    stiffness: Gain = 0.0
    """Stiffness of the drive, N m/rad or N/m."""
    target_velocity: Speed = 0.0
    """Target velocity until the first command to the joint, rad/s or m/s."""
    max_force: Positive | None = None
    """Limit of the drive's torque or force, N m or N; default: the description's effort."""
    max_acceleration: Positive | None = None
    """Maximum rate of change of the velocity set point, rad/s2 or m/s2; default: no limit."""
    max_velocity: Positive | None = None
    """Maximum velocity set point, and maximum rate of change of the position set point, rad/s or m/s; default: no limit."""
    overtravel: NotNegative = 0.0
    """Distance by which position targets can exceed both ends of the joint's range, rad or m; lets a gripper press at an end."""
    interpolate: bool = False
    """If true, the set points move to new targets at a constant rate over one tick, as in servo drives; if false, they jump."""
    gravity_compensation: bool = False
    """If true, the drive adds the effort that carries the weight of all links beyond its joint."""


class UsdDriveSpec(FileSpec):
    """A joint's drive with gains in the units of USD, in which angles are degrees."""

    damping: Gain = 0.0
    """Damping of the drive, N m s/deg or N s/m."""
    stiffness: Gain = 0.0
    """Stiffness of the drive, N m/deg or N/m."""
    target_velocity: Speed = 0.0
    """Target velocity until the first command to the joint, deg/s or m/s."""
    max_force: Positive | None = None
    """Limit of the drive's torque or force, N m or N; default: the description's effort."""
    overtravel: NotNegative = 0.0
    """Distance by which position targets can exceed both ends of the joint's range, deg or m; lets a gripper press at an end."""


class SpringSpec(FileSpec):
    """A passive spring at a joint."""

    stiffness: Gain
    """Stiffness of the spring, N m/rad or N/m."""
    rest: Speed = 0.0
    """Position of the joint at which the spring exerts no force, rad or m."""


class JointSpec(FileSpec):
    """Changes to a joint of the robot description."""

    enabled: bool = True
    """If false, the joint is removed; see `weld`."""
    weld: bool = False
    """If true and the joint is disabled, its child link is welded to its parent link, so that the child does not fall off."""
    position: Vector | None = None
    """Origin of the joint in the frame of its parent link, m; overrides the description."""
    drive: DriveSpec | None = None
    """Drive of the joint, with gains in SI units."""
    usd_drive: UsdDriveSpec | None = None
    """Drive of the joint, with gains in the units of USD, instead of `drive`."""
    armature: NotNegative = 0.0
    """Inertia of the rotor, reflected through the gear to the joint, kg m2 or kg."""
    start: Speed | None = None
    """Position of the joint at the start and after a reset, rad or m; also the first target of a position drive."""
    limits: Pair | None = None
    """Lowest and highest position of the joint, rad or m; overrides the description."""
    spring: SpringSpec | None = None
    """Passive spring at the joint."""

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
    """Red, green and blue from 0 to 1, for visuals that have no colour in the description or in their mesh."""


class WheelColliderSpec(FileSpec):
    """A collider centred on the axis of a wheel's joint; it replaces all colliders of the wheel's link."""

    shape: Literal["ellipsoid", "cylinder"] = "ellipsoid"
    """Shape of the collider: an ellipsoid touches the floor at one point, a cylinder along its width."""
    radius: Positive
    """Radius of the wheel, m."""
    width: Positive
    """Width of the wheel, m."""
    offset: float = 0.0
    """Position of the wheel's middle along the joint's axis, relative to the joint, m."""


class MaterialSpec(FileSpec):
    """A physics material: the friction of the colliders to which it is bound."""

    static_friction: NotNegative = 0.5
    """No effect: MuJoCo has one friction coefficient, which is `dynamic_friction`."""
    dynamic_friction: NotNegative = 0.5
    """Friction coefficient; with `across`, only along `direction`."""
    restitution: float = Field(default=0.0, ge=0, le=1)
    """No effect: MuJoCo's contacts have no restitution."""
    combine: Literal["average", "min", "multiply", "max"] = "average"
    """Rule that computes the friction of a contact from this friction and that of the floor, as in PhysX."""
    across: NotNegative | None = None
    """Friction coefficient across `direction`; `dynamic_friction` then acts along it. Default: equal in all directions."""
    direction: Direction | None = None
    """Direction along which `dynamic_friction` acts at the point of contact, as a vector in the frame of `expressed_in`."""
    expressed_in: str = ""
    """Link in whose frame `direction` is given; default: the parent link of the wheel's joint."""
    steady_sliding: bool = False
    """Whether the colliders keep their load while they slide, as skid-steered wheels must. If false, a collider that slides with
    much friction loses contact with the floor again and again, which changes turn rates by up to a tenth. Needs `across`."""
    bind: tuple[str, ...] = Field(default=(), strict=False)
    """Links whose colliders have this material."""

    @model_validator(mode="after")
    def _two_directions(self) -> MaterialSpec:
        if (self.across is None) != (self.direction is None):
            raise ValueError("friction in two directions needs both `across` and `direction`")
        if self.expressed_in and self.direction is None:
            raise ValueError("`expressed_in` is the frame of `direction`; give a `direction` too")
        if self.steady_sliding and self.direction is None:
            remedy = "for equal friction, repeat `dynamic_friction`"
            raise ValueError(f"`steady_sliding` needs `across` and `direction`; {remedy}")
        return self


class FrameSpec(FileSpec):
    """A frame that is added to the robot: an Xform prim without geometry."""

    parent: str
    """Path of the parent prim, relative to the robot's prim."""
    position: Vector = (0.0, 0.0, 0.0)
    """Position in the frame of the parent, m."""
    orientation: Orientation = UPRIGHT
    """Orientation in the frame of the parent."""


class _TypeOfSensor:
    """Pydantic type of the key `type` of a sensor: a kind of device, or a rig, which consists of several devices."""

    @staticmethod
    def __get_pydantic_core_schema__(_: Any, handler: Any) -> Any:
        return handler(Literal[(*DEVICES.all, "realsense_d455", "rig")])


def _name_or_figures(value: Any) -> Any:
    if not isinstance(value, str | dict):
        raise ValueError(f"expected the name of a profile, or a mapping with its values, got {shown(value)}")
    return value


class SensorSpec(FrameSpec, defer_build=True):
    """A sensor that is mounted on a prim of the robot."""

    type: Annotated[str, _TypeOfSensor]
    """Kind of the sensor; its profile has the section of this name, or `rig` for realsense_d455."""
    profile: Annotated[str | dict[str, Any], BeforeValidator(_name_or_figures)] = ""
    """Name of a sensor profile, such as microscan3_9m_20hz, or a mapping with its values, such as {rate: 10.0, …}."""
    noise_std: NotNegative | None = None
    """Standard deviation of the measured distances, m; default: the value of the profile."""
    sees_own_robot: bool | None = None
    """If false, rays pass through the sensor's own robot. By default, rays hit the robot, except for the sensor's own link."""
    ignores: tuple[str, ...] = Field(default=(), strict=False)
    """Links of the robot through which rays pass, in addition to the sensor's own link."""


class RobotSpec(FileSpec, defer_build=True):
    """A robot file: a robot description, changes to it, mounted sensors, and graphs."""

    format: Format = 1
    robot: Name
    """Name of the robot's type; the scene gives each robot its own name."""
    doc: str = ""
    """Description for readers of the file."""
    extends: str = ""
    """Robot file on which this file is based. Mappings are merged key by key; other values replace those of the base file.
    Null removes an entry of the base file, as in `graphs: {cmd_vel: null}`."""
    urdf: str = ""
    """Robot description: a URDF file, or a .xacro or .sdf file, which is converted to URDF."""
    mjcf: str = ""
    """MuJoCo model (MJCF) of the robot, instead of `urdf`. The model is used unchanged; its actuators are the robot's drives."""
    usd: str = ""
    """USD stage with the robot, instead of `urdf`. Needs usd-core."""
    usd_robot: str = ""
    """Path or name of the robot's prim, for a stage with several robots."""
    usd_variants: dict[str, str] = {}
    """Variants to select in the stage, as SET: NAME for all prims, or "PRIM:SET": NAME."""
    usd_assets: tuple[str, ...] = Field(default=(), strict=False)
    """Folders with copies of assets that the stage refers to on a server; the end of the asset's path is looked up there."""
    usd_replace: dict[str, str] = {}
    """Files in place of references of the stage, by reference."""
    start: str = ""
    """Keyframe of the MuJoCo model in which the robot starts."""
    xacro_arguments: dict[str, str | bool | int | float] = {}
    """Values of the xacro file's arguments by name, as in `xacro file name:=value`."""
    package_paths: tuple[str, ...] = Field(default=(), strict=False)
    """Folders of ROS packages, or folders that contain packages, for references with package:// and $(find …)."""
    base_link: str = "base_link"
    """Root link of the robot, which moves freely in the world unless `fixed_base` is true."""
    fixed_base: bool = False
    """If true, the root link is fixed to the world, as for an arm; a root link named `world` is always fixed."""
    articulation_root: str = ""
    """Link whose prim can stand for the robot in graphs, like the robot's prim and base link; default: the freely moving link."""
    self_collision: bool = False
    """If true, the robot's links collide with each other, except links that a joint connects."""
    links: dict[str, LinkSpec] = {}
    """Changes to links, by link name."""
    joints: dict[str, JointSpec] = {}
    """Changes to joints, by joint name."""
    keep_only_joints: tuple[str, ...] = Field(default=(), strict=False)
    """Joints to keep; if the list is not empty, every other joint of the description is disabled."""
    wheel_colliders: dict[str, Literal["as_urdf", "ellipsoid"] | WheelColliderSpec] = {}
    """Colliders of wheels, by link: `ellipsoid` replaces a cylinder, {radius: …, width: …} replaces all, `as_urdf` keeps all."""
    materials: dict[Name, MaterialSpec] = {}
    """Physics materials, as name: {dynamic_friction: 0.8, bind: [left_wheel]}."""
    frames: dict[Name, FrameSpec] = {}
    """Frames to add to the robot, as name: {parent: base_link, position: [0, 0, 0]}."""
    sensors: dict[Name, SensorSpec] = {}
    """Sensors to mount, as name: {type: lidar, profile: microscan3_9m_20hz, parent: base_link}."""
    namespaces: dict[str, Namespace] = {}
    """ROS 2 namespaces (`isaac:namespace`) of prims, by prim path relative to the robot's prim."""
    name_overrides: dict[str, str] = {}
    """Frame names in TF (`isaac:nameOverride`) of prims, by prim path relative to the robot's prim."""
    graphs: dict[Name, GraphUse] = {}
    """Graphs that each robot of this type runs, as name: {use: graphs/dd100/cmd_vel.yaml}."""
