"""The registry of classes that implement devices, such as sensors, in a simulation.

Each class is defined in a module of `graphengine.physics.sensors`, together with the profile that contains its parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, NamedTuple, TypeVar

from pydantic import Field

from graphengine.descriptions.engine import mujoco
from graphengine.devices.device import DEVICE_OF, device_of
from graphengine.devices.stage import Prim
from graphengine.format.kinds import Kinds
from graphengine.format.spec import Spec
from graphengine.physics.sensor_faults import make_faulty

D = TypeVar("D")

Rate = Annotated[float, Field(ge=0.001, le=10_000.0)]
Deviation = Annotated[float, Field(ge=0.0, le=1000.0)]
Offset = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Offsets = Annotated[tuple[Offset, Offset, Offset], Field(strict=False)]


def check_less(**bounds: float) -> None:
    """Check that the first of two named values is less than the second.

    Raises:
        ValueError: the first value is not less than the second.
    """
    (low, least), (high, most) = bounds.items()
    if not least < most:
        raise ValueError(f"{low} must be less than {high}, but {least:g} is not less than {most:g}")


class Profile(Spec):
    """Base class of the sections of a sensor profile; each contains the parameters of one kind of device."""

    casts_rays: ClassVar[bool] = False
    """Whether the device casts rays. The keys `sees_own_robot` and `ignores` have an effect only on devices that do."""

    def facts(self) -> dict[str, Any]:
        """Return the values that the profile adds to the `facts` of a device's prim."""
        return self.model_dump()


class Implementation(NamedTuple):
    """The implementation of one kind of device in a simulation."""

    handle: Any
    """Subclass of `Handle` that implements the device's Protocol; it is called with simulation, prim and device options."""
    profile: type[Profile]
    build: Callable[[mujoco.MjSpec, str, Prim], None] | None = None
    """Function that adds the device's elements, such as welds, to the model of its robot.

    Its arguments are the robot's model, the name of the body that carries the device, and the device's prim.
    """


IMPLEMENTATIONS: Kinds[Implementation] = Kinds("graphengine.physics.sensors")
"""Implementations by the kind of the device, such as `lidar`."""


def implements(
    interface: Callable[..., D],
    profile: type[Profile],
    build: Callable[[mujoco.MjSpec, str, Prim], None] | None = None,
) -> Callable[[Callable[..., D]], Any]:
    """Return a class decorator that registers a subclass of `Handle` as the implementation of a device.

    Args:
        interface: Protocol of the device.
        profile: class of the device's parameters.
        build: see `Implementation.build`.
    """

    def register(handle: Callable[..., D]) -> Callable[..., D]:
        entry = device_of(interface)
        IMPLEMENTATIONS.add(entry.kind, Implementation(handle, profile, build))
        DEVICE_OF[handle] = entry
        if entry.sample is not None:
            make_faulty(handle, entry.sample)
        return handle

    return register
