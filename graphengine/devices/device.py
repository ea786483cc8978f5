"""The registry of devices. A module of this package defines one kind: its readings, its Protocol and its stub.

    @device("contact", ContactSensor, usd="IsaacContactSensor", title="a contact sensor")
    class ContactSensorStub(Stub): ...

`graphengine.physics.sensors` has a module for each kind too, with its profile and the handle that implements the Protocol.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from graphengine.devices.rotation import IDENTITY, Quaternion
from graphengine.devices.stage import Prim
from graphengine.format.kinds import DEVICES
from graphengine.format.stateful import Shared

D = TypeVar("D")


class Sensor(Protocol):
    """The interface of all sensors."""

    @property
    def prim_path(self) -> str:
        """Path of the sensor's prim; namespaces of topics are collected from this prim and its ancestors."""


class SampledSensor(Sensor, Protocol):
    """A sensor with samples: sample n belongs to the first tick at or after n / rate seconds.

    All nodes that read a sample get the same object, which is never modified.
    """

    @property
    def rate(self) -> float:
        """Samples per second."""

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick."""


class TickSensor(SampledSensor, Protocol):
    """A sensor with at most one sample per tick."""

    @property
    def index(self) -> int:
        """Number of the newest sample since play."""


class Stub(Shared):
    """A device without physics for checks and tests; tests write its readings.

    Args:
        prim: prim of the device; its `facts` hold the values of the sensor's profile, in tests only some of them.
    """

    def __init__(self, prim: Prim) -> None:
        self.prim_path = prim.path
        self.rate: float = prim.facts.get("rate", 30.0)
        self.due, self.index = False, 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """One kind of device.

    Attributes:
        kind: name of the kind, which is also the `type` in robot files, the kind of the prims, and the section in a profile.
        stub: function that makes a stub from a prim and options.
        usd: USD type of the device's prims.
        title: the kind with an article, for messages, such as `a lidar`.
        child: name of the device's prim below the mount's prim; empty if both are the same prim.
        orientation: orientation of the child in the mount's frame.
        in_rigs: whether a rig, which is a sensor of several devices, may contain devices of this kind.
        ticks_only: whether the device has at most one sample per tick, so that graphs that run at physics steps cannot read it.
    """

    kind: str
    stub: Callable[..., Any]
    usd: str
    title: str
    child: str = ""
    orientation: Quaternion = IDENTITY
    in_rigs: bool = False
    ticks_only: bool = False


DEVICE_OF: dict[Any, Device] = {}
"""Kind of device of each Protocol, stub and implementation."""


def device(
    kind: str, interface: Callable[..., D], *, rank: int = 100, **facts: Any
) -> Callable[[Callable[..., D]], Any]:
    """Return a decorator that registers a kind of device; it decorates the stub class, which must match the Protocol.

    Args:
        kind: name of the kind, as in `Device`.
        interface: Protocol of the device.
        rank: order of kinds in messages; lower ranks come first.
        facts: values of the other attributes of `Device`.
    """

    def register(stub: Callable[..., D]) -> Callable[..., D]:
        entry = Device(kind=kind, stub=stub, ticks_only=TickSensor in getattr(interface, "__mro__", ()), **facts)
        DEVICES.add(kind, entry, rank)
        DEVICE_OF[interface] = DEVICE_OF[stub] = entry
        return stub

    return register


def device_of(interface: Callable[..., Any]) -> Device:
    """Return the kind of device that a Protocol, a stub or an implementation belongs to.

    Raises:
        TypeError: no kind of device is registered for it.
    """
    if interface not in DEVICE_OF:
        raise TypeError(f"{interface!r} is no device; give a Protocol that a module of graphengine.devices registers")
    return DEVICE_OF[interface]
