"""A world without physics for `graphrun check` and for tests. Its handles are stubs whose values tests set."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partialmethod
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices import rotation
from graphengine.devices.backend import Friction, Light, select_joints
from graphengine.devices.contact_points import Contacts
from graphengine.devices.device import device_of
from graphengine.devices.entity import Entity, Overlap
from graphengine.devices.motion import JointFacts
from graphengine.devices.rotation import IDENTITY, ORIGIN, Quaternion, Vector3
from graphengine.devices.stage import Prim, Stage
from graphengine.devices.visible import Bodies
from graphengine.format.errors import UnknownEntityError
from graphengine.format.faults import Faults
from graphengine.format.stateful import Shared, Stateful

D = TypeVar("D")


class DryEntities:
    """The entities of a world without physics. They can be listed, but have no state and cannot be moved."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def all(self) -> Sequence[Entity]:
        """Return all robots, then all bodies that are not links of robots."""
        robots = [Entity(prim.entity_name, prim.path, "robot", False) for prim in self._stage.prims("robot")]
        return [*robots, *(Entity(prim.name, prim.path, "object", False) for prim in self._stage.prims("body"))]

    def touching(self) -> Mapping[str, Overlap]:
        """Return an empty mapping, because there is no physics."""
        return {}

    def _refuse(self, name: str, *_: Any, **__: Any) -> Any:
        """Raise UnknownEntityError, because entities have no state without physics."""
        raise UnknownEntityError(f"no entity {name!r}: the world has no physics")

    state = bounds = overlaps = clearance = touched = place = reset = push = _refuse


class DryWorld(Stateful):
    """A world without physics. Prims move only if a test or a node sets their pose.

    Args:
        stage: stage of the world.
        tick_period: time between two ticks, s: numerator and denominator.
        substeps: number of physics steps per tick.
    """

    kept = ("_frictions", "_lights", "clamped_commands", "dropped_pictures", "gravity")

    def __init__(self, stage: Stage, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        self.stage = stage
        self.tick_period = tick_period
        self.substeps = substeps
        self.realtime = False
        self.seed = 0
        self.faults = Faults()
        self.dropped_pictures: dict[str, int] = {}
        self.clamps_commands = True
        self.clamped_commands: dict[str, int] = {}
        self.gravity: Vector3 = (0.0, 0.0, -9.81)
        self.rays_in_use = ""
        self._frictions: dict[str, Friction] = {}
        self._lights: dict[str, Light] = {}
        self._bodies: dict[Prim, BodyStub] = {}
        self._robots: dict[Prim, ArticulationStub] = {}
        self._surfaces: dict[Prim, SurfaceStub] = {}
        self._devices: dict[tuple[Any, ...], Any] = {}

    def bodies(self) -> Bodies:
        """Return an empty description: no body is visible."""
        return Bodies()

    def poses(self) -> NDArray[np.float64]:
        """Return an empty array of shape (0, 7)."""
        return np.zeros((0, 7))

    def contacts(self) -> Contacts:
        """Return empty arrays, because there is no physics."""
        return Contacts()

    def set_gravity(self, gravity: Vector3) -> None:
        """Set the attribute `gravity`; this has no other effect."""
        self.gravity = gravity

    def friction(self, prim: Prim) -> Friction:
        """Return the friction that was set last; if none was set, the friction of the material's prim."""
        built = prim.facts["static_friction"], prim.facts["dynamic_friction"]
        return self._frictions.get(prim.path, built)

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Set the value that `friction` returns; this has no other effect."""
        self._frictions[prim.path] = friction

    def light(self, prim: Prim) -> Light:
        """Return the intensity and colour that were set last; if none were set, 1 and the colour of the light's prim."""
        return self._lights.get(prim.path, (1.0, prim.facts["diffuse"]))

    def set_light(self, prim: Prim, light: Light) -> None:
        """Set the value that `light` returns; this has no other effect."""
        self._lights[prim.path] = light

    def body(self, prim: Prim) -> BodyStub:
        """Return the stub of a prim, the same object at each call. It moves with the stub of the parent prim until `place`."""
        if prim not in self._bodies:
            carrier = self.body(prim.parent) if prim.parent else None
            self._bodies[prim] = BodyStub(prim.position, prim.orientation, carrier=carrier)
        return self._bodies[prim]

    frame = body

    def mass(self, prim: Prim) -> float:
        """Return 1 kg for every prim."""
        return 1.0

    def placement(self, prim: Prim) -> BodyStub | None:
        """Return the stub with which nodes set the pose of a prim; None if the prim is not a body, link or robot."""
        movable = prim.body is not None or self.stage.stands_for_robot(prim) is not None
        return self.body(prim) if movable else None

    def conveyor(self, prim: Prim) -> SurfaceStub:
        """Return the stub of a body's surface, the same object at each call."""
        return self._surfaces.setdefault(prim, SurfaceStub())

    def articulation(self, robot: Prim) -> ArticulationStub:
        """Return the stub of a robot's joints, the same object at each call."""
        return self._robots.setdefault(robot, ArticulationStub(robot))

    def device(self, interface: Callable[..., D], prim: Prim, **options: Any) -> D:
        """Return the stub of a device. Calls with equal arguments return the same object."""
        found = device_of(interface)
        place = (prim, found.kind, *sorted(options.items()))
        if place not in self._devices:
            self._devices[place] = found.stub(prim, **options)
        made: D = self._devices[place]
        return made

    def picture_driver(self) -> str:
        """Return an empty string, because no images are rendered."""
        return ""

    @property
    def entities(self) -> DryEntities:
        """The robots and bodies of the stage, as entities."""
        return DryEntities(self.stage)

    def begin_tick(self, tick: int) -> None:
        """Do nothing. Tests set the samples of the sensors."""

    def step(self) -> None:
        """Do nothing, because there is no physics."""

    zero_commands = reset_state = reset_time = close = step


@dataclass(slots=True)
class BodyStub(Shared):
    """Pose and velocity of a prim; tests assign the fields.

    Attributes:
        position: position, m, in the world frame; with a carrier, in the carrier's frame.
        orientation: orientation as a quaternion (x, y, z, w), in the same frame as `position`.
        linear: linear velocity in the world frame, m/s; ignored with a carrier.
        angular: angular velocity in the world frame, rad/s; ignored with a carrier.
        carrier: stub of the prim with which this prim moves, or None.
    """

    position: Vector3 = ORIGIN
    orientation: Quaternion = IDENTITY
    linear: Vector3 = (0.0, 0.0, 0.0)
    angular: Vector3 = (0.0, 0.0, 0.0)
    carrier: BodyStub | None = None

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Return position (m) and orientation in the world frame."""
        pose = (self.position, self.orientation)
        return rotation.compose(self.carrier.pose(), pose) if self.carrier else pose

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Set the pose in the world frame and a velocity of zero, and detach the prim from its carrier."""
        self.position, self.orientation, self.carrier = position, orientation, None
        self.linear = self.angular = (0.0, 0.0, 0.0)

    @property
    def released(self) -> bool:
        """Whether the handle is no longer valid; always false."""
        return False

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Return linear (m/s) and angular (rad/s) velocity of the prim's origin in the world frame."""
        if self.carrier is None:
            return self.linear, self.angular
        linear, angular = self.carrier.velocity()
        arm = rotation.rotate(self.carrier.pose()[1], self.position)
        return tuple(np.add(linear, np.cross(angular, arm)).tolist()), angular


@dataclass(slots=True)
class SurfaceStub(Shared):
    """The surface of a conveyor for tests. It stores the velocity that nodes set.

    Attributes:
        linear: linear velocity in the body's frame, m/s.
        angular: angular velocity in the body's frame, rad/s.
    """

    linear: Vector3 = (0.0, 0.0, 0.0)
    angular: Vector3 = (0.0, 0.0, 0.0)

    def move(self, linear: Vector3, angular: Vector3) -> None:
        """Store linear (m/s) and angular (rad/s) velocity in the body's frame."""
        self.linear, self.angular = linear, angular


class ArticulationStub(JointFacts, Shared):
    """The joints of a robot for tests. Tests set `state`; nodes set `targets`, which are NaN for joints without a command.

    Args:
        robot: prim of the robot, whose facts have the names and limits of the joints.
    """

    resets = 0

    def __init__(self, robot: Prim) -> None:
        self.prim_path = robot.path
        super().__init__(robot)
        self.target_ranges, at_rest = self.ranges, np.zeros(len(self.joint_names))
        self.stiffness: NDArray[np.float64] = np.array(robot.facts.get("stiffness", at_rest))
        self.state: dict[str, ArrayLike] = {"position": at_rest, "velocity": at_rest, "effort": at_rest}
        self.targets = {kind: [math.nan] * len(self.commanded_names) for kind in self.state}

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> JointSelectionStub:
        """Return the joints with these names; without names, those with these indices; with neither, all joints."""
        return JointSelectionStub(self, select_joints(self, names, indices))

    def _read(self, kind: str) -> NDArray[np.float64]:
        return np.array(self.state[kind], np.float64)

    positions = partialmethod(_read, "position")
    velocities = partialmethod(_read, "velocity")
    efforts = partialmethod(_read, "effort")

    def set_points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the position and velocity targets that nodes set; 0 for joints without a target."""
        return np.nan_to_num(self.targets["position"]), np.nan_to_num(self.targets["velocity"])

    def wrenches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return zero forces (N) and zero torques (N m) at the joints, as two arrays of shape (joints, 3)."""
        return np.zeros((len(self.joint_names), 3)), np.zeros((len(self.joint_names), 3))


class JointSelectionStub(Shared):
    """Selected joints of an articulation stub. It stores commands in the stub's `targets`."""

    def __init__(self, robot: ArticulationStub, joints: Sequence[int]) -> None:
        self.names = tuple(robot.commanded_names[joint] for joint in joints)
        self.robot, self.joints = robot, joints

    def command(self, positions: Any = None, velocities: Any = None, efforts: Any = None) -> None:
        """Store the targets in the articulation stub; NaN keeps the target of its joint."""
        for target, values in zip(self.robot.targets.values(), (positions, velocities, efforts), strict=True):
            for joint, value in zip(self.joints, values or [math.nan] * len(self.joints), strict=True):
                target[joint] = target[joint] if math.isnan(value) else value

    def undriven(self, kind: str) -> Sequence[str]:
        """Return an empty sequence: every joint takes commands of every kind."""
        return ()
