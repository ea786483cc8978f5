"""The handles of a simulation: one for each prim and kind, whoever asks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from graphengine.devices.stage import at_or_below
from graphengine.physics.dynamics.handles import Handle

H = TypeVar("H", bound=Handle)


class HandleTable:
    """Handles by kind and place, a prim's path and what else tells it from others.

    Attributes:
        watching: those that want to see every physics step.
    """

    def __init__(self) -> None:
        self.watching: list[Handle] = []
        self._handles: dict[tuple[type[Handle], str], Handle] = {}

    def find(self, kind: type[H], place: str, make: Callable[[], H]) -> H:
        """The handle at a place, made when it is first asked for."""
        handle = self._handles.get((kind, place))
        if not isinstance(handle, kind):
            handle = self._handles[kind, place] = make()
            self._changed()
        return handle

    def forget(self, prim_path: str) -> None:
        """Let go of the handles of a prim and of all below it."""
        for key in [key for key in self._handles if at_or_below(key[1], prim_path)]:
            self._handles.pop(key).reset()
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
