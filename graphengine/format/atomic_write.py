"""Atomic writing: a file appears, or replaces an older one, only when it is complete.

A symbolic link at the path is replaced and its target is not changed, as the folder may be untrusted.
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
    """Write several files, all or none; missing folders are created.

    A new file has the mode of the umask; a replaced file keeps its mode.

    Raises:
        OSError: a file cannot be written; `filename` names it.
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
    """Mode of the file to replace; None for a missing file or a link.

    Raises:
        OSError: the path is a folder or device.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "not a regular file")
    return stat.S_IMODE(path.lstat().st_mode) & 0o777 if path.is_file() and not path.is_symlink() else None


def _write(part: Path, content: bytes, mode: int | None) -> None:
    """Write a new file and flush it to the disk."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    with open(os.open(part, flags, 0o666 if mode is None else mode), "wb") as file:
        if mode is not None:
            os.fchmod(file.fileno(), mode)
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Name the final file in errors instead of the temporary one."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
