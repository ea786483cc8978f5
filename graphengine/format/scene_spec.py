"""The pydantic model of scene files."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from graphengine.format.legal_names import Name, Namespace, PrimPath
from graphengine.format.mover_values import Corner, Loop, Point, Shape, keys_of_stop
from graphengine.format.spec import Duration, FileSpec, Format, GraphUse, Period, Positive, RobotUse


class PhysicsSpec(FileSpec):
    """The tick rate, and the number of physics steps in a tick."""

    tick_rate: Positive = Field(default=60.0, le=10_000)
    """Number of ticks per second of simulation time."""
    substeps: int = Field(default=4, ge=1, le=1000)
    """Number of MuJoCo steps per tick."""


class EarthSpec(FileSpec):
    """The place of the world's origin on Earth, as in SDF's `<spherical_coordinates>`; satellite navigation needs it."""

    latitude_deg: float = Field(ge=-90, le=90)
    """Geodetic latitude (WGS84), degrees, positive north of the equator."""
    longitude_deg: float = Field(ge=-180, le=180)
    """Longitude (WGS84), degrees, positive east of Greenwich."""
    elevation: float = Field(default=0.0, ge=-1e5, le=1e5)
    """Height above the WGS84 ellipsoid, m."""
    heading_deg: float = Field(default=0.0, ge=-360, le=360)
    """Angle from east to the world's x axis, counter-clockwise seen from above, degrees; with 0, x points east and y north."""


class LockstepSpec(FileSpec):
    """A topic on which the run waits for a program: after each period, the next tick waits for the program's messages."""

    topic: Annotated[str, Field(max_length=1000)]
    """Full name of a topic to which graphs subscribe, such as /dd100_0000/cmd_vel."""
    period: Period
    """Simulation time between two waits, such as 0.1s: the period with which the program sends its messages."""
    messages: int = Field(default=1, ge=1, le=1000)
    """Number of messages in each period; the first tick after the period receives exactly these, in order of arrival."""
    timeout: Period = 5.0
    """Maximum wall time of a wait, such as 5s; a longer wait ends the run with an error."""


def _one_of_each(entries: tuple[LockstepSpec, ...]) -> tuple[LockstepSpec, ...]:
    topics = [entry.topic for entry in entries]
    for topic in topics:
        if topics.count(topic) > 1:
            raise ValueError(f"{topic} has two entries; write one for each topic")
    return entries


LockstepSpecs = Annotated[
    tuple[LockstepSpec, ...],
    Field(strict=False, max_length=1000),
    AfterValidator(_one_of_each),
    BeforeValidator(
        lambda value: (value,) if isinstance(value, dict) else value,
        json_schema_input_type=LockstepSpec | tuple[LockstepSpec, ...],
    ),
]
"""One entry, or a list of them: one for each topic."""


class MoverStop(FileSpec):
    """A point of a mover's path: `[x, y]`, `[x, y, z]` or `{at: [x, y], pause: 2s}`."""

    at: Point
    """Position of the point, m; z is the height of the mover's feet or base."""
    pause: Duration = 0.0
    """Time for which the mover stops at this point, such as 2s."""


Stop = Annotated[MoverStop, BeforeValidator(keys_of_stop, json_schema_input_type=MoverStop | Point)]


class MoverSpec(FileSpec):
    """A person, vehicle or other body that moves along a path regardless of obstacles; its pose depends only on time and seed."""

    shape: Shape
    """`person`, `forklift`, `box` (which needs a `size`), or the path of a mesh file."""
    size: Annotated[tuple[Positive, Positive, Positive], Field(strict=False)] | None = None
    """Length, width and height of a box, m."""
    path: Annotated[tuple[Stop, ...], Field(strict=False, max_length=1000)] | None = None
    """Points of the path, as a list of [x, y], [x, y, z] or {at: [x, y], pause: 2s}."""
    region: Annotated[tuple[Corner, Corner], Field(strict=False)] | None = None
    """Two opposite corners of a rectangle in which the mover walks between random free points; an alternative to `path`."""
    speed: Annotated[float, Field(gt=0, le=100)]
    """Speed, m/s."""
    loop: Loop = False
    """`true`: straight from the last point to the first one, repeatedly; `there_and_back`: back along the path, repeatedly."""
    start: Duration = 0.0
    """Time at which the mover starts, such as 2s."""

    @model_validator(mode="after")
    def _one_path(self) -> MoverSpec:
        if (self.path is None) == (self.region is None):
            raise ValueError("give either a `path`: [[x, y], …] or a `region`: [[x, y], [x, y]]")
        if self.path == ():
            raise ValueError("the path of a mover needs at least one point [x, y]")
        if self.region is not None and self.loop:
            raise ValueError("a mover in a `region` always walks on; remove `loop`")
        if (self.shape == "box") != (self.size is not None):
            raise ValueError("the shape `box` needs a `size`: [length, width, height], and no other shape has one")
        return self


class SceneSpec(FileSpec):
    """A scene file: a world, its robots, and graphs outside of robots."""

    format: Format = 1
    scene: Name
    """Name of the scene."""
    doc: str = ""
    """Description for readers of the file."""
    world: str
    """MJCF, SDF or USD file with the world: all except the robots."""
    usd_variants: dict[str, str] = {}
    """Variants to select in a USD world, as SET: NAME or PRIM:SET: NAME."""
    usd_assets: Annotated[tuple[str, ...], Field(strict=False, max_length=100)] = ()
    """Folders with copies of the assets of a USD world that are on servers."""
    usd_replace: dict[str, str] = {}
    """Files in place of assets of a USD world, by the reference to the asset."""
    spherical_coordinates: EarthSpec | None = None
    """Place of the world on Earth, as {latitude_deg: 47.38, longitude_deg: 8.54}; overrides that of an SDF world."""
    physics: PhysicsSpec = PhysicsSpec()
    """Tick rate and physics steps, as {tick_rate: 60, substeps: 4}."""
    settle: bool = False
    """If true, physics runs until all bodies are at rest before the simulation starts at t = 0."""
    robots: dict[Name, RobotUse] = {}
    """Robots of the scene, as name: {use: robots/dd100.yaml, position: [0, 0, 0]}."""
    movers: dict[Name, MoverSpec] = {}
    """People and vehicles that move along paths, as name: {shape: person, path: [[0, 2], [0, 8]], speed: 1.2, loop: true}."""
    graphs: dict[Name, GraphUse] = {}
    """Graphs outside of robots, as name: {use: graphs/clock.yaml, at: /World/clock}."""
    namespaces: dict[PrimPath, Namespace] = {}
    """ROS 2 namespaces (`isaac:namespace`) of prims of the world, robots, graphs or nodes, by prim path."""
    lockstep: LockstepSpecs = ()
    """Topics on which the run waits for programs, as {topic: /dd100_0000/cmd_vel, period: 0.1s}, or a list of such entries."""
    tf: Literal["namespaced", "global"] = "namespaced"
    """`namespaced`: each robot has TF topics in its namespace; `global`: all robots share /tf; frame names have namespaces."""
