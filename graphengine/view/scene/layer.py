"""The base class of the layers of the 3D part."""

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
        name: name of the layer in requests of viewers.
        title: title in the panel of the 3D part.
        hint: tooltip in this panel.
        shown: whether a viewer shows the layer; each viewer gets its own visibility.
        needs: name of the layer's data in `FrameLayers`; empty if body poses are enough.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    hint: ClassVar[str]
    shown: bool = False
    needs: ClassVar[str] = ""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.path = f"/{self.name}"

    def draw(self, layers: SceneLayers) -> None:
        """Draw the layer for a new scene; called after a reset of the viser scene."""
        self._scene.add_frame(self.path, show_axes=False, visible=False)
        self._draw(layers)

    def update(self, poses: Poses, frame: FrameLayers) -> None:
        """Draw the layer's data of a frame."""
        self._update(poses, frame)

    def _draw(self, layers: SceneLayers) -> None: ...

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Draw the layer's data of a frame; called for each frame, even while the layer is hidden."""
