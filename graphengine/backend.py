"""What the engine asks of the world and of the network; and stand-ins for a dry setup, which answer without either."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.context import (
    Articulation,
    Body,
    Frame,
    JointSelection,
    Lidar,
    Publisher,
    QoS,
    Quaternion,
    Scan,
    Subscription,
    Vector3,
)
from graphengine.diagnostics import JointError, did_you_mean, listing
from graphengine.stage import Prim, Stage


class World(Protocol):
    """Physics and sensors of a scene. Handles stay valid for its life."""

    @property
    def stage(self) -> Stage:
        """The prim tree that the handles belong to."""

    @property
    def tick_period(self) -> tuple[int, int]:
        """Seconds between two ticks as numerator and denominator, exact."""

    @property
    def substeps(self) -> int:
        """Physics steps in a tick."""

    def body(self, prim: Prim) -> Body:
        """The rigid body at, or carrying, a prim."""

    def frame(self, prim: Prim) -> Frame:
        """The pose of a prim."""

    def articulation(self, robot: Prim) -> Articulation:
        """The joints of a robot prim."""

    def lidar(self, prim: Prim) -> Lidar:
        """The ray-casting sensor at a lidar prim."""

    def step(self) -> None:
        """Apply the joints' targets and integrate one substep; afterwards every handle reads the new state.

        Raises:
            PhysicsError: the state is not finite any more.
        """

    def begin_tick(self, tick: int) -> None:
        """Tell the sensors, after the tick's last substep, that tick n is at time n times the tick period."""

    def zero_commands(self) -> None:
        """Set every joint's target velocity and effort to zero."""

    def reset(self) -> None:
        """Go back to the state at the start, commands and sensors included."""

    def close(self) -> None:
        """Release what the world holds; safe to call twice."""


@dataclass(frozen=True, slots=True)
class TopicClaim:
    """An endpoint that a node asked for: what the checks and `graphrun topics` know of the ROS 2 side."""

    node: str
    """Prim path of the node."""
    graph: str
    topic: str
    message_type: str
    direction: str
    """`publish` or `subscribe`."""
    qos: QoS
    ros_context: int = 0
    rate: float | None = None
    """Messages a second; None when an event decides."""
    latched: bool = False
    frame_id: str = ""
    transforms: tuple[tuple[str, str], ...] = ()


class Closable(Protocol):
    """An endpoint of the network, which its owner closes."""

    def close(self) -> None:
        """Leave the topic; safe to call twice."""


class OwnedPublisher(Publisher, Closable, Protocol):
    """A publisher as its owner sees it."""


class OwnedSubscription(Subscription, Closable, Protocol):
    """A subscription as its owner sees it."""


class Network(Protocol):
    """Endpoints for the topics that nodes claim."""

    def publisher(self, claim: TopicClaim) -> OwnedPublisher:
        """An endpoint to write to."""

    def subscription(self, claim: TopicClaim) -> OwnedSubscription:
        """An endpoint to read from."""

    def freeze(self) -> None:
        """Begin a tick: what has arrived so far is what subscriptions deliver, what comes later waits for the next tick."""

    def flush(self) -> None:
        """End a tick: what was published in it leaves now."""

    def log(self, severity: str, message: str) -> None:
        """Pass a message for people on to the network."""

    def close(self) -> None:
        """Leave the network; safe to call twice."""


class DryWorld:
    """A world without physics: handles that are at rest, for checks and for tests of nodes."""

    def __init__(self, stage: Stage, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        self.stage = stage
        self.tick_period = tick_period
        self.substeps = substeps

    def body(self, prim: Prim) -> Body:
        """A body at rest."""
        return DryBody(prim)

    def frame(self, prim: Prim) -> Frame:
        """A frame at the world's origin."""
        return DryBody(prim)

    def articulation(self, robot: Prim) -> Articulation:
        """Joints that stay where they are."""
        return DryArticulation(robot)

    def lidar(self, prim: Prim) -> Lidar:
        """A sensor that sees nothing."""
        return DryLidar(prim)

    def step(self) -> None:
        """Nothing moves."""

    def begin_tick(self, tick: int) -> None:
        """Nothing is due."""

    def zero_commands(self) -> None:
        """Nothing was commanded."""

    def reset(self) -> None:
        """Nothing has changed."""

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


def select_joints(articulation: Articulation, names: Sequence[str], indices: Sequence[int]) -> list[int]:
    """Positions of the joints that a selection means: by name, else by index, else all.

    Raises:
        JointError: a name or index that the articulation does not have.
    """
    known = articulation.joint_names
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known) or listing(known, "joints")
            raise JointError(f"{articulation.prim_path} has no joint {name!r}", name, hint)
    for index in indices:
        if not 0 <= index < len(known):
            raise JointError(f"{articulation.prim_path} has no joint {index}", index, f"legal: 0 to {len(known) - 1}")
    return [known.index(name) for name in names] or [int(index) for index in indices] or list(range(len(known)))


class DryArticulation:
    """A robot whose joints are known and do not move."""

    def __init__(self, robot: Prim) -> None:
        self.prim_path = robot.path
        self.joint_names: tuple[str, ...] = tuple(robot.facts.get("joints", ()))
        self.prismatic: tuple[bool, ...] = tuple(robot.facts.get("prismatic", (False,) * len(self.joint_names)))

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> JointSelection:
        """A selection that takes commands and does nothing."""
        chosen = select_joints(self, names, indices)
        return DryJointSelection(tuple(self.joint_names[i] for i in chosen))

    def positions(self) -> NDArray[np.float64]:
        """Zeros."""
        return np.zeros(len(self.joint_names))

    velocities = positions
    efforts = positions


class DryJointSelection:
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
        self.due = False

    @property
    def directions(self) -> NDArray[np.float64]:
        """Beams in the sensor's plane."""
        first, last, increment = self.angles
        azimuth = first + increment * np.arange(round((last - first) / increment) + 1)
        return np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1)

    def scan(self) -> Scan:
        """No return anywhere."""
        beams = len(self.directions)
        return Scan(0.0, 0, np.full(beams, np.inf, np.float32), np.zeros(beams, np.float32))


class DryNetwork:
    """Endpoints that lead nowhere."""

    def publisher(self, claim: TopicClaim) -> OwnedPublisher:
        """Nobody listens."""
        return DryEndpoint(claim.topic)

    def subscription(self, claim: TopicClaim) -> OwnedSubscription:
        """Nobody speaks."""
        return DryEndpoint(claim.topic)

    def freeze(self) -> None:
        """Nothing has arrived."""

    def flush(self) -> None:
        """Nothing was published."""

    def log(self, severity: str, message: str) -> None:
        """Nobody reads."""

    def close(self) -> None:
        """Nothing is held."""


class DryEndpoint:
    """A publisher nobody listens to, and a subscription nobody writes to."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.wanted = False
        self.skipped = 0

    def close(self) -> None:
        """Nothing is held."""

    def publish(self, message: Any) -> None:
        """Drop it."""

    def newest(self) -> Any | None:
        """Nothing."""
        return None

    def take(self) -> Sequence[Any]:
        """Nothing."""
        return ()
