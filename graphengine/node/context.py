"""Every Protocol that a node may touch: the only door between the node library and the world outside it.

A node gets a `Context` in `setup` and keeps the handles it asks for. Handles stay valid for the life of the session: after a
robot is added or removed the engine rebinds them in place. Units are SI; quaternions are (x, y, z, w); frames are named where
a value is returned.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol, TypedDict, Unpack

import numpy as np

from graphengine.devices.motion import Articulation, Body, Frame, FrameLink, Placement
from graphengine.devices.sensor import (
    Camera,
    ContactSensor,
    Imu,
    Lidar,
    Quaternion,
    Vector3,
)
from graphengine.messages.endpoints import Publisher, ServiceClient, ServiceServer, Subscription
from graphengine.node.clock import Clock
from graphengine.node.keys import Keyboard
from graphengine.node.mailbox import Mailbox
from graphengine.node.prims.stage_prims import PrimAttribute, Prims
from graphengine.node.variable import Variable


class EndpointOptions(TypedDict, total=False):
    """What a node can say of a topic or service besides its type and name."""

    namespace: str
    """Used verbatim when not empty."""
    qos_profile: str
    """JSON text of a QoS profile; empty for reliable, volatile, keep-last."""
    ros_context: int
    """Handle from `ros_context`."""


class TopicOptions(EndpointOptions, total=False):
    """What a node can say of a topic; an empty namespace is collected from prims."""

    outermost_namespace: bool
    """Keep only the outermost collected value, as TF nodes do."""
    queue_size: int
    """History depth without a profile; 10 by default."""


class ServiceOptions(EndpointOptions, total=False):
    """What a node can say of a service."""

    collects_namespace: bool
    """An empty namespace is collected from the prims above the node."""


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
    def graph_path(self) -> str:
        """The prim that the node's graph is put at."""

    @property
    def clock(self) -> Clock:
        """Simulation time."""

    @property
    def runs(self) -> Literal["tick", "physics_step"]:
        """How often the node's graph runs."""

    def wired(self, output: str) -> bool:
        """Whether a wire takes that output of the node, by its field: what is costly need not be computed for nobody."""

    def wires_into(self, pin: str) -> int:
        """How many wires end at an execution input of the node, by its field."""

    def body(self, prim: str) -> Body:
        """The rigid body at, or carrying, a prim."""

    def frame(self, prim: str) -> Frame:
        """The pose of any prim."""

    def placement(self, prim: str) -> Placement | None:
        """What puts a prim somewhere; None for one that neither moves by itself nor stands for a robot that does."""

    def transform_tree(self, targets: Sequence[str], parent: str = "", *, loops: bool = True) -> Sequence[FrameLink]:
        """The edges that OmniGraph expands target prims to: a robot to its links, any other prim to one edge.

        Args:
            targets: paths of prims.
            parent: path of the parent frame's prim; empty for the world.
            loops: whether a link or body that is the parent and a target has an edge from itself to itself.
        """

    def articulation(self, prim: str) -> Articulation:
        """The robot that a prim stands for."""

    def joint_names(self, prim: str) -> Sequence[str]:
        """Names under which a robot's joints are published: `isaac:nameOverride`, else the joint's own."""

    def robot_description(self, prim: str) -> RobotDescription:
        """The description of the robot that a prim stands for."""

    def render_product(self, prim: str, width: int, height: int) -> str:
        """Path of the render product of a sensor or camera prim; the same answer for the same question."""

    def viewport(self, name: str, size: tuple[int, int] | None = None, *, make: bool = False) -> str:
        """Path of the render product of a viewport, which shows the first camera that `exchange_camera` is asked for.

        Args:
            name: of the viewport; "Viewport" is always there.
            size: width and height of its pictures from now on, pixels; as they are when None, at first 1280 x 720.
            make: make it unless it is there.
        """

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
        namespace_from: str = "",
        latched: bool = False,
        rate: float | None = None,
        frame_id: str = "",
        transforms: Sequence[tuple[str, str]] = (),
        **options: Unpack[TopicOptions],
    ) -> Publisher:
        """A topic to write to.

        Args:
            message_type: ROS 2 name, as in `nav_msgs/msg/Odometry`.
            topic: name below the namespace; leading and trailing non-alphanumerics are dropped.
            namespace_from: prim where collection of the namespace starts; the node's own prim when empty.
            latched: transient local with depth 1, whatever the profile says.
            rate: messages a second where the node knows better than its place in the graph.
            frame_id: what goes into the header, for the table of topics.
            transforms: (parent, child) pairs that will be published, for the checks of the TF tree.
            options: what can be said of every topic.
        """

    def subscription(
        self, message_type: str, topic: str, *, alternatives: Sequence[str] = (), **options: Unpack[TopicOptions]
    ) -> Subscription:
        """A topic to read from; arguments as for `publisher`.

        `alternatives` are message types that will do as well, in place of the first where that is not what others publish.
        """

    def service_server(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceServer:
        """A service to offer.

        Args:
            service_type: ROS 2 name, as in `std_srvs/srv/SetBool`.
            service: name below the namespace; leading and trailing non-alphanumerics are dropped.
            options: what can be said of every service.
        """

    def service_client(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceClient:
        """A service to call; arguments as for `service_server`."""

    def stage(self) -> Prims:
        """All prims of the stage, those that come and go among them."""

    def attribute(self, prim: str, name: str, *, writable: bool = False) -> PrimAttribute:
        """An attribute of a prim; `writable` for one that can be changed while the simulation runs."""

    def server(self, handle: int) -> ServiceServer:
        """The server of that handle, whichever node opened it."""

    def variable(self, name: str) -> Variable:
        """A variable of the node's graph."""

    def mailbox(self, name: str) -> Mailbox:
        """A named queue of the session."""

    def environment(self, name: str) -> str:
        """A variable of the environment that the user lets graphs read; empty where there is none."""

    def read_file(self, path: str) -> tuple[Path, str]:
        """A text file, named from the folder of the graph file, where it is and its text."""

    def allow_scripts(self) -> None:
        """Refuse to go on unless the user lets graphs run Python."""

    def when_closed(self, function: Callable[[], None]) -> None:
        """Have something done when the node is set up again, and when the session ends."""

    def keyboard(self) -> Keyboard:
        """The keys of whoever runs the session."""

    def random(self) -> np.random.Generator:
        """A generator seeded by the session's seed and the node's prim path."""

    def log(self, severity: Literal["info", "warning", "error"], message: str) -> None:
        """Tell the user, once for each different message."""
