"""For tests of nodes: a Context over a world and topics that tests write and read; and a check of node classes.

    context = RecordingContext()
    robot = context.world.add_robot("/dd100", ["left", "right"])
    node = IsaacArticulationController(robot_path="/dd100", velocity_command=np.array([1.0, 2.0]))
    node.setup(context)
    node.compute()
    assert robot.targets["velocity"] == [1.0, 2.0]

`context.transport.messages("/odom")` reads a topic back, `context.transport.inject("/cmd_vel", twist)` feeds one.
"""

from __future__ import annotations

import inspect
import itertools
import json
import math
import re
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partialmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine import backend, dry, rotation
from graphengine.context import BOX_3D, ContactReading, ImuSample, Picture, Quaternion, Scan, Vector3
from graphengine.diagnostics import GraphError
from graphengine.graph_variable import GraphVariable
from graphengine.node import Node, NodeClassError
from graphengine.node_context import NodeContext, Services
from graphengine.registry import Registry, default_registry
from graphengine.ros.memory import MemoryTransport
from graphengine.ros.network import LiveNetwork
from graphengine.schema import make_schema
from graphengine.simulation_clock import SimulationClock
from graphengine.stage import IDENTITY, ORIGIN, Prim, Stage
from graphengine.types import UnionType


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


class RecordingArticulation(dry.DryArticulation):
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


class RecordingSelection(dry.DryJointSelection):
    """Some joints; a command writes the articulation's targets."""

    def __init__(self, robot: RecordingArticulation, joints: Sequence[int]) -> None:
        super().__init__(tuple(robot.joint_names[joint] for joint in joints))
        self.robot, self.joints = robot, joints

    def command(self, positions: Any = None, velocities: Any = None, efforts: Any = None) -> None:
        """Set what is given and not NaN."""
        for target, values in zip(self.robot.targets.values(), (positions, velocities, efforts), strict=True):
            for joint, value in zip(self.joints, values or [math.nan] * len(self.joints), strict=True):
                target[joint] = target[joint] if math.isnan(value) else value


class RecordingLidar(dry.DryLidar):
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


class RecordingCamera(dry.DryCamera):
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


class RecordingImu(dry.DryImu):
    """An inertial unit that measures what tests write to `measured`."""

    measured: ImuSample | None = None

    def sample(self) -> ImuSample:
        """What the test says, else rest."""
        return self.measured or super().sample()


class RecordingContactSensor(dry.DryContactSensor):
    """A contact sensor that feels what tests write to `felt`."""

    felt: ContactReading | None = None

    def reading(self) -> ContactReading:
        """What the test says, else nothing."""
        return self.felt or super().reading()


class RecordingEntities(dry.DryEntities):
    """The robots and bodies of a test's world, by their prim paths."""

    def __init__(self, world: RecordingWorld) -> None:
        super().__init__(world.stage)
        self._world = world

    def place(
        self,
        name: str,
        position: Vector3 | None = None,
        orientation: Quaternion | None = None,
        linear: Vector3 | None = None,
        angular: Vector3 | None = None,
    ) -> None:
        """Put one somewhere else."""
        body = self._world.body(self._world.stage.find(name))
        present = body.pose()
        body.place(position or present[0], orientation or present[1])
        body.linear, body.angular = linear or body.linear, angular or body.angular


class RecordingWorld(dry.DryWorld):
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


class RecordingContext(NodeContext):
    """One node's door to a world and a network of a test; `wanted` says whether somebody listens to all topics."""

    clock: SimulationClock

    def __init__(
        self, prim_path: str = "/World/graph/node", *, wanted: bool = True, ros_domain_id: int | None = None
    ) -> None:
        self.world, self._memory = RecordingWorld(), MemoryTransport(wants_all=wanted)
        self.logged: list[tuple[str, str]] = []  # severity and text
        self.variables: dict[str, GraphVariable] = {}
        network = LiveNetwork(lambda _: self._memory, 0, lambda text: self.logged.append(("network", text)))
        self.services = Services(self.world, network, domain_from_environment=ros_domain_id)
        self.services.log = lambda severity, _, message: self.logged.append((severity, message))
        clock = SimulationClock(self.world.tick_period)
        super().__init__(self.services, clock, "graph", prim_path, 1.0 / clock.delta, self.variables)

    @property
    def transport(self) -> MemoryTransport:
        """The topics, with everything that was published until now."""
        self.services.network.flush()
        return self._memory

    def tick(self, ticks: int = 1) -> None:
        """Begin the next tick: time goes on, what arrived becomes visible."""
        for _ in range(ticks):
            shared = self.services
            frozen: list[Any] = [shared.network, shared.keys, *shared.mailboxes.values(), *self.variables.values()]
            for part in frozen:
                part.freeze()
            self.clock.set_frame(self.clock.frame + 1)

    def stop(self, *nodes: Node) -> None:
        """Stop as a session does: time is 0, nodes' outputs and state are at their defaults."""
        self.services.network.forget_calls()
        for node in nodes:
            node.reset()
            node.clear()
        for path in self.services.generators:
            self.services.reseed(path)
        self.clock.stop()


def check_node(cls: type[Node], make: Callable[[], RecordingContext] = RecordingContext, /, **inputs: Any) -> None:
    """Raise NodeClassError with all that users and the engine expect of a node class and do not find.

    A docstring whose first line is a fact; ports that say what they are; units on physical numbers. A name that nobody else has;
    legal defaults; a JSON Schema. Ticks that touch nothing undeclared, and that are the same in every instance and every play; a
    node may refuse its inputs. `make` gives its surroundings, `inputs` values by field of what it cannot do without.
    """
    problems = [*_words(cls), *_shape(cls), *_behaviour(cls, make, inputs)]
    if problems:
        raise NodeClassError("\n  - ".join([f"{cls.__module__}.{cls.__qualname__} is not a sound node:", *problems]))


_PHYSICAL = "acceleration angle delay distance dt duration effort force frequency length mass period position radius "
_PHYSICAL += "rate second speed stamp temperature time timeout torque translation velocity velocitie"


def _words(cls: type[Node]) -> Iterator[str]:
    first = (inspect.getdoc(cls) or "").partition("\n")[0] if cls.__doc__ else ""
    if not first.endswith(".") or re.match(r"(?i)(this|a node|the node|node that|class)\b", first):
        yield f"the first line of its docstring states a fact and ends with a full stop, it is {first!r}"
    for port in (port for port in cls.fields.values() if port.side != "state" and not port.is_exec):
        told = port.doc or port.unit or port.tokens or port.component or re.search(r"[A-Z_]", port.name)
        if not told and port.name.lower() not in cls.type_name.lower():
            yield f"{port.name}: a name of one word needs a doc"
        words = {word.removesuffix("s") for word in port.field.split("_")}
        real = str(port.type).startswith(("double", "float", "half", "vector"))
        if real and not port.unit and "type" not in words and words.intersection(_PHYSICAL.split()):
            yield f"{port.name}: a physical number needs a unit"


def _shape(cls: type[Node]) -> Iterator[str]:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+", cls.type_name):
        yield f"a registered name has several parts, as in my_robots.Gripper; type= is {cls.type_name!r}"
    for name in (cls.type_name, *cls.aliases):
        if (other := default_registry().types.get(name, cls)) not in cls.__mro__:  # one may have grown ports
            yield f"{name!r} is the name of {other.__module__}.{other.__qualname__}"
    named = [f"{port.side}:{port.name}" for port in cls.fields.values()]
    yield from (f"{named.count(name)} ports are called {name}" for name in sorted(set(named)) if named.count(name) > 1)
    for port in cls.fields.values():
        try:
            if port.side != "state" and not port.is_exec and not port.required:
                port.check(port.default)
        except (TypeError, ValueError) as error:
            yield f"{port.name}: its default {port.default!r} is not legal: {error}"
    try:
        registry = Registry()
        registry.add(cls)
        json.dumps(make_schema("graph", registry), allow_nan=False)
    except Exception as error:  # whatever it is, the author has to know
        yield f"it cannot be described as JSON Schema: {error}"


def _behaviour(cls: type[Node], make: Callable[[], RecordingContext], inputs: Mapping[str, Any]) -> Iterator[str]:
    ports = [p for p in cls.fields.values() if p.side == "inputs" and (p.required or isinstance(p.type, UnionType))]
    given = {p.required for p in ports if p.field in inputs and isinstance(p.required, str)}
    needed = [p.field for p in ports if p.field not in inputs and p.required not in given]
    if needed:
        yield f"check_node needs values for what the node cannot do without: {', '.join(needed)}"
        return
    try:
        (one, again), (other, _) = (_two_plays(cls(**inputs), make()) for _ in range(2))
        if one != other:
            yield "two instances with the same inputs do not do the same; take time and chance from the context"
        elif one != again:
            yield "after a stop it is not what it was; a State that setup binds has no default, any other has one"
    except Exception as error:  # whatever it is, the author has to know
        yield f"{type(error).__name__} in line {traceback.extract_tb(error.__traceback__)[-1].lineno}: {error}"


def _two_plays(node: Any, context: RecordingContext) -> list[list[object]]:
    """Everything a node shows in three ticks, and again after a stop, in a form that compares."""
    if hasattr(node, "__dict__"):
        raise TypeError("instances have a __dict__, where misspelt attributes hide; a base class lacks __slots__")
    record, again = plays = [list[object](), list[object]()]
    try:
        node.setup(context)
        for record, tick in itertools.product(plays, range(3)):
            if tick == 0 and record is again:
                context.clock.set_frame(0)  # before the stop, so that time since the session began repeats too
                context.stop(node)
            context.tick()
            sent = {claim.topic: len(context.transport.raw(claim.topic)) for claim in context.services.claims}
            for port in node.fields.values():
                if port.is_exec and port.side == "inputs" and not port.control:
                    setattr(node, port.field, 1)
            fired = node.compute()
            if node.kind() == "pusher":
                fired = list(itertools.islice(fired, 1000))
            elif fired is not None and not node.gated:
                raise TypeError("compute returns what to fire, but the class is not gated=True")
            record += [fired, node.update() if node.kind() == "latent" and node.active else None]
            outputs = [getattr(node, p.field) for p in node.fields.values() if p.side == "outputs" and not p.is_exec]
            record += [(v.dtype.str, v.shape, v.tobytes()) if isinstance(v, np.ndarray) else repr(v) for v in outputs]
            record += [context.transport.raw(topic)[before:] for topic, before in sent.items()]
    except (ValueError, GraphError) as refusal:
        record.append(str(refusal))
    return plays if again else [record, record]
