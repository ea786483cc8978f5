"""Keeps the newest sample of a sensor. Programs read this sample between two ticks."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from graphengine.format.kinds import DEVICES
from graphengine.physics.handles.motion_handles import CoreHandle
from graphengine.physics.implementations import IMPLEMENTATIONS


class NewestSample(CoreHandle):
    """The newest sample of the sensor at a prim.

    Attributes:
        sample: the sample, with read-only arrays; None before the first one and after a reset.
    """

    def _set_up(self) -> None:
        self._take = DEVICES.all[self._prim.kind].sample
        self.sample: Any = None
        self._sensor()  # a sensor that observes the physics steps of a tick must exist before them

    def _sensor(self) -> Any:
        return self._simulation.handles.find(IMPLEMENTATIONS.all[self._prim.kind].handle, self._prim)

    def reset(self) -> None:
        """Discard the sample."""
        self.sample = None

    def save(self) -> Any:
        """Return the sample itself, because samples never change."""
        return self.sample

    def restore(self, saved: Any) -> None:
        """Set the sample that `save` returned."""
        self.sample = saved

    def update(self) -> None:
        """Take the sample of this tick, if the sensor has a new one. Call this once in each tick, after the graphs.

        Raises:
            RenderError: the image of a camera could not be rendered.
        """
        if (sample := self._take(self._sensor())) is not None:
            views = {name: array.view() for name, array in _arrays(sample)}
            for view in views.values():
                view.flags.writeable = False
            self.sample = replace(sample, **views)


def _arrays(sample: Any) -> list[tuple[str, np.ndarray[Any, Any]]]:
    values = [(field.name, getattr(sample, field.name)) for field in fields(sample)]
    return [(name, value) for name, value in values if isinstance(value, np.ndarray)]
