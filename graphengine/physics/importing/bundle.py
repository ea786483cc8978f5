"""Copies for a project of its own: meshes beside the description, and the graphs that the robot file uses."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from graphengine.format.files import shipped
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.files.packages import Packages, package_of
from graphengine.physics.files.xml import Element
from graphengine.physics.importing.draft import Draft

FOLDER = "meshes"
"""Folder of the meshes beside the description."""


def bundle_meshes(urdf: Urdf) -> dict[Path, Path]:
    """Make references to meshes lead to a folder beside the description; what is not found stays as it is.

    Returns:
        the file of each mesh, by its path relative to the description.
    """
    sources: dict[Path, Path] = {}
    for element in _meshes(urdf.element):
        reference = element.get("filename")
        source = _find(reference, urdf.packages)
        if source is not None:
            target = _free(Path(FOLDER, package_of(reference) or "", source.name), source, sources)
            sources[target] = source
            element.attributes["filename"] = target.as_posix()
    return sources


def bundle_graphs(draft: Draft) -> dict[Path, Path]:
    """Make the robot use copies of the included graphs, in a folder next to that of the robot file.

    Returns:
        the file of each graph, by its path relative to the folder of the robot file.
    """
    sources: dict[Path, Path] = {}
    for entry in draft.sections["graphs"].values():
        source, target = shipped() / entry.value["use"], Path("..", entry.value["use"])
        if source.is_file():
            sources[target] = source
            entry.value["use"] = target.as_posix()
    return sources


def _meshes(root: Element) -> Iterator[Element]:
    return (element for element in root.walk() if element.tag == "mesh" and element.get("filename"))


def _find(reference: str, packages: Packages) -> Path | None:
    places = (place for place in packages.places(reference) if packages.files.may_read(place) and place.is_file())
    return next((place.resolve() for place in places), None)


def _free(target: Path, source: Path, taken: dict[Path, Path]) -> Path:
    """The target, with a number if another file has its name."""
    number, free = 2, target
    while taken.get(free, source) != source:
        free = target.with_stem(f"{target.stem}_{number}")
        number += 1
    return free
