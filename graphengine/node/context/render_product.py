"""Render products: helper nodes find a camera, lidar or radar by the path of its render product."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graphengine.devices.camera import Camera
from graphengine.format.stateful import Shared, Stateful


@dataclass(slots=True)
class RenderProduct(Stateful):
    """The render product of a camera, lidar, radar or viewport. The camera of a render product can be exchanged."""

    prim: str
    """Path of the camera, lidar or radar; empty for a viewport that does not have a camera yet."""
    size: tuple[int, int]
    """Width and height of the images, pixels; not used for a lidar or radar."""
    camera: ProductCamera | None = None
    """The camera object that all nodes share; None until a node requests it."""

    def save(self) -> tuple[str, ProductCamera | None, Camera | None]:
        """Return the prim path, the shared camera object, and the camera to which the camera object forwards its calls now."""
        return self.prim, self.camera, self.camera.source if self.camera is not None else None

    def restore(self, saved: tuple[str, ProductCamera | None, Camera | None]) -> None:
        """Restore a state that `save` returned."""
        self.prim, self.camera, source = saved
        if self.camera is not None and source is not None:
            self.camera.show(source)

    def reset(self) -> None:
        """Let the camera object, if there is one, forward its calls to the original camera again."""
        if self.camera is not None:
            self.camera.show(self.camera.own)


class ProductCamera(Shared):
    """The camera object that nodes get for a render product. It forwards all calls to the camera that the product shows now.

    Args:
        own: the camera that is shown first, and again after `RenderProduct.reset`.
    """

    __slots__ = ("own", "source")

    def __init__(self, own: Camera) -> None:
        self.own = self.source = own

    def __getattr__(self, name: str) -> Any:
        return getattr(self.source, name)

    def show(self, source: Camera) -> None:
        """Forward all calls to the camera `source` from now on."""
        self.source = source
