"""The specs of graph and scene files, and the base of all specs. They are frozen, picklable, and validated by pydantic once.

`graphrun schema` prints their JSON Schema, so editors show the descriptions of this module.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

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
    """Base of all specs: frozen; unknown keys and values of another type are errors."""

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
Gain = Annotated[float, Field(ge=0, le=1e12)]
Speed = Annotated[float, Field(ge=-1e10, le=1e10)]
Format = Annotated[
    Literal[1], BeforeValidator(_whole_number), Field(description="Version of the file format; missing means 1.")
]


class FileSpec(Spec, use_attribute_docstrings=True):
    """Base of the specs of files: the docstring of a key is its description in messages and in the schema."""


class ParameterSpec(FileSpec):
    """A parameter of a graph: `$(name)` in the file is replaced by its value, which the user of the graph gives."""

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
    """Run the node once, at its first execution since play."""
    ticks: int | None = Field(default=None, ge=1, le=MAX_TICKS)
    """Run the node at every n-th execution, first at the n-th."""
    hz: Positive | None = Field(default=None, le=MAX_HZ)
    """Run the node at this rate: at the first execution at or after each multiple of 1 / hz s of simulation time."""

    @model_validator(mode="before")
    @classmethod
    def _short_form(cls, data: Any) -> Any:
        if isinstance(data, str) and data != "once":
            raise ValueError(f"expected `once`, {{ticks: 3}} or {{hz: 10}}, got {data!r}")
        return {"once": True} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _one_form(self) -> EverySpec:
        if self.once + (self.ticks is not None) + (self.hz is not None) != 1:
            raise ValueError("give exactly one of once, {ticks: 3} and {hz: 10}")
        return self


class NodeSpec(FileSpec):
    """A node: a type or a subgraph, and values of its inputs."""

    type: str = ""
    """Registered OmniGraph name of the node type; for included types, its last part suffices."""
    subgraph: str = ""
    """Graph file to use as a subgraph, in place of a type; the file declares inputs and outputs."""
    parameters: dict[Name, Any] = {}
    """Values for the parameters of the subgraph, by name."""
    inputs: dict[str, Any] = {}
    """Values of inputs, by port name."""
    every: EverySpec | None = None
    """How often the node is executed: once, {ticks: 3} or {hz: 10}."""
    doc: str = ""

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
            raise ValueError("only a node with a `subgraph` has `parameters`; write values of ports below `inputs:`")
        if self.subgraph and self.every:
            raise ValueError("a subgraph has no `every`; write `every` at nodes in the subgraph's own file")
        return self


class GraphSpec(FileSpec):
    """A graph file: nodes, wires, and the graph's place in the prim tree."""

    format: Format = 1
    graph: Name
    """Name of the graph."""
    doc: str = ""
    at: PrimPath = ""
    """Path of the graph's prim; namespaces of topics are collected from this prim and its ancestors."""
    parameters: dict[Name, ParameterSpec] = {}
    """Parameters of the graph, as name: {type: …, default: …}."""
    runs: Literal["tick", "physics_step"] = "tick"
    """How often the graph runs: once per tick, or once per physics step."""
    evaluator: Annotated[Literal["execution", "push"], BeforeValidator(_evaluator)] = "execution"
    """`execution` runs the nodes that execution reaches, `push` runs all nodes in each pass."""
    variables: dict[Name, VariableSpec] = {}
    """Variables of the graph, as name: {type: …, default: …}."""
    nodes: dict[Name, NodeSpec] = {}
    """Nodes of the graph, as name: type, or name: {type: …, inputs: {…}}."""
    connections: tuple[Connection, ...] = Field(default=(), strict=False)
    """Wires of the graph, one per line: Node.port -> Node.port"""
    inputs: dict[str, str] = {}
    """Inputs that the graph has when it is used as a subgraph, as name: Node.port."""
    outputs: dict[str, str] = {}
    """Outputs that the graph has when it is used as a subgraph, as name: Node.port."""
    layout: dict[Name, Pair] = {}
    """Positions of nodes in drawings, as name: [x, y]."""
    scene: str = ""
    """Scene file that `graphrun run` loads for this graph."""


class Orientation(FileSpec):
    """A rotation: about the fixed x, then y, then z axis as in URDF, or a unit quaternion with the scalar last."""

    rpy_deg: Vector | None = None
    quaternion_xyzw: Annotated[tuple[float, float, float, float], Field(strict=False)] | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Orientation:
        if (self.rpy_deg is None) == (self.quaternion_xyzw is None):
            raise ValueError("give either rpy_deg: [roll, pitch, yaw] or quaternion_xyzw: [x, y, z, w]")
        if self.quaternion_xyzw is not None and abs(math.hypot(*self.quaternion_xyzw) - 1.0) > 0.01:
            raise ValueError("the quaternion of a rotation must have length 1")
        return self


UPRIGHT = Orientation(rpy_deg=(0.0, 0.0, 0.0))


class GraphUse(FileSpec):
    """The use of a graph file at a prim, with values for its parameters."""

    use: str
    at: PrimPath = ""
    """Path of the graph's prim, instead of `at` in the graph file."""
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


class JointStartSpec(FileSpec):
    """The start position of one joint of one robot."""

    start: Speed
    """Position at the start, rad or m, instead of the robot file's."""


class RobotUse(FileSpec):
    """The use of a robot file in a scene, once or as a fleet: `NAME_0000`, `NAME_0001` and so on."""

    use: str
    """Robot file, or a robot description alone: a URDF, xacro, SDF or MJCF file, or the text of a URDF, SDF or MJCF."""
    at: RobotPath | None = None
    """Path of the robot's prim, such as /World/robot; default /NAME. In a fleet, the robot's number is appended."""
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT
    count: int | None = Field(default=None, ge=1, le=MAX_ROBOTS)
    """Number of robots, in rows along the x axis."""
    spacing: Annotated[tuple[Positive, Positive], Field(strict=False)] | None = None
    """Distances between robots in a row, and between rows along the y axis, m."""
    per_row: int | None = Field(default=None, ge=1)
    """Robots per row; default all."""
    places: Annotated[tuple[PlaceSpec, ...], Field(strict=False, max_length=MAX_ROBOTS)] | None = None
    """Pose of each robot relative to `position` and `orientation`, instead of `count`."""
    namespace: NamespacePattern | None = None
    """Namespace of the base link, instead of the robot file's; {name} is the robot's name, {index:04} its number."""
    start: str = ""
    """Keyframe of a MuJoCo model in which the robot starts, instead of the robot file's."""
    joints: dict[str, JointStartSpec] = {}
    """Positions of joints at the start, as name: {start: …}."""
    robot_state: bool = False
    """Publish the topics of robot_state_publisher."""

    @model_validator(mode="after")
    def _one_fleet(self) -> RobotUse:
        if self.count is not None and self.places is not None:
            raise ValueError("a fleet has a `count` or `places`, not both")
        if (self.count or 1) > 1 and self.spacing is None:
            raise ValueError("a fleet with a `count` needs a `spacing`: [x, y], in m")
        if self.count is None and (self.spacing or self.per_row):
            raise ValueError("`spacing` and `per_row` need a `count`")
        return self


class SceneSpec(FileSpec):
    """A scene file: a world, its robots, and graphs outside of robots."""

    format: Format = 1
    scene: Name
    doc: str = ""
    world: str
    """MJCF or SDF file of everything except the robots."""
    physics: PhysicsSpec = PhysicsSpec()
    settle: bool = False
    """Simulate until the robots are at rest before t = 0."""
    robots: dict[Name, RobotUse] = {}
    graphs: dict[Name, GraphUse] = {}
    namespaces: dict[PrimPath, Namespace] = {}
    """`isaac:namespace` of prims, by path: the world, robots, graphs or nodes."""
    tf: Literal["namespaced", "global"] = "namespaced"
    """`namespaced`: each robot has its own TF topics, in its namespace. `global`: all robots publish on /tf and /tf_static, and
    the names of a robot's frames begin with its namespace."""
