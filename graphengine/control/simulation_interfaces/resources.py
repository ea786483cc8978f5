"""Resources of entities: files named by a URI, and robot descriptions as text."""

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
from graphengine.scene.loaded_scene import LoadedScene

FORMATS = ("urdf", "xacro", "mjcf", "graphengine")
"""Resource formats in SimulatorFeatures; `graphengine` stands for robot files."""
UNSUPPORTED_FORMAT, NO_RESOURCE = 103, 104
_SUFFIXES = (".urdf", ".xacro", ".xml", ".yaml", ".yml")
_NAMED = re.compile(r"<(?:robot\b[^>]*?\bname|mujoco\b[^>]*?\bmodel)\s*=\s*[\"']([^\"']*)[\"']")
_LISTED = tuple(suffix for suffix in _SUFFIXES if suffix != ".xml")
"""Suffixes of the files that `spawnables` lists, without MJCF files, which may contain worlds."""
MAX_LISTED = 1000


def use_of(scene: LoadedScene, uri: str, text: str) -> str:
    """Return the value for `use` in a scene file that refers to a resource; `text` is used only without `uri`.

    Raises:
        RefusedError: neither is given, the format is not supported, or no readable file has this name.
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
    files, folder = _places(scene)
    try:
        files.find(path, folder)
    except NotFoundError as error:
        raise RefusedError(NOT_FOUND, "\n  ".join((error.message, *filter(None, error.help)))) from None
    return path


def name_of(use: str) -> str:
    """Return an entity name made from a resource: the name in a description, or the name of a file without its suffixes.

    The name is empty if the description has none.
    """
    if use.lstrip().startswith("<"):
        found = _NAMED.search(use[:10_000])
        name = found[1] if found else ""
    else:
        name = Path(use).name.partition(".")[0]
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:100]
    return f"_{plain}" if plain[:1].isdigit() else plain


def spawnables(scene: LoadedScene, sources: Sequence[str]) -> tuple[list[tuple[str, str]], list[str]]:
    """Return URI and description of each spawnable resource, and the given sources that are not readable folders.

    Lists robot files and robot descriptions in the folder of the scene, its subfolder `robots`, `sources`, and the built-in ones.
    """
    files, beside = _places(scene)
    folders = {Path(): beside, Path("robots"): beside / "robots"}
    unknown: list[str] = []
    for source in sources:
        folder = beside / unquote(source.removeprefix("file://"))
        if files.may_read(folder) and os.path.isdir(folder):  # which takes a name that no folder can have, too
            folders[folder] = folder
        else:
            unknown.append(source)
    found: dict[str, str] = {}
    for name, folder in folders.items():
        found |= {str(name / path.name): doc for path, doc in _spawnable(folder, files)}
    shipped = files.base / "scenes" / "robots"
    found |= {str(Path("robots", path.name)): doc for path, doc in _spawnable(shipped, files)}
    return list(found.items())[:MAX_LISTED], unknown


def _places(scene: LoadedScene) -> tuple[Files, Path]:
    """Return the access to files that the scene may read, and the folder of the scene for relative names."""
    assert scene.world is not None
    scenery = scene.world.scenery
    return scenery.library.files, scenery.scene.folder


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
