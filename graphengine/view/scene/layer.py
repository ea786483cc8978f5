"""The base of the layers of the 3D part."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.view.layer_data import FrameLayers, SceneLayers

if TYPE_CHECKING:
    import viser

Poses = NDArray[np.float64]


class Layer:
    """A layer that viewers show or hide; a subclass draws it below the node `self.path`.

    Args:
        scene: viser scene to draw in.

    Attributes:
        name: name of the layer in `FrameLayers` and requests to the run.
        title: title in the panel.
        hint: tooltip in the panel.
        shown: whether the layer is shown.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    hint: ClassVar[str]
    shown: bool = False

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.path = f"/{self.name}"

    def draw(self, layers: SceneLayers) -> None:
        """Draw a new scene, after a reset of the viser scene."""
        self._root = self._scene.add_frame(self.path, show_axes=False, visible=self.shown)
        self._draw(layers)

    def update(self, poses: Poses, frame: FrameLayers) -> None:
        """Draw the layer's part of a frame; a layer that is switched off is hidden."""
        self._root.visible = self.shown
        self._update(poses, frame)

    def _draw(self, layers: SceneLayers) -> None: ...

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Draw the layer's part of a frame; called even while the layer is hidden."""
