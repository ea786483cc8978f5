"""Render products: the paths by which helpers find a camera or lidar, and the camera behind one, which may be exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from graphengine.devices.sensor import Camera, Picture
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


def _of_source(name: str) -> Any:
    return property(attrgetter(f"source.{name}"))


class ProductCamera(Shared):
    """The camera that a render product shows at the moment, which may change while others hold this."""

    __slots__ = ("own", "source")

    def __init__(self, own: Camera) -> None:
        self.own = self.source = own

    def show(self, source: Camera) -> None:
        """Be that camera from here on."""
        self.source = source

    prim_path: str = _of_source("prim_path")
    """Path of the camera's prim."""
    rate: float = _of_source("rate")
    """Pictures a second."""
    size: tuple[int, int] = _of_source("size")
    """Width and height, pixels."""
    intrinsics: tuple[float, float, float, float] = _of_source("intrinsics")
    """fx, fy, cx, cy in pixels."""
    clip: tuple[float, float] = _of_source("clip")
    """Nearest and farthest distance seen, m."""
    latency: int = _of_source("latency")
    """Ticks from capture to delivery."""
    labels: Mapping[int, str] = _of_source("labels")
    """Prim path of each number of a segmentation."""
    due: bool = _of_source("due")
    """Whether a new sample falls into this tick."""
    index: int = _of_source("index")
    """Number of the newest sample since play."""

    def request(self, *, segmentation: bool = False) -> None:
        """Capture this tick's sample if one is due."""
        self.source.request(segmentation=segmentation)

    def delivered(self) -> Picture | None:
        """The picture whose turn it is in this tick."""
        return self.source.delivered()
