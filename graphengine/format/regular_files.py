"""Opens files whose paths come from users or other files; refuses pipes and devices, which could block."""

from __future__ import annotations

import errno
import os
import stat
from typing import BinaryIO

StrPath = str | os.PathLike[str]
"""A path as text or as a path object."""


def open_regular(path: StrPath) -> BinaryIO:
    """Open a regular file for reading; return the binary file object.

    Raises:
        OSError: the file does not exist, may not be read, or is a folder, pipe or device.
    """
    file = open(path, "rb", opener=_without_waiting)  # noqa: SIM115  # it is returned
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise OSError(errno.EINVAL, "not a regular file", os.fspath(path))
    return file


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
