"""Which bodies are in each other, as far as physics will push them apart."""

from __future__ import annotations

from collections.abc import Collection

from graphengine.world.engine import mujoco

LEAST = 0.005
"""Depth from which it counts, m: what rests on something sinks in by less."""


def overlaps(model: mujoco.MjModel, data: mujoco.MjData, roots: Collection[int]) -> dict[int, float]:
    """The shapes that some topmost bodies are stuck in, and how deep, m; one for each topmost body that they belong to.

    Contacts are those of the state that MuJoCo looked at last; shapes that it lets pass through each other do not count.
    """
    deep = (data.contact.dist <= -LEAST) & (data.contact.geom >= 0).all(axis=1)
    found: dict[int, tuple[float, int]] = {}
    for pair, distance in zip(data.contact.geom[deep].tolist(), data.contact.dist[deep].tolist(), strict=True):
        owners = model.body_rootid[model.geom_bodyid[pair]].tolist()
        within = [root in roots for root in owners]
        if within.count(True) == 1:
            other = within.index(False)
            found[owners[other]] = max(found.get(owners[other], (0.0, 0)), (-distance, pair[other]))
    return {geom: depth for depth, geom in sorted(found.values(), reverse=True)}
