"""A world whose bodies, robots and sensors tests define, move and read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partialmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices import backend, dry_world, rotation
from graphengine.devices.entity import Move
from graphengine.devices.sensor import BOX_3D, ContactReading, ImuSample, Picture, Quaternion, Scan, Vector3
from graphengine.devices.stage import IDENTITY, ORIGIN, Prim, Stage


@dataclass(slots=True)
class RecordingBody:
    """Where a prim is and how it moves, for tests to write: in the world frame, or fixed to what carries it."""

    position: Vector3 = ORIGIN
    orientation: Quaternion = IDENTITY
    linear: Vector3 = (0.0, 0.0, 0.0)
    angular: Vector3 = (0.0, 0.0, 0.0)
    carrier: RecordingBody | None = None

    def pose(self) -> tuple[Vector3, Quaternion]:
        """In the world frame."""
        pose = (self.position, self.orientation)
        return rotation.compose(self.carrier.pose(), pose) if self.carrier else pose

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Be there, at rest."""
        self.position, self.orientation, self.carrier = position, orientation, None
        self.linear = self.angular = (0.0, 0.0, 0.0)

    def velocity(self) -> tuple[Vector3, Vector3]:
        """In the world frame; what is carried at r moves with v + w x r."""
        if self.carrier is None:
            return self.linear, self.angular
        linear, angular = self.carrier.velocity()
        arm = rotation.rotate(self.carrier.pose()[1], self.position)
        return tuple(np.add(linear, np.cross(angular, arm)).tolist()), angular


class RecordingArticulation(dry_world.DryArticulation):
    """Joints whose `state` tests write; `targets` are what nodes wrote, NaN where never."""

    def __init__(self, robot: Prim) -> None:
        super().__init__(robot)
        self.state: dict[str, ArrayLike] = {
            kind: np.zeros(len(self.joint_names)) for kind in ("position", "velocity", "effort")
        }
        self.targets = {kind: [math.nan] * len(self.joint_names) for kind in self.state}

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> RecordingSelection:
        """Joints by name, else by index, else all."""
        return RecordingSelection(self, backend.select_joints(self, names, indices))

    def set_points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What nodes wrote; NaN where never."""
        return np.array(self.targets["position"]), np.array(self.targets["velocity"])

    def _told(self, kind: str) -> NDArray[np.float64]:
        return np.array(self.state[kind], np.float64)

    positions = partialmethod(_told, "position")
    velocities = partialmethod(_told, "velocity")
    efforts = partialmethod(_told, "effort")


class RecordingSelection(dry_world.DryJointSelection):
    """Some joints; a command writes the articulation's targets."""

    def __init__(self, robot: RecordingArticulation, joints: Sequence[int]) -> None:
        super().__init__(tuple(robot.joint_names[joint] for joint in joints))
        self.robot, self.joints = robot, joints

    def command(self, positions: Any = None, velocities: Any = None, efforts: Any = None) -> None:
        """Set what is given and not NaN."""
        for target, values in zip(self.robot.targets.values(), (positions, velocities, efforts), strict=True):
            for joint, value in zip(self.joints, values or [math.nan] * len(self.joints), strict=True):
                target[joint] = target[joint] if math.isnan(value) else value


class RecordingLidar(dry_world.DryLidar):
    """A lidar that sees what tests say; `casts` counts how often it was asked."""

    casts = 0
    _seen: Scan | None = None

    def see(self, ranges: ArrayLike, intensities: ArrayLike = 0.0, *, time: float = 0.0, index: int = 0) -> None:
        """Make a sample due: one range a beam, inf where nothing is."""
        distances = np.array(ranges, np.float32)
        brightness = np.full(distances.shape, intensities, np.float32)
        self.due, self.index, self._seen = True, index, Scan(time, index, distances, brightness)

    def scan(self) -> Scan:
        """The sample, or one without returns."""
        self.casts += 1
        return self._seen or super().scan()


class RecordingCamera(dry_world.DryCamera):
    """A camera that delivers what tests show it; `requests` counts how often it was asked to capture."""

    requests = 0
    _picture: Picture | None = None

    def show(
        self,
        rgb: ArrayLike,
        depth: ArrayLike = math.inf,
        segmentation: ArrayLike = 0,
        boxes: NDArray[np.void] | None = None,
        *,
        time: float = 0.0,
        index: int = 0,
    ) -> None:
        """Make a picture the one that is delivered from here on: height x width x 3, a value or one a pixel, records of boxes."""
        colours = np.array(rgb, np.uint8)
        plane = colours.shape[:2]
        self.size = (plane[1], plane[0])
        self.due, self.index = True, index
        numbers = np.full(plane, segmentation, np.int32)
        solids = np.zeros(0, BOX_3D) if boxes is None else boxes
        self._picture = Picture(time, index, colours, np.full(plane, depth, np.float32), numbers, solids)

    def request(self, *, segmentation: bool = False) -> None:
        """Count."""
        self.requests += 1

    def delivered(self) -> Picture | None:
        """What the test shows."""
        return self._picture


class RecordingImu(dry_world.DryImu):
    """An inertial unit that measures what tests write to `measured`."""

    measured: ImuSample | None = None

    def sample(self) -> ImuSample:
        """What the test says, else rest."""
        return self.measured or super().sample()


class RecordingContactSensor(dry_world.DryContactSensor):
    """A contact sensor that feels what tests write to `felt`."""

    felt: ContactReading | None = None

    def reading(self) -> ContactReading:
        """What the test says, else nothing."""
        return self.felt or super().reading()


class RecordingEntities(dry_world.DryEntities):
    """The robots and bodies of a test's world, by their prim paths."""

    def __init__(self, world: RecordingWorld) -> None:
        super().__init__(world.stage)
        self._world = world

    def place(self, name: str, move: Move) -> None:
        """Put one somewhere else."""
        body = self._world.body(self._world.stage.find(name))
        present = body.pose()
        body.place(move.position or present[0], move.orientation or present[1])
        body.linear, body.angular = move.linear or body.linear, move.angular or body.angular


class RecordingWorld(dry_world.DryWorld):
    """Bodies, robots and lidars that tests define and move; other prims are defined on `stage`. It serves sessions too."""

    def __init__(self, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        super().__init__(Stage(), tick_period, substeps)
        self._bodies: dict[Prim, RecordingBody] = {}
        self._robots: dict[Prim, RecordingArticulation] = {}
        self._lidars: dict[Prim, RecordingLidar] = {}
        self._cameras: dict[tuple[Prim, tuple[int, int] | None], RecordingCamera] = {}
        self._imus: dict[Prim, RecordingImu] = {}
        self._contact_sensors: dict[Prim, RecordingContactSensor] = {}

    def add_body(self, path: str, position: Vector3 = ORIGIN, orientation: Quaternion = IDENTITY) -> RecordingBody:
        """Define a rigid body by its pose in the world."""
        prim = self.stage.add(path, "body", position=position, orientation=orientation, body=path)
        return self._bodies.setdefault(prim, RecordingBody(position, orientation))

    def add_robot(self, path: str, joints: Sequence[str] = (), **facts: Any) -> RecordingArticulation:
        """Define a robot with a `base_link` below Geometry, fixed to the robot's own prim, which is a body."""
        base = f"{path}/Geometry/base_link"
        robot = self.stage.add(path, "robot", body=base, facts={"base_link": base, "joints": tuple(joints), **facts})
        self.stage.add(base, "link", body=base)
        self._bodies[robot] = RecordingBody()
        return self.articulation(robot)

    def add_lidar(self, path: str, **facts: Any) -> RecordingLidar:
        """Define a lidar by `rate` (Hz), `angles` (first, last, increment; rad) and `ranges` (near, far; m)."""
        return self.lidar(self.stage.add(path, "lidar", facts=facts))

    def add_camera(self, path: str, **facts: Any) -> RecordingCamera:
        """Define a camera by `rate` (Hz), `size` (pixels), `fov_deg` (horizontal, vertical) and `clip` (near, far; m)."""
        return self.camera(self.stage.add(path, "camera", facts=facts))

    def add_imu(self, path: str, **facts: Any) -> RecordingImu:
        """Define an inertial unit by `rate` (Hz)."""
        return self.imu(self.stage.add(path, "imu", facts=facts))

    def add_contact_sensor(self, path: str, **facts: Any) -> RecordingContactSensor:
        """Define a contact sensor."""
        return self.contact_sensor(self.stage.add(path, "contact", facts=facts))

    def body(self, prim: Prim) -> RecordingBody:
        """The prim's handle, always the same; it is fixed to its parent's unless it was defined as a body."""
        if prim not in self._bodies:
            carrier = self.body(prim.parent) if prim.parent else None
            self._bodies[prim] = RecordingBody(prim.position, prim.orientation, carrier=carrier)
        return self._bodies[prim]

    frame = body

    @property
    def entities(self) -> RecordingEntities:
        """Robots and bodies as wholes."""
        return RecordingEntities(self)

    def placement(self, prim: Prim) -> RecordingBody | None:
        """The prim's handle if it is a body, which stays where nodes put it."""
        return self.body(prim) if prim.body is not None else None

    def articulation(self, robot: Prim) -> RecordingArticulation:
        """The robot's joints, always the same."""
        return self._robots.setdefault(robot, RecordingArticulation(robot))

    def lidar(self, prim: Prim) -> RecordingLidar:
        """The lidar, always the same."""
        return self._lidars.setdefault(prim, RecordingLidar(prim))

    def camera(self, prim: Prim, size: tuple[int, int] | None = None) -> RecordingCamera:
        """The camera in a size, always the same."""
        return self._cameras.setdefault((prim, size), RecordingCamera(prim, size))

    def imu(self, prim: Prim) -> RecordingImu:
        """The inertial unit, always the same."""
        return self._imus.setdefault(prim, RecordingImu(prim))

    def contact_sensor(self, prim: Prim) -> RecordingContactSensor:
        """The contact sensor, always the same."""
        return self._contact_sensors.setdefault(prim, RecordingContactSensor(prim))
