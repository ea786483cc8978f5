"""Finds overlapping bodies that physics will push apart."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from graphengine.physics.engine import mujoco
from graphengine.physics.model.geoms import extents

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
    deep = (data.contact.dist <= -LEAST) & (data.contact.geom >= 0).all(axis=1)
    found: dict[int, tuple[float, int]] = {}
    contacts = data.contact.geom[deep].tolist(), data.contact.dist[deep].tolist(), data.contact.frame[deep, 2].tolist()
    for pair, distance, rise in zip(*contacts, strict=True):
        owners = model.body_rootid[model.geom_bodyid[pair]].tolist()
        within = [root in roots for root in owners]
        if within.count(True) == 1:
            other = within.index(False)
            if not floors and model.geom_type[pair[other]] == _PLANE and (rise if other == 0 else -rise) > _CARRIES:
                continue
            found[owners[other]] = max(found.get(owners[other], (0.0, 0)), (-distance, pair[other]))
    return {geom: depth for depth, geom in sorted(found.values(), reverse=True)}


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

    Contacts with a support do not count. A contact is one with a support if its normal shows that the other geom is below the
    entity, and if its depth is less than `LEAST` or the other geom is a plane (a floor supports at any depth).

    Args:
        model: model of the world.
        data: state with the contacts that MuJoCo computed last.
        owners: names of entities by their root bodies.
    """
    found: dict[str, tuple[float, int]] = {}
    contacts, kinds, roots = data.contact, model.geom_type, model.body_rootid[model.geom_bodyid]
    for pair, distance, rise in zip(
        contacts.geom.tolist(), contacts.dist.tolist(), contacts.frame[:, 2].tolist(), strict=True
    ):
        if distance >= 0.0 or min(pair) < 0:
            continue
        names = [owners.get(int(roots[geom])) for geom in pair]
        for own, other, up in ((0, 1, -rise), (1, 0, rise)):
            name, geom, depth = names[own], pair[other], -distance
            carries = up > _CARRIES and (depth < LEAST or kinds[geom] == _PLANE)
            if name is not None and name != names[other] and not carries:
                found[name] = max(found.get(name, (0.0, geom)), (depth, geom))
    return found


def contacts_of(model: mujoco.MjModel, data: mujoco.MjData, roots: Collection[int]) -> list[int]:
    """Return the ids of the geoms that touch an entity, in ascending order; supports count, too.

    Args:
        model: model of the world.
        data: state with the contacts that MuJoCo computed last.
        roots: ids of the topmost bodies of the entity.
    """
    pairs = data.contact.geom[(data.contact.dist < 0.0) & (data.contact.geom >= 0).all(axis=1)]
    own = np.isin(model.body_rootid[model.geom_bodyid[pairs]], list(roots))
    found: list[int] = np.unique(pairs[~own & own[:, ::-1]]).tolist()
    return found
