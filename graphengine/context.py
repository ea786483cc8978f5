"""Every Protocol that a node may touch: the only door between the node library and the world outside it.

A node gets a `Context` in `setup` and keeps the handles it asks for. Handles stay valid for the life of the session: after a
robot is added or removed the engine rebinds them in place. Units are SI; quaternions are (x, y, z, w); frames are named where
a value is returned.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.sensor import Camera as Camera
from graphengine.sensor import ContactReading as ContactReading
from graphengine.sensor import ContactSensor as ContactSensor
from graphengine.sensor import Imu as Imu
from graphengine.sensor import ImuSample as ImuSample
from graphengine.sensor import Lidar as Lidar
from graphengine.sensor import Picture as Picture
from graphengine.sensor import Quaternion as Quaternion
from graphengine.sensor import Scan as Scan
from graphengine.sensor import Vector3 as Vector3


class Clock(Protocol):
    """Simulation time as the running graph sees it; constant within one pass."""

    @property
    def time(self) -> float:
        """Seconds since play; the first tick is at one tick period."""

    @property
    def monotonic_time(self) -> float:
        """Seconds of simulation since the session began, continuing over stop and play."""

    @property
    def wall_time(self) -> float:
        """Seconds since the epoch when the tick began; the only time that is not simulation's."""

    @property
    def delta(self) -> float:
        """Seconds between two passes of this graph."""

    @property
    def frame(self) -> int:
        """Number of this tick since play; the first is 1."""


class Body(Protocol):
    """A rigid body, or the rigid body that carries a prim."""

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Position (m) and orientation of the prim in the world frame."""

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Linear (m/s) and angular (rad/s) velocity of the prim's origin, in the world frame."""


class Frame(Protocol):
    """The pose of any prim, whether or not physics knows it."""

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Position (m) and orientation in the world frame."""


@dataclass(frozen=True, slots=True)
class FrameLink:
    """One edge of a transform tree: a named child frame below a named parent frame."""

    parent_name: str
    child_name: str
    parent: Frame | None
    """None stands for the world frame."""
    child: Frame
    optical: bool = False
    """Cameras turn by 180 degrees about x: from looking along -z to the ROS optical frame."""
    fixed: tuple[Vector3, Quaternion] | None = None
    """Pose of the child in the parent's frame where it never changes, because one body carries both."""


class JointSelection(Protocol):
    """Some joints of an articulation, in the order they were asked for."""

    @property
    def names(self) -> tuple[str, ...]:
        """Joint names in order."""

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Set targets from the next physics step on.

        Each sequence has one value a joint (rad or m, rad/s or m/s, N m or N); None leaves that kind as it is, and so does
        NaN for a single joint.
        """


class Articulation(Protocol):
    """A robot's moving joints."""

    @property
    def prim_path(self) -> str:
        """Path of the robot's prim."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """All moving joints, in the articulation's order."""

    @property
    def prismatic(self) -> tuple[bool, ...]:
        """For each joint, whether it slides."""

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> JointSelection:
        """Joints by name, else by index, else all.

        Raises:
            JointError: a name or index that the articulation does not have.
        """

    def positions(self) -> NDArray[np.float64]:
        """Joint positions, rad or m; a fresh array."""

    def velocities(self) -> NDArray[np.float64]:
        """Joint velocities, rad/s or m/s; a fresh array."""

    def efforts(self) -> NDArray[np.float64]:
        """Torque or force of each joint's drive after the last step, N m or N; a fresh array."""

    def wrenches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Forces (N) and torques (N m) with which each joint's parent link holds its child link, in the child's frame.

        Each has the shape (joints, 3); torques are about the child link's origin. Fresh arrays.
        """


class Publisher(Protocol):
    """One topic to write to."""

    @property
    def topic(self) -> str:
        """Full topic name."""

    @property
    def wanted(self) -> bool:
        """Whether somebody listens or records; a message that nobody wants need not be built."""

    def publish(self, message: Any) -> None:
        """Send a message of `graphengine.ros.messages` to every sink; encoded once."""


class Subscription(Protocol):
    """One topic to read from; deliveries are frozen at the start of each tick."""

    @property
    def topic(self) -> str:
        """Full topic name."""

    def newest(self) -> Any | None:
        """The newest message delivered in this tick, once; None when there is none. Older ones count as skipped."""

    def take(self) -> Sequence[Any]:
        """All messages delivered in this tick, oldest first, once."""

    @property
    def skipped(self) -> int:
        """How many messages were passed over by `newest` since play."""


class Variable(Protocol):
    """A graph's variable."""

    value: Any

    @property
    def changed(self) -> bool:
        """Whether the value at the start of this tick differs from the one at the start of the tick before."""


class Mailbox(Protocol):
    """Impulses and custom events by name: what is posted in one tick is taken in the next."""

    def post(self, item: Any = None) -> None:
        """Queue an item for the next tick."""

    def take(self) -> Sequence[Any]:
        """Items posted before this tick, oldest first, once."""


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """What robot_state_publisher knows of a robot."""

    urdf: str
    fixed: tuple[tuple[str, str, Vector3, Quaternion], ...]
    """Parent frame, child frame, translation (m) and rotation of every fixed joint."""
    moving: tuple[FrameLink, ...]
    """Links that joints move, below the links that carry them."""


class Context(Protocol):
    """What a node can ask for in `setup`. Everything handed out is owned, and closed, by the context."""

    @property
    def prim_path(self) -> str:
        """The node's own prim: its graph's prim, then its name."""

    @property
    def clock(self) -> Clock:
        """Simulation time."""

    @property
    def runs(self) -> Literal["tick", "physics_step"]:
        """How often the node's graph runs."""

    def wired(self, output: str) -> bool:
        """Whether a wire takes that output of the node, by its field: what is costly need not be computed for nobody."""

    def body(self, prim: str) -> Body:
        """The rigid body at, or carrying, a prim."""

    def frame(self, prim: str) -> Frame:
        """The pose of any prim."""

    def transform_tree(self, targets: Sequence[str], parent: str = "") -> Sequence[FrameLink]:
        """The edges that OmniGraph expands target prims to: a robot to its links, any other prim to one edge."""

    def articulation(self, prim: str) -> Articulation:
        """The robot that a prim stands for."""

    def joint_names(self, prim: str) -> Sequence[str]:
        """Names under which a robot's joints are published: `isaac:nameOverride`, else the joint's own."""

    def robot_description(self, prim: str) -> RobotDescription:
        """The description of the robot that a prim stands for."""

    def render_product(self, prim: str, width: int, height: int) -> str:
        """Path of the render product of a sensor or camera prim; the same answer for the same question."""

    def lidar(self, render_product: str) -> Lidar:
        """The lidar behind a render product, or at a prim path; in graphs that run once a tick."""

    def camera(self, render_product: str) -> Camera:
        """The camera behind a render product, in its size, or at a prim path, in its own; in graphs that run once a tick."""

    def exchange_camera(self, render_product: str, prim: str) -> Callable[[], None]:
        """What, when called, lets a render product show what another camera sees, to all who hold its camera."""

    def imu(self, prim: str) -> Imu:
        """The inertial unit at a prim."""

    def contact_sensor(self, prim: str) -> ContactSensor:
        """The contact sensor at a prim."""

    def ros_context(self, domain_id: int, use_environment: bool) -> int:
        """Handle of a ROS 2 domain; 0 means the session's own."""

    def publisher(
        self,
        message_type: str,
        topic: str,
        *,
        namespace: str = "",
        namespace_from: str = "",
        outermost_namespace: bool = False,
        qos_profile: str = "",
        queue_size: int = 10,
        latched: bool = False,
        ros_context: int = 0,
        rate: float | None = None,
        frame_id: str = "",
        transforms: Sequence[tuple[str, str]] = (),
    ) -> Publisher:
        """A topic to write to.

        Args:
            message_type: ROS 2 name, as in `nav_msgs/msg/Odometry`.
            topic: name below the namespace; leading and trailing non-alphanumerics are dropped.
            namespace: used verbatim when not empty; else collected from prims.
            namespace_from: prim where collection starts; the node's own prim when empty.
            outermost_namespace: keep only the outermost collected value, as TF nodes do.
            qos_profile: JSON text of a QoS profile; empty for reliable, volatile, keep-last `queue_size`.
            queue_size: history depth without a profile.
            latched: transient local with depth 1, whatever the profile says.
            ros_context: handle from `ros_context`.
            rate: messages a second where the node knows better than its place in the graph.
            frame_id: what goes into the header, for the table of topics.
            transforms: (parent, child) pairs that will be published, for the checks of the TF tree.
        """

    def subscription(
        self,
        message_type: str,
        topic: str,
        *,
        namespace: str = "",
        outermost_namespace: bool = False,
        qos_profile: str = "",
        queue_size: int = 10,
        ros_context: int = 0,
        alternatives: Sequence[str] = (),
    ) -> Subscription:
        """A topic to read from; arguments as for `publisher`.

        `alternatives` are message types that will do as well, in place of the first where that is not what others publish.
        """

    def variable(self, name: str) -> Variable:
        """A variable of the node's graph."""

    def mailbox(self, name: str) -> Mailbox:
        """A named queue of the session."""

    def random(self) -> np.random.Generator:
        """A generator seeded by the session's seed and the node's prim path."""

    def log(self, severity: Literal["info", "warning", "error"], message: str) -> None:
        """Tell the user, once for each different message."""


@dataclass(frozen=True, slots=True)
class QoS:
    """Quality of service of an endpoint, in the words of OmniGraph's QoS profiles; times in seconds, 0 for unlimited."""

    history: Literal["keepLast", "keepAll", "systemDefault"] = "keepLast"
    depth: int = 10
    reliability: Literal["reliable", "bestEffort", "systemDefault"] = "reliable"
    durability: Literal["volatile", "transientLocal", "systemDefault"] = "volatile"
    deadline: float = 0.0
    lifespan: float = 0.0
    liveliness: Literal["automatic", "manualByTopic", "systemDefault"] = "systemDefault"
    lease_duration: float = 0.0
