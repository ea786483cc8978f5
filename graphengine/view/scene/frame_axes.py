"""The layer of frames: the axes of robots' links, sensors and frame prims, with their names in TF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from graphengine.view.layer_data import FrameLayers, Mount, SceneLayers
from graphengine.view.scene.carried import Carried
from graphengine.view.scene.layer import Layer, Poses

MOST_NAMES = 40
"""Maximum number of frames for which names are shown; with more frames, no names are shown, as they would overlap."""
LENGTH = 0.12
"""Length of an axis, m."""
TEXT_HEIGHT = 0.018
"""Height of a name, m."""


class FrameAxes(Layer):
    """Axes of each frame: x is red, y green and z blue."""

    name = "frames"
    title = "Frames"
    hint = "Links, sensors and frames of robots, named as in TF; x red, y green, z blue"

    def _draw(self, layers: SceneLayers) -> None:
        self._carried = Carried.of([(frame.body, frame.pose) for frame in layers.frames])
        self._last: Poses | None = None
        count = len(layers.frames)
        self._axes: Any = self._scene.add_batched_axes(
            f"{self.path}/axes",
            np.tile(np.array([1.0, 0.0, 0.0, 0.0], np.float32), (count, 1)),
            np.zeros((count, 3), np.float32),
            axes_length=LENGTH,
            axes_radius=LENGTH / 24,
        )
        self._names = {
            row: self._scene.add_label(
                f"{self.path}/names/{row}",
                ", ".join(names),
                font_size_mode="scene",
                font_scene_height=TEXT_HEIGHT,
                anchor="bottom-left",
            )
            for row, names in _names(layers.frames if count <= MOST_NAMES else ()).items()
        }

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Move the axes with their bodies."""
        if not self.shown or not len(self._carried.rows):
            return
        if self._last is not None and np.array_equal(poses, self._last):
            return
        self._last = poses
        positions, rotations = self._carried.at(poses)
        self._axes.batched_positions, self._axes.batched_wxyzs = positions, rotations
        for row, label in self._names.items():
            label.position = positions[row]


def _names(frames: Sequence[Mount]) -> Mapping[int, Sequence[str]]:
    """Return the names of frames in groups with the same position on a body, by the index of a group's first frame."""
    places: dict[tuple[int, ...], int] = {}
    found: dict[int, list[str]] = {}
    for row, frame in enumerate(frames):
        place = (frame.body, *(round(x / TEXT_HEIGHT) for x in frame.pose[0]))
        found.setdefault(places.setdefault(place, row), []).append(frame.name)
    return found
