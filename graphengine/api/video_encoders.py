"""Encodes images to a video: animated GIF and WebP with Pillow, MP4 with ffmpeg."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import IO

from PIL import ImageFile

from graphengine.format.errors import RenderError, UsageError
from graphengine.format.wording import listing

Size = tuple[int, int]

QUALITY = 72
"""Quality of WebP, 0 to 100."""


class Film(ImageFile.ImageFile):
    """A file of raw RGB images as one Pillow image with several frames, of which only one is in memory.

    Args:
        file: the images, one after another, without a header.
        size: width and height of each image, pixels.
    """

    format = "FILM"

    def __init__(self, file: IO[bytes], size: Size) -> None:
        self._shape, self.file = size, file
        self._bytes = 3 * size[0] * size[1]
        self.n_frames = os.fstat(file.fileno()).st_size // self._bytes
        super().__init__(file)

    def _open(self) -> None:
        self._mode, self._size = "RGB", self._shape
        self.seek(0)

    def seek(self, frame: int) -> None:
        """Select a frame, which is read when its pixels are needed; raise EOFError after the last one, as Pillow expects."""
        if frame >= self.n_frames:
            raise EOFError
        self._frame, self.fp = frame, self.file
        self.tile = [ImageFile._Tile("raw", (0, 0, *self._shape), frame * self._bytes, ("RGB", 0, 1))]

    def tell(self) -> int:
        """Return the number of the selected frame, from 0."""
        return self._frame

    def durations(self, fps: int, unit: int) -> list[int]:
        """Return the duration of each frame in ms as a multiple of `unit`, such that roundings do not add up."""
        ends = [unit * round(1000 * frame / fps / unit) for frame in range(self.n_frames + 1)]
        return [after - before for before, after in pairwise(ends)]


def check_path(path: Path) -> None:
    """Check that a video can be written to this path.

    Raises:
        UsageError: the suffix is not one of `ENCODERS`, the path is a folder, or ffmpeg is needed and missing.
    """
    suffix = path.suffix.lower()
    if suffix not in ENCODERS or path.is_dir():
        raise UsageError(
            f"{path}: write the name of a video file, such as video.webp\n  {listing(ENCODERS, 'formats')}"
        )
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise UsageError(
            f"{path}: MP4 needs the program ffmpeg, which is not on the path\n"
            "  on Debian and Ubuntu: apt-get install ffmpeg\n  or write a .webp or .gif file, which needs no other program"
        )


def _animation(film: Film, fps: int, kind: str, unit: int, **options: int) -> bytes:
    """Encode an animation that repeats for ever; `unit` is the time that the format counts in, ms."""
    content = io.BytesIO()
    film.save(content, kind, save_all=True, loop=0, duration=film.durations(fps, unit), **options)
    return content.getvalue()


def _webp(film: Film, fps: int) -> bytes:
    return _animation(film, fps, "WEBP", 1, quality=QUALITY, method=4, kmin=0, kmax=10**6)


def _gif(film: Film, fps: int) -> bytes:
    return _animation(film, fps, "GIF", 10)


def _mp4(film: Film, fps: int) -> bytes:
    """Encode an MP4 that all browsers show; its colour format needs even numbers of pixels.

    Raises:
        RenderError: ffmpeg failed.
    """
    os.lseek(film.file.fileno(), 0, os.SEEK_SET)  # ffmpeg reads the file itself
    with tempfile.TemporaryDirectory(prefix="graphrun-") as folder:
        target = Path(folder) / "video.mp4"
        given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "{}x{}".format(*film.size), "-r", str(fps), "-i", "-"]
        made = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(target)]
        command = ["ffmpeg", "-v", "error", *given, *made]
        result = subprocess.run(command, stdin=film.file, capture_output=True, check=False)
        if result.returncode or not target.exists():
            raise RenderError(f"ffmpeg failed: {result.stderr.decode(errors='replace').strip()[-500:]}")
        return target.read_bytes()


ENCODERS: Mapping[str, Callable[[Film, int], bytes]] = MappingProxyType({".gif": _gif, ".mp4": _mp4, ".webp": _webp})
"""Function that encodes a film with a number of frames per second, by the suffix of the file."""
