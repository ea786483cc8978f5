"""What a node is handed out of the stage and the world: bodies, robots and sensors by the paths of prims."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Literal

from graphengine.context import (
    Articulation,
    Body,
    Camera,
    ContactSensor,
    Frame,
    FrameLink,
    Imu,
    Lidar,
    Placement,
    RobotDescription,
)
from graphengine.diagnostics import ContextError, PrimError, listing
from graphengine.running.node_context.services import Services
from graphengine.running.prims.stage_prims import BoundAttribute, StagePrims
from graphengine.running.render_product import ProductCamera, RenderProduct
from graphengine.running.transform_tree import expand
from graphengine.sensor import LARGEST_PICTURE
from graphengine.stage import Prim, PrimKind


def _named(kind: PrimKind) -> str:
    return {"imu": "an imu", "contact": "a contact sensor"}.get(kind, f"a {kind}")


class WorldHandles:
    """Part of a node's context. Handles need no closing: they live as long as the world."""

    def __init__(self, services: Services, runs: Literal["tick", "physics_step"]) -> None:
        self._services = services
        self.runs: Literal["tick", "physics_step"] = runs
        self.prims: set[str] = set()
        """Paths of the prims that it handed something out of."""

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
                "the robot file can name a link for it: articulation_root" if owner and prim.kind == "link" else "",
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

    def stage(self) -> StagePrims:
        """All prims of the stage."""
        return StagePrims(self._services.world)

    def attribute(self, prim: str, name: str, *, writable: bool = False) -> BoundAttribute:
        """An attribute of a prim."""
        return StagePrims(self._services.world).attribute(self._find(prim).path, name, writable=writable)
