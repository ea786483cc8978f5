"""A world without physics: handles at rest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.backend import select_joints
from graphengine.devices.entity import Entity
from graphengine.devices.motion import Body, Frame, Placement
from graphengine.devices.sensor import (
    ContactReading,
    Friction,
    ImuSample,
    Light,
    Picture,
    Quaternion,
    Scan,
    Vector3,
    beam_directions,
    pinhole,
)
from graphengine.devices.stage import Prim, Stage
from graphengine.format.errors import UnknownEntityError
from graphengine.format.stateful import Shared, Stateful


class DryEntities:
    """The robots and bodies of a stage, which nobody moves."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def all(self) -> Sequence[Entity]:
        """Robots, and bodies that hang on no other prim with a body."""
        robots = [Entity(prim.entity_name, prim.path, "robot", False) for prim in self._stage.prims("robot")]
        return [*robots, *(Entity(prim.name, prim.path, "object", False) for prim in self._stage.prims("body"))]

    def _refuse(self, name: str, *_: Any, **__: Any) -> Any:
        """Raise `UnknownEntityError`: none of them can be asked for its state, or moved."""
        raise UnknownEntityError(f"no entity {name!r}: the world has no physics")

    state = bounds = overlaps = place = push = _refuse


class DryWorld(Stateful):
    """A world without physics: handles that are at rest, for checks and for tests of nodes."""

    kept = ("_frictions", "_lights", "clamped_commands", "dropped_pictures", "gravity")

    def __init__(self, stage: Stage, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        self.stage = stage
        self.tick_period = tick_period
        self.substeps = substeps
        self.realtime = False
        self.dropped_pictures: dict[str, int] = {}
        self.clamps_commands = True
        self.clamped_commands: dict[str, int] = {}
        self.gravity: Vector3 = (0.0, 0.0, -9.81)
        self.rays_in_use = ""
        self._frictions: dict[str, Friction] = {}
        self._lights: dict[str, Light] = {}

    def set_gravity(self, gravity: Vector3) -> None:
        """Nothing falls."""
        self.gravity = gravity

    def friction(self, prim: Prim) -> Friction:
        """What was written last, else what the material's facts say."""
        built = prim.facts["static_friction"], prim.facts["dynamic_friction"]
        return self._frictions.get(prim.path, built)

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Nothing slides."""
        self._frictions[prim.path] = friction

    def light(self, prim: Prim) -> Light:
        """What was written last, else what the light's facts say."""
        return self._lights.get(prim.path, (1.0, prim.facts["diffuse"]))

    def set_light(self, prim: Prim, light: Light) -> None:
        """Nothing is lit."""
        self._lights[prim.path] = light

    def body(self, prim: Prim) -> Body:
        """A body at rest."""
        return DryBody(prim)

    def frame(self, prim: Prim) -> Frame:
        """A frame at the world's origin."""
        return DryBody(prim)

    def mass(self, prim: Prim) -> float:
        """One kilogram."""
        return 1.0

    def placement(self, prim: Prim) -> Placement | None:
        """A body that stays where it is, if the prim has one."""
        return DryPlacement() if prim.body is not None or self.stage.stands_for_robot(prim) is not None else None

    def articulation(self, robot: Prim) -> DryArticulation:
        """Joints that stay where they are."""
        return DryArticulation(robot)

    def lidar(self, prim: Prim) -> DryLidar:
        """A sensor that sees nothing."""
        return DryLidar(prim)

    def camera(self, prim: Prim, size: tuple[int, int] | None = None) -> DryCamera:
        """A camera that delivers nothing."""
        return DryCamera(prim, size)

    def imu(self, prim: Prim) -> DryImu:
        """A sensor at rest."""
        return DryImu(prim)

    def contact_sensor(self, prim: Prim) -> DryContactSensor:
        """A sensor that nothing touches."""
        return DryContactSensor(prim)

    def picture_driver(self) -> str:
        """Nothing draws."""
        return ""

    @property
    def entities(self) -> DryEntities:
        """Robots and bodies that nobody moves."""
        return DryEntities(self.stage)

    def step(self) -> None:
        """Nothing moves."""

    def begin_tick(self, tick: int) -> None:
        """Nothing is due."""

    def zero_commands(self) -> None:
        """Nothing was commanded."""

    def reset_state(self) -> None:
        """Nothing has changed."""

    def reset_time(self) -> None:
        """No time has passed."""

    def close(self) -> None:
        """Nothing is held."""


class DryBody:
    """At rest at the origin."""

    def __init__(self, prim: Prim) -> None:
        self.prim = prim

    def pose(self) -> tuple[Vector3, Quaternion]:
        """The origin."""
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Zero."""
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


class DryPlacement:
    """Moves nothing."""

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Take a pose."""


class DryArticulation:
    """A robot whose joints are known and do not move."""

    def __init__(self, robot: Prim) -> None:
        self.prim_path = robot.path
        self.joint_names: tuple[str, ...] = tuple(robot.facts.get("joints", ()))
        self.prismatic: tuple[bool, ...] = tuple(robot.facts.get("prismatic", (False,) * len(self.joint_names)))

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> DryJointSelection:
        """A selection that takes commands and does nothing."""
        chosen = select_joints(self, names, indices)
        return DryJointSelection(tuple(self.joint_names[i] for i in chosen))

    def positions(self) -> NDArray[np.float64]:
        """Zeros."""
        return np.zeros(len(self.joint_names))

    velocities = positions
    efforts = positions

    def set_points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Zeros."""
        return np.zeros(len(self.joint_names)), np.zeros(len(self.joint_names))

    def wrenches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Zeros."""
        return np.zeros((len(self.joint_names), 3)), np.zeros((len(self.joint_names), 3))


class DryJointSelection(Shared):
    """Remembers nothing."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Take a command."""


class DryLidar:
    """A lidar with its profile and nothing to see. The prim's facts hold `rate`, `angles` and `ranges`."""

    def __init__(self, prim: Prim) -> None:
        self.prim_path = prim.path
        self.rate: float = prim.facts.get("rate", 10.0)
        self.angles: tuple[float, float, float] = prim.facts.get("angles", (0.0, 0.0, 1.0))
        self.ranges: tuple[float, float] = prim.facts.get("ranges", (0.05, 10.0))
        self.elevations: NDArray[np.float64] = np.array(prim.facts.get("elevations", (0.0,)), float)
        self.due, self.index = False, 0

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors of the beams, ring after ring."""
        return beam_directions(self.angles, self.elevations)

    def scan(self) -> Scan:
        """No return anywhere."""
        beams = len(self.directions)
        return Scan(0.0, 0, np.full(beams, np.inf, np.float32), np.zeros(beams, np.float32))


class DryCamera:
    """A camera with its profile that never delivers; its prim's facts hold `size`, `fov_deg`, `clip` and `rate`."""

    def __init__(self, prim: Prim, size: tuple[int, int] | None = None) -> None:
        self.prim_path = prim.path
        self.rate: float = prim.facts.get("rate", 30.0)
        self.size: tuple[int, int] = size or prim.facts.get("size", (640, 480))
        self.clip: tuple[float, float] = prim.facts.get("clip", (0.01, 100.0))
        self.intrinsics = pinhole(self.size, prim.facts.get("fov_deg", (90.0, 90.0))[0])
        self.latency = 1
        self.labels: dict[int, str] = {}
        self.due, self.index = False, 0

    def request(self, *, segmentation: bool = False) -> None:
        """Nothing is captured."""

    def delivered(self) -> Picture | None:
        """Nothing."""
        return None


class DryImu:
    """At rest and upright."""

    def __init__(self, prim: Prim) -> None:
        self.prim_path = prim.path
        self.rate: float = prim.facts.get("rate", 100.0)
        self.due = False

    def sample(self) -> ImuSample:
        """Nothing but gravity."""
        return ImuSample(0.0, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 9.81), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


class DryContactSensor:
    """Touched by nothing."""

    def __init__(self, prim: Prim) -> None:
        self.prim_path = prim.path

    def reading(self) -> ContactReading:
        """No force."""
        return ContactReading(0.0, False, 0.0)
