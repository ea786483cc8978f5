"""Small pictures of cameras for a page: those that graphs receive, else rendered for the page, one at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.camera import Camera, Picture
from graphengine.devices.stage import Prim
from graphengine.format.errors import RenderError

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

WIDTH = 320
"""Most pixels of a picture in a row."""
PAUSE = 0.25
"""Least wall time between two pictures of a camera, s."""
SHARE = 0.2
"""Part of the wall time that rendering for the page may take."""
FRESH = 1.0
"""Age up to which a picture that a graph received is shown, s of simulation."""

Pixels = NDArray[np.uint8]


class CameraPictures:
    """Takes pictures of cameras without waiting for them.

    Args:
        session: what is seen.

    Attributes:
        error: why no more pictures are rendered; empty while they are.
    """

    def __init__(self, session: SessionCore) -> None:
        self._session = session
        self._cameras: Sequence[Prim] = ()
        self._job: tuple[str, float, Future[Picture]] | None = None
        """Camera, beginning, s of wall time, and result of the picture that is being rendered."""
        self._next = 0.0
        """Wall time from which on another picture may be rendered, s."""
        self._shown: dict[str, tuple[float, object]] = {}
        """When the last picture of a camera was taken, s of wall time, and its number, or the tick in which it was rendered."""
        self.error = ""

    def find(self, cameras: Sequence[Prim]) -> None:
        """Take pictures of these cameras from now on."""
        self._cameras = cameras
        self._job = None
        self._shown.clear()

    def take(self, now: float, tick: int) -> Mapping[str, Pixels]:
        """New pictures by the cameras' paths.

        Args:
            now: wall time, s.
            tick: number of the present tick; nothing is rendered twice in a tick.
        """
        found: dict[str, Pixels] = {}
        others = []
        for prim in self._cameras:
            picture = self._received(prim.path, tick)
            if picture is None:
                others.append(prim)
            elif self._is_due(prim.path, now, ("number", picture.index)):
                self._shown[prim.path] = now, ("number", picture.index)
                found[prim.path] = _small(picture.rgb)
        if self._job is not None and self._job[2].done():
            found.update(self._rendered(now))
        if self._job is None and not self.error and now >= self._next:
            self._render(others, now, tick)
        return found

    def _received(self, path: str, tick: int) -> Picture | None:
        """The newest picture of a camera that a graph received, if it is not old."""
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
        """Begin to render the camera whose last picture is the oldest."""
        due = [prim for prim in cameras if self._is_due(prim.path, now, ("tick", tick))]
        if not due:
            return
        prim = min(due, key=lambda prim: self._shown.get(prim.path, (0.0, None))[0])
        width, height = prim.facts["size"]
        small = min(width, WIDTH)
        camera = self._session.services.world.device(Camera, prim, size=(small, max(1, round(height * small / width))))
        self._shown[prim.path] = now, ("tick", tick)
        self._job = prim.path, now, camera.preview()

    def _rendered(self, now: float) -> Mapping[str, Pixels]:
        assert self._job is not None
        path, begun, done = self._job
        self._job = None
        self._next = now + (now - begun) * (1.0 / SHARE - 1.0)
        try:
            return {path: done.result().rgb}
        except RenderError as error:
            self.error = str(error)
            return {}


def _small(pixels: Pixels) -> Pixels:
    """Every nth pixel, so that a row has at most `WIDTH`."""
    step = -(-pixels.shape[1] // WIDTH)
    return np.ascontiguousarray(pixels[::step, ::step])
