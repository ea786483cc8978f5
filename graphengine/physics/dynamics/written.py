"""What graphs wrote over things that belong to the model and not to the state, such as frictions and lights.

It is kept by prim path: a model that has a robot more or less takes it over, and `put_back` undoes it.
"""

from __future__ import annotations

from typing import Generic, TypeVar

from graphengine.devices.stage import Prim, Stage
from graphengine.physics.engine import mujoco

T = TypeVar("T")


class Written(Generic[T]):
    """Values of prims of one kind, where they are others than those that were built.

    Args:
        stage: with the prims, whose facts are what they were built with.
    """

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._written: dict[str, T] = {}

    def built(self, prim: Prim) -> T:
        """What a prim was built with."""
        raise NotImplementedError

    def tell(self, model: mujoco.MjModel, prim: Prim, value: T) -> None:
        """Tell MuJoCo of a prim's value."""
        raise NotImplementedError

    def of(self, prim: Prim) -> T:
        """A prim's value."""
        return self._written[prim.path] if prim.path in self._written else self.built(prim)

    def write(self, model: mujoco.MjModel, prim: Prim, value: T) -> None:
        """Give a prim another value."""
        self.tell(model, prim, value)
        self._written[prim.path] = value

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Write in another model what was written before; prims that are gone are forgotten."""
        self._written = {path: value for path, value in self._written.items() if path in self._stage}
        for path, value in self._written.items():
            self.tell(model, self._stage.find(path), value)

    def put_back(self, model: mujoco.MjModel) -> None:
        """Let all have what they were built with."""
        for prim in map(self._stage.find, self._written):
            self.tell(model, prim, self.built(prim))
        self._written.clear()
