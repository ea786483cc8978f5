"""Handles, through which nodes use a prim in a simulation, and the table of a simulation's handles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar

from graphengine.devices.device import SampleReader
from graphengine.devices.stage import Prim
from graphengine.format.faults import Faults
from graphengine.format.prim_paths import at_or_below
from graphengine.format.stateful import Stateful
from graphengine.physics.sensor_faults import Output, advance

S = TypeVar("S")


class Handle(Stateful, Generic[S]):
    """Base class of handles: gives access to one prim in the current model of a simulation of the class `S`."""

    sees_steps: ClassVar[bool] = False
    """Whether the simulation calls the `see_...` methods of the handle in every physics step."""
    casts_rays: ClassVar[bool] = False
    """Whether the handle casts rays; their kernels are compiled before the nodes of a session are set up."""

    reader: ClassVar[SampleReader | None] = None
    """Reads the samples of a sensor; None for other handles."""
    output: Output | None = None
    """Output of a sensor while a fault acts on it; None without a fault."""
    released = False
    """Whether the table has released the handle; the handle may then belong to an earlier model."""

    def __init__(self, simulation: S, prim: Prim) -> None:
        self._simulation = simulation
        self._prim = prim
        self.prim_path = prim.path
        self._set_up()
        self.bind()

    def _set_up(self) -> None:
        """Set the attributes that do not depend on the current model; called once, before the first `bind`."""

    @classmethod
    def key(cls, prim: Prim, **options: Any) -> str:
        """Return the key of a handle in the table: the prim's path. Subclasses with options append these to the path."""
        return prim.path

    def bind(self) -> None:
        """Look up the prim's ids and array views in the simulation's current model, if the handle needs any."""

    def reset(self) -> None:
        """Discard all measurements; called when the simulation or only its time is reset, and when the handle is released.

        At a reset of the simulation, all bodies are already at their start. A handle is created when a node first asks for it,
        usually before the first step.
        """

    def see_forces(self) -> None:
        """Observe the contact forces of a physics step; the body poses are still the poses before the step."""

    def see_motion(self) -> None:
        """Observe the state after a physics step."""

    def see_displacement(self) -> None:
        """Observe that a body was moved to another pose between two steps; this displacement is not motion."""


H = TypeVar("H", bound=Handle[Any])


class HandleTable:
    """The handles of a simulation; a handle is found by its class and key.

    Attributes:
        watching: handles whose `sees_steps` is true.
        feeling: those of `watching` that observe contact forces.
    """

    def __init__(self, simulation: object) -> None:
        self._simulation = simulation
        self.watching: list[Handle[Any]] = []
        self.feeling: list[Handle[Any]] = []
        self._handles: dict[tuple[type[Handle[Any]], str], Handle[Any]] = {}

    def find(self, kind: type[H], prim: Prim, **options: Any) -> H:
        """Return the handle of a prim for a handle class and options; it is created at first use."""
        key = kind.key(prim, **options)
        handle = self._handles.get((kind, key))
        if not isinstance(handle, kind):
            handle = self._handles[kind, key] = kind(self._simulation, prim, **options)
            self._changed()
        return handle

    def forget(self, prim_path: str) -> None:
        """Release the handles of a prim and of all prims below it."""
        for key in [key for key in self._handles if at_or_below(key[1], prim_path)]:
            self._release(key)
        self._changed()

    def _release(self, key: tuple[type[Handle[Any]], str]) -> None:
        handle = self._handles.pop(key)
        handle.reset()
        handle.released = True

    def advance(self, faults: Faults) -> None:
        """Determine the outputs of all sensors with faults in this tick."""
        for (_, key), handle in self._handles.items():
            if handle.reader is not None:
                advance(handle, key, faults)

    def save(self) -> dict[tuple[type[Handle[Any]], str], Any]:
        """Return the states of all handles."""
        return {key: handle.save() for key, handle in self._handles.items()}

    def restore(self, saved: Mapping[tuple[type[Handle[Any]], str], Any]) -> None:
        """Restore the states of all handles. Handles that did not exist at `save` are released; `find` creates them again."""
        for key in [key for key in self._handles if key not in saved]:
            self._release(key)
        for key, handle in self._handles.items():
            handle.restore(saved[key])
        self._changed()

    def bind(self) -> None:
        """Bind all handles to the simulation's current model."""
        for handle in self._handles.values():
            handle.bind()

    def reset(self, prim_path: str = "") -> None:
        """Discard the measurements of the handles of a prim and of all prims below it; of all handles if the path is empty."""
        for (_, key), handle in self._handles.items():
            if not prim_path or at_or_below(key, prim_path):
                handle.reset()
                handle.output = None

    def clear(self) -> None:
        """Release all handles."""
        for key in list(self._handles):
            self._release(key)
        self._changed()

    def _changed(self) -> None:
        self.watching = [handle for handle in self._handles.values() if handle.sees_steps]
        self.feeling = [handle for handle in self.watching if type(handle).see_forces is not Handle.see_forces]
