"""Corrects masses and inertias for MuJoCo, which refuses impossible inertias and moving links without mass.

PhysX accepts such descriptions and substitutes values. This module substitutes values too, and reports each substitution.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.robot_description import Inertial, Link, Moments, RobotDescription
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import listing

WATER = 1000.0
"""Density of colliders of links without a mass, and of the balls that replace missing inertias, kg/m3."""
LEAST_MASS = 0.001
"""Mass that a moving link without mass and colliders receives, kg; negligible, but large enough for the solver."""
LEAST_MOMENT = 1e-14
"""MuJoCo treats moments of inertia up to this value as zero, kg m2."""
_ROUNDING = 1e-9


def inertials(description: RobotDescription, *, free: bool, findings: Findings) -> dict[str, Inertial]:
    """Return a dict from link names to mass and inertia; for links not in the dict, MuJoCo derives them from the colliders.

    Colliders have the density of water. A link without mass that is fixed to a link with mass stays without mass.

    Args:
        description: robot description.
        free: whether the root link can move.
        findings: receives notes on substituted values.
    """
    links = description.links.values()
    found = {link.name: _given(link) or _sphere(0.0, 0.0) for link in links}
    groups = list(_weightless(description, free=free))
    solid = [link for group in groups for link in group if link.colliders]
    bare = [group[0] for group in groups if not any(link.colliders for link in group)]
    for link in solid:
        del found[link.name]
    for link in bare:
        found[link.name] = _sphere(LEAST_MASS, _ball_moment(LEAST_MASS))
    replaced = [description.links[name] for name in found if _mend(found, description.links[name])]
    _tell("moving links without a mass get the mass of their colliders at 1000 kg/m3", solid, findings)
    _tell(f"moving links without mass and colliders get a mass of {LEAST_MASS * 1000:g} g", bare, findings)
    text = "a moment of inertia that is missing or zero, or exceeds the sum of the other two, is impossible"
    _tell(f"{text}; a possible value replaces it", replaced, findings)
    return found


def _given(link: Link) -> Inertial | None:
    """Return the inertial of a link that has a mass above zero, or that states both mass and inertia; otherwise None."""
    return link.inertial if link.inertial is not None and (link.mass or link.inertial.moments is not None) else None


def _tell(text: str, links: list[Link], findings: Findings) -> None:
    if links:
        findings.add("N103", text, links[0].element.span, listing((link.name for link in links), "links"))


def _weightless(description: RobotDescription, *, free: bool) -> Iterator[list[Link]]:
    """Yield each group of rigidly connected links that can move and together have no mass; the first link carries the others."""
    for top in description.depth_first():
        if not (top.carrier.moves if top.carrier is not None else free):
            continue
        group = [top]
        for link in group:
            group.extend(description.links[joint.child] for joint in link.below if not joint.moves)
        if not any(link.mass for link in group):
            yield group


def _mend(found: dict[str, Inertial], link: Link) -> bool:
    """Replace the inertia of a link in `found` if it is physically impossible; return whether it was replaced."""
    inertial = found[link.name]
    if link.mass == 0:
        return False
    matrix = matrix_of(inertial.moments or (0.0,) * 6)
    instead = mended(matrix, link.mass)
    if instead is matrix:
        return False
    found[link.name] = replace(inertial, moments=moments_of(instead))
    return True


def matrix_of(moments: Sequence[float]) -> NDArray[np.float64]:
    """Return the 3x3 inertia tensor with the given moments and products of inertia, in the order of `TERMS`."""
    xx, yy, zz, xy, xz, yz = moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def moments_of(matrix: NDArray[np.float64]) -> Moments:
    """Return the moments and products of inertia of a 3x3 inertia tensor, in the order of `TERMS`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix.tolist()
    return xx, yy, zz, xy, xz, yz


def possible(inertia: NDArray[np.float64]) -> bool:
    """Return whether MuJoCo accepts a 3x3 inertia tensor (kg m2).

    Its principal moments must be positive, and none may exceed the sum of the other two.
    """
    smallest, middle, largest = np.linalg.eigvalsh(inertia)
    return bool(smallest > LEAST_MOMENT and (smallest + middle) * (1 - _ROUNDING) >= largest)


def mended(inertia: NDArray[np.float64], mass: float) -> NDArray[np.float64]:
    """Return the given 3x3 inertia tensor (kg m2) if MuJoCo accepts it, else a similar tensor that it accepts.

    If no similar tensor exists, all moments of the result equal the mean moment, or the moment of a ball of water with this
    mass (kg).
    """
    if possible(inertia):
        return inertia
    for candidate in (inertia, np.diag(np.diag(inertia))):  # products that are too large are mostly made up
        moments, axes = np.linalg.eigh(candidate)
        if moments[0] > LEAST_MOMENT:
            # The two smaller moments are raised, so the moments of a thin plate keep their first six digits.
            least = moments[2] * (1 + 2 * _ROUNDING)  # smallest legal sum of the two
            excess = least - moments[0] - moments[1]
            if excess > 0.0:
                moments[1] = min(moments[1] + excess / 2, moments[2])
                moments[0] = least - moments[1]
            return np.asarray((axes * moments) @ axes.T, np.float64)
    mean = float(np.trace(inertia)) / 3
    return np.eye(3) * (mean if mean > LEAST_MOMENT else _ball_moment(mass))


def _ball_moment(mass: float) -> float:
    """Return the moment of inertia (2/5 m r^2, kg m2) of a ball of water with the given mass, kg."""
    radius = math.cbrt(3 * mass / (4 * math.pi * WATER))
    return max(0.4 * mass * radius * radius, 2 * LEAST_MOMENT)


def _sphere(mass: float, moment: float) -> Inertial:
    """Return a mass, kg, at the origin with the same moment of inertia about all axes, kg m2."""
    return Inertial(mass, (moment, moment, moment, 0.0, 0.0, 0.0))
