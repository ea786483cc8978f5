"""Writes files atomically: a file appears, or replaces an older file, only when the content is complete.

A symbolic link at the path is replaced, but the link's target does not change: in an untrusted folder, a link can point anywhere.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path


def write_together(contents: Mapping[Path, bytes]) -> None:
    """Write several files, and create missing folders; files are replaced only after all contents are written.

    The umask determines the permissions of a new file; a replaced file keeps its permissions.

    Raises:
        OSError: a file cannot be written; `filename` of the exception is the path of this file.
    """
    parts: dict[Path, Path] = {}
    try:
        for path, content in contents.items():
            with _naming(path):
                with contextlib.suppress(FileExistsError):
                    path.parent.mkdir(parents=True)
                parts[path] = path.with_name(f".{secrets.token_hex(8)}.part")
                _write(parts[path], content, _mode_of(path))
        for path, part in parts.items():
            with _naming(path):
                os.replace(part, path)
    finally:
        for part in parts.values():
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def _mode_of(path: Path) -> int | None:
    """Return the permission bits of the file to replace; None if the path does not exist or is a symbolic link.

    Raises:
        OSError: the path is a folder, pipe or device.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "not a regular file")
    return stat.S_IMODE(path.lstat().st_mode) & 0o777 if path.is_file() and not path.is_symlink() else None


def _write(part: Path, content: bytes, mode: int | None) -> None:
    """Create a file with the content, and flush it to the disk; without a mode, the umask determines the permissions."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    with open(os.open(part, flags, 0o666 if mode is None else mode), "wb") as file:
        if mode is not None:
            os.fchmod(file.fileno(), mode)
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Return a context that replaces the `filename` of an OSError, a temporary file, with `path`."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
