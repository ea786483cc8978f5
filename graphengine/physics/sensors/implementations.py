"""The registry of device implementations in a simulation; each is defined with its profile in a module of this package."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import Field

from graphengine.devices.device import DEVICE_OF, device_of
from graphengine.devices.stage import Prim
from graphengine.format.kinds import Kinds
from graphengine.format.spec import Spec
from graphengine.physics.engine import mujoco

D = TypeVar("D")

Rate = Annotated[float, Field(ge=0.001, le=10_000.0)]
Deviation = Annotated[float, Field(ge=0.0, le=1000.0)]
Offset = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Offsets = Annotated[tuple[Offset, Offset, Offset], Field(strict=False)]


def check_less(**bounds: float) -> None:
    """Check that the first of two values, given by name, is less than the second.

    Raises:
        ValueError: it is not less.
    """
    (low, least), (high, most) = bounds.items()
    if not least < most:
        raise ValueError(f"{low} must be less than {high}, and {least:g} is not less than {most:g}")


class Profile(Spec):
    """A section of a sensor profile: the parameters of one kind of device."""

    def facts(self) -> dict[str, Any]:
        """Return the facts that a prim of the device gets from its profile."""
        return self.model_dump()


class Implementation(NamedTuple):
    """The implementation of one kind of device in a simulation."""

    handle: Any
    """Creates the `Handle` that implements the device's Protocol, from the simulation, the prim and the device's options."""
    profile: type[Profile]
    build: Callable[[mujoco.MjSpec, str, Prim], None] | None = None
    """Adds the elements that a device needs to the model of its robot, from the name of the carrying body and the prim."""


IMPLEMENTATIONS: Kinds[Implementation] = Kinds("graphengine.physics.sensors")
"""Implementations by kind of device."""


def implements(
    interface: Callable[..., D],
    profile: type[Profile],
    build: Callable[[mujoco.MjSpec, str, Prim], None] | None = None,
) -> Callable[[Callable[..., D]], Any]:
    """Register an implementation; decorates the subclass of `Handle` that implements the device's Protocol.

    The arguments are those of `Implementation`.
    """

    def register(handle: Callable[..., D]) -> Callable[..., D]:
        entry = device_of(interface)
        IMPLEMENTATIONS.add(entry.kind, Implementation(handle, profile, build))
        DEVICE_OF[handle] = entry
        return handle

    return register
