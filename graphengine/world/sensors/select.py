"""Which rays a simulation casts."""

from __future__ import annotations

from graphengine.diagnostics import UsageError
from graphengine.world.engine import mujoco
from graphengine.world.sensors.multiray import MultiRays
from graphengine.world.sensors.rays import Rays, RaysChoice


def select_rays(choice: RaysChoice, model: mujoco.MjModel, data: mujoco.MjData) -> Rays:
    """The faster rays, where numba is installed and they know every shape of the model, unless others are asked for.

    Raises:
        UsageError: `fast` was asked for and cannot be.
    """
    if choice == "mujoco":
        return MultiRays(model, data)
    try:
        from graphengine.world.sensors.fast.rays import FastRays, why_not  # numba takes 0.4 s to import
    except ImportError as error:
        if choice == "fast":
            raise UsageError(f"rays 'fast' need numba: {error}\n  pip install 'graphengine[fast]'") from error
        return MultiRays(model, data)
    unknown = why_not(model)
    if unknown and choice == "fast":
        raise UsageError(f"rays 'fast' do not meet {unknown}\n  rays 'mujoco' do")
    return MultiRays(model, data) if unknown else FastRays(model, data)
