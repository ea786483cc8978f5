"""Makes videos of a session's world: takes images at a constant rate in simulation time, and writes them as one file."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from graphengine.api.pictures import find_camera, look
from graphengine.api.video_encoders import ENCODERS, Film, check_path
from graphengine.format.atomic_write import write_together
from graphengine.format.errors import UsageError

if TYPE_CHECKING:
    from graphengine.physics.simulation import Simulation

SIZE = (640, 360)
"""Default width and height of videos of a view, pixels."""
FPS = 20
"""Default number of images per second; browsers slow down GIFs with more than 50."""
FASTEST = 60
"""Maximum number of images per second."""
SHADOW_MAP = 4096
"""Side of the shadow map, texels."""
MAX_FRAMES = 20_000
"""Maximum number of images of a video."""
MAX_BYTES = 2_000_000_000
"""Maximum size of all images of a video before compression, bytes."""


class Video:
    """A video of a view or of a camera prim. Its images are kept in a temporary file until `write` is called.

    Args:
        world: world to show.
        path: file that `write` writes; its suffix determines the format.
        camera: name of a view, or name or path of a camera prim.
        seconds: duration in simulation time, s.
        delta: duration of a tick, s.
        size: width and height, pixels; None is the camera's own size, or `SIZE` for a view.
        fps: images per second of simulation time.

    Raises:
        UsageError: an argument is invalid, the video would be too large, there is no such camera, or ffmpeg is missing.
    """

    def __init__(
        self,
        world: Simulation,
        path: Path,
        camera: str,
        seconds: float,
        delta: float,
        size: tuple[int, int] | None = None,
        fps: int = FPS,
    ) -> None:
        from graphengine.physics.views.views import ViewCamera, ViewRenderer

        check_path(path)
        self.path, self.fps = path, fps
        prim = find_camera(world, camera)
        self.size: tuple[int, int] = size or (prim.facts["size"] if prim is not None else SIZE)
        self.planned = check_length(seconds, fps, self.size)
        self.frames = 0
        """Number of images taken so far; `planned` is their number at the end."""
        self._delta, self._ticks = delta, 0
        self._closing = ExitStack()
        self._film = self._closing.enter_context(tempfile.TemporaryFile())  # noqa: SIM115 - `close` closes it
        self._take: Callable[[float], NDArray[Any]]
        if prim is not None:
            self._take = lambda time: look(world, camera, size).rgb
        else:
            view, renderer = ViewCamera(world, camera, self.size), ViewRenderer(world, SHADOW_MAP)
            self._closing.callback(renderer.close)
            self._take = lambda time: renderer.draw(view.view(time)).rgb

    def after_ticks(self, ticks: int = 1) -> bool:
        """Take all images that are due. Return whether the video still lacks images.

        Args:
            ticks: number of ticks that have run since the last call; 0 before the first tick.

        Raises:
            RenderError: OpenGL is missing or failed.
        """
        self._ticks += ticks
        while self.frames < self.planned and self._ticks >= self._due():
            self._film.write(self._take(self.frames / self.fps).tobytes())
            self.frames += 1
        return self.frames < self.planned

    def _due(self) -> int:
        return round(self.frames / self.fps / self._delta)

    def write(self) -> None:
        """Write the file with the images taken so far.

        Raises:
            OSError: the file cannot be written.
            RenderError: ffmpeg failed.
        """
        self._film.flush()
        encode = ENCODERS[self.path.suffix.lower()]
        write_together({self.path: encode(Film(self._film, self.size), self.fps)})

    def close(self) -> None:
        """Release OpenGL and delete the temporary file."""
        self._closing.close()


def check_length(seconds: float, fps: int, size: tuple[int, int]) -> int:
    """Return the number of images of a video.

    Raises:
        UsageError: the duration or the rate is out of bounds, or the video would be too large.
    """
    if not 1 <= fps <= FASTEST:
        raise UsageError(f"fps: expected 1 to {FASTEST} images per second, got {fps}")
    if not 0.0 < seconds < math.inf:
        raise UsageError(f"seconds: expected a duration of more than 0 s, got {seconds!r}")
    frames = max(math.floor(seconds * fps + 1e-6), 1)
    if frames > MAX_FRAMES or 3 * frames * size[0] * size[1] > MAX_BYTES:
        what = f"{frames} images of {size[0]} x {size[1]} pixels are too large for a video"
        raise UsageError(f"{what}\n  make it shorter, smaller, or of fewer images per second")
    return frames
