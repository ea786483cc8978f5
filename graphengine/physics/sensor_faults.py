"""Faults of sensors: while a fault acts on a sensor, its readers get the newest sample that has passed the fault."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from graphengine.devices.device import SampleReader
from graphengine.format.faults import Faults


@dataclass(frozen=True, slots=True)
class Output:
    """The output of a faulty sensor in a tick.

    Attributes:
        sample: the newest sample that has passed the fault.
        index: number of the sample.
        fresh: whether the sample has passed the fault in this tick.
    """

    sample: Any
    index: int
    fresh: bool


def make_faulty(handle: Any, reader: SampleReader) -> None:
    """Let the methods of a sensor's class return `output` of the sensor while a fault acts on it.

    Args:
        handle: subclass of `Handle` that implements a sensor.
        reader: names the method that returns a sample.
    """
    handle.reader, handle.kept = reader, (*handle.kept, "output")
    read = getattr(handle, reader.method)
    faulty = _unless_faulty(read, lambda sensor: sensor.output.sample)
    setattr(handle, reader.method, functools.wraps(read)(faulty))
    for name, output in (("due", _is_due), ("index", lambda sensor: sensor.output.index)) if reader.lasts else ():
        if isinstance(own := getattr(handle, name, None), property):
            setattr(handle, name, property(_unless_faulty(own.fget, output), doc=own.__doc__))


def _unless_faulty(read: Any, output: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda sensor: read(sensor) if sensor.output is None else output(sensor)


def _is_due(sensor: Any) -> bool:
    """Return whether a sample has passed the fault in this tick; graphs that run per physics step get it in the next tick."""
    simulation, output = sensor._simulation, sensor.output
    return output.fresh and (not simulation.stepping or simulation.in_first_step)


def advance(handle: Any, key: str, faults: Faults) -> None:
    """Take the sample of this tick and set the output of a sensor with a fault; without a fault, remove its output.

    Args:
        handle: sensor.
        key: name of the handle in its table.
        faults: faults that act in this tick; the keys are prim paths.
    """
    last: Output | None = handle.output
    handle.output = None
    if handle.prim_path not in faults.acting:
        return
    reader: SampleReader = handle.reader
    is_new = not reader.lasts or getattr(handle, "due", True)
    sample = getattr(handle, reader.method)() if is_new or last is None else None
    made = Output(sample, getattr(handle, "index", 0), fresh=True)
    arrived = faults.passing(handle.prim_path, key, [made] if is_new and sample is not None else [])
    if arrived:
        handle.output = arrived[-1]
    else:
        kept = last or made
        handle.output = Output(kept.sample if reader.lasts else None, kept.index, fresh=False)
