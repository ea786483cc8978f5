"""The Context that nodes get: names and checks from the stage, handles from a world and a network.

The same class serves a dry setup, over stand-ins, and a running session; so what `check` sees is what `run` does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from graphengine.backend import Closable, EndpointClaim, Network, OwnedServer, World
from graphengine.context import (
    Articulation,
    Body,
    Camera,
    Clock,
    ContactSensor,
    Frame,
    FrameLink,
    Imu,
    Lidar,
    Placement,
    Publisher,
    QoS,
    RobotDescription,
    ServiceClient,
    ServiceServer,
    Subscription,
)
from graphengine.diagnostics import ContextError, PrimError, TopicError, listing
from graphengine.graph_variable import GraphVariable
from graphengine.keys import HeldKeys
from graphengine.mailbox import NodeMailbox, QueueMailbox
from graphengine.permissions import Permissions
from graphengine.prim_attributes import BoundAttribute, StagePrims
from graphengine.render_product import ProductCamera, RenderProduct
from graphengine.ros import names, qos
from graphengine.seeds import key_of
from graphengine.sensor import LARGEST_PICTURE
from graphengine.stage import Prim, PrimKind, Stage, at_or_below
from graphengine.transform_tree import expand


@dataclass(slots=True)
class Services:
    """What all contexts of a session share."""

    world: World
    network: Network
    seed: int = 0
    domain_id: int = 0
    """The session's ROS 2 domain, which handle 0 means."""
    domain_from_environment: int | None = None
    """ROS_DOMAIN_ID, where the caller found one."""
    log: Callable[[str, str, str], None] = lambda severity, node, message: None
    claims: list[EndpointClaim] = field(default_factory=list)
    servers: dict[int, OwnedServer] = field(default_factory=dict)
    """Servers that are open, by their handles."""
    handles: dict[tuple[str, int], int] = field(default_factory=dict)
    """Of the n-th server of each node, by its prim path; a node that is set up again has those that it had."""
    mailboxes: dict[str, QueueMailbox] = field(default_factory=dict)
    permissions: Permissions = field(default_factory=Permissions)
    keys: HeldKeys = field(default_factory=HeldKeys)
    generators: dict[str, np.random.Generator] = field(default_factory=dict)
    """Random numbers of each node that asked for them, by its prim path."""
    render_products: dict[str, RenderProduct] = field(default_factory=dict)

    @property
    def stage(self) -> Stage:
        """The prim tree."""
        return self.world.stage

    def reseed(self, path: str) -> None:
        """Begin a node's random numbers at their beginning."""
        generator = self.generators.setdefault(path, np.random.Generator(np.random.Philox()))
        generator.bit_generator.state = np.random.Philox(key=key_of(self.seed, path)).state

    def forget(self, prim: str) -> None:
        """Let go of the render products of sensors at and below a prim."""
        for path in [path for path, product in self.render_products.items() if at_or_below(product.prim, prim)]:
            del self.render_products[path]


def _named(kind: PrimKind) -> str:
    return {"imu": "an imu", "contact": "a contact sensor"}.get(kind, f"a {kind}")


class _Closing:
    """Something to be done once, when what a node was handed out is closed."""

    def __init__(self, function: Callable[[], None]) -> None:
        self.close = function


class NodeContext:
    """One node's door to the session."""

    def __init__(
        self,
        services: Services,
        clock: Clock,
        graph: str,
        prim_path: str,
        rate: float | None,
        variables: Mapping[str, GraphVariable],
        runs: Literal["tick", "physics_step"] = "tick",
        wired: Mapping[str, int] | None = None,
        graph_path: str = "",
        folder: Path = Path(),
    ) -> None:
        self.runs: Literal["tick", "physics_step"] = runs
        self._wired = wired
        self._services = services
        self._graph = graph
        self._folder = folder
        self._rate = rate
        self._variables = variables
        self._owned: list[Closable] = []
        self._claims: list[EndpointClaim] = []
        self._servers: list[int] = []
        self.clock = clock
        self.prim_path = prim_path
        self.graph_path = graph_path or prim_path.rpartition("/")[0]
        self.prims: set[str] = set()
        """Paths of the prims that it handed something out of."""

    def close(self) -> None:
        """Close what was handed out, before the node is set up again or when its session ends."""
        for endpoint in self._owned:
            endpoint.close()
        self._owned.clear()
        for claim in self._claims:
            self._services.claims.remove(claim)
        self._claims.clear()
        for handle in self._servers:
            del self._services.servers[handle]
        self._servers.clear()

    def _find(self, path: str, *kinds: PrimKind) -> Prim:
        prim = self._services.stage.find(path)
        self.prims.add(prim.path)
        if kinds and prim.kind not in kinds:
            wanted = " or ".join((_named(kinds[0]), *kinds[1:]))
            inside = [child.path for child in prim.descendants() if child.kind in kinds]
            others = [other.path for kind in kinds for other in self._services.stage.prims(kind)]
            near = listing(inside, "below it") if inside else listing(others, "those there are")
            raise PrimError(f"{path!r} is {_named(prim.kind)}, not {wanted}", path, near)
        return prim

    def wired(self, output: str) -> bool:
        """Whether a wire takes an output of the node; every output, where there is no graph."""
        return self._wired is None or output in self._wired

    def wires_into(self, pin: str) -> int:
        """How many wires end at an execution input of the node; one, where there is no graph."""
        return 1 if self._wired is None else self._wired.get(pin, 0)

    def body(self, prim: str) -> Body:
        """The rigid body at, or carrying, a prim."""
        found = self._find(prim)
        if not any(ancestor.body is not None for ancestor in found.ancestors()):
            bodies = [p.path for p in found.descendants() if p.body is not None]
            raise PrimError(
                f"{prim!r} is a {found.kind} that no rigid body carries",
                prim,
                listing(bodies[:5], "bodies below it") if bodies else "",
            )
        return self._services.world.body(found)

    def frame(self, prim: str) -> Frame:
        """The pose of any prim."""
        return self._services.world.frame(self._find(prim))

    def placement(self, prim: str) -> Placement | None:
        """What puts a prim somewhere; None for one that neither moves by itself nor stands for a robot that does."""
        return self._services.world.placement(self._find(prim))

    def transform_tree(self, targets: Sequence[str], parent: str = "") -> Sequence[FrameLink]:
        """The edges that target prims expand to."""
        stage = self._services.stage
        return expand(
            stage,
            [self._find(target) for target in targets],
            self._find(parent) if parent else None,
            self._services.world.frame,
        )

    def _robot(self, path: str) -> Prim:
        stage = self._services.stage
        prim = self._find(path)
        robot = stage.stands_for_robot(prim)
        if robot is None:
            owner = stage.robot_of(prim)
            stands = (
                [p for p in (owner.path, owner.facts.get("base_link"), owner.facts.get("articulation_root")) if p]
                if owner
                else []
            )
            robots = [p.path for p in stage.prims("robot")]
            raise PrimError(
                f"{path!r} does not stand for a robot",
                path,
                listing(dict.fromkeys(stands), f"what stands for {owner.path}") if owner else listing(robots, "robots"),
            )
        return robot

    def articulation(self, prim: str) -> Articulation:
        """The robot that a prim stands for."""
        return self._services.world.articulation(self._robot(prim))

    def joint_names(self, prim: str) -> Sequence[str]:
        """Names under which a robot's joints are published."""
        robot = self._robot(prim)
        overrides = {p.facts.get("joint", p.name): p.name_override for p in robot.descendants() if p.kind == "joint"}
        return tuple(overrides.get(name) or name for name in robot.facts.get("joints", ()))

    def robot_description(self, prim: str) -> RobotDescription:
        """The description of the robot that a prim stands for."""
        robot = self._robot(prim)
        stage = self._services.stage
        links = [stage.find(path) for path in robot.facts.get("moving_links", ())]
        moving = expand(stage, links, None, self._services.world.frame)
        carried = tuple(
            FrameLink(link.parent.frame_name, edge.child_name, self._services.world.frame(link.parent), edge.child)
            for link, edge in zip(links, moving, strict=True)
            if link.parent is not None
        )
        return RobotDescription(robot.facts.get("urdf", ""), tuple(robot.facts.get("fixed_transforms", ())), carried)

    def render_product(self, prim: str, width: int, height: int) -> str:
        """Path of the render product of a sensor or camera prim."""
        found = self._find(prim, "lidar", "camera")
        for pixels in (width, height) if found.kind == "camera" else ():
            if not 1 <= pixels <= LARGEST_PICTURE:
                legal = f"width and height are 1 to {LARGEST_PICTURE}"
                raise ContextError(f"there is no picture of {width} x {height} pixels", pixels, legal)
        slug = found.path.strip("/").replace("/", "_")
        path = f"/Render/{slug}" if found.kind == "lidar" else f"/Render/{slug}_{width}x{height}"
        self._services.render_products.setdefault(path, RenderProduct(found.path, (width, height)))
        return path

    def _expect_ticks(self, sensor: str) -> None:
        if self.runs == "physics_step":
            raise ContextError(
                f"a {sensor} has one sample a tick, and this graph runs at every physics step",
                None,
                "put the node into a graph with `runs: tick`",
            )

    def lidar(self, render_product: str) -> Lidar:
        """The lidar behind a render product, or at a prim path."""
        self._expect_ticks("lidar")
        product = self._services.render_products.get(render_product)
        return self._services.world.lidar(self._find(product.prim if product else render_product, "lidar"))

    def camera(self, render_product: str) -> Camera:
        """The camera behind a render product, in the product's size, or at a prim path in its own."""
        self._expect_ticks("camera")
        product = self._services.render_products.get(render_product)
        if product is None:
            return self._services.world.camera(self._find(render_product, "camera"))
        return self._camera_of(product)

    def exchange_camera(self, render_product: str, prim: str) -> Callable[[], None]:
        """What lets a render product show what another camera sees."""
        product = self._services.render_products.get(render_product)
        if product is None:
            known = listing(self._services.render_products, "render products")
            raise ContextError(f"no render product {render_product!r}", render_product, known)
        self._expect_ticks("camera")
        other = self._services.world.camera(self._find(prim, "camera"), product.size)
        return partial(self._camera_of(product).show, other)

    def _camera_of(self, product: RenderProduct) -> ProductCamera:
        prim = self._find(product.prim, "camera")
        if product.camera is None:
            product.camera = ProductCamera(self._services.world.camera(prim, product.size))
        return product.camera

    def imu(self, prim: str) -> Imu:
        """The inertial unit at a prim."""
        return self._services.world.imu(self._find(prim, "imu"))

    def contact_sensor(self, prim: str) -> ContactSensor:
        """The contact sensor at a prim."""
        return self._services.world.contact_sensor(self._find(prim, "contact"))

    def ros_context(self, domain_id: int, use_environment: bool) -> int:
        """Handle of a ROS 2 domain: the domain's number and one."""
        environment = self._services.domain_from_environment
        domain = environment if use_environment and environment is not None else domain_id
        if not 0 <= domain <= 232:
            raise TopicError(f"{domain} is not a ROS 2 domain", domain_id, "legal: 0 to 232")
        return domain + 1

    def _claim(
        self, direction: str, message_type: str, topic: str, namespace: str, start: str, outermost: bool, **facts: Any
    ) -> EndpointClaim:
        full = names.full_topic(namespace or self._collected(start or self.prim_path, outermost), topic)
        return self._note(direction, message_type, full, **facts)

    def _collected(self, start: str, outermost: bool = False) -> str:
        """The namespace that prims give, from one up to the root."""
        return names.join_namespaces(self._services.stage.namespaces(start), outermost)

    def _note(self, direction: str, message_type: str, full: str, **facts: Any) -> EndpointClaim:
        """A claim of the node, which ends with what it was handed out."""
        claim = EndpointClaim(self.prim_path, self._graph, full, message_type, direction, **facts)
        self._services.claims.append(claim)
        self._claims.append(claim)
        return claim

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
        """A topic to write to."""
        claim = self._claim(
            "publish",
            message_type,
            topic,
            namespace,
            namespace_from,
            outermost_namespace,
            qos=qos.parse_qos(qos_profile, queue_size, latched),
            ros_context=ros_context,
            rate=rate if rate is not None else self._rate,
            latched=latched,
            frame_id=frame_id,
            transforms=tuple(transforms),
        )
        publisher = self._services.network.publisher(claim)
        self._owned.append(publisher)
        return publisher

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
        """A topic to read from."""
        claim = self._claim(
            "subscribe",
            message_type,
            topic,
            namespace,
            "",
            outermost_namespace,
            qos=qos.parse_qos(qos_profile, queue_size, False),
            ros_context=ros_context,
            alternatives=tuple(alternatives),
        )
        subscription = self._services.network.subscription(claim)
        self._owned.append(subscription)
        return subscription

    def _service(
        self,
        direction: str,
        service_type: str,
        service: str,
        namespace: str,
        collects_namespace: bool,
        qos_profile: str,
        ros_context: int,
    ) -> EndpointClaim:
        if not namespace and collects_namespace:
            namespace = self._collected(self.prim_path)
        full = names.full_topic(namespace, service, "service name")
        quality = qos.parse_qos(qos_profile, QoS().depth, False)
        return self._note(direction, service_type, full, qos=quality, ros_context=ros_context)

    def service_server(
        self,
        service_type: str,
        service: str,
        *,
        namespace: str = "",
        collects_namespace: bool = False,
        qos_profile: str = "",
        ros_context: int = 0,
    ) -> ServiceServer:
        """A service to offer."""
        claim = self._service("serve", service_type, service, namespace, collects_namespace, qos_profile, ros_context)
        handles = self._services.handles
        handle = handles.setdefault((self.prim_path, len(self._servers)), len(handles) + 1)
        server = self._services.network.server(claim, handle)
        self._owned.append(server)
        self._servers.append(handle)
        self._services.servers[handle] = server
        return server

    def service_client(
        self,
        service_type: str,
        service: str,
        *,
        namespace: str = "",
        collects_namespace: bool = False,
        qos_profile: str = "",
        ros_context: int = 0,
    ) -> ServiceClient:
        """A service to call."""
        claim = self._service("call", service_type, service, namespace, collects_namespace, qos_profile, ros_context)
        client = self._services.network.client(claim)
        self._owned.append(client)
        return client

    def stage(self) -> StagePrims:
        """All prims of the stage."""
        return StagePrims(self._services.world)

    def attribute(self, prim: str, name: str, *, writable: bool = False) -> BoundAttribute:
        """An attribute of a prim."""
        return StagePrims(self._services.world).attribute(self._find(prim).path, name, writable=writable)

    def server(self, handle: int) -> ServiceServer:
        """The server of that handle.

        Raises:
            ContextError: there is none.
        """
        if handle not in self._services.servers:
            raise ContextError(
                f"no service server has the handle {handle}",
                handle,
                "wire serverHandle from a ROS2ServiceServerRequest",
            )
        return self._services.servers[handle]

    def variable(self, name: str) -> GraphVariable:
        """A variable of the node's graph."""
        if name not in self._variables:
            raise ContextError(f"the graph has no variable {name!r}", name, listing(self._variables, "variables"))
        return self._variables[name]

    def mailbox(self, name: str) -> NodeMailbox:
        """A named queue of the session."""
        return NodeMailbox(self._services.mailboxes.setdefault(name, QueueMailbox(name)))

    def environment(self, name: str) -> str:
        """A variable of the environment."""
        return self._services.permissions.variable(name)

    def read_file(self, path: str) -> tuple[Path, str]:
        """A text file, named from the folder of the graph file."""
        return self._services.permissions.read(path, self._folder)

    def allow_scripts(self) -> None:
        """Refuse to go on unless the user lets graphs run Python."""
        self._services.permissions.require_scripts()

    def when_closed(self, function: Callable[[], None]) -> None:
        """Have something done at the end."""
        self._owned.append(_Closing(function))

    def keyboard(self) -> HeldKeys:
        """The keys of whoever runs the session."""
        self._services.keys.asked = True
        return self._services.keys

    def random(self) -> np.random.Generator:
        """A generator seeded by the session's seed and the node's prim path."""
        if self.prim_path not in self._services.generators:
            self._services.reseed(self.prim_path)
        return self._services.generators[self.prim_path]

    def log(self, severity: Literal["info", "warning", "error"], message: str) -> None:
        """Tell the user."""
        self._services.log(severity, self.prim_path, message)
