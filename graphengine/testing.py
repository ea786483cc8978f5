"""For tests of nodes: a Context that records, over a world and a network that tests write; and a check of node classes.

    context = RecordingContext()
    robot = context.world.add_robot("/dd100", ["left", "right"])
    node = IsaacArticulationController(robot_path="/dd100", velocity_command=np.array([1.0, 2.0]))
    node.setup(context)
    node.compute()
    assert robot.velocity_targets == [1.0, 2.0]

Prims, namespaces, QoS and transform trees are the engine's own. `RecordingWorld` and `RecordingNetwork` also serve a whole session.
"""

from __future__ import annotations

import inspect
import itertools
import json
import math
import re
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine import rotation
from graphengine.backend import (
    DryArticulation,
    DryEndpoint,
    DryJointSelection,
    DryLidar,
    DryNetwork,
    DryWorld,
    TopicClaim,
    select_joints,
)
from graphengine.context import Quaternion, Scan, Vector3
from graphengine.diagnostics import GraphError, listing
from graphengine.node import Node, NodeClassError, Port
from graphengine.node_context import GraphVariable, NodeContext, Services, SimulationClock
from graphengine.registry import Registry, default_registry
from graphengine.ros import messages
from graphengine.schema import make_schema
from graphengine.stage import IDENTITY, ORIGIN, Prim, Stage
from graphengine.types import UnionType


@dataclass(slots=True)
class Motion:
    """Where a body is and how it moves, in the world frame."""

    position: Vector3 = ORIGIN
    orientation: Quaternion = IDENTITY
    linear: Vector3 = (0.0, 0.0, 0.0)
    angular: Vector3 = (0.0, 0.0, 0.0)


class RecordingBody:
    """A prim's pose and velocity: its own motion, or that of the nearest prim above that has one."""

    def __init__(self, motions: Mapping[str, Motion], prim: Prim) -> None:
        self._motions = motions
        self._prim = prim

    def _carried(self) -> tuple[Motion, rotation.Pose]:
        """What carries the prim, and the prim's pose in it."""
        pose: rotation.Pose = (ORIGIN, IDENTITY)
        for prim in self._prim.ancestors():
            if prim.path in self._motions:
                return self._motions[prim.path], pose
            pose = rotation.compose((prim.position, prim.orientation), pose)
        return Motion(), pose

    def pose(self) -> tuple[Vector3, Quaternion]:
        """In the world frame."""
        motion, pose = self._carried()
        return rotation.compose((motion.position, motion.orientation), pose)

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Linear and angular, in the world frame; v + w x r for what is carried at r."""
        motion, (arm, _) = self._carried()
        (x, y, z), (wx, wy, wz) = rotation.rotate(motion.orientation, arm), motion.angular
        vx, vy, vz = motion.linear
        return (vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x), motion.angular


class RecordingArticulation(DryArticulation):
    """Joints where a test puts them, and the targets that nodes gave them; NaN where nothing was commanded."""

    def __init__(self, robot: Prim) -> None:
        super().__init__(robot)
        joints = len(self.joint_names)
        self.state: dict[str, ArrayLike] = {kind: [0.0] * joints for kind in ("position", "velocity", "effort")}
        self.position_targets = [math.nan] * joints
        self.velocity_targets = [math.nan] * joints
        self.effort_targets = [math.nan] * joints
        self.commands = 0
        """How often a node commanded."""

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> RecordingSelection:
        """Joints by name, else by index, else all."""
        return RecordingSelection(self, select_joints(self, names, indices))

    def positions(self) -> NDArray[np.float64]:
        """What the test says."""
        return np.array(self.state["position"], np.float64)

    def velocities(self) -> NDArray[np.float64]:
        """What the test says."""
        return np.array(self.state["velocity"], np.float64)

    def efforts(self) -> NDArray[np.float64]:
        """What the test says."""
        return np.array(self.state["effort"], np.float64)


class RecordingSelection(DryJointSelection):
    """Some joints; a command writes the articulation's targets."""

    def __init__(self, articulation: RecordingArticulation, joints: Sequence[int]) -> None:
        super().__init__(tuple(articulation.joint_names[joint] for joint in joints))
        self._articulation = articulation
        self._joints = joints

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Set what is given and not NaN."""
        robot = self._articulation
        robot.commands += 1
        targets = (robot.position_targets, robot.velocity_targets, robot.effort_targets)
        for target, values in zip(targets, (positions, velocities, efforts), strict=True):
            for joint, value in zip(self._joints, values or [math.nan] * len(self._joints), strict=True):
                target[joint] = target[joint] if math.isnan(value) else value


class RecordingLidar(DryLidar):
    """A lidar that sees what a test says; `casts` counts how often it was asked."""

    casts = 0
    _seen: Scan | None = None

    def see(self, ranges: ArrayLike, intensities: ArrayLike = 0.0, *, time: float = 0.0, index: int = 0) -> None:
        """Make a sample due: one range a beam, inf where nothing is."""
        distances = np.array(ranges, np.float32)
        brightness = np.broadcast_to(np.array(intensities, np.float32), distances.shape)
        self.due, self._seen = True, Scan(time, index, distances, brightness)

    def scan(self) -> Scan:
        """The sample, or one without returns."""
        self.casts += 1
        return self._seen or super().scan()


class RecordingWorld(DryWorld):
    """Prims, bodies, robots and lidars that tests define and move."""

    def __init__(self, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        super().__init__(Stage(), tick_period, substeps)
        self.motions: dict[str, Motion] = {}
        """By prim path."""
        self.robots: dict[str, RecordingArticulation] = {}
        self.lidars: dict[str, RecordingLidar] = {}

    def add_body(self, path: str, position: Vector3 = ORIGIN, orientation: Quaternion = IDENTITY) -> Motion:
        """Define a rigid body; write what comes back to move it."""
        prim = self.stage.add(path, "body", body=path)
        self.motions[prim.path] = motion = Motion(position, orientation)
        return motion

    def add_robot(
        self, path: str, joints: Sequence[str] = (), prismatic: Sequence[bool] = (), **facts: Any
    ) -> RecordingArticulation:
        """Define a robot with a `base_link` below Geometry that carries its other links, which the test adds."""
        base = f"{path}/Geometry/base_link"
        slides = tuple(prismatic) or (False,) * len(joints)
        facts = {"base_link": base, "joints": tuple(joints), "prismatic": slides, **facts}
        robot = self.stage.add(path, "robot", body=base, facts=facts)
        self.stage.add(base, "link", body=base)
        for joint in joints:
            self.stage.add(f"{path}/Physics/{joint}", "joint")
        self.motions[path] = self.motions[base] = Motion()
        return self.articulation(robot)

    def add_lidar(self, path: str, **facts: Any) -> RecordingLidar:
        """Define a lidar; facts are its `rate` (Hz), `angles` (first, last, increment; rad) and `ranges` (near, far; m)."""
        return self.lidar(self.stage.add(path, "lidar", facts=facts))

    def body(self, prim: Prim) -> RecordingBody:
        """A handle that follows the motions."""
        return RecordingBody(self.motions, prim)

    frame = body

    def articulation(self, robot: Prim) -> RecordingArticulation:
        """The robot's joints, always the same."""
        return self.robots.setdefault(robot.path, RecordingArticulation(robot))

    def lidar(self, prim: Prim) -> RecordingLidar:
        """The lidar, always the same."""
        return self.lidars.setdefault(prim.path, RecordingLidar(prim))


class RecordingEndpoint(DryEndpoint):
    """A topic: what was published, or what is delivered. `wanted` is the test's to set."""

    def __init__(self, claim: TopicClaim, *, wanted: bool = True) -> None:
        super().__init__(claim.topic)
        self.claim = claim
        self.wanted = wanted
        self.messages: list[Any] = []
        depth = max(claim.qos.depth, 1) if claim.qos.history == "keepLast" else None
        self._arrived: deque[Any] = deque(maxlen=depth)
        self._visible: deque[Any] = deque(maxlen=depth)

    def publish(self, message: Any) -> None:
        """Keep the message; it must be what its type says, and of the topic's type."""
        messages.check(message)
        if messages.message_type(message) != self.claim.message_type:
            raise TypeError(f"{self.topic} is {self.claim.message_type}, not {messages.message_type(message)}")
        self.messages.append(message)

    def deliver(self, *arriving: Any) -> None:
        """Let messages arrive; the next tick sees them, as far as the queue holds them."""
        self._arrived.extend(arriving)

    def freeze(self) -> None:
        """Begin a tick."""
        self._visible.extend(self._arrived)
        self._arrived.clear()

    def newest(self) -> Any | None:
        """The newest message, once."""
        taken = self.take()
        self.skipped += max(len(taken) - 1, 0)
        return taken[-1] if taken else None

    def take(self) -> Sequence[Any]:
        """All messages, once."""
        taken = list(self._visible)
        self._visible.clear()
        return taken


class RecordingNetwork(DryNetwork):
    """Topics that tests read and feed."""

    def __init__(self, *, wanted: bool = True) -> None:
        self.wanted = wanted
        """Whether somebody listens to topics that are opened from now on."""
        self.publishers: list[RecordingEndpoint] = []
        self.subscriptions: list[RecordingEndpoint] = []

    def publisher(self, claim: TopicClaim) -> RecordingEndpoint:
        """An endpoint that keeps what is published."""
        self.publishers.append(made := RecordingEndpoint(claim, wanted=self.wanted))
        return made

    def subscription(self, claim: TopicClaim) -> RecordingEndpoint:
        """An endpoint that delivers what tests feed."""
        self.subscriptions.append(made := RecordingEndpoint(claim))
        return made

    def published(self, topic: str) -> list[Any]:
        """Messages on a topic, oldest first; of several publishers, one after the other."""
        return [message for publisher in self.publishers if publisher.topic == topic for message in publisher.messages]

    def deliver(self, topic: str, *arriving: Any) -> None:
        """Let messages arrive on a topic that a node reads; the next tick sees them.

        Raises:
            LookupError: nobody reads it.
        """
        readers = [subscription for subscription in self.subscriptions if subscription.topic == topic]
        if not readers:
            raise LookupError(f"nobody reads {topic}; {listing([s.topic for s in self.subscriptions], 'topics read')}")
        for reader in readers:
            reader.deliver(*arriving)

    def freeze(self) -> None:
        """Begin a tick."""
        for subscription in self.subscriptions:
            subscription.freeze()


class RecordingContext(NodeContext):
    """One node's door to a world and a network of a test.

    Args:
        prim_path: of the node; namespaces are collected from here.
        world: an empty one when None.
        network: one on which everything is wanted when None.
        seed: of `random`.
        domain_from_environment: what ROS_DOMAIN_ID would say.
        variables: values of the graph's variables.
    """

    clock: SimulationClock

    def __init__(
        self,
        prim_path: str = "/World/graph/node",
        *,
        world: RecordingWorld | None = None,
        network: RecordingNetwork | None = None,
        seed: int = 0,
        domain_from_environment: int | None = None,
        variables: Mapping[str, Any] | None = None,
    ) -> None:
        self.world = world or RecordingWorld()
        self.network = network or RecordingNetwork()
        self.logged: list[tuple[str, str]] = []
        """Severity and text of what the node said."""
        self.variables = {name: GraphVariable(value) for name, value in (variables or {}).items()}
        self.services = Services(self.world, self.network, seed, domain_from_environment=domain_from_environment)
        self.services.log = lambda severity, _, message: self.logged.append((severity, message))
        clock = SimulationClock(self.world.tick_period)
        super().__init__(self.services, clock, "graph", prim_path, 1.0 / clock.delta, self.variables)

    def tick(self, ticks: int = 1) -> None:
        """Begin the next tick: time goes on, what arrived before becomes visible."""
        for _ in range(ticks):
            self.network.freeze()
            for item in (*self.services.mailboxes.values(), *self.variables.values()):
                item.freeze()
            self.clock.set_frame(self.clock.frame + 1)

    def stop(self, *nodes: Node) -> None:
        """Stop, as a session does: time back to 0, nodes' outputs and state back to their defaults."""
        for node in nodes:
            node.reset()
            node.clear()
        self.clock.stop()


def check_node(
    cls: type[Node], make_context: Callable[[], RecordingContext] = RecordingContext, **inputs: Any
) -> None:
    """Hold a node class against what users and the engine expect of it.

    Its words: a docstring whose first line is a fact, ports that explain themselves or have a doc, units on physical numbers. Its
    shape: a name that nobody else has, legal defaults, a JSON Schema. Its behaviour, on its defaults and `inputs`: setup and
    compute touch nothing undeclared and do the same each time; that they refuse the inputs (ValueError, GraphError) is fine.

    Args:
        cls: class of the node.
        make_context: gives the node's surroundings, new ones each time.
        inputs: values for inputs that the node cannot do without, by field.

    Raises:
        NodeClassError: it lists everything that is wrong.
    """
    problems = [*_words(cls), *_shape(cls), *_behaviour(cls, make_context, inputs)]
    if problems:
        lines = "".join(f"\n  - {problem}" for problem in problems)
        raise NodeClassError(f"{cls.__module__}.{cls.__qualname__} is not a sound node:{lines}")


_PHYSICAL = set("acceleration angle delay distance dt duration effort force frequency length mass period position".split())
_PHYSICAL |= set("radius rate second speed stamp temperature time timeout torque translation velocity".split())


def _words(cls: type[Node]) -> Iterator[str]:
    first = (inspect.getdoc(cls) or "").partition("\n")[0] if cls.__doc__ else ""
    if not first:
        yield "it has no docstring; its first line is what `graphrun nodes` shows"
    elif re.match(r"(this|a node|the node|node that|class)\b", first, re.IGNORECASE) or not first.endswith("."):
        yield f"the docstring's first line states a fact and ends with a full stop, it is {first!r}"
    for port in cls.fields.values():
        if port.side == "state":
            continue
        said = re.search(r"[A-Z_]", port.name) or port.component or port.name.lower() in cls.type_name.lower()
        if not (port.doc or port.unit or port.tokens or said):
            yield f"{port.name}: a name of one word needs a doc"
        words = re.findall(r"[a-z]+", re.sub(r"[A-Z]", lambda match: f" {match[0].lower()}", port.name))
        real = not isinstance(port.type, UnionType) and port.type.base in ("half", "float", "double")
        if real and not port.unit and any(word.removesuffix("s") in _PHYSICAL for word in [*words, "".join(words)]):
            yield f"{port.name}: a physical number needs a unit, even if it is 1"


def _shape(cls: type[Node]) -> Iterator[str]:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+", cls.type_name):
        yield f"a registered name has at least two parts, as in my_robots.Gripper; type= is {cls.type_name!r}"
    for name in (cls.type_name, *cls.aliases):
        other = default_registry().types.get(name, cls)
        if other is not cls:
            yield f"{name!r} is the name of {other.__module__}.{other.__qualname__}"
    twice = [key for key, ports in itertools.groupby(sorted(f"{p.side}:{p.name}" for p in cls.fields.values()))
             if len(list(ports)) > 1]  # fmt: skip
    yield from (f"two ports are called {key}" for key in twice)
    for port in cls.fields.values():
        if port.side != "state" and not port.is_exec and not port.required:
            try:
                port.check(port.default)
            except (TypeError, ValueError) as error:
                yield f"{port.name}: its default {port.default!r} is not legal: {error}"
    try:
        registry = Registry()
        registry.add(cls)
        json.dumps(make_schema("graph", registry), allow_nan=False)
    except Exception as error:  # whatever it is, the author has to know
        yield f"it cannot be described as JSON Schema: {error}"


def _behaviour(cls: type[Node], make_context: Callable[[], RecordingContext], inputs: dict[str, Any]) -> Iterator[str]:
    groups: dict[object, list[Port]] = {}
    for port in cls.fields.values():
        if port.required:
            groups.setdefault(port.field if port.required is True else port.required, []).append(port)
    needed = [ports[0].field for ports in groups.values() if not any(port.field in inputs for port in ports)]
    if needed:
        yield f"check_node needs a value for {' and '.join(needed)}, which the node cannot do without"
        return
    try:
        one, other = (_recorded(cls(**inputs), make_context()) for _ in range(2))
    except _Problem as problem:
        yield str(problem)
    except Exception as error:
        yield f"its constructor raises {type(error).__name__}: {error}"
    else:
        if one != other:
            yield "two instances with the same inputs do not do the same; take time and chance from the context"


class _Problem(Exception):
    """A node that does what it must not."""


def _recorded(node: Node, context: RecordingContext) -> list[object]:
    """Everything a node shows in three ticks, in a form that compares."""
    cls, record, step = type(node), list[object](), "setup"
    if hasattr(node, "__dict__"):
        raise _Problem("its instances have a __dict__, so that misspelt attributes go unnoticed: a base lacks __slots__")
    try:
        node.setup(context)
        for _ in range(3):
            step = "compute"
            context.tick()
            for port in cls.fields.values():
                if port.is_exec and port.side == "inputs":
                    setattr(node, port.field, 1)
            fired = node.compute()
            if cls.kind() == "pusher":
                fired = list(itertools.islice(fired, 1000))
            elif fired is not None and not (cls.gated or cls.kind() == "data"):
                raise _Problem("compute returns what to fire, but the class is not gated=True")
            step = "update"
            record += [fired, node.update() if isinstance(node, _Latent) and node.active else None]
            outputs = [getattr(node, p.field) for p in cls.fields.values() if p.side == "outputs" and not p.is_exec]
            record += [(v.dtype.str, v.shape, v.tobytes()) if isinstance(v, np.ndarray) else repr(v) for v in outputs]
    except (ValueError, GraphError) as refusal:
        record.append(f"{step}: {refusal}")
    except _Problem:
        raise
    except Exception as error:
        line = traceback.extract_tb(error.__traceback__)[-1].lineno
        touches = " (an attribute that is not declared, or a State that setup does not bind)"
        why = touches if isinstance(error, AttributeError) else ""
        raise _Problem(f"{step} raises {type(error).__name__} in line {line}: {error}{why}") from error
    return [*record, *(messages.encode(m) for publisher in context.network.publishers for m in publisher.messages)]
