"""Selects the method by which the rays of a model's sensors are cast.

There are two implementations: `mujoco`, which always works, and `fast`, which is compiled by numba and takes a tenth of the time
or less.
"""

from __future__ import annotations

import contextlib
from typing import Literal

from graphengine.descriptions.engine import mujoco
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError
from graphengine.physics.ray_casting.casters import Rays

RaysChoice = Literal["auto", "mujoco", "fast"]


def select_rays(choice: RaysChoice, model: mujoco.MjModel, data: mujoco.MjData) -> Rays:
    """Return the requested ray casting method; `auto` is `fast` if numba works and supports all shapes of the model.

    Raises:
        UsageError: `fast` was requested but cannot be used.
    """
    obstacle = "" if choice == "mujoco" else _obstacle(model)
    if obstacle and choice == "fast":
        raise UsageError(obstacle)
    if obstacle or choice == "mujoco":
        from graphengine.physics.ray_casting.multiray import MultiRays

        return MultiRays(model, data)
    from graphengine.physics.ray_casting.fast.rays import FastRays

    return FastRays(model, data)


def compile_kernels(choice: RaysChoice) -> None:
    """Compile the kernels of the fast method if it can be selected; the first time, this takes up to a minute."""
    if choice != "mujoco":
        with contextlib.suppress(Exception):  # of numba; `select_rays` reports it
            from graphengine.physics.ray_casting.fast.rays import trouble

            trouble()


def _obstacle(model: mujoco.MjModel) -> str:
    """Return the reason why the fast method cannot be used with a model, with a remedy; empty if it can be used."""
    try:
        from graphengine.physics.ray_casting.fast.rays import trouble, why_not  # numba takes 0.4 s to import
    except Exception as error:  # numba is not there, or one of its libraries does not fit
        return f"rays 'fast' need numba: {error}\n  {install_command('fast')}"
    if why := trouble():
        return f"rays 'fast' cannot be cast here: {why}\n  use rays 'mujoco' instead"
    if unknown := why_not(model):
        return f"rays 'fast' do not support {unknown}\n  use rays 'mujoco' instead"
    return ""
