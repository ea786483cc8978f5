"""Corrects masses and inertias for MuJoCo: impossible values, and moving links without mass.

PhysX accepts such descriptions and makes up values. This module does so too, and reports it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from graphengine.format.diagnostics import Findings
from graphengine.format.wording import listing
from graphengine.physics.description.urdf import Urdf, UrdfLink
from graphengine.physics.files.xml import Element, numbers

WATER = 1000.0
"""Density that colliders and made-up bodies have, kg/m3."""
LEAST_MASS = 0.001
"""Of a moving link without mass and colliders, kg: next to nothing, and enough for arithmetic."""
LEAST_MOMENT = 1e-14
"""Below this MuJoCo takes a moment of inertia for zero, kg m2."""
_ROUNDING = 1e-9

_TERMS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def inertials(urdf: Urdf, *, free: bool, findings: Findings) -> dict[str, Element]:
    """Return the `inertial` of each link that has one; MuJoCo computes the mass of other links from their colliders, as water.

    A link without mass that is fixed to one with mass needs none, as URDF specifies.

    Args:
        urdf: robot description.
        free: whether its root link moves.
        findings: receives notes on made-up values, and values that are not numbers.
    """
    links = urdf.links.values()
    found = {link.name: link.element.first("inertial") or _sphere(link.element, 0.0, 0.0) for link in links}
    groups = list(_weightless(urdf, free=free))
    solid = [link for group in groups for link in group if link.colliders]
    bare = [group[0] for group in groups if not any(link.colliders for link in group)]
    for link in solid:
        del found[link.name]
    for link in bare:
        found[link.name] = _sphere(link.element, LEAST_MASS, _ball_moment(LEAST_MASS))
    replaced = [urdf.links[name] for name in found if _mend(found, urdf.links[name], findings)]
    _tell("links that move and state no mass weigh what their colliders do at 1000 kg/m3", solid, findings)
    _tell(f"links that move and have neither mass nor colliders weigh {LEAST_MASS * 1000:g} g", bare, findings)
    text = "a moment of inertia that is zero, or more than the other two together, belongs to no body; a possible one counts"
    _tell(text, replaced, findings)
    return found


def _tell(text: str, links: list[UrdfLink], findings: Findings) -> None:
    if links:
        findings.add("N103", text, links[0].element.span, listing((link.name for link in links), "links"))


def _weightless(urdf: Urdf, *, free: bool) -> Iterator[list[UrdfLink]]:
    """Yield groups of rigidly connected links without mass; the link at the movable joint is the first of its group."""
    for top in urdf.depth_first():
        if not (top.carrier.moves if top.carrier is not None else free):
            continue
        group = [top]
        for link in group:
            group.extend(urdf.links[joint.child] for joint in link.below if not joint.moves)
        if not any(link.mass for link in group):
            yield group


def _mend(found: dict[str, Element], link: UrdfLink, findings: Findings) -> bool:
    """Replace the inertia of a link if it is physically impossible; return whether it was replaced."""
    inertial = found[link.name]
    inertia = inertial.first("inertia")
    if inertia is None or link.mass == 0:
        return False
    terms = numbers(" ".join(inertia.get(term, "0") for term in _TERMS), len(_TERMS))
    if terms is None:
        findings.add("S103", f"link {link.name!r}: the inertia must have six numbers, in kg m2", inertia.span)
        return False
    xx, yy, zz, xy, xz, yz = terms
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    instead = mended(matrix, link.mass)
    if instead is matrix:
        return False
    terms = tuple(float(instead[row, column]) for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    attributes = dict(zip(_TERMS, map(repr, terms), strict=True))
    others = [child for child in inertial.children if child is not inertia]
    found[link.name] = Element("inertial", {}, inertial.span, [*others, Element("inertia", attributes, inertia.span)])
    return True


def possible(inertia: NDArray[np.float64]) -> bool:
    """Return whether MuJoCo accepts an inertia: its principal moments are positive, and none exceeds the sum of the others."""
    smallest, middle, largest = np.linalg.eigvalsh(inertia)
    return bool(smallest > LEAST_MOMENT and (smallest + middle) * (1 - _ROUNDING) >= largest)


def mended(inertia: NDArray[np.float64], mass: float) -> NDArray[np.float64]:
    """Return the inertia itself if it is possible, else a similar one, kg m2."""
    if possible(inertia):
        return inertia
    for candidate in (inertia, np.diag(np.diag(inertia))):  # products that are too large are mostly made up
        moments, axes = np.linalg.eigh(candidate)
        if moments[0] > LEAST_MOMENT:
            # The two smaller ones are raised: rounded numbers of a thin plate stay what they are to six digits.
            least = moments[2] * (1 + 2 * _ROUNDING)  # of their sum
            excess = least - moments[0] - moments[1]
            if excess > 0.0:
                moments[1] = min(moments[1] + excess / 2, moments[2])
                moments[0] = least - moments[1]
            return np.asarray((axes * moments) @ axes.T, np.float64)
    mean = float(np.trace(inertia)) / 3
    return np.eye(3) * (mean if mean > LEAST_MOMENT else _ball_moment(mass))


def _ball_moment(mass: float) -> float:
    """Return the moment of inertia of a ball of water, 2/5 m r^2, kg m2."""
    radius = math.cbrt(3 * mass / (4 * math.pi * WATER))
    return max(0.4 * mass * radius * radius, 2 * LEAST_MOMENT)


def _sphere(element: Element, mass: float, moment: float) -> Element:
    """Return an `inertial` element with the same moment about all axes."""
    moments = dict(zip(_TERMS, map(repr, (moment, moment, moment, 0.0, 0.0, 0.0)), strict=True))
    children = [Element("mass", {"value": repr(mass)}, element.span), Element("inertia", moments, element.span)]
    return Element("inertial", {}, element.span, children)
