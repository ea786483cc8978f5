"""The layer of the occupancy map, drawn just above the floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graphengine.view.layer_data import FLOOR, FloorMap, FrameLayers, SceneLayers
from graphengine.view.scene.layer import Layer, Poses

HEIGHT = 0.02
"""Height of the image above z = 0, m; an image closer to the floor flickers when seen from afar."""
OCCUPIED, FREE = (20, 24, 40, 235), (60, 150, 90, 80)
"""Colours of occupied and free cells: red, green, blue and opacity, 0 to 255. Unknown cells are transparent."""


class FloorPicture(Layer):
    """The occupancy map that `graphrun map` makes: occupied cells are dark, free cells green."""

    name = needs = FLOOR
    title = "Map"
    hint = "The occupancy map of the scene at time 0, as graphrun map makes it: obstacles dark, free floor green"
    _floor: FloorMap | None = None

    def _draw(self, layers: SceneLayers) -> None:
        if self._floor is not None:
            self._show(self._floor)

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Show the map if the frame contains it."""
        if frame.floor is not None:
            self._floor = frame.floor
            self._show(frame.floor)

    def _show(self, floor: FloorMap) -> None:
        rows, columns = floor.cells.shape
        width, height = columns * floor.cell, rows * floor.cell
        middle = (floor.corner[0] + width / 2, floor.corner[1] + height / 2, HEIGHT)
        self._scene.add_image(
            f"{self.path}/cells",
            picture(floor),
            width,
            height,
            format="png",
            cast_shadow=False,
            receive_shadow=False,
            position=middle,
        )


def picture(floor: FloorMap) -> NDArray[np.uint8]:
    """Return the map as an RGBA image, shape (rows, columns, 4); the first row is in the south, where viser draws it."""
    pixels = np.zeros((*floor.cells.shape, 4), np.uint8)
    pixels[floor.cells == 100] = OCCUPIED
    pixels[floor.cells == 0] = FREE
    return pixels
