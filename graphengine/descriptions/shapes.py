"""Colliders and visuals of links, and the geometries that they can have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graphengine.descriptions.files.xml import Element
from graphengine.devices.rotation import Pose, Vector3
from graphengine.format.diagnostics import Span

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity from 0 to 1."""
MAX_COLOUR = 1e38
"""Maximum magnitude of a colour component; MuJoCo stores colours in single precision."""


@dataclass(frozen=True, slots=True)
class Box:
    """A box; lengths of its edges along x, y and z, m."""

    size: Vector3


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere; radius in m."""

    radius: float


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder about the z axis; radius and length in m."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Capsule:
    """A capsule about the z axis; radius, and length of the cylinder between its hemispheres, in m."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A mesh in a file.

    Attributes:
        filename: reference to the file as it is written in the description.
        scale: factors along x, y and z.
        element: element with the reference.
    """

    filename: str
    scale: Vector3
    element: Element


Solid = Box | Sphere | Cylinder | Capsule
Geometry = Solid | Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A collider or a visual of a link.

    Attributes:
        name: name in the physics model: the link's name, a dot, and the number of the element among the children of the link.
        visual: whether the shape is only drawn; otherwise it is a collider.
        geometry: form and size.
        pose: pose in the frame of the link.
        colour: colour of its material; None if the description gives none.
        element: `visual` or `collision` element.
        place: source location of the geometry.
    """

    name: str
    visual: bool
    geometry: Geometry
    pose: Pose
    colour: Colour | None
    element: Element
    place: Span

    @property
    def span(self) -> Span:
        """Source location of the element."""
        return self.element.span


def kind_of(geometry: Geometry) -> str:
    """Return the name of a geometry in URDF, e.g. `box`."""
    return type(geometry).__name__.lower()


def sizes_of(geometry: Geometry) -> Sequence[float]:
    """Return the sizes of a geometry in MuJoCo: radius and half lengths, m; none for a mesh."""
    match geometry:
        case Box(size):
            return [length / 2 for length in size]
        case Sphere(radius):
            return [radius]
        case Cylinder(radius, length) | Capsule(radius, length):
            return [radius, length / 2]
    return []
