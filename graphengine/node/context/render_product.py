"""Render products: the paths by which helpers find a camera or lidar, and the camera behind one, which may be exchanged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graphengine.devices.camera import Camera
from graphengine.format.stateful import Shared, Stateful


@dataclass(slots=True)
class RenderProduct(Stateful):
    """What a sensor's pictures are taken for."""

    prim: str
    """Path of the camera or lidar; empty for a viewport that shows no camera yet."""
    size: tuple[int, int]
    """Width and height of a camera's pictures, pixels."""
    camera: ProductCamera | None = None
    """The camera that was handed out."""

    def save(self) -> tuple[str, ProductCamera | None, Camera | None]:
        """What it is made for, and the camera that it shows."""
        return self.prim, self.camera, self.camera.source if self.camera is not None else None

    def restore(self, saved: tuple[str, ProductCamera | None, Camera | None]) -> None:
        """Show that camera again."""
        self.prim, self.camera, source = saved
        if self.camera is not None and source is not None:
            self.camera.show(source)

    def reset(self) -> None:
        """Show what it was made for."""
        if self.camera is not None:
            self.camera.show(self.camera.own)


class ProductCamera(Shared):
    """The camera that a render product shows at the moment, which may change while others hold this; it has what that has."""

    __slots__ = ("own", "source")

    def __init__(self, own: Camera) -> None:
        self.own = self.source = own

    def __getattr__(self, name: str) -> Any:
        return getattr(self.source, name)

    def show(self, source: Camera) -> None:
        """Be that camera from here on."""
        self.source = source
