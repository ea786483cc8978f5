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
    """Something that viewers switch on and off; a subclass draws it below `self.path`.

    Args:
        scene: where it is drawn.

    Attributes:
        name: by which the run knows it.
        title: by which viewers know it.
        hint: what it shows.
        shown: whether it is switched on.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    hint: ClassVar[str]
    shown: bool = False

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.path = f"/{self.name}"

    def draw(self, layers: SceneLayers) -> None:
        """Begin with another scene; all that was drawn before is gone."""
        self._root = self._scene.add_frame(self.path, show_axes=False, visible=self.shown)
        self._draw(layers)

    def update(self, poses: Poses, frame: FrameLayers) -> None:
        """Show a frame, and whether the layer is on."""
        self._root.visible = self.shown
        self._update(poses, frame)

    def _draw(self, layers: SceneLayers) -> None: ...

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Show a frame; also called while the layer is off."""
