"""Handles, which bind prims to a simulation, and their table: one handle per prim and kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from graphengine.devices.stage import Prim, at_or_below
from graphengine.format.stateful import Stateful

if TYPE_CHECKING:
    from graphengine.physics.core import SimulationCore


class Handle(Stateful):
    """Binds a prim to a simulation."""

    sees_steps: ClassVar[bool] = False
    """Whether the simulation calls the methods `see_...` of the handle in every physics step."""

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self._simulation = simulation
        self._prim = prim
        self.prim_path = prim.path
        self.bind()

    @classmethod
    def key(cls, prim: Prim, **options: Any) -> str:
        """Return the key of a handle: the prim's path, followed by the options of subclasses that have any."""
        return prim.path

    def bind(self) -> None:
        """Find ids and views in the simulation's current model."""
        raise NotImplementedError

    def reset(self) -> None:
        """Discard measurements since the start."""

    def see_forces(self) -> None:
        """Called in a step when contacts and their forces are computed, before bodies move."""

    def see_motion(self) -> None:
        """Called after a step."""

    def see_displacement(self) -> None:
        """Called after a body was placed elsewhere between two steps, which does not count as motion."""


H = TypeVar("H", bound=Handle)


class HandleTable:
    """The handles of a simulation by kind and key.

    Attributes:
        watching: handles that observe each physics step.
    """

    def __init__(self, simulation: SimulationCore) -> None:
        self._simulation = simulation
        self.watching: list[Handle] = []
        self._handles: dict[tuple[type[Handle], str], Handle] = {}

    def find(self, kind: type[H], prim: Prim, **options: Any) -> H:
        """Return the handle of a prim with given options; it is created at first use."""
        key = kind.key(prim, **options)
        handle = self._handles.get((kind, key))
        if not isinstance(handle, kind):
            handle = self._handles[kind, key] = kind(self._simulation, prim, **options)
            self._changed()
        return handle

    def forget(self, prim_path: str) -> None:
        """Release the handles of a prim and of all prims below it."""
        for key in [key for key in self._handles if at_or_below(key[1], prim_path)]:
            self._handles.pop(key).reset()
        self._changed()

    def save(self) -> dict[tuple[type[Handle], str], Any]:
        """Return the states of all handles."""
        return {key: handle.save() for key, handle in self._handles.items()}

    def restore(self, saved: Mapping[tuple[type[Handle], str], Any]) -> None:
        """Restore the states of all handles; handles created since `save` are released, and created again at next use."""
        for key in [key for key in self._handles if key not in saved]:
            self._handles.pop(key).reset()
        for key, handle in self._handles.items():
            handle.restore(saved[key])
        self._changed()

    def bind(self) -> None:
        """Bind all handles to another model."""
        for handle in self._handles.values():
            handle.bind()

    def reset(self) -> None:
        """Discard the measurements of all handles since the start."""
        for handle in self._handles.values():
            handle.reset()

    def clear(self) -> None:
        """Release all handles."""
        self.reset()
        self._handles.clear()
        self._changed()

    def _changed(self) -> None:
        self.watching = [handle for handle in self._handles.values() if handle.sees_steps]
