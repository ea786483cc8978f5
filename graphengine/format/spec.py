"""The pydantic models of graph files and of parts of scene files, and the base class of all such models (specs).

Specs are frozen and picklable. `graphrun schema` prints their JSON Schema, so editors show the docstrings of the keys.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from graphengine.format.durations import in_seconds
from graphengine.format.key_docs import key_docs
from graphengine.format.legal_names import Name, NamespacePattern, PrimPath, RobotPath
from graphengine.format.wording import shown

FORMAT = 1
MAX_TICKS = 2**32 - 1
"""Highest number of ticks of the key `every`."""
MAX_HZ = 10_000
"""Highest rate of the key `every`, Hz."""


def _name_keys(schema: dict[str, Any]) -> None:
    """Convert `patternProperties` of a JSON Schema to `propertyNames`, so that editors report keys that are illegal names."""
    for value in schema.get("properties", {}).values():
        for pattern, item in value.pop("patternProperties", {}).items():
            value["propertyNames"] = {**value.get("propertyNames", {}), "pattern": pattern}
            value["additionalProperties"] = item


class Spec(BaseModel):
    """Base class of all specs: immutable models, for which unknown keys and values of a wrong type are errors."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, json_schema_extra=_name_keys, defer_build=True
    )


def _whole_number(value: Any) -> Any:
    if type(value) is not int:
        raise ValueError(f"expected 1, got {shown(value)}")
    return value


def _evaluator(value: Any) -> Any:
    if value in ("dirty_push", "lazy"):
        ways = "push, which computes every node, or execution, which computes a data node when another node reads it"
        raise ValueError(f"{value!r} graphs are not supported; use {ways}")
    return value


def _not_zero(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    if not any(vector):
        raise ValueError("a direction cannot be the zero vector; write one such as [1, 0, 0]")
    return vector


Pair = Annotated[tuple[float, float], Field(strict=False)]
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Direction = Annotated[Vector, AfterValidator(_not_zero)]
Connection = Annotated[str, Field(max_length=1000)]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
_DURATION = BeforeValidator(in_seconds, json_schema_input_type=float | str)
Duration = Annotated[float, Field(ge=0, le=1e6), _DURATION]
"""A time such as 2s, 500ms, 2min, or a number of seconds."""
Period = Annotated[float, Field(gt=0, le=1e6), _DURATION]
"""A duration above 0."""
Gain = Annotated[float, Field(ge=0, le=1e12)]
Speed = Annotated[float, Field(ge=-1e10, le=1e10)]
Format = Annotated[
    Literal[1],
    BeforeValidator(_whole_number),
    Field(description="Version of the file format; 1 if the key is missing."),
]


def _describe_keys(schema: dict[str, Any], model: type[BaseModel]) -> None:
    """Add the descriptions of the keys to the JSON Schema of a spec."""
    docs = key_docs(model)
    for key, value in schema.get("properties", {}).items():
        if key in docs:
            value["description"] = docs[key]
    _name_keys(schema)


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


InnerPorts = Annotated[
    tuple[str, ...],
    Field(strict=False),
    BeforeValidator(_as_list, json_schema_input_type=str | tuple[str, ...]),
]
"""One `Node.port`, or a list of them."""


class FileSpec(Spec, json_schema_extra=_describe_keys):
    """Base class of the specs of files; messages and the JSON Schema show the docstring of a key as its description."""


class ParameterSpec(FileSpec):
    """A parameter of a graph. The scene, robot or graph that uses the file sets a value, which replaces `$(name)`."""

    type: str
    """Type of the parameter: a port type such as double, string or target."""
    default: Any = None
    """Value if the scene, robot or graph sets none; a parameter without a default must be set."""
    doc: str = ""
    """Description for readers of the file."""


class VariableSpec(FileSpec):
    """A typed variable of the graph, which its nodes can read and write."""

    type: str
    """Type of the variable: a port type such as double, string or target."""
    default: Any = None
    """Value at the start and after a reset; default: the zero of the type."""
    doc: str = ""
    """Description for readers of the file."""


class EverySpec(FileSpec):
    """How often a node is executed, or an event fires: once, at every n-th execution, or at a rate."""

    once: bool = False
    """If true, the node runs only once, at its first execution since play."""
    ticks: int | None = Field(default=None, ge=1, le=MAX_TICKS)
    """The node runs at every n-th execution, first at the n-th."""
    hz: Positive | None = Field(default=None, le=MAX_HZ)
    """The node runs at this rate: at the first execution at or after each multiple of 1 / hz s of simulation time."""

    @model_validator(mode="before")
    @classmethod
    def _short_form(cls, data: Any) -> Any:
        if isinstance(data, str) and data != "once":
            raise ValueError(f"expected `once`, `{{ticks: 3}}` or `{{hz: 10}}`, got {data!r}")
        return {"once": True} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _one_form(self) -> EverySpec:
        if self.once + (self.ticks is not None) + (self.hz is not None) != 1:
            raise ValueError("give exactly one of the keys `once`, `ticks` and `hz`, as in `{hz: 10}`")
        return self


class NodeSpec(FileSpec):
    """A node of a graph: a node type or a subgraph, and values of its inputs."""

    type: str = ""
    """Registered OmniGraph name of the node type; for types that graphengine includes, the last part of the name suffices."""
    subgraph: str = ""
    """Graph file to use as a subgraph, an alternative to `type`; the node's ports are the file's `inputs` and `outputs`."""
    parameters: dict[Name, Any] = {}
    """Values of the parameters of the subgraph, by name."""
    inputs: dict[str, Any] = {}
    """Values of inputs, by port name."""
    every: EverySpec | None = None
    """How often the node runs: `once`, `{ticks: 3}` or `{hz: 10}`; default: at every execution."""
    doc: str = ""
    """Description for readers of the file; drawings show it as a tooltip."""

    @model_validator(mode="before")
    @classmethod
    def _short_form(cls, data: Any) -> Any:
        return {"type": data} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _type_or_subgraph(self) -> NodeSpec:
        if not self.type and not self.subgraph:
            raise ValueError("a node needs a `type` or a `subgraph`")
        if self.type and self.subgraph:
            raise ValueError("a node has a `type` or a `subgraph`, not both")
        if self.type and self.parameters:
            raise ValueError("only a node with a `subgraph` has `parameters`; set port values under `inputs:`")
        if self.subgraph and self.every:
            remedy = "set `every` on the nodes in the subgraph's own file"
            raise ValueError(f"`every` is not allowed beside `subgraph`; {remedy}")
        return self


class GraphSpec(FileSpec):
    """A graph file: nodes, wires, and the path of the graph's prim."""

    format: Format = 1
    graph: Name
    """Name of the graph."""
    doc: str = ""
    """Description for readers of the file."""
    at: PrimPath = ""
    """Path of the graph's prim. The namespaces of this prim and its ancestors form the namespace of the graph's topics."""
    parameters: dict[Name, ParameterSpec] = {}
    """Parameters of the graph, as name: {type: …, default: …}."""
    runs: Literal["tick", "physics_step"] = "tick"
    """How often the graph runs: once per tick, or once per physics step."""
    evaluator: Annotated[Literal["execution", "push"], BeforeValidator(_evaluator)] = "execution"
    """`execution` runs the nodes that execution wires reach from an event; `push` runs all nodes in each pass."""
    variables: dict[Name, VariableSpec] = {}
    """Variables of the graph, as name: {type: …, default: …}."""
    nodes: dict[Name, NodeSpec] = {}
    """Nodes of the graph, as name: type, or name: {type: …, inputs: {…}}."""
    connections: tuple[Connection, ...] = Field(default=(), strict=False)
    """Wires of the graph, as a list of entries Node.port -> Node.port"""
    inputs: dict[str, InnerPorts] = {}
    """Inputs of the graph when another graph uses it as a subgraph, as name: Node.port, or name: [Node.port, Other.port]."""
    outputs: dict[str, str] = {}
    """Outputs of the graph when another graph uses it as a subgraph, as name: Node.port."""
    layout: dict[Name, Pair] = {}
    """Positions of nodes in drawings of the graph, as name: [x, y]."""
    scene: str = ""
    """Scene file that `graphrun run` loads when it is given only this graph."""


class Orientation(FileSpec):
    """A rotation: degrees about the fixed x, then y, then z axis as in URDF, or a unit quaternion with the scalar last."""

    rpy_deg: Vector | None = None
    """Roll, pitch and yaw, degrees."""
    quaternion_xyzw: Annotated[tuple[float, float, float, float], Field(strict=False)] | None = None
    """Unit quaternion [x, y, z, w]."""

    @model_validator(mode="after")
    def _one_form(self) -> Orientation:
        if (self.rpy_deg is None) == (self.quaternion_xyzw is None):
            raise ValueError("give either rpy_deg: [roll, pitch, yaw] or quaternion_xyzw: [x, y, z, w]")
        if self.quaternion_xyzw is not None and abs(math.hypot(*self.quaternion_xyzw) - 1.0) > 0.01:
            raise ValueError("the quaternion of a rotation must have length 1")
        return self


UPRIGHT = Orientation(rpy_deg=(0.0, 0.0, 0.0))


class GraphUse(FileSpec):
    """An entry of `graphs` in a scene or robot file: a graph file, the path of its prim, and values of its parameters."""

    use: str
    """Graph file, or the path of one that graphengine includes, such as graphs/clock.yaml."""
    at: PrimPath = ""
    """Path of the graph's prim; overrides `at` in the graph file. In a robot file, `$(robot)` is the path of the robot."""
    parameters: dict[Name, Any] = {}
    """Values of the graph's parameters, by name."""


MAX_ROBOTS = 1000
"""Maximum number of robots of a fleet."""


class PlaceSpec(FileSpec):
    """The pose of one robot of a fleet, relative to the pose of the fleet."""

    position: Vector = (0.0, 0.0, 0.0)
    """Position relative to that of the fleet, m."""
    orientation: Orientation = UPRIGHT
    """Orientation relative to that of the fleet."""


class JointStartSpec(FileSpec):
    """The start position of one joint of one robot."""

    start: Speed
    """Position of the joint at the start, rad or m; overrides the robot file."""


class RobotUse(FileSpec):
    """An entry of `robots` in a scene: one robot, or a fleet of identical robots named NAME_0000, NAME_0001 and so on."""

    use: str
    """Robot file, or a robot description without a robot file: a URDF, xacro, SDF or MJCF file, or URDF, SDF or MJCF text."""
    at: RobotPath | None = None
    """Path of the robot's prim, such as /World/robot; default: /NAME. In a fleet, the number of the robot is appended."""
    position: Vector = (0.0, 0.0, 0.0)
    """Position of the robot's root link in the world, m; in a fleet, that of the first robot."""
    orientation: Orientation = UPRIGHT
    """Orientation of the robot in the world: `{rpy_deg: [roll, pitch, yaw]}` or `{quaternion_xyzw: [x, y, z, w]}`."""
    count: int | None = Field(default=None, ge=1, le=MAX_ROBOTS)
    """Number of robots in the fleet; they stand in rows along the x axis."""
    spacing: Annotated[tuple[Positive, Positive], Field(strict=False)] | None = None
    """Distance between the robots of a row (x), and between rows (y), m."""
    per_row: int | None = Field(default=None, ge=1)
    """Number of robots per row; default: all robots stand in one row."""
    places: Annotated[tuple[PlaceSpec, ...], Field(strict=False, max_length=MAX_ROBOTS)] | None = None
    """Pose of each robot of the fleet, relative to `position` and `orientation`; an alternative to `count`."""
    namespace: NamespacePattern | None = None
    """Namespace of the base link; overrides the robot file. {name} is the robot's name, {index:04} its number with 4 digits."""
    start: str = ""
    """Keyframe of the MuJoCo model in which the robot starts; overrides the robot file."""
    joints: dict[str, JointStartSpec] = {}
    """Start positions of joints, as name: {start: …}."""
    robot_state: bool = False
    """If true, the simulation publishes the topics of robot_state_publisher for the robot."""

    @model_validator(mode="after")
    def _one_fleet(self) -> RobotUse:
        if self.count is not None and self.places is not None:
            raise ValueError("a fleet has a `count` or `places`, not both")
        if (self.count or 1) > 1 and self.spacing is None:
            raise ValueError("a fleet with a `count` needs a `spacing`: [x, y], in m")
        if self.count is None and (self.spacing or self.per_row):
            raise ValueError("`spacing` and `per_row` need a `count`")
        return self
