"""The part of a node's context that returns handles to bodies, robots and sensors, given by prim path."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, TypeVar, cast

from graphengine.devices.camera import LARGEST_PICTURE, Camera
from graphengine.devices.device import Device, device_of
from graphengine.devices.holonomic_wheels import HolonomicWheel
from graphengine.devices.motion import Articulation, Body, Frame, FrameLink, Placement, Surface
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.devices.stage import Prim, PrimKind
from graphengine.format.errors import ContextError, PrimError
from graphengine.format.kinds import DEVICES
from graphengine.format.wording import listing
from graphengine.node.context.frame_names import full_frame, prim_prefix
from graphengine.node.context.render_product import ProductCamera, RenderProduct
from graphengine.node.context.session_services import Services
from graphengine.node.context.transform_tree import expand
from graphengine.node.prims.stage_prims import PrimAttribute, Prims

D = TypeVar("D")


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """The data that robot_state_publisher publishes for a robot: its URDF text and the transforms of its joints."""

    urdf: str
    fixed: tuple[tuple[str, str, Vector3, Quaternion], ...]
    """Parent frame, child frame, translation (m) and rotation (x, y, z, w) of every fixed joint."""
    moving: tuple[FrameLink, ...]
    """TF edges from parent link to child link, one for each movable joint."""


def _named(kind: PrimKind) -> str:
    return DEVICES.all[kind].title if kind in DEVICES.all else f"a {kind}"


def _expect_size(width: int, height: int) -> None:
    for pixels in (width, height):
        if not 1 <= pixels <= LARGEST_PICTURE:
            legal = f"legal: width and height from 1 to {LARGEST_PICTURE}"
            raise ContextError(f"an image cannot have {width} x {height} pixels", pixels, legal)


_RENDERED = ("lidar", "camera", "radar")
"""Kinds of device that have render products."""
_VIEWPORTS = "/Render/viewports/"
"""Path prefix of the render products of viewports."""


class WorldHandles:
    """The methods of a node's context that return handles to bodies, robots, sensors and attributes of prims.

    Handles stay valid as long as the world exists; nodes need not close them. All methods that take a prim path raise PrimError
    if no prim has this path or if the prim is of the wrong kind.
    """

    def __init__(self, services: Services, runs: Literal["tick", "physics_step"]) -> None:
        self._services = services
        self.runs: Literal["tick", "physics_step"] = runs
        self.asked: dict[str, Prim] = {}
        """Prims that the node looked up; the key is the path as the node wrote it."""

    def _find(self, path: str, *kinds: PrimKind) -> Prim:
        prim = self._services.stage.find(path)
        self.asked[path] = prim
        if kinds and prim.kind not in kinds:
            *first, last = (_named(kinds[0]), *kinds[1:])
            wanted = f"{', '.join(first)} or {last}" if first else last
            inside = [child.path for child in prim.descendants() if child.kind in kinds]
            others = [other.path for kind in kinds for other in self._services.stage.prims(kind)]
            near = listing(inside, "below it") if inside else listing(others, "prims of this kind")
            raise PrimError(f"{path!r} is {_named(prim.kind)}, not {wanted}", path, near)
        return prim

    def body(self, prim: str) -> Body:
        """Return a handle to the pose and velocity of a prim that is a rigid body or is fixed to one.

        Raises:
            PrimError: neither the prim nor any of its ancestors has a rigid body.
        """
        found = self._find(prim)
        if not any(ancestor.body is not None for ancestor in found.ancestors()):
            bodies = [p.path for p in found.descendants() if p.body is not None]
            text = f"{prim!r} is a {found.kind}, and neither it nor a prim above it has a rigid body"
            raise PrimError(text, prim, listing(bodies[:5], "bodies below it") if bodies else "")
        return self._services.world.body(found)

    def frame(self, prim: str) -> Frame:
        """Return a handle to the pose of any prim."""
        return self._services.world.frame(self._find(prim))

    def placement(self, prim: str) -> Placement | None:
        """Return a handle that moves a prim to a pose and holds it there.

        Return None if the prim cannot be moved separately, as is the case for sensors and for links behind fixed joints.
        """
        return self._services.world.placement(self._find(prim))

    def conveyor(self, prim: str) -> Surface:
        """Return a handle that sets the surface velocity of a body or link; the surface then acts as a conveyor belt.

        Raises:
            PrimError: the prim is not a rigid body, or a joint moves the body.
            ContextError: the body is the base of a robot that is not fixed to the world.
        """
        found = self._find(prim)
        if found.body is None:
            bodies = [p.path for p in self._services.stage.prims() if p.body is not None and p.kind in ("body", "link")]
            text = f"{prim!r} is {_named(found.kind)}, which has no rigid body"
            raise PrimError(text, prim, listing(bodies, "bodies"))
        robot = self._services.stage.robot_of(found)
        if found.facts.get("jointed") or (robot is not None and found.path in robot.facts.get("moving_links", ())):
            advice = "a conveyor must be fixed to the world or to another body; remove the joint"
            raise PrimError(f"{prim!r} cannot be a conveyor: a joint moves it", prim, advice)
        return self._services.world.conveyor(found)

    def transform_tree(self, targets: Sequence[str], parent: str = "", *, loops: bool = True) -> Sequence[FrameLink]:
        """Return the TF edges for target prims: for a robot, one edge for each of its links; for any other prim, one edge.

        Args:
            targets: paths of the target prims.
            parent: path of the prim whose frame is the parent frame; empty for the world frame.
            loops: if `parent` is also a target, whether to return an edge from this frame to itself.
        """
        found, above = [self._find(target) for target in targets], self._find(parent) if parent else None
        return expand(self._services.stage, found, above, self._services.world.frame, loops=loops)

    def _robot(self, path: str) -> Prim:
        stage = self._services.stage
        prim = self._find(path)
        robot = stage.stands_for_robot(prim)
        if robot is None:
            owner = stage.robot_of(prim)
            hint, link = listing([p.path for p in stage.prims("robot")], "robots"), ""
            if owner:
                stands = (owner.path, owner.facts.get("base_link"), owner.facts.get("articulation_root"))
                hint = listing(dict.fromkeys(filter(None, stands)), f"for the robot {owner.path}, write one of")
                link = "or make this link the articulation_root in the robot file" if prim.kind == "link" else ""
            text = f"{path!r} is not the root prim, base link or articulation root of a robot"
            raise PrimError(text, path, hint, link)
        return robot

    def articulation(self, prim: str) -> Articulation:
        """Return a handle to the movable joints of a robot; `prim` is its root prim, base link or articulation root."""
        return self._services.world.articulation(self._robot(prim))

    def joint(self, prim: str) -> tuple[Articulation, int]:
        """Return the articulation to which a joint belongs, and the index of the joint in the articulation.

        Args:
            prim: path of the joint's prim.

        Raises:
            PrimError: the prim is not a movable joint of a robot.
        """
        found = self._find(prim, "joint")
        robot = self._services.stage.robot_of(found)
        names = robot.facts.get("joints", ()) if robot is not None else ()
        if robot is None or found.facts.get("joint", found.name) not in names:
            raise PrimError(f"{prim!r} is not a movable joint", prim, listing(names, "movable joints"))
        return self._services.world.articulation(robot), names.index(found.facts.get("joint", found.name))

    def joint_names(self, prim: str) -> Sequence[str]:
        """Return the names under which the movable joints of a robot are published, in the articulation's order.

        The published name of a joint is its `isaac:nameOverride`; without one, it is the joint's name in the robot description.
        """
        robot = self._robot(prim)
        overrides = {p.facts.get("joint", p.name): p.name_override for p in robot.descendants() if p.kind == "joint"}
        return tuple(overrides.get(name) or name for name in robot.facts.get("joints", ()))

    def holonomic_wheels(self, prim: str) -> Sequence[HolonomicWheel]:
        """Return the mecanum and omnidirectional wheels of a robot; `prim` is its root prim, base link or articulation root."""
        return tuple(self._robot(prim).facts.get("holonomic_wheels", ()))

    def base_link(self, prim: str) -> Frame:
        """Return a handle to the pose of a robot's base link.

        Args:
            prim: path of the robot's root prim, base link or articulation root.
        """
        return self.frame(self._robot(prim).facts["base_link"])

    def robot_description(self, prim: str) -> RobotDescription:
        """Return the URDF and the joint transforms of a robot; `prim` is its root prim, base link or articulation root."""
        robot = self._robot(prim)
        stage, frame = self._services.stage, self._services.world.frame
        links = [stage.find(path) for path in robot.facts.get("moving_links", ())]
        moving = expand(stage, links, None, frame)
        name = partial(full_frame, stage, prefix=prim_prefix(stage, robot))
        joints = robot.facts.get("fixed_transforms", ())
        fixed = tuple((name(parent), name(child), place, turn) for parent, child, place, turn in joints)
        carried = tuple(
            FrameLink(name(link.parent.frame_name), edge.child_name, frame(link.parent), edge.child)
            for link, edge in zip(links, moving, strict=True)
            if link.parent is not None
        )
        return RobotDescription(robot.facts.get("urdf", ""), fixed, carried)

    def render_product(self, prim: str, width: int, height: int) -> str:
        """Return the path of the render product of a lidar, radar or camera; create the render product if it does not exist.

        Args:
            prim: path of the sensor's prim.
            width: width of a camera's images, pixels; not used for other sensors.
            height: height of a camera's images, pixels; not used for other sensors.

        Raises:
            ContextError: the prim is a camera, and the size is not legal for images.
        """
        found = self._find(prim, *_RENDERED)
        if found.kind == "camera":
            _expect_size(width, height)
        slug = found.path.strip("/").replace("/", "_")
        path = f"/Render/{slug}_{width}x{height}" if found.kind == "camera" else f"/Render/{slug}"
        numbered = (f"{path}_{number}" for number in itertools.count(2))  # /a/b_c and /a_b/c give the same path
        products, product = self._services.render_products, RenderProduct(found.path, (width, height))
        return next(p for p in itertools.chain([path], numbered) if products.setdefault(p, product).prim == found.path)

    def viewport(self, name: str, size: tuple[int, int] | None = None, *, make: bool = False) -> str:
        """Return the path of a viewport's render product.

        A new viewport has no camera. To give it one, call the function that `exchange_camera` returns.

        Args:
            name: name of the viewport; "Viewport" always exists.
            size: new width and height of the viewport's images, pixels. None keeps the current size, initially 1280 x 720.
            make: whether to create the viewport if it does not exist.

        Raises:
            ContextError: the viewport does not exist, or the size is not legal for images.
        """
        path, products = f"{_VIEWPORTS}{name}", self._services.render_products
        if make or name == "Viewport":
            products.setdefault(path, RenderProduct("", (1280, 720)))
        if path not in products:
            known = [known.removeprefix(_VIEWPORTS) for known in products if known.startswith(_VIEWPORTS)]
            near = listing(known, "viewports") if known else "create one with IsaacCreateViewport"
            raise ContextError(f"there is no viewport {name!r}", name, near)
        if size is not None:
            _expect_size(*size)
            product = products[path]
            product.size = size
            if product.camera is not None:
                product.camera.own = self._camera(product.prim, size)
                product.camera.show(self._camera(product.camera.source.prim_path, size))
        return path

    def _expect_ticks(self, found: Device) -> None:
        if self.runs == "physics_step":
            text = f"{found.title} is sampled once a tick, but this graph runs at every physics step"
            raise ContextError(text, None, "move the node to a graph with `runs: tick`")

    def kind(self, prim: str) -> PrimKind:
        """Return the kind of a prim, such as `lidar`; for the path of a render product, the kind of its sensor."""
        product = self._services.render_products.get(prim)
        return self._find(product.prim if product is not None and product.prim else prim).kind

    def device(self, interface: Callable[..., D], prim: str, **options: Any) -> D:
        """Return a handle to the sensor or gripper at a prim, or to the sensor of a render product.

        Args:
            interface: Protocol of the device, such as `Lidar` of `graphengine.devices.lidar`.
            prim: path of the prim or of the render product.
            options: if `prim` is the path of a camera's prim, `size` is the width and height of the images, pixels. If `prim` is
                the path of a render product, the images have the size of the render product. Other devices have no options.

        Raises:
            ContextError: the device is sampled once per tick but the graph runs at every physics step, or the path is that of a
                viewport without a camera.
        """
        found = device_of(interface)
        if found.ticks_only:
            self._expect_ticks(found)
        product = self._services.render_products.get(prim) if found.kind in _RENDERED else None
        if product is not None and found.kind == "camera":
            return cast("D", self._camera_of(product))
        path = product.prim if product is not None else prim
        return self._services.world.device(interface, self._find(path, found.kind), **options)

    def exchange_camera(self, render_product: str, prim: str) -> Callable[[], None]:
        """Return a function that switches a render product to the camera `prim`.

        After a call of the returned function, all nodes that use the render product get the images of the camera `prim`.

        Args:
            render_product: path of the render product.
            prim: path of the camera's prim.

        Raises:
            ContextError: the render product does not exist, or the node's graph runs at every physics step.
        """
        product = self._services.render_products.get(render_product)
        if product is None:
            known = listing(self._services.render_products, "render products")
            raise ContextError(f"there is no render product {render_product!r}", render_product, known)
        self._expect_ticks(device_of(Camera))
        other, world = self._find(prim, "camera"), self._services.world
        world.device(Camera, other, size=product.size)  # raises if the world refuses the size
        product.prim = product.prim or other.path

        def exchange() -> None:
            self._camera_of(product).show(world.device(Camera, other, size=product.size))

        return exchange

    def _camera_of(self, product: RenderProduct) -> ProductCamera:
        if not product.prim:
            remedy = "execute an IsaacSetCameraOnRenderProduct node first"
            raise ContextError("the viewport shows no camera", None, remedy)
        own = self._camera(product.prim, product.size)
        if product.camera is None:
            product.camera = ProductCamera(own)
        return product.camera

    def _camera(self, prim: str, size: tuple[int, int]) -> Camera:
        return self._services.world.device(Camera, self._find(prim, "camera"), size=size)

    def stage(self) -> Prims:
        """Return access to the prims of the stage and to their attributes."""
        return Prims(self._services.world)

    def attribute(self, prim: str, name: str, *, writable: bool = False) -> PrimAttribute:
        """Return a handle to an attribute of a prim.

        Args:
            prim: path of the prim.
            name: USD name of the attribute, such as `xformOp:translate`.
            writable: whether the node needs to write the attribute.

        Raises:
            ContextError: the prim has no attribute with this name, or `writable` is true and the attribute is read-only.
        """
        return self.stage().attribute(self._find(prim).path, name, writable=writable)
