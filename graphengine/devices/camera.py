"""Cameras: the Protocol and the stub."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices.device import Stub, TickSensor, device
from graphengine.devices.rotation import Quaternion
from graphengine.devices.stage import Prim

if TYPE_CHECKING:
    from concurrent.futures import Future

LARGEST_PICTURE = 8192
"""Maximum width and height of a picture, pixels."""

BOX_3D = np.dtype(
    [
        ("semanticId", "<u4"),
        ("low", "<f4", (3,)),
        ("high", "<f4", (3,)),
        ("transform", "<f4", (4, 4)),
        ("occlusionRatio", "<f4"),
    ]
)
"""Record of a 3D box: its object's number, two opposite corners (m), and a matrix with the axes and the origin of the corners'
frame as rows."""

LOOKING_FORWARD: Quaternion = (0.5, -0.5, -0.5, 0.5)
"""Rotates a camera (view along -z, +y up) to look along the x axis of its mount with z up."""


@dataclass(frozen=True, slots=True)
class Picture:
    """The picture of a camera at one instant; row 0 is the upper edge."""

    time: float
    """Simulation time of the tick in which the picture was captured, s."""
    index: int
    """Number of this sample since play."""
    rgb: NDArray[np.uint8]
    """Colours, 0 to 255, shape (height, width, 3)."""
    depth: NDArray[np.float32]
    """Distance along the optical axis, m, shape (height, width); inf without a surface in the clip range."""
    segmentation: NDArray[np.int32] | None = None
    """Number of the visible prim at each pixel, as in `Camera.labels`; 0 for none. None unless requested."""
    boxes: NDArray[np.void] | None = None
    """BOX_3D records of all prims of finite size, visible or not, in the camera's optical frame; None without `segmentation`."""


class Camera(TickSensor, Protocol):
    """A pinhole camera. It delivers a picture `latency` ticks after its capture.

    Pixels are square. The optical axis meets the picture at (cx, cy), in pixels from the centre of the upper left pixel: the
    middle of a picture that is w pixels wide is at (w - 1) / 2.
    """

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""

    @property
    def intrinsics(self) -> tuple[float, float, float, float]:
        """Focal lengths fx and fy, and the principal point cx, cy, in pixels."""

    @property
    def clip(self) -> tuple[float, float]:
        """Smallest and largest visible distance along the optical axis, m."""

    @property
    def latency(self) -> int:
        """Ticks from capture to delivery."""

    @property
    def labels(self) -> Mapping[int, str]:
        """Prim path for each number in a segmentation."""

    def request(self, *, segmentation: bool = False) -> None:
        """Capture a picture in this tick if one is due; several requests in a tick render it once."""

    def delivered(self) -> Picture | None:
        """Return the picture delivered in this tick, shared by all callers; None if this tick delivers none."""

    @property
    def latest(self) -> Picture | None:
        """Newest picture that was delivered to any caller; None before the first."""

    def preview(self) -> Future[Picture]:
        """Render a picture of the current state in the background, without effect on samples and deliveries.

        The future raises RenderError if OpenGL is missing or fails.
        """


def pinhole(size: tuple[int, int], horizontal_fov: float) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy (pixels) of a camera with a centred lens and square pixels.

    Args:
        size: width and height, pixels.
        horizontal_fov: field of view from the left to the right edge of the picture, degrees. The centre of pixel 0 lies half a
            pixel inside the edge.
    """
    width, height = size
    focal = width / 2 / math.tan(math.radians(horizontal_fov) / 2)
    return focal, focal, (width - 1) / 2, (height - 1) / 2


@device(
    "camera", Camera, usd="Camera", title="a camera", rank=2, child="Camera", orientation=LOOKING_FORWARD, in_rigs=True
)
class CameraStub(Stub):
    """A camera that delivers pictures set by tests, at first none; `requests` and `previews` count calls."""

    requests = 0
    previews = 0
    _picture: Picture | None = None

    def __init__(self, prim: Prim, size: tuple[int, int] | None = None) -> None:
        super().__init__(prim)
        self.size: tuple[int, int] = size or prim.facts.get("size", (640, 480))
        self.clip: tuple[float, float] = prim.facts.get("clip", (0.01, 100.0))
        self.intrinsics = pinhole(self.size, prim.facts.get("fov_deg", (90.0, 90.0))[0])
        self.latency = 1
        self.labels: dict[int, str] = {}

    def show(
        self,
        rgb: ArrayLike,
        depth: ArrayLike = math.inf,
        segmentation: ArrayLike = 0,
        boxes: NDArray[np.void] | None = None,
        *,
        time: float = 0.0,
        index: int = 0,
    ) -> None:
        """Set the picture to deliver.

        Args:
            rgb: shape (height, width, 3), 0 to 255.
            depth: m; one value for all pixels, or one per pixel.
            segmentation: number of the visible prim; one for all pixels, or one per pixel.
            boxes: BOX_3D records; None: no boxes.
            time: simulation time of the capture, s.
            index: number of the sample since play.
        """
        colours = np.array(rgb, np.uint8)
        plane = colours.shape[:2]
        self.size = (plane[1], plane[0])
        self.due, self.index = True, index
        numbers = np.full(plane, segmentation, np.int32)
        solids = np.zeros(0, BOX_3D) if boxes is None else boxes
        self._picture = Picture(time, index, colours, np.full(plane, depth, np.float32), numbers, solids)

    def request(self, *, segmentation: bool = False) -> None:
        """Count the request."""
        self.requests += 1

    def delivered(self) -> Picture | None:
        """Return the picture set by the test."""
        return self._picture

    @property
    def latest(self) -> Picture | None:
        """The picture set by the test."""
        return self._picture

    def preview(self) -> Future[Picture]:
        """Return the picture set by the test, or a black picture."""
        self.previews += 1
        width, height = self.size
        black = np.zeros((height, width, 3), np.uint8)
        from concurrent.futures import Future  # not at the start: most scenes have no camera

        made: Future[Picture] = Future()
        made.set_result(self._picture or Picture(0.0, 0, black, np.full((height, width), np.inf, np.float32)))
        return made
