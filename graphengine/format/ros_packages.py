"""ROS packages on disk: folders with a manifest, `package.xml`, that names the package."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

MANIFEST = "package.xml"
MAX_FOLDERS = 20_000

_MAX_BYTES = 256 * 1024
"""Of a manifest, which are searched for the name."""
_NAME = re.compile(rb"<name>\s*([\w.-]+)\s*</name>")


def manifest_name(folder: Path) -> str | None:
    """The name of a package by the manifest in its folder; None where there is no manifest, or no name in it."""
    manifest = folder / MANIFEST
    if not manifest.is_file():
        return None
    with manifest.open("rb") as file:
        found = _NAME.search(file.read(_MAX_BYTES))
    return found[1].decode("ascii", "replace") if found else None


def walk(top: Path, depth: int, closes: Callable[[Sequence[str]], bool]) -> Iterator[tuple[Path, list[str]]]:
    """Folders of a tree with the names of their files, nearest to the top first within each branch; hidden ones are left out.

    Args:
        top: the first folder.
        depth: levels below the top that are entered.
        closes: whether the folders in a folder below the top are left out, by the names of its files.
    """
    for count, (place, folders, names) in enumerate(os.walk(top)):
        yield Path(place), names
        below = len(Path(place).relative_to(top).parts)
        left_out = below >= depth or (below > 0 and closes(names))
        folders[:] = [] if left_out else sorted(folder for folder in folders if not folder.startswith("."))
        if count >= MAX_FOLDERS:
            return
