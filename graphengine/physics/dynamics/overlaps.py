"""Finds overlapping bodies that physics will push apart."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.geoms import extents

LEAST = 0.005
"""Smallest depth that counts as an overlap, m; a body at rest sinks less deep into its support."""
_CARRIES = 0.7
"""Smallest vertical component of a contact normal for a support: the surface is inclined by less than about 45 degrees."""
_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_SURFACES = (_PLANE, int(mujoco.mjtGeom.mjGEOM_HFIELD))
_STEP = 0.05
"""Height of the obstacles that an entity drives over, m."""


def overlaps(
    model: mujoco.MjModel, data: mujoco.MjData, roots: Collection[int], *, floors: bool = True
) -> dict[int, float]:
    """Return the ids of geoms that overlap an entity, with depths (m), deepest first.

    Of each other topmost body and the bodies below it, only the geom that overlaps deepest is returned. The function uses the
    contacts that MuJoCo computed last, so geoms that do not collide with each other do not overlap either.

    Args:
        model: compiled model.
        data: state with the contacts.
        roots: ids of the topmost bodies of the entity.
        floors: whether overlaps with planes below the entity count.
    """
    owner = model.body_rootid[model.geom_bodyid].tolist()
    found: dict[int, tuple[float, int]] = {}
    for own, other, depth, up in _touches(data):
        if depth < LEAST or owner[own] not in roots or owner[other] in roots:
            continue
        if floors or model.geom_type[other] != _PLANE or up <= _CARRIES:
            found[owner[other]] = max(found.get(owner[other], (0.0, 0)), (depth, other))
    return {geom: depth for depth, geom in sorted(found.values(), reverse=True)}


def _touches(data: mujoco.MjData) -> Iterator[tuple[int, int, float, float]]:
    """Yield each contact of two geoms twice, once for each geom: ids of this and the other geom, depth (m), and rise.

    The rise is the vertical component of the contact normal from the other geom to this geom; it is 1 if the other geom is below.
    """
    contact = data.contact
    chosen = (contact.dist < 0.0) & (contact.geom >= 0).all(axis=1)
    rows = contact.geom[chosen].tolist(), contact.dist[chosen].tolist(), contact.frame[chosen, 2].tolist()
    for (one, other), distance, rise in zip(*rows, strict=True):
        yield one, other, -distance, -rise
        yield other, one, -distance, rise


def distances(model: mujoco.MjModel, data: mujoco.MjData, root: int, margin: float) -> dict[int, float]:
    """Return the ids of geoms that are close to an entity, with distances (m); 0 for geoms that overlap it.

    Of each other topmost body and the bodies below it, only the closest geom is returned. Geoms that the entity can drive over
    (up to `_STEP` above its lowest point) or under, planes, height fields, and geoms without collisions are left out.

    Args:
        model: compiled model.
        data: state with the poses of the geoms.
        root: id of the topmost body of the entity.
        margin: largest distance that counts, m.
    """
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    roots = model.body_rootid[model.geom_bodyid]
    own = np.flatnonzero(solid & (roots == root))
    bounds = extents(model, data, own.tolist())
    if bounds is None:
        return {}
    low, high = bounds[0][2] + _STEP, bounds[1][2]
    others = np.flatnonzero(solid & (roots != root) & ~np.isin(model.geom_type, _SURFACES))
    reach = np.linalg.norm(bounds[1][:2] - bounds[0][:2]) / 2.0 + margin
    centre = (bounds[0] + bounds[1])[:2] / 2.0
    others = others[np.linalg.norm(data.geom_xpos[others, :2] - centre, axis=1) <= reach + model.geom_rbound[others]]
    found: dict[int, tuple[float, int]] = {}
    for geom in others.tolist():
        box = extents(model, data, [geom])
        if box is None or box[1][2] <= low or box[0][2] >= high:
            continue
        near = min(mujoco.mj_geomDistance(model, data, mine, geom, margin + LEAST, None) for mine in own.tolist())
        if near <= margin:
            body = int(roots[geom]) or -geom  # geoms of the world itself are not one obstacle
            found[body] = min(found.get(body, (math.inf, 0)), (max(0.0, near), geom))
    return {geom: distance for distance, geom in found.values()}


def touching(model: mujoco.MjModel, data: mujoco.MjData, owners: Mapping[int, str]) -> dict[str, tuple[float, int]]:
    """Return the deepest contact of each entity by the entity's name: its depth (m) and the id of the other geom.

    Contacts with a support do not count. The other geom is a support if it is below the entity according to the contact normal,
    and if it is a plane or the depth is less than `LEAST`. A plane supports at any depth.

    Args:
        model: model of the world.
        data: state with the contacts that MuJoCo computed last.
        owners: names of entities by their root bodies.
    """
    owner = [owners.get(root) for root in model.body_rootid[model.geom_bodyid].tolist()]
    found: dict[str, tuple[float, int]] = {}
    for own, other, depth, up in _touches(data):
        name = owner[own]
        carries = up > _CARRIES and (depth < LEAST or model.geom_type[other] == _PLANE)
        if name is not None and name != owner[other] and not carries:
            found[name] = max(found.get(name, (0.0, other)), (depth, other))
    return found


def contacts_of(model: mujoco.MjModel, data: mujoco.MjData, roots: Collection[int]) -> list[int]:
    """Return the ids of the geoms that touch an entity, in ascending order; supports count, too.

    Args:
        model: model of the world.
        data: state with the contacts that MuJoCo computed last.
        roots: ids of the topmost bodies of the entity.
    """
    owner = model.body_rootid[model.geom_bodyid].tolist()
    pairs = ((owner[own], owner[other], other) for own, other, _, _ in _touches(data))
    return sorted({geom for root, foreign, geom in pairs if root in roots and foreign not in roots})
