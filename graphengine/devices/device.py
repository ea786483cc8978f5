"""The registry of devices: sensors and grippers. A module of this package defines each kind: its readings, Protocol and stub.

    @device("contact", ContactSensor, usd="IsaacContactSensor", title="a contact sensor")
    class ContactSensorStub(Stub): ...

For each kind, a module of `graphengine.physics.sensors` defines the profile and the class that implements the Protocol in MuJoCo.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from graphengine.devices.rotation import IDENTITY, Quaternion
from graphengine.devices.stage import Prim
from graphengine.format.kinds import DEVICES
from graphengine.format.stateful import Shared

D = TypeVar("D")
R = TypeVar("R")


class Sensor(Protocol):
    """The common Protocol of all sensors and grippers."""

    @property
    def prim_path(self) -> str:
        """Path of the sensor's prim. The namespaces of this prim and its ancestors form the namespace of the sensor's topics."""


class SampledSensor(Sensor, Protocol):
    """A sensor that takes samples at a fixed rate. Sample n belongs to the first tick at or after n / rate seconds.

    All nodes that read a sample get the same object, which is never modified.
    """

    @property
    def rate(self) -> float:
        """Number of samples per second."""

    @property
    def due(self) -> bool:
        """Whether this tick has a new sample."""


class TickSensor(SampledSensor, Protocol):
    """A sensor with at most one sample per tick."""

    @property
    def index(self) -> int:
        """Index of the newest sample since the start of play."""


class Stub(Shared):
    """Base class of stubs, which replace devices in `graphrun check` and in tests. Tests set the readings of stubs.

    Args:
        prim: prim of the device. The profile's values in `facts` of the prim replace the class attributes with the same names.
    """

    rate = 30.0
    due = False
    index = 0

    def __init__(self, prim: Prim) -> None:
        self.prim_path = prim.path
        vars(self).update({name: value for name, value in prim.facts.items() if hasattr(self, name)})


class ReadingStub(Stub, Generic[R]):
    """Base class of stubs whose reading a test assigns to `measured`, or sets with a method `measure` of the subclass."""

    measured: R

    def reading(self) -> R:
        """Return the value of `measured`."""
        return self.measured


class SampleReader:
    """Calls a method of a device in each tick with a new sample; in every tick if the device has no rate.

    Args:
        method: name of the method, which returns a sample.
    """

    lasts = True
    """Whether the method returns the newest sample in ticks without a new sample too; if false, it then returns None."""

    def __init__(self, method: str) -> None:
        self.method = method

    def __call__(self, device: Any) -> Any:
        """Return the sample of this tick, or None."""
        return getattr(device, self.method)() if getattr(device, "due", True) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A registered kind of device.

    Attributes:
        kind: name of the kind. Robot files use it as `type`, prims as their kind, and profiles as the name of a section.
        stub: function that returns a stub, given a prim and options.
        usd: USD type of the device's prims for the service GetPrims. For a kind that Isaac Sim does not have, choose a name, such
            as `RangeSensor`.
        title: name of the kind in messages, with an article, such as `a lidar`.
        child: name of the device's prim, which is a child of the mount's prim; empty if the mount's prim is the device.
        orientation: orientation of the device's prim in the mount's frame.
        in_rigs: whether a rig (a sensor that consists of several devices) may contain devices of this kind.
        sample: reader that returns the new sample of a device in this tick, or None without a new sample; called once in each
            tick, after the graphs. None for a device that is not a sensor.
        ticks_only: whether the device has at most one sample per tick. Graphs that run at physics steps cannot read such devices.
    """

    kind: str
    stub: Callable[..., Any]
    usd: str
    title: str
    child: str = ""
    orientation: Quaternion = IDENTITY
    in_rigs: bool = False
    sample: SampleReader | None = None
    ticks_only: bool = False


def when_due(method: str) -> SampleReader:
    """Return a reader that calls the method with this name."""
    return SampleReader(method)


DEVICE_OF: dict[Any, Device] = {}
"""A dict to each registered kind of device from its Protocol, from its stub and from its implementation."""


def device(
    kind: str, interface: Callable[..., D], *, rank: int = 100, **facts: Any
) -> Callable[[Callable[..., D]], Any]:
    """Return a decorator for a stub class that registers a kind of device. The stub class must implement the Protocol.

    Args:
        kind: name of the kind, as in `Device`.
        interface: Protocol of the device.
        rank: position of the kind when messages list kinds; lower ranks come first.
        facts: values of the other attributes of `Device`.
    """

    def register(stub: Callable[..., D]) -> Callable[..., D]:
        entry = Device(kind=kind, stub=stub, ticks_only=TickSensor in getattr(interface, "__mro__", ()), **facts)
        DEVICES.add(kind, entry, rank)
        DEVICE_OF[interface] = DEVICE_OF[stub] = entry
        return stub

    return register


def device_of(interface: Callable[..., Any]) -> Device:
    """Return the kind of device to which a Protocol, a stub or an implementation belongs.

    Raises:
        TypeError: the argument belongs to no registered kind.
    """
    if interface not in DEVICE_OF:
        raise TypeError(f"{interface!r} is not a device; pass a Protocol that a module of graphengine.devices defines")
    return DEVICE_OF[interface]
