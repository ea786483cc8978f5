"""Finds resources from which entities can be spawned: files with a URI, and robot descriptions as text."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from graphengine.control.simulation_interfaces.results import NOT_FOUND, RefusedError
from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files, NotFoundError
from graphengine.format.spec_reader import kind_of

FORMATS = ("urdf", "xacro", "mjcf", "graphengine")
"""Resource formats that SimulatorFeatures lists; `graphengine` is the format of robot files."""
UNSUPPORTED_FORMAT, NO_RESOURCE = 103, 104
_SUFFIXES = (".urdf", ".xacro", ".xml", ".yaml", ".yml")
_NAMED = re.compile(r"<(?:robot\b[^>]*?\bname|mujoco\b[^>]*?\bmodel)\s*=\s*[\"']([^\"']*)[\"']")
_LISTED = tuple(suffix for suffix in _SUFFIXES if suffix != ".xml")
"""Suffixes of the files that `spawnables` lists: no MJCF files, because these may contain worlds."""
MAX_LISTED = 1000
"""Maximum number of spawnable files that a response lists."""


def use_of(files: Files, folder: Path, uri: str, text: str) -> str:
    """Return the value of the key `use` of a scene file for a resource.

    Args:
        files: folders from which files may be read.
        folder: folder of the scene, where relative paths start.
        uri: path or `file://` URI of the resource; empty if `text` is given.
        text: URDF or MJCF description; used only if `uri` is empty.

    Raises:
        RefusedError: `uri` and `text` are empty, the format is not supported, the file does not exist, or it may not be read.
    """
    if not uri:
        if not text.strip():
            raise RefusedError(NO_RESOURCE, "give a uri or a resource_string")
        if not text.lstrip().startswith("<"):
            raise RefusedError(UNSUPPORTED_FORMAT, "a resource_string must be a URDF or MJCF description")
        return text
    path = unquote(uri.removeprefix("file://")) if uri.startswith("file://") else uri
    if "://" in path or Path(path).suffix not in _SUFFIXES:
        legal = "legal: paths and file:// of " + ", ".join(f"*{suffix}" for suffix in _SUFFIXES)
        raise RefusedError(UNSUPPORTED_FORMAT, f"{uri[:200]!r} cannot be spawned; {legal}")
    try:
        files.find(path, folder)
    except NotFoundError as error:
        raise RefusedError(NOT_FOUND, "\n  ".join((error.message, *filter(None, error.help)))) from None
    return path


def name_of(use: str) -> str:
    """Return a name for an entity: the name in a robot description, or the file name of a resource without suffixes.

    The result is empty if a description contains no name.
    """
    if use.lstrip().startswith("<"):
        found = _NAMED.search(use[:10_000])
        name = found[1] if found else ""
    else:
        name = Path(use).name.partition(".")[0]
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:100]
    return f"_{plain}" if plain[:1].isdigit() else plain


def spawnables(files: Files, beside: Path, sources: Sequence[str]) -> tuple[list[tuple[str, str]], list[str]]:
    """Return (URI, description) of each resource that can be spawned, and the unreadable sources.

    The resources are the robot files and robot descriptions in the scene's folder `beside`, in its subfolder `robots`, in the
    folders `sources`, and in the package. A source is unreadable if it is not a folder that may be read.
    """
    folders = {Path(): beside, Path("robots"): beside / "robots"}
    unknown: list[str] = []
    for source in sources:
        folder = beside / unquote(source.removeprefix("file://"))
        if files.may_read(folder) and os.path.isdir(folder):  # `os.path.isdir` accepts illegal names too
            folders[folder] = folder
        else:
            unknown.append(source)
    found: dict[str, str] = {}
    for name, folder in folders.items():
        found |= {str(name / path.name): doc for path, doc in _spawnable(folder, files)}
    shipped = files.base / "scenes" / "robots"
    found |= {str(Path("robots", path.name)): doc for path, doc in _spawnable(shipped, files)}
    return list(found.items())[:MAX_LISTED], unknown


def _spawnable(folder: Path, files: Files) -> Iterator[tuple[Path, str]]:
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    for path in paths:
        if path.suffix not in _LISTED or not path.is_file() or not files.may_read(path):
            continue
        if path.suffix not in (".yaml", ".yml"):
            yield path, "description"
            continue
        read = document.load(path, Findings())
        if read is not None and kind_of(read) == "robot":
            yield path, str(read.data.get("doc") or read.data.get("robot") or "")
