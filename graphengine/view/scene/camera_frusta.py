"""The layer of cameras: the viewing frustum of each camera, with its image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from viser.transforms import SO3

from graphengine.view.layer_data import CAMERAS, FrameLayers, SceneLayers
from graphengine.view.scene.carried import Carried
from graphengine.view.scene.layer import Layer, Poses

if TYPE_CHECKING:
    import viser

ABOUT_X = SO3(np.array([0.0, 1.0, 0.0, 0.0], np.float32))
"""Half a turn about x: viser's cameras look along z with y down, a `SeenCamera` along -z with y up."""
SIZE = 0.15
"""Size of a frustum; for a given size, viser draws frusta of equal volume for all fields of view."""


class CameraFrusta(Layer):
    """Draws one frustum with the camera's image for each camera."""

    name = needs = CAMERAS
    title = "Cameras"
    hint = "One camera of each rig with its image, a few times per second; rendering takes CPU time of the run"

    def _draw(self, layers: SceneLayers) -> None:
        self._carried = Carried.of([(camera.mount.body, camera.mount.pose) for camera in layers.cameras])
        self._last: Poses | None = None
        self._frusta: dict[str, viser.CameraFrustumHandle] = {
            camera.mount.name: self._scene.add_camera_frustum(
                self.path + camera.mount.name,
                fov=camera.field_of_view,
                aspect=camera.aspect,
                scale=SIZE,
                thickness=0.01,
                color=(90, 110, 140),
                cast_shadow=False,
                receive_shadow=False,
            )
            for camera in layers.cameras
        }

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Move the cameras with their bodies, and show new images."""
        if not self.shown or not self._frusta:
            return
        for path, pixels in frame.pictures.items():
            if path in self._frusta:
                self._frusta[path].image = pixels
        if self._last is not None and np.array_equal(poses, self._last):
            return
        self._last = poses
        positions, rotations = self._carried.at(poses)
        turned = (SO3(rotations) @ ABOUT_X).wxyz
        for frustum, position, rotation in zip(self._frusta.values(), positions, turned, strict=True):
            frustum.position, frustum.wxyz = position, rotation
