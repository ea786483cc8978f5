"""Render products: paths by which helper nodes find a camera, lidar or radar; the camera can be exchanged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graphengine.devices.camera import Camera
from graphengine.format.stateful import Shared, Stateful


@dataclass(slots=True)
class RenderProduct(Stateful):
    """A render product of a lidar, a camera or a viewport."""

    prim: str
    """Path of the camera, lidar or radar; empty for a viewport that shows no camera yet."""
    size: tuple[int, int]
    """Width and height of a camera's pictures, pixels."""
    camera: ProductCamera | None = None
    """The camera object that nodes hold; None if no node requested it yet."""

    def save(self) -> tuple[str, ProductCamera | None, Camera | None]:
        """Return the prim path, the camera object, and the camera to which this object forwards."""
        return self.prim, self.camera, self.camera.source if self.camera is not None else None

    def restore(self, saved: tuple[str, ProductCamera | None, Camera | None]) -> None:
        """Return to a state that `save` returned."""
        self.prim, self.camera, source = saved
        if self.camera is not None and source is not None:
            self.camera.show(source)

    def reset(self) -> None:
        """Show the original camera."""
        if self.camera is not None:
            self.camera.show(self.camera.own)


class ProductCamera(Shared):
    """A camera object for nodes. It forwards to the current camera of a render product, which may be exchanged meanwhile."""

    __slots__ = ("own", "source")

    def __init__(self, own: Camera) -> None:
        self.own = self.source = own

    def __getattr__(self, name: str) -> Any:
        return getattr(self.source, name)

    def show(self, source: Camera) -> None:
        """Forward to the camera `source` from now on."""
        self.source = source
