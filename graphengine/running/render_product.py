"""Render products: the paths by which helpers find a camera or lidar, and the camera behind one, which may be exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graphengine.context import Camera, Picture


@dataclass(slots=True)
class RenderProduct:
    """What a sensor's pictures are taken for."""

    prim: str
    """Path of the camera or lidar."""
    size: tuple[int, int]
    """Width and height of a camera's pictures, pixels."""
    camera: ProductCamera | None = None
    """The camera that was handed out."""

    def reset(self) -> None:
        """Show what it was made for."""
        if self.camera is not None:
            self.camera.show(self.camera.own)


class ProductCamera:
    """The camera that a render product shows at the moment, which may change while others hold this."""

    __slots__ = ("own", "source")

    def __init__(self, own: Camera) -> None:
        self.own = self.source = own

    def show(self, source: Camera) -> None:
        """Be that camera from here on."""
        self.source = source

    @property
    def prim_path(self) -> str:
        """Path of the camera's prim."""
        return self.source.prim_path

    @property
    def rate(self) -> float:
        """Pictures a second."""
        return self.source.rate

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.source.size

    @property
    def intrinsics(self) -> tuple[float, float, float, float]:
        """fx, fy, cx, cy in pixels."""
        return self.source.intrinsics

    @property
    def clip(self) -> tuple[float, float]:
        """Nearest and farthest distance seen, m."""
        return self.source.clip

    @property
    def latency(self) -> int:
        """Ticks from capture to delivery."""
        return self.source.latency

    @property
    def labels(self) -> Mapping[int, str]:
        """Prim path of each number of a segmentation."""
        return self.source.labels

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick."""
        return self.source.due

    @property
    def index(self) -> int:
        """Number of the newest sample since play."""
        return self.source.index

    def request(self, *, segmentation: bool = False) -> None:
        """Capture this tick's sample if one is due."""
        self.source.request(segmentation=segmentation)

    def delivered(self) -> Picture | None:
        """The picture whose turn it is in this tick."""
        return self.source.delivered()
