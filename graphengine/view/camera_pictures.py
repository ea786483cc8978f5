"""Provides camera images for the page: images that graphs receive, otherwise images rendered only for the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.camera import Camera, Picture
from graphengine.devices.stage import Prim
from graphengine.format.errors import RenderError

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

WIDTH, LARGE = 320, 960
"""Maximum width of an image in the 3D part, and in the pane of images, pixels."""
PAUSE = 0.25
"""Minimum wall time between two images of a camera, s."""
SHARE = 0.2
"""Maximum fraction of wall time in which images for the page are rendered."""
FRESH = 1.0
"""Maximum age of an image from a graph, s of simulation time; instead of an older image, one is rendered for the page."""

Pixels = NDArray[Any]


class CameraPictures:
    """Collects camera images without blocking the run.

    Args:
        session: session with the cameras.
        width: maximum width of the images, pixels.

    Attributes:
        error: reason why rendering for the page stopped; empty if it did not stop.
    """

    def __init__(self, session: SessionCore, width: int = WIDTH) -> None:
        self._session = session
        self._width = width
        self._cameras: Sequence[Prim] = ()
        self._job: tuple[str, float, Future[Picture]] | None = None
        """The image that is being rendered: path of its camera, start (wall time, s), and future of the image."""
        self._next = 0.0
        """Earliest wall time at which the next rendering may start, s."""
        self._shown: dict[str, tuple[float, object]] = {}
        """Wall time, s, and identity of each camera's last image; the identity is its number, or the tick of its rendering."""
        self.error = ""

    def find(self, cameras: Sequence[Prim]) -> None:
        """Set the cameras whose images `take` collects."""
        self._cameras = cameras
        self._job = None
        self._shown.clear()

    def take(self, now: float, tick: int) -> Mapping[str, Picture]:
        """Return new images by camera path; those of graphs may be wider.

        Args:
            now: current wall time, s.
            tick: number of the current tick; a camera is rendered at most once per tick.
        """
        found: dict[str, Picture] = {}
        others = []
        for prim in self._cameras:
            picture = self._received(prim.path, tick)
            if picture is None:
                others.append(prim)
            elif self._is_due(prim.path, now, ("number", picture.index)):
                self._shown[prim.path] = now, ("number", picture.index)
                found[prim.path] = picture
        if self._job is not None and self._job[2].done():
            found.update(self._rendered(now))
        if self._job is None and not self.error and now >= self._next:
            self._render(others, now, tick)
        return found

    def _received(self, path: str, tick: int) -> Picture | None:
        """Return the newest image that a graph received from a camera; None if no image is newer than `FRESH`."""
        seconds, ticks = self._session.services.world.tick_period
        for product in self._session.services.render_products.values():
            picture: Picture | None = (
                product.camera.latest if product.prim == path and product.camera is not None else None
            )
            if picture is not None and 0.0 <= tick * seconds / ticks - picture.time <= FRESH:
                return picture
        return None

    def _is_due(self, path: str, now: float, what: object) -> bool:
        when, last = self._shown.get(path, (-PAUSE, None))
        return now - when >= PAUSE and what != last

    def _render(self, cameras: Sequence[Prim], now: float, tick: int) -> None:
        """Start to render an image of the camera whose last image is the oldest."""
        due = [prim for prim in cameras if self._is_due(prim.path, now, ("tick", tick))]
        if not due:
            return
        prim = min(due, key=lambda prim: self._shown.get(prim.path, (0.0, None))[0])
        width, height = prim.facts["size"]
        small = min(width, self._width)
        camera = self._session.services.world.device(Camera, prim, size=(small, max(1, round(height * small / width))))
        self._shown[prim.path] = now, ("tick", tick)
        self._job = prim.path, now, camera.preview()

    def _rendered(self, now: float) -> Mapping[str, Picture]:
        assert self._job is not None
        path, begun, done = self._job
        self._job = None
        self._next = now + (now - begun) * (1.0 / SHARE - 1.0)
        try:
            return {path: done.result()}
        except RenderError as error:
            self.error = str(error)
            return {}


def shrunk(pixels: Pixels, width: int = WIDTH) -> Pixels:
    """Return an image with only every nth row and column, so that it is at most `width` pixels wide."""
    step = -(-pixels.shape[1] // width)
    return np.ascontiguousarray(pixels[::step, ::step])
