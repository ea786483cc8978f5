"""The Protocol of cameras, their images, and a camera stub for tests."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices.device import SampleReader, Stub, TickSensor, device
from graphengine.devices.rotation import Quaternion
from graphengine.devices.stage import Prim

if TYPE_CHECKING:
    from concurrent.futures import Future

LARGEST_PICTURE = 8192
"""Maximum width and height of an image, pixels."""

BOX_3D = np.dtype(
    [
        ("semanticId", "<u4"),
        ("low", "<f4", (3,)),
        ("high", "<f4", (3,)),
        ("transform", "<f4", (4, 4)),
        ("occlusionRatio", "<f4"),
    ]
)
"""Record of a 3D bounding box.

`semanticId` is the segmentation ID of the prim. `low` and `high` are two opposite corners in the frame of the prim's body, m. The
rows of `transform` are the three axes and the origin of this frame in the camera's optical frame. `occlusionRatio` is 0.
"""

LOOKING_FORWARD: Quaternion = (0.5, -0.5, -0.5, 0.5)
"""Orientation of a camera in its mount. A camera looks along its -z axis with +y up; the mount has x forward and z up."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One image of a camera, with colours and depths. Row 0 is the upper edge."""

    time: float
    """Simulation time of the tick in which the image was captured, s."""
    index: int
    """Sample index since the start of play."""
    rgb: NDArray[np.uint8]
    """Colours, 0 to 255, shape (height, width, 3)."""
    depth: NDArray[np.float32]
    """Distance along the optical axis, m, shape (height, width); inf where there is no surface within the clip range."""
    segmentation: NDArray[np.int32] | None = None
    """Segmentation ID of the prim visible at each pixel, shape (height, width); 0 for no prim. None unless it was requested."""
    boxes: NDArray[np.void] | None = None
    """BOX_3D records of all prims of finite size, inside and outside the image; None unless segmentation was requested."""


class Camera(TickSensor, Protocol):
    """A pinhole camera. It delivers each image `latency` ticks after the image was captured.

    Pixels are square. The optical axis meets the image at the principal point (cx, cy), in pixels from the centre of the upper
    left pixel. The middle of an image that is w pixels wide is therefore at (w - 1) / 2.
    """

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the images, pixels."""

    @property
    def intrinsics(self) -> tuple[float, float, float, float]:
        """Focal lengths fx and fy and principal point cx, cy, in pixels."""

    @property
    def clip(self) -> tuple[float, float]:
        """Smallest and largest visible distance along the optical axis, m."""

    @property
    def latency(self) -> int:
        """Number of ticks from the capture of an image to its delivery."""

    @property
    def labels(self) -> Mapping[int, str]:
        """A dict from segmentation IDs to prim paths."""

    def request(self, *, segmentation: bool = False) -> None:
        """Request the image of this tick. If a sample is due, the image is captured; several requests capture one image.

        Args:
            segmentation: whether the image needs `segmentation` and `boxes`.
        """

    def delivered(self) -> Picture | None:
        """Return the image that is delivered in this tick, or None in a tick without delivery. All callers get the same object.

        Raises:
            RenderError: the image could not be rendered.
        """

    @property
    def latest(self) -> Picture | None:
        """The newest image that `delivered` has returned to any caller; None before the first image."""

    def preview(self) -> Future[Picture]:
        """Render an image of the current state in the background, independently of samples and deliveries.

        The future raises RenderError if OpenGL is missing or fails.
        """


def pinhole(size: tuple[int, int], horizontal_fov: float) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy (pixels) of a camera with a centred lens and square pixels.

    Args:
        size: width and height of the image, pixels.
        horizontal_fov: field of view from the left to the right edge of the image, degrees. The edges are half a pixel outside
            the centres of the outermost pixels.
    """
    width, height = size
    focal = width / 2 / math.tan(math.radians(horizontal_fov) / 2)
    return focal, focal, (width - 1) / 2, (height - 1) / 2


class _PictureReader(SampleReader):
    """Requests the image of each tick, and returns the image that is delivered in this tick."""

    lasts = False

    def __call__(self, camera: Camera) -> Picture | None:
        camera.request()
        return camera.delivered()


@device(
    "camera",
    Camera,
    usd="Camera",
    title="a camera",
    rank=2,
    child="Camera",
    orientation=LOOKING_FORWARD,
    in_rigs=True,
    sample=_PictureReader("delivered"),
)
class CameraStub(Stub):
    """A camera for tests. It delivers the image that a test sets with `show`; initially it delivers none.

    `requests` and `previews` count the calls of `request` and `preview`.
    """

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
        """Set the image that the camera delivers.

        Args:
            rgb: colours, 0 to 255, shape (height, width, 3).
            depth: distance along the optical axis, m; one value for all pixels, or one per pixel.
            segmentation: segmentation ID of the visible prim; one ID for all pixels, or one per pixel.
            boxes: BOX_3D records; None means no boxes.
            time: simulation time of the capture, s.
            index: sample index since the start of play.
        """
        colours = np.array(rgb, np.uint8)
        plane = colours.shape[:2]
        self.size = (plane[1], plane[0])
        self.due, self.index = True, index
        numbers = np.full(plane, segmentation, np.int32)
        solids = np.zeros(0, BOX_3D) if boxes is None else boxes
        self._picture = Picture(time, index, colours, np.full(plane, depth, np.float32), numbers, solids)

    def request(self, *, segmentation: bool = False) -> None:
        """Increment `requests`."""
        self.requests += 1

    def delivered(self) -> Picture | None:
        """Return the image that the test set."""
        return self._picture

    @property
    def latest(self) -> Picture | None:
        """The image that the test set."""
        return self._picture

    def preview(self) -> Future[Picture]:
        """Return a completed future with the image that the test set; without such an image, with a black image."""
        self.previews += 1
        width, height = self.size
        black = np.zeros((height, width, 3), np.uint8)
        from concurrent.futures import Future  # a late import, because most scenes have no camera

        made: Future[Picture] = Future()
        made.set_result(self._picture or Picture(0.0, 0, black, np.full((height, width), np.inf, np.float32)))
        return made
