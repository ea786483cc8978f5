"""The specs of the three kinds of file: graph, scene and robot. Frozen, picklable, validated by pydantic once.

`graphrun schema` prints their JSON Schema, so editors show the descriptions of this module.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from graphengine.format.kinds import DEVICES
from graphengine.format.legal_names import Name, Namespace, NamespacePattern, PrimPath, RobotPath
from graphengine.format.wording import shown

FORMAT = 1
MAX_TICKS = 2**32 - 1
MAX_HZ = 10_000


def _name_keys(schema: dict[str, Any]) -> None:
    """Add the pattern of names to the keys in a schema, which pydantic leaves out."""
    for value in schema.get("properties", {}).values():
        for pattern, item in value.pop("patternProperties", {}).items():
            value["propertyNames"] = {**value.get("propertyNames", {}), "pattern": pattern}
            value["additionalProperties"] = item


class Spec(BaseModel):
    """Base of all specs: frozen, without unknown keys and type conversions."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, json_schema_extra=_name_keys, defer_build=True
    )


def _whole_number(value: Any) -> Any:
    if type(value) is not int:
        raise ValueError(f"expected 1, got {shown(value)}")
    return value


def _evaluator(value: Any) -> Any:
    if value in ("dirty_push", "lazy"):
        raise ValueError(
            f"{value!r} graphs are not supported; use push, which computes every node, "
            "or execution, which computes a data node when another node reads it"
        )
    return value


Pair = Annotated[tuple[float, float], Field(strict=False)]
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Connection = Annotated[str, Field(max_length=1000)]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Gain = Annotated[float, Field(ge=0, le=1e12)]
Speed = Annotated[float, Field(ge=-1e10, le=1e10)]
Format = Annotated[
    Literal[1], BeforeValidator(_whole_number), Field(description="Version of the file format; missing means 1.")
]


class FileSpec(Spec, use_attribute_docstrings=True):
    """Base of the specs of files: the docstring of a key is its description in messages and in the schema."""


class ParameterSpec(FileSpec):
    """A value that a user of the graph gives; it replaces `$(name)`."""

    type: str
    """A port type such as double, string or target."""
    default: Any = None
    doc: str = ""


class VariableSpec(FileSpec):
    """A typed variable of the graph, written and read by its nodes."""

    type: str
    default: Any = None
    doc: str = ""


class EverySpec(FileSpec):
    """How often a node is executed or an event fires: `once`, every n-th time, or at a rate."""

    once: bool = False
    """Only the first time since play."""
    ticks: int | None = Field(default=None, ge=1, le=MAX_TICKS)
    """Every n-th time, starting with the n-th."""
    hz: Positive | None = Field(default=None, le=MAX_HZ)
    """The first time at or after each k / hz seconds of simulation."""

    @model_validator(mode="before")
    @classmethod
    def _short_form(cls, data: Any) -> Any:
        if isinstance(data, str) and data != "once":
            raise ValueError(f"{data!r} is not `once`; else give {{ticks: 3}} or {{hz: 10}}")
        return {"once": True} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _one_form(self) -> EverySpec:
        if self.once + (self.ticks is not None) + (self.hz is not None) != 1:
            raise ValueError("give one of once, {ticks: 3} and {hz: 10}")
        return self


class NodeSpec(FileSpec):
    """A node: a type or a subgraph, and values of its inputs."""

    type: str = ""
    """Registered OmniGraph name, or only its last part for included types."""
    subgraph: str = ""
    """A graph file with declared inputs and outputs, in place of type."""
    parameters: dict[Name, Any] = {}
    """Values for the parameters of the subgraph."""
    inputs: dict[str, Any] = {}
    """Values by port name."""
    every: EverySpec | None = None
    """How often it is executed: once, {ticks: 3} or {hz: 10}."""
    doc: str = ""

    @model_validator(mode="before")
    @classmethod
    def _short_form(cls, data: Any) -> Any:
        return {"type": data} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _type_or_subgraph(self) -> NodeSpec:
        if not self.type and not self.subgraph:
            raise ValueError("a node needs a type, or a subgraph in its place")
        if self.type and self.subgraph:
            raise ValueError("a node has a type or a subgraph, not both")
        if self.type and self.parameters:
            raise ValueError(
                "a subgraph has parameters, a node of a type has none; values of its ports stand below `inputs:`"
            )
        if self.subgraph and self.every:
            raise ValueError("a subgraph has no `every`; give it to nodes in the subgraph's own file")
        return self


class GraphSpec(FileSpec):
    """A graph file: nodes, wires, and the graph's place in the prim tree."""

    format: Format = 1
    graph: Name
    """Name of the graph."""
    doc: str = ""
    at: PrimPath = ""
    """The graph's own prim; namespaces are collected from here."""
    parameters: dict[Name, ParameterSpec] = {}
    """Name to {type: …, default: …}."""
    runs: Literal["tick", "physics_step"] = "tick"
    """How often the graph runs."""
    evaluator: Annotated[Literal["execution", "push"], BeforeValidator(_evaluator)] = "execution"
    """`execution` runs the nodes that execution reaches, `push` runs all nodes in each pass."""
    variables: dict[Name, VariableSpec] = {}
    """Name to {type: …, default: …}."""
    nodes: dict[Name, NodeSpec] = {}
    """Name to a type, or to {type: …, inputs: {…}}."""
    connections: tuple[Connection, ...] = Field(default=(), strict=False)
    """One wire per line: Node.port -> Node.port"""
    inputs: dict[str, str] = {}
    """Ports that the graph has as a subgraph: name to Node.port."""
    outputs: dict[str, str] = {}
    """Ports that the graph has as a subgraph: name to Node.port."""
    layout: dict[Name, Pair] = {}
    """Node to [x, y], for drawings."""
    scene: str = ""
    """Scene file that `graphrun run` loads for this graph."""


class Orientation(FileSpec):
    """A rotation: about the fixed x, then y, then z axis as in URDF, or a unit quaternion with the scalar last."""

    rpy_deg: Vector | None = None
    quaternion_xyzw: Annotated[tuple[float, float, float, float], Field(strict=False)] | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Orientation:
        if (self.rpy_deg is None) == (self.quaternion_xyzw is None):
            raise ValueError("give one of rpy_deg: [roll, pitch, yaw] and quaternion_xyzw: [x, y, z, w]")
        if self.quaternion_xyzw is not None and abs(math.hypot(*self.quaternion_xyzw) - 1.0) > 0.01:
            raise ValueError("a rotation quaternion has length 1")
        return self


UPRIGHT = Orientation(rpy_deg=(0.0, 0.0, 0.0))


class GraphUse(FileSpec):
    """The use of a graph file at a prim, with values for its parameters."""

    use: str
    at: PrimPath = ""
    """Overrides the graph file's own `at`."""
    parameters: dict[Name, Any] = {}


MAX_ROBOTS = 1000


class PhysicsSpec(FileSpec):
    """The rate of ticks, and the number of physics steps in a tick."""

    tick_rate: Positive = Field(default=60.0, le=10_000)
    """Ticks of graphs and physics per second."""
    substeps: int = Field(default=4, ge=1, le=1000)
    """MuJoCo steps per tick."""


class PlaceSpec(FileSpec):
    """The pose of one robot of a fleet."""

    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT


class RobotUse(FileSpec):
    """The use of a robot file in a scene, once or as a fleet: `NAME_0000`, `NAME_0001` and so on."""

    use: str
    """Robot file, or a description alone: a file of URDF, xacro or MJCF, or the text of a URDF or MJCF."""
    at: RobotPath | None = None
    """Path of the robot's prim, as in /World/robot; default /NAME. A fleet's number is appended."""
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT
    count: int | None = Field(default=None, ge=1, le=MAX_ROBOTS)
    """Number of robots, in rows along the x axis."""
    spacing: Annotated[tuple[Positive, Positive], Field(strict=False)] | None = None
    """Distances between robots in a row, and between rows along the y axis, m."""
    per_row: int | None = Field(default=None, ge=1)
    """Robots per row; default all."""
    places: Annotated[tuple[PlaceSpec, ...], Field(strict=False, max_length=MAX_ROBOTS)] | None = None
    """Pose of each robot, relative to position and orientation; replaces count."""
    namespace: NamespacePattern | None = None
    """Replaces the robot file's namespace on its base link; {name} is the robot's name, {index:04} its number."""
    robot_state: bool = False
    """Publish the topics of robot_state_publisher."""

    @model_validator(mode="after")
    def _one_fleet(self) -> RobotUse:
        if self.count is not None and self.places is not None:
            raise ValueError("a fleet has a count or places, not both")
        if (self.count or 1) > 1 and self.spacing is None:
            raise ValueError("a fleet with a count needs a spacing: [x, y], in m")
        if self.count is None and (self.spacing or self.per_row):
            raise ValueError("spacing and per_row belong to a count")
        return self


class SceneSpec(FileSpec):
    """A scene file: a world, its robots, and graphs outside of robots."""

    format: Format = 1
    scene: Name
    doc: str = ""
    world: str
    """MJCF file of everything except the robots."""
    physics: PhysicsSpec = PhysicsSpec()
    settle: bool = False
    """Simulate until the robots are at rest before t = 0."""
    robots: dict[Name, RobotUse] = {}
    graphs: dict[Name, GraphUse] = {}
    namespaces: dict[PrimPath, Namespace] = {}
    """`isaac:namespace` by prim: of the world, a robot, a graph or a node."""


class DriveSpec(FileSpec):
    """A joint's drive in SI units."""

    damping: Gain = 0.0
    """N m s/rad, or N s/m."""
    stiffness: Gain = 0.0
    """N m/rad, or N/m."""
    target_velocity: Speed = 0.0
    """rad/s, or m/s, until the first command to the joint."""
    max_force: Positive | None = None
    """Limit of the drive's torque or force, N m or N; default: the description's effort."""
    max_acceleration: Positive | None = None
    """Limit on the slope of the velocity set point, rad/s2, or m/s2."""


class UsdDriveSpec(FileSpec):
    """A joint's drive in USD's units: angles in degrees."""

    damping: Gain = 0.0
    """N m s/deg."""
    stiffness: Gain = 0.0
    """N m/deg."""
    target_velocity: Speed = 0.0
    """deg/s, or m/s."""
    max_force: Positive | None = None
    """Limit of the drive's torque or force, N m or N; default: the description's effort."""


class JointSpec(FileSpec):
    """Changes to a joint of the robot description."""

    enabled: bool = True
    weld: bool = False
    """Weld a child that a disabled joint would let fall off."""
    position: Vector | None = None
    """Overrides the joint's origin in its parent link, m."""
    drive: DriveSpec | None = None
    usd_drive: UsdDriveSpec | None = None
    armature: NotNegative = 0.0
    """Rotor inertia seen at the joint, kg m2, or kg."""

    @model_validator(mode="after")
    def _one_drive(self) -> JointSpec:
        if self.drive and self.usd_drive:
            raise ValueError("a joint has a drive or a usd_drive, not both")
        return self


class MaterialSpec(FileSpec):
    """A physics material."""

    static_friction: NotNegative = 0.5
    """No effect if it differs: MuJoCo has one friction, which is the dynamic one."""
    dynamic_friction: NotNegative = 0.5
    restitution: float = Field(default=0.0, ge=0, le=1)
    """No effect: MuJoCo's contacts have no restitution."""
    combine: Literal["average", "min", "multiply", "max"] = "average"
    """How to combine with the floor's friction; applied at build and when a graph writes it."""
    bind: tuple[str, ...] = Field(default=(), strict=False)
    """Links whose colliders have this material."""


class FrameSpec(FileSpec):
    """An empty Xform."""

    parent: str
    """Parent prim, relative to the robot."""
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT


class _TypeOfSensor:
    """A kind of device, or a type of rig."""

    @staticmethod
    def __get_pydantic_core_schema__(_: Any, handler: Any) -> Any:
        return handler(Literal[(*DEVICES.all, "realsense_d455", "rig")])


class SensorSpec(FrameSpec, defer_build=True):
    """A sensor on a link."""

    type: Annotated[str, _TypeOfSensor]
    profile: str = ""
    """Name of a sensor profile, such as microscan3_9m_20hz."""
    noise_std: NotNegative | None = None
    """Standard deviation of measured distances, m; default is the profile's."""


class RobotSpec(FileSpec, defer_build=True):
    """A robot file: a description, changes to it, mounted sensors, and graphs."""

    format: Format = 1
    robot: Name
    doc: str = ""
    extends: str = ""
    """Robot file that this one extends."""
    urdf: str = ""
    """URDF file, or a .xacro file that expands to one."""
    xacro_arguments: dict[str, str | bool | int | float] = {}
    """Values of the xacro file's arguments, as in `xacro file name:=value`."""
    package_paths: tuple[str, ...] = Field(default=(), strict=False)
    """ROS packages, or folders that contain them, for package:// and $(find …)."""
    base_link: str = "base_link"
    """Root link; the free joint moves it."""
    fixed_base: bool = False
    """Fix the root link to the world, as for an arm; a root link named `world` is always fixed."""
    articulation_root: str = ""
    """Link that stands for the robot in graphs; empty: the freely moving link."""
    self_collision: bool = False
    """Let the robot's links collide with each other, except those connected by a joint."""
    joints: dict[str, JointSpec] = {}
    keep_only_joints: tuple[str, ...] = Field(default=(), strict=False)
    """Disables every other joint of the description."""
    wheel_colliders: dict[str, Literal["as_urdf", "ellipsoid"]] = {}
    """Wheel link to collider shape."""
    materials: dict[Name, MaterialSpec] = {}
    frames: dict[Name, FrameSpec] = {}
    sensors: dict[Name, SensorSpec] = {}
    namespaces: dict[str, Namespace] = {}
    """`isaac:namespace` by prim, relative to the robot."""
    name_overrides: dict[str, str] = {}
    """`isaac:nameOverride` by prim, relative to the robot."""
    graphs: dict[Name, GraphUse] = {}


KINDS: dict[str, type[Spec]] = {"graph": GraphSpec, "scene": SceneSpec, "robot": RobotSpec}
