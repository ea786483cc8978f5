"""Converts masses and inertias of SDF links, and computes them from collisions for `<inertial auto="true">`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphengine.descriptions.engine import Floats
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.inertia import WATER, matrix_of, moments_of
from graphengine.descriptions.robot_description import TERMS, Inertial, Moments
from graphengine.descriptions.sdf.sdf_frames import SdfFrame, place_of
from graphengine.descriptions.sdf.sdf_shapes import shape_of, solid_of
from graphengine.descriptions.sdf.sdf_values import (
    SdfError,
    find,
    flag,
    number_at,
    numbers_at,
    pose_of,
    seen_from,
    text_at,
)
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Sphere
from graphengine.devices.rotation import IDENTITY, Pose, Quaternion, compose, relative, rotate
from graphengine.format.wording import printable

_DEFAULTS = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)


class Mass(NamedTuple):
    """Mass and inertia of a link.

    Attributes:
        mass: mass, kg.
        moments: ixx, iyy, izz, ixy, ixz and iyz about the centre of mass and the axes of `pose`, kg m2.
        pose: pose of the inertial frame in the outermost scope; its origin is the centre of mass.
    """

    mass: float
    moments: Moments
    pose: Pose


def is_mere_frame(link: SdfFrame) -> bool:
    """Return whether a link has neither inertial nor shapes, and is only a frame here; in SDF, its mass is 1 kg."""
    return not any(link.element.first(tag) for tag in ("inertial", "collision", "visual"))


def inertial_of(link: SdfFrame, frame: Pose) -> Inertial:
    """Return the mass and inertia of a link of a robot.

    Args:
        link: frame of the SDF link.
        frame: pose in the outermost scope of the link's frame in URDF.

    Raises:
        SdfError: a value is not a number, the mass is negative, or an automatic inertia cannot be computed.
    """
    mass, moments, pose = mass_of(link)
    if mass < 0.0:
        text = f"link {printable(link.name)!r}: the mass {mass!r} is not a number of at least 0 (kg)"
        raise SdfError(text, (find(link.element, "inertial", "mass") or link.element).span)
    return Inertial(mass, moments, seen_from(frame, pose))


def mass_of(link: SdfFrame) -> Mass:
    """Return the mass and inertia of a link; the defaults of SDF are 1 kg and principal moments of 1 kg m2.

    Raises:
        SdfError: a value is not a number, or an automatic inertia cannot be computed.
    """
    element = link.element.first("inertial")
    if element is not None and flag(element.get("auto")):
        return _of_collisions(link, element)
    inertia = find(element, "inertia")
    terms = zip(TERMS, _DEFAULTS, strict=True)
    xx, yy, zz, xy, xz, yz = (number_at(inertia, term, default=usual) for term, usual in terms)
    pose = compose(link.place, pose_of(find(element, "pose")))
    return Mass(number_at(element, "mass", default=1.0), (xx, yy, zz, xy, xz, yz), pose)


def _of_collisions(link: SdfFrame, element: Element) -> Mass:
    """Return the mass and inertia of a link, computed from volume and density of its collisions."""
    usual = number_at(element, "density", default=WATER)
    masses, centres, matrices = [], [], []
    for collision in link.element.all("collision"):
        shape = shape_of(collision)
        if shape is not None:
            volume, moments = _body(shape)
            mass = volume * number_at(collision, "density", default=usual)
            centre, rotation = relative(link.place, place_of(collision, link))
            masses.append(mass)
            centres.append(np.array(centre))
            matrices.append(mass * matrix_of(turned((*moments, 0.0, 0.0, 0.0), rotation)))
    total = math.fsum(masses)
    if not total > 0.0:
        text = f"link {printable(link.name)!r}: an automatic inertia requires a collision with a volume"
        raise SdfError(text, element.span)
    middle = sum((mass * place for mass, place in zip(masses, centres, strict=True)), np.zeros(3)) / total
    matrix: Floats = np.zeros((3, 3))
    for mass, place, own in zip(masses, centres, matrices, strict=True):
        apart = place - middle
        matrix += own + mass * (np.dot(apart, apart) * np.eye(3) - np.outer(apart, apart))
    mass = total
    if text_at(element, "mass"):
        mass = number_at(element, "mass", default=total)
        matrix *= mass / total
    x, y, z = middle.tolist()
    return Mass(mass, moments_of(matrix), compose(link.place, ((x, y, z), IDENTITY)))


def turned(moments: Moments, rotation: Quaternion) -> Moments:
    """Return moments of inertia (ixx, iyy, izz, ixy, ixz, iyz) about the axes of another frame.

    Args:
        moments: moments in the rotated frame.
        rotation: rotation (x, y, z, w) of that frame in the frame of the result.
    """
    axes = np.array([rotate(rotation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))])
    return moments_of(axes.T @ matrix_of(moments) @ axes)


def _body(shape: Element) -> tuple[float, tuple[float, float, float]]:
    """Return the volume (m3) of a shape, and moments of inertia (x, y, z) about the axes of the shape, divided by the mass (m2).

    Raises:
        SdfError: the inertia of this shape is not implemented, or a size is not a number.
    """
    solid = solid_of(shape)
    if isinstance(solid, Box):
        x, y, z = (side**2 / 12.0 for side in solid.size)
        return math.prod(solid.size), (y + z, x + z, x + y)
    if isinstance(solid, Sphere) or shape.tag == "ellipsoid":
        radii = (solid.radius,) * 3 if solid is not None else numbers_at(shape, "radii", default=(1.0, 1.0, 1.0))
        x, y, z = (part**2 / 5.0 for part in radii)
        return 4.0 / 3.0 * math.pi * math.prod(radii), (y + z, x + z, x + y)
    if isinstance(solid, Cylinder | Capsule):
        radius, length = solid.radius, solid.length
        tube, ball = math.pi * radius**2 * length, 4.0 / 3.0 * math.pi * radius**3
        across, along = tube * (radius**2 / 4.0 + length**2 / 12.0), tube * radius**2 / 2.0
        if isinstance(solid, Cylinder) or not tube + ball:
            return tube, ((across / tube, across / tube, along / tube) if tube else (0.0, 0.0, 0.0))
        across += ball * (0.4 * radius**2 + length**2 / 4.0 + 0.375 * length * radius)
        along += ball * 0.4 * radius**2
        return tube + ball, (across / (tube + ball), across / (tube + ball), along / (tube + ball))
    raise SdfError(f"the automatic inertia of a {shape.tag} is not supported", shape.span, "write <mass> and <inertia>")
