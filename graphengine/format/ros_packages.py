"""Finds ROS packages on disk: folders with a manifest, `package.xml`, which contains the name of the package."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

MANIFEST = "package.xml"
MAX_FOLDERS = 20_000
"""Maximum number of folders that are searched for ROS packages."""

_MAX_BYTES = 256 * 1024
"""Number of bytes at the beginning of a manifest in which the name of the package is searched."""
_NAME = re.compile(rb"<name>\s*([\w.-]+)\s*</name>")


def manifest_name(folder: Path) -> str | None:
    """Return the package name in the manifest of a folder; None without a manifest or without a name in the manifest."""
    manifest = folder / MANIFEST
    if not manifest.is_file():
        return None
    with manifest.open("rb") as file:
        found = _NAME.search(file.read(_MAX_BYTES))
    return found[1].decode("ascii", "replace") if found else None


def package_folder(path: Path) -> Path:
    """Return the folder of the ROS package that contains a file; for a file outside of packages, the folder of the file."""
    resolved = path.resolve()
    return next((folder for folder in resolved.parents if (folder / MANIFEST).is_file()), resolved.parent)


def walk(top: Path, depth: int, closes: Callable[[Sequence[str]], bool]) -> Iterator[tuple[Path, list[str]]]:
    """Yield the folders of a tree with the names of their files; each folder precedes its subfolders.

    Hidden folders are skipped, and at most MAX_FOLDERS folders are visited.

    Args:
        top: folder at which the tree begins.
        depth: maximum number of levels below `top`.
        closes: called with the names of the files in a folder below `top`; the result True skips the subfolders.
    """
    for count, (place, folders, names) in enumerate(os.walk(top), 1):
        yield Path(place), names
        below = len(Path(place).relative_to(top).parts)
        left_out = below >= depth or (below > 0 and closes(names))
        folders[:] = [] if left_out else sorted(folder for folder in folders if not folder.startswith("."))
        if count >= MAX_FOLDERS:
            return
