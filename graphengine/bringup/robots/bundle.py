"""Chooses the files to copy into the robot's project: meshes, MuJoCo models, and graphs that the robot file uses."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from graphengine.descriptions.files.packages import Packages, package_of
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.robot_files.draft import Draft, shipped_graph
from graphengine.format.files import shipped

MESHES = "meshes"
"""Folder beside the description for copies of meshes that the description names by path."""


def bundle_meshes(description: RobotDescription) -> dict[Path, Path]:
    """Choose a path beside the description for a copy of each mesh, and change the references in the description.

    References into packages stay unchanged, because other ROS programs read them too; so do references to missing files.

    Returns:
        a dict from the path of each copy, relative to the description, to the file to copy.
    """
    sources: dict[Path, Path] = {}
    for element in (each for each in description.element.walk() if each.tag == "mesh" and each.get("filename")):
        reference = element.get("filename")
        source = _find(reference, description.packages)
        if source is None:
            continue
        parts = reference.rpartition("://")[2].strip("/").split("/")
        if package_of(reference) is not None and [_name(part) for part in parts] == parts:
            target = Path(*parts)  # a package is looked up first beside the description
        else:
            target = _free(Path(MESHES, _name(parts[-1])), source, sources)
            element.attributes["filename"] = target.as_posix()
        sources[target] = source
    return sources


def bundle_model(model: Path, library: Library, name: str) -> dict[Path, Path]:
    """Return a dict from the copies of a MuJoCo model's files, relative to the folder of the robot file, to the files.

    The copies are in the folder `NAME_model`.

    Args:
        model: path of the model's file.
        library: library that has read the model.
        name: name of the robot.
    """
    files = [model.resolve(), *library.read_files()]
    folder = Path(os.path.commonpath([file.parent for file in files]))
    return {Path(f"{name}_model", file.relative_to(folder)): file for file in files}


def bundle_stage(files: Sequence[Path], name: str) -> dict[Path, Path]:
    """Return the files of a USD stage, by the paths of their copies in the folder `NAME_stage` beside the robot file."""
    folder = Path(os.path.commonpath([file.resolve().parent for file in files]))
    return {Path(f"{name}_stage", file.resolve().relative_to(folder)): file for file in files}


def bundle_graphs(draft: Draft) -> dict[Path, Path]:
    """Change the draft to use copies of the included graphs; the copies are in a folder next to that of the robot file.

    Returns:
        a dict from the path of each copy, relative to the folder of the robot file, to the file of a graph or subgraph.
    """
    sources: dict[Path, Path] = {}
    for entry in draft.graphs.values():
        use = entry.value["use"]
        for reference in _with_subgraphs(use):
            sources[Path("..", reference)] = shipped() / reference
        entry.value["use"] = Path("..", use).as_posix()
    return sources


def _with_subgraphs(reference: str) -> Iterator[str]:
    """Yield the reference to an included graph, then the references to all its direct and indirect subgraphs."""
    yield reference
    nodes = shipped_graph(reference).get("nodes", {}).values()
    for name in dict.fromkeys(node["subgraph"] for node in nodes if isinstance(node, dict) and "subgraph" in node):
        yield from _with_subgraphs(os.path.normpath(Path(reference).parent / name))


def _name(text: str) -> str:
    """Return a file name in which `_` replaces characters that are special in paths or URIs."""
    return re.sub(r"[^\w.+-]", "_", text).lstrip(".") or "_"


def _find(reference: str, packages: Packages) -> Path | None:
    places = (place for place in packages.places(reference) if packages.files.may_read(place) and place.is_file())
    return next((place.resolve() for place in places), None)


def _free(target: Path, source: Path, taken: dict[Path, Path]) -> Path:
    """Return the target path, with a number after the name if another file has this path."""
    number, free = 2, target
    while taken.get(free, source) != source:
        free = target.with_stem(f"{target.stem}_{number}")
        number += 1
    return free
