"""Which rays a simulation casts."""

from __future__ import annotations

from graphengine.format.errors import UsageError
from graphengine.physics.engine import mujoco
from graphengine.physics.sensors.multiray import MultiRays
from graphengine.physics.sensors.rays import Rays, RaysChoice


def select_rays(choice: RaysChoice, model: mujoco.MjModel, data: mujoco.MjData) -> Rays:
    """The faster rays, where numba works and they know every shape of the model, unless others are asked for.

    Raises:
        UsageError: `fast` was asked for and cannot be.
    """
    obstacle = "" if choice == "mujoco" else _obstacle(model)
    if obstacle and choice == "fast":
        raise UsageError(obstacle)
    if obstacle or choice == "mujoco":
        return MultiRays(model, data)
    from graphengine.physics.sensors.fast.rays import FastRays

    return FastRays(model, data)


def _obstacle(model: mujoco.MjModel) -> str:
    """What keeps the faster rays from serving a model, and what helps; empty if nothing does."""
    try:
        from graphengine.physics.sensors.fast.rays import trouble, why_not  # numba takes 0.4 s to import
    except Exception as error:  # numba is not there, or one of its libraries does not fit
        return f"rays 'fast' need numba: {error}\n  pip install 'graphengine[fast]'"
    if why := trouble():
        return f"rays 'fast' cannot be cast here: {why}\n  rays 'mujoco' can"
    if unknown := why_not(model):
        return f"rays 'fast' do not meet {unknown}\n  rays 'mujoco' do"
    return ""
