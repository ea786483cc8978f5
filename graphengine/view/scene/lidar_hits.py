"""The layer of lidars: the points that lidar beams hit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.view.image_encoding import NEAR_TO_FAR, mixed
from graphengine.view.layer_data import LIDAR, FrameLayers, SceneLayers
from graphengine.view.scene.carried import Carried, Floats, turned
from graphengine.view.scene.layer import Layer, Poses

FAR = 10.0
"""Distance beyond which all hits have the same colour, m."""
BRIGHTEST = 255.0
"""Intensity of a white surface."""
DARK_TO_BRIGHT = ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37))


class LidarHits(Layer):
    """Points that lidar beams hit, with colours by range."""

    name = needs = LIDAR
    title = "Lidar"
    hint = "Points that lidar beams hit, coloured by range"

    def _draw(self, layers: SceneLayers) -> None:
        self._carried = Carried.of([(lidar.mount.body, lidar.mount.pose) for lidar in layers.lidars])
        self._beams = {lidar.mount.name: lidar.beams for lidar in layers.lidars}
        nothing = np.zeros((1, 3), np.float32)
        for path in self._beams:  # a viewer may see the hits of one robot only
            self._scene.add_frame(self.path + path, show_axes=False)
        self._clouds: dict[str, Any] = {
            path: self._scene.add_point_cloud(
                f"{self.path}{path}/points", nothing, nothing, point_size=0.04, point_shape="circle", visible=False
            )
            for path in self._beams
        }

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Show the hits of a frame."""
        if not self.shown or not frame.scans:
            return
        positions, rotations = self._carried.at(poses)
        for row, (path, cloud) in enumerate(self._clouds.items()):
            if path not in frame.scans:
                continue
            ranges, intensities = frame.scans[path]
            hit = np.isfinite(ranges)
            cloud.visible = bool(hit.any())
            if not cloud.visible:
                continue
            turns = np.broadcast_to(rotations[row], (int(hit.sum()), 4))
            cloud.points = positions[row] + turned(turns, self._beams[path][hit] * ranges[hit, None])
            cloud.colors = self._colours(ranges[hit], intensities[hit])

    def _colours(self, ranges: Floats, intensities: Floats) -> NDArray[np.uint8]:
        return mixed(NEAR_TO_FAR, ranges / FAR)


class LidarIntensities(LidarHits):
    """Points that lidar beams hit, with colours by intensity."""

    name = "intensity"
    title = "Lidar intensity"
    hint = "Points that lidar beams hit, coloured by intensity"

    def _colours(self, ranges: Floats, intensities: Floats) -> NDArray[np.uint8]:
        return mixed(DARK_TO_BRIGHT, intensities / BRIGHTEST)
