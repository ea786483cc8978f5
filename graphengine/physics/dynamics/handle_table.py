"""A handle, which is a prim's place in a simulation, and the table of all: one for each prim and kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from graphengine.devices.stage import Prim, at_or_below
from graphengine.format.stateful import Stateful

if TYPE_CHECKING:
    from graphengine.physics.core import SimulationCore


class Handle(Stateful):
    """A prim's place in a simulation."""

    sees_steps: ClassVar[bool] = False
    """Whether it is told of every physics step, by the methods below."""

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self._simulation = simulation
        self._prim = prim
        self.prim_path = prim.path
        self.bind()

    @classmethod
    def key(cls, prim: Prim, **options: Any) -> str:
        """The prim's path, and below it what else tells handles of a prim apart; a subclass with options takes them."""
        return prim.path

    def bind(self) -> None:
        """Find ids and views in the simulation's present model."""
        raise NotImplementedError

    def reset(self) -> None:
        """Forget what was seen since the start."""

    def see_forces(self) -> None:
        """Look at what acts in a step: contacts and their forces are known, bodies are where they were before it."""

    def see_motion(self) -> None:
        """Look at where the step led."""

    def see_displacement(self) -> None:
        """Take note that something was put elsewhere between two steps, which is no motion."""


H = TypeVar("H", bound=Handle)


class HandleTable:
    """The handles of a simulation by kind and key.

    Attributes:
        watching: those that want to see every physics step.
    """

    def __init__(self, simulation: SimulationCore) -> None:
        self._simulation = simulation
        self.watching: list[Handle] = []
        self._handles: dict[tuple[type[Handle], str], Handle] = {}

    def find(self, kind: type[H], prim: Prim, **options: Any) -> H:
        """The handle of a prim with some options, made when it is first asked for."""
        key = kind.key(prim, **options)
        handle = self._handles.get((kind, key))
        if not isinstance(handle, kind):
            handle = self._handles[kind, key] = kind(self._simulation, prim, **options)
            self._changed()
        return handle

    def forget(self, prim_path: str) -> None:
        """Let go of the handles of a prim and of all below it."""
        for key in [key for key in self._handles if at_or_below(key[1], prim_path)]:
            self._handles.pop(key).reset()
        self._changed()

    def save(self) -> dict[tuple[type[Handle], str], Any]:
        """States of all handles."""
        return {key: handle.save() for key, handle in self._handles.items()}

    def restore(self, saved: Mapping[tuple[type[Handle], str], Any]) -> None:
        """Let all go back; those that came since are forgotten, and asked for again where they are needed."""
        for key in [key for key in self._handles if key not in saved]:
            self._handles.pop(key).reset()
        for key, handle in self._handles.items():
            handle.restore(saved[key])
        self._changed()

    def bind(self) -> None:
        """Let all find their places in another model."""
        for handle in self._handles.values():
            handle.bind()

    def reset(self) -> None:
        """Let all forget what they saw since the start."""
        for handle in self._handles.values():
            handle.reset()

    def clear(self) -> None:
        """Let go of all."""
        self.reset()
        self._handles.clear()
        self._changed()

    def _changed(self) -> None:
        self.watching = [handle for handle in self._handles.values() if handle.sees_steps]
