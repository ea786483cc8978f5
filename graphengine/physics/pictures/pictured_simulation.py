"""A simulation with a thread that renders the images of its cameras."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from graphengine.format.errors import RenderError
from graphengine.physics.core.simulation_core import SimulationCore
from graphengine.physics.pictures import opengl
from graphengine.physics.pictures.render_thread import RenderThread


class PicturedSimulation(SimulationCore):
    """A simulation whose cameras can capture images. Arguments and errors are those of `SimulationCore`."""

    @cached_property
    def studio(self) -> RenderThread:
        """The thread that renders the images of all cameras; it is started at first use."""
        return RenderThread(self)

    def picture_driver(self) -> str:
        """Return the name and version of the OpenGL driver, or `not there` if OpenGL cannot be used."""
        try:
            return opengl.driver()
        except RenderError:
            return "not there"

    def save(self) -> Any:
        """Return a copy of the current state; wait for images that are being rendered."""
        return super().save(), self.studio.save()

    def restore(self, saved: Any) -> None:
        """Restore a state that `save` returned for the same robots."""
        state, studio = saved
        super().restore(state)
        self.studio.restore(studio)

    def close(self) -> None:
        """Release the handles and the renderer."""
        super().close()
        self.studio.close()
