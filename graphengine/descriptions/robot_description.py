"""Robot descriptions as plain data: links, joints and the tree that they form."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.shapes import Cylinder, Shape, Sphere
from graphengine.devices.rotation import NOWHERE, Pose, Vector3, compose, multiply, rotate

if TYPE_CHECKING:
    from graphengine.descriptions.actuators.mjcf_actuators import Actuator
    from graphengine.descriptions.actuators.mjcf_model import Keyframe, MjcfModel
    from graphengine.descriptions.usd_model import UsdModel

TURNING = ("revolute", "continuous")
MOVING = (*TURNING, "prismatic")
WORLD = "world"
"""Name of a root link that represents the world; a robot with this root link cannot move freely."""


Moments = tuple[float, float, float, float, float, float]
"""Moments of inertia and products of inertia, kg m2, in the order of `TERMS`."""
TERMS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of `inertia` in URDF."""


@dataclass(frozen=True, slots=True)
class Inertial:
    """Mass (kg) of a link and its moments of inertia about the axes of `pose`, whose origin is the centre of mass.

    `moments` is None if the description gives only a mass.
    """

    mass: float
    moments: Moments | None
    pose: Pose = NOWHERE


@dataclass(slots=True, eq=False)
class Link:
    """A link of a robot description, with its colliders and visuals in order of the file."""

    name: str
    element: Element
    inertial: Inertial | None
    shapes: Sequence[Shape]
    carrier: Joint | None = None
    """The joint that connects this link to its parent; None for the root."""
    below: list[Joint] = field(default_factory=list)
    """The joints that connect the children of this link, in order of the file."""

    @property
    def mass(self) -> float:
        """Mass, kg; 0 if the description gives none."""
        return self.inertial.mass if self.inertial is not None else 0.0

    @property
    def colliders(self) -> list[Shape]:
        """The collision shapes of the link."""
        return [shape for shape in self.shapes if not shape.visual]

    @property
    def empty(self) -> bool:
        """Whether the link is only a frame: it has neither mass, colliders nor visuals."""
        return self.inertial is None and not self.shapes


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits of a joint: position (rad or m), effort (N m or N) and velocity (rad/s or m/s); None if absent.

    `element` is the element of the user's file that states them; None if there is none.
    """

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    element: Element | None = None


@dataclass(frozen=True, slots=True)
class Mimic:
    """The law of a mimic joint: its position is `multiplier` times the position of joint `leader`, plus `offset` (rad or m)."""

    leader: str
    multiplier: float
    offset: float
    element: Element


@dataclass(slots=True, eq=False)
class Joint:
    """A joint. `pose` is the pose of the child link in the parent link's frame at joint position zero."""

    name: str
    type: str
    parent: str
    child: str
    pose: Pose
    element: Element
    stated_axis: Vector3 = (1.0, 0.0, 0.0)
    """Axis in the frame of the child link as the description states it, of any length; the physics engine normalises it."""
    bounds: Bounds = Bounds()
    losses: tuple[float, float] = (0.0, 0.0)
    """Damping (N m s/rad or N s/m) and friction (N m or N) of the joint."""
    mimic: Mimic | None = None

    @property
    def axis(self) -> Vector3:
        """Axis in the frame of the child link, a unit vector."""
        x, y, z = self.stated_axis
        length = math.hypot(x, y, z) or 1.0
        return x / length, y / length, z / length

    @property
    def moves(self) -> bool:
        """Whether the joint is revolute, continuous or prismatic."""
        return self.type in MOVING

    @property
    def limits(self) -> tuple[float, float] | None:
        """Lower and upper position limit, rad or m; None without limits, or if the lower limit is not below the upper."""
        lower, upper = self.bounds.lower or 0.0, self.bounds.upper or 0.0
        return (lower, upper) if self.type != "continuous" and lower < upper else None

    @property
    def effort(self) -> float | None:
        """Effort limit, N m or N; None if the description has no limit above zero."""
        return _positive(self.bounds.effort)

    @property
    def velocity(self) -> float | None:
        """Velocity limit, rad/s or m/s; None if the description has no limit above zero."""
        return _positive(self.bounds.velocity)


def _positive(limit: float | None) -> float | None:
    return limit if limit is not None and limit > 0 else None


@dataclass(frozen=True, slots=True)
class Wheel:
    """A wheel on a joint: its radius, m, and the position of its centre along the axle, m."""

    joint: str
    radius: float
    along: float


@dataclass(slots=True, eq=False)
class RobotDescription:
    """A robot description whose links form one tree.

    Attributes:
        element: root element of the description as URDF, with xacro expanded. Later changes of links and joints are not in it;
            `urdf_writer.description_text` writes them.
        packages: finds the packages to which mesh references refer.
        links: links by name, in order of the file.
        joints: joints by name, in order of the file.
        root: link without a parent joint.
        mjcf: MuJoCo model of the robot if MJCF describes it, otherwise None.
        usd: what a USD stage says about the robot if one describes it, otherwise None.
    """

    element: Element
    packages: Packages
    links: dict[str, Link]
    joints: dict[str, Joint]
    root: str
    mjcf: MjcfModel | None = None
    usd: UsdModel | None = None

    @property
    def moves_freely(self) -> bool:
        """Whether the description lets the root link move freely."""
        return self.mjcf.free if self.mjcf is not None else self.root != WORLD

    @property
    def actuators(self) -> Sequence[Actuator]:
        """Actuators of the MuJoCo model; empty for other descriptions."""
        return self.mjcf.actuators if self.mjcf is not None else ()

    @property
    def keyframes(self) -> Mapping[str, Keyframe]:
        """Keyframes of the MuJoCo model by name; empty for other descriptions."""
        return self.mjcf.keyframes if self.mjcf is not None else {}

    @property
    def mass(self) -> float:
        """Mass of all links, kg."""
        return sum(link.mass for link in self.links.values())

    def centre_of_mass(self) -> Vector3:
        """Return the centre of mass in the root link's frame, m, with all joints at position zero; the origin without mass."""
        x, y, z, total = 0.0, 0.0, 0.0, self.mass
        for link in self.links.values():
            pose = link.inertial.pose if link.inertial is not None else NOWHERE
            place, _ = compose(self.pose_in_root(link.name), pose)
            share = link.mass / total if total else 0.0
            x, y, z = x + share * place[0], y + share * place[1], z + share * place[2]
        return x, y, z

    def depth_first(self, start: str = "") -> Iterator[Link]:
        """Yield a link (by default the root) and all links below it, depth first; parents come before their children."""
        pending = [self.links[start or self.root]]
        while pending:
            link = pending.pop()
            yield link
            pending.extend(self.links[joint.child] for joint in reversed(link.below))

    def moving(self) -> list[Joint]:
        """Return the moving joints breadth first from the root, which is the order of a PhysX articulation."""
        links = [self.links[self.root]]
        for link in links:
            links.extend(self.links[joint.child] for joint in link.below)
        return [link.carrier for link in links if link.carrier is not None and link.carrier.moves]

    def carriers(self, link: str) -> Iterator[Joint]:
        """Yield the joints between a link and the root link, starting with the joint that carries the link."""
        while (carrier := self.links[link].carrier) is not None:
            yield carrier
            link = carrier.parent

    def turns_in(self, link: str) -> str:
        """Return the link relative to which a link moves: the parent of the nearest moving joint, e.g. the chassis of a wheel.

        Return the root link if no moving joint is above the link.
        """
        return next((carrier.parent for carrier in self.carriers(link) if carrier.moves), self.root)

    def pose_in_root(self, link: str) -> Pose:
        """Return the pose of a link in the root link's frame, with all joints at position zero."""
        pose = NOWHERE
        for carrier in self.carriers(link):
            pose = compose(carrier.pose, pose)
        return pose

    def axes_in_root(self) -> dict[str, Vector3]:
        """Return a dict from joint names to axes in the root link's frame, with all joints at position zero."""
        rotations, axes = {self.root: NOWHERE[1]}, {}
        for link in self.depth_first():
            for joint in link.below:
                rotations[joint.child] = multiply(rotations[link.name], joint.pose[1])
                axes[joint.name] = rotate(rotations[joint.child], joint.axis)
        return axes

    def wheels(
        self, joints: Iterable[Joint], shapes: Mapping[str, tuple[float, float]] = MappingProxyType({})
    ) -> list[Wheel]:
        """Return the wheels on the given joints, in the same order; joints without a wheel are skipped.

        `Wheel.along` of all wheels is measured along the axle of the first wheel.

        Args:
            joints: joints that may carry wheels.
            shapes: radius of a wheel, and distance of its centre from the joint along the axis (both m), by link name. Wheels
                on other links are recognized by their colliders.
        """
        found: list[Wheel] = []
        axle = None
        for joint in joints:
            wheel = self._wheel(joint) if joint.child not in shapes else self._given_wheel(joint, *shapes[joint.child])
            if wheel is None:
                continue
            axle = axle or rotate(self.pose_in_root(joint.child)[1], joint.axis)
            found.append(Wheel(joint.name, wheel[0], sum(a * b for a, b in zip(wheel[1], axle, strict=True))))
        return found

    def _given_wheel(self, joint: Joint, radius: float, offset: float) -> tuple[float, Vector3]:
        x, y, z = joint.axis
        centre = compose(self.pose_in_root(joint.child), ((x * offset, y * offset, z * offset), NOWHERE[1]))
        return radius, centre[0]

    def _wheel(self, joint: Joint) -> tuple[float, Vector3] | None:
        """Return radius (m) and centre (m, in the root link's frame) of the wheel on a joint; None if there is no wheel.

        A wheel is a spherical collider, or a cylindrical one about the joint's axis, on a continuous joint.
        """
        if joint.type != "continuous":
            return None
        for collider in self.links[joint.child].colliders:
            shape = collider.geometry
            if not isinstance(shape, Sphere | Cylinder):
                continue
            cosine = sum(a * b for a, b in zip(rotate(collider.pose[1], (0.0, 0.0, 1.0)), joint.axis, strict=True))
            if isinstance(shape, Sphere) or abs(cosine) > 0.99:
                return shape.radius, compose(self.pose_in_root(joint.child), collider.pose)[0]
        return None


def track(wheels: Sequence[Wheel]) -> float | None:
    """Return the track width (m): the distance between the outermost wheels along the axle; None if it is zero."""
    distance = max(w.along for w in wheels) - min(w.along for w in wheels) if wheels else 0.0
    return distance if distance > 1e-6 else None
