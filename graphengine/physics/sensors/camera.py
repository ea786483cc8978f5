"""A camera: an image captured in one tick is delivered a fixed number of ticks later, however long rendering takes.

A sample (see `sampling`) is captured when it is first requested in its tick, and rendered by the `render_thread`. The tick in
which the image is due waits until it is rendered. A simulation in real time does not wait: it drops and counts late images. While
an image is being rendered, the camera captures no other image, because each image in a queue would be late.

An object nearer than the clip range hides the objects behind it, as with a real lens, but gets no depth. Surfaces are visible
only from their front: a camera inside a closed shape sees out of the shape, while rays hit its inside.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from concurrent.futures import Future, wait
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from graphengine.devices.camera import LARGEST_PICTURE, Camera, Picture, pinhole
from graphengine.devices.stage import Prim
from graphengine.format.spec import NotNegative, Pair
from graphengine.physics.implementations import Deviation, Profile, Rate, implements
from graphengine.physics.pictures.frame_capture import Lens
from graphengine.physics.pictures.rendering import Image
from graphengine.physics.sensors.sampling import Sampled

if TYPE_CHECKING:
    from graphengine.physics.pictures.pictured_simulation import PicturedSimulation

NEAREST = 0.05
"""Greatest distance of the renderer's near plane, m; nearer objects are not drawn. A smaller value makes depths less precise."""

PixelCount = Annotated[int, Field(ge=1, le=LARGEST_PICTURE)]


class CameraProfile(Profile):
    """The parameters of a pinhole camera with square pixels."""

    size: Annotated[tuple[PixelCount, PixelCount], Field(strict=False)]
    """Width and height, pixels."""
    fov_deg: Pair
    """Horizontal and vertical field of view, degrees; images use the horizontal one."""
    clip: Pair = (0.01, 100.0)
    """Nearest and farthest distance seen, m."""
    rate: Rate = 30.0
    """Images per second."""
    latency: NotNegative = Field(default=0.1, le=10.0)
    """Time from capture to delivery, s; at least one tick."""
    depth: bool = False
    """Whether the camera is a depth camera."""
    colour_noise: NotNegative = Field(default=0.0, le=255)
    """Standard deviation of colour noise, 0 to 255."""
    depth_noise: Deviation = 0.0
    """Standard deviation of depth noise at 1 m, m; it grows with the square of the distance."""

    @field_validator("fov_deg")
    @classmethod
    def _a_pinhole_sees(cls, degrees: tuple[float, float]) -> tuple[float, float]:
        if not all(0.1 <= degree <= 179.0 for degree in degrees):
            raise ValueError("the field of view of a pinhole camera must be from 0.1 to 179 degrees")
        return degrees

    @field_validator("clip")
    @classmethod
    def _in_front(cls, clip: tuple[float, float]) -> tuple[float, float]:
        if not 0.001 <= clip[0] < clip[1] <= 1_000_000.0:
            raise ValueError("must be [nearest, farthest] in ascending order, from 0.001 to 1000000 m")
        return clip


@dataclass(frozen=True, slots=True)
class _Exposure:
    """An image that was captured and is not delivered yet."""

    captured: int
    """Tick in which the image was captured."""
    segmented: bool
    picture: Future[Picture]

    def __deepcopy__(self, _: object) -> _Exposure:
        """Return the object itself, because it does not change after rendering."""
        wait([self.picture])
        return self


@implements(Camera, CameraProfile)
class PinholeCamera(Sampled):
    """A camera without lens distortion; its profile is read from the `facts` of its prim.

    Args:
        simulation: simulation that the camera sees.
        prim: camera prim.
        size: width and height of the images, pixels; None uses the size in the profile. The horizontal field of view is the same
            for all sizes.
    """

    kept = ("_delivery", "_pending", "_segmented", "_skipped")

    def __init__(self, simulation: PicturedSimulation, prim: Prim, size: tuple[int, int] | None = None) -> None:
        facts = prim.facts
        self.size: tuple[int, int] = size or facts["size"]
        self.clip: tuple[float, float] = facts["clip"]
        self.intrinsics = pinhole(self.size, facts["fov_deg"][0])
        delay = Fraction(repr(facts["latency"])) / Fraction(*simulation.tick_period)
        self.latency = max(1, math.ceil(delay))
        self._noise: tuple[float, float] = facts.get("colour_noise", 0.0), facts.get("depth_noise", 0.0)
        near, far = self.clip
        self._lens = Lens.pinhole(self.size, self.intrinsics[0], min(near, NEAREST), far)
        self._pending: deque[_Exposure] = deque()
        self.reset()
        self._studio = simulation.studio
        self._studio.expect(self._lens)
        super().__init__(simulation, prim)

    @classmethod
    def key(cls, prim: Prim, **options: Any) -> str:
        """Return the prim's path and the image size as the key; each size has its own handle."""
        width, height = options.get("size") or prim.facts["size"]
        return f"{prim.path}/{width}x{height}"

    def reset(self) -> None:
        """Discard images that are not delivered yet."""
        for exposure in self._pending:
            exposure.picture.cancel()
        self._pending.clear()
        self._skipped = 0
        self._segmented = False
        self._delivery: tuple[int, Picture | None] = (0, None)
        self.latest: Picture | None = None

    @property
    def labels(self) -> Mapping[int, str]:
        """Prim path of each segmentation ID."""
        return self._studio.labels

    def request(self, *, segmentation: bool = False) -> None:
        """Capture this tick's sample if one is due; all callers in the tick share one image.

        Args:
            segmentation: whether this sample and all later samples get a segmentation.
        """
        tick = self._simulation.tick
        self._segmented |= segmentation
        newest = self._pending[-1] if self._pending else None
        if newest is not None and newest.captured == tick:
            if newest.segmented or not segmentation:
                return
            self._pending.pop().picture.cancel()  # the first who wants segments was not the first to ask in this tick
        elif tick == self._skipped or not self.due:
            return
        elif self._simulation.realtime and newest is not None and not newest.picture.done():
            self._skipped = tick
            self._drop()
            return
        self._pending.append(_Exposure(tick, self._segmented, self._expose(self._segmented)))

    def delivered(self) -> Picture | None:
        """Return the image that is due in this tick, the same object for all callers; None if no image is due.

        Raises:
            RenderError: the image could not be rendered.
        """
        tick = self._simulation.tick
        if self._delivery[0] != tick:
            self._delivery = (tick, self._take(tick - self.latency))
            self.latest = self._delivery[1] or self.latest
        return self._delivery[1]

    def preview(self) -> Future[Picture]:
        """Render an image of the current state in the background, without effect on samples and deliveries."""
        return self._expose(False)

    def picture(self, *, segmentation: bool = False) -> Picture:
        """Render an image of the current state, wait for the image, and return it.

        Raises:
            RenderError: the image could not be rendered.
        """
        return self._expose(segmentation).result()

    def _take(self, captured: int) -> Picture | None:
        """Return the image captured in a tick, or None; discard images captured earlier that were not collected."""
        while self._pending and self._pending[0].captured < captured:
            self._pending.popleft().picture.cancel()
        if not self._pending or self._pending[0].captured > captured:
            return None
        picture = self._pending.popleft().picture
        if self._simulation.realtime and not picture.done():
            picture.cancel()
            self._drop()
            return None
        return picture.result()

    def _drop(self) -> None:
        counts, path = self._simulation.dropped_pictures, self.prim_path
        counts[path] = counts.get(path, 0) + 1

    def _expose(self, segmentation: bool) -> Future[Picture]:
        studio, index = self._studio, self.index
        generator = self._noise_of(index) if any(self._noise) else None
        pose = self.pose()
        shot = studio.capture(pose, self._lens, segmentation=segmentation)
        boxes = studio.boxes(pose) if segmentation else None
        develop = partial(_develop, clip=self.clip, noise=self._noise, generator=generator, boxes=boxes)
        return studio.draw(shot, partial(develop, self._simulation.time, index))


def _develop(
    time: float,
    index: int,
    image: Image,
    *,
    clip: tuple[float, float],
    noise: tuple[float, float],
    generator: np.random.Generator | None,
    boxes: NDArray[np.void] | None,
) -> Picture:
    """Return the camera's output for a rendered image: with noise, and with infinite depth outside the clip range."""
    rgb, depth = image.rgb, image.depth
    visible = (depth >= clip[0]) & (depth <= clip[1])
    if generator is not None:
        rgb, depth = _with_noise(rgb, depth, noise, generator)
        depth = depth.clip(*clip)
    depth = np.where(visible, depth, np.float32(np.inf))
    for array in (rgb, depth, image.segmentation, boxes):
        if array is not None:
            array.flags.writeable = False
    return Picture(time, index, rgb, depth, image.segmentation, boxes)


def _with_noise(
    rgb: NDArray[np.uint8], depth: NDArray[np.float32], noise: tuple[float, float], generator: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Add normally distributed noise to colours and depths.

    The standard deviation is constant for colours. For depths, it grows with the square of the distance, as for stereo cameras.
    """
    colour, at_one_metre = np.float32(noise[0]), np.float32(noise[1])
    if colour:
        noisy = rgb + colour * generator.standard_normal(rgb.shape, np.float32)
        rgb = np.rint(noisy).clip(0, 255).astype(np.uint8)
    if at_one_metre:
        depth = depth + at_one_metre * depth**2 * generator.standard_normal(depth.shape, np.float32)
    return rgb, depth
