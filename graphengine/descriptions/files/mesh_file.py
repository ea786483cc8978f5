"""Data model of the mesh files of a description, before and after they are loaded."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from graphengine.descriptions.files import meshes

Outcome = Literal["unchanged", "converted", "unreadable", "missing"]


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh that MuJoCo can read: its key in `Library.assets`, and the colour in the mesh file or None."""

    key: str
    colour: meshes.Colour | None = None


@dataclass(frozen=True, slots=True)
class LoadedMesh:
    """The result of loading a mesh file: the meshes that MuJoCo can read, or in `why` the reason why there are none."""

    outcome: Outcome
    files: list[MeshFile]
    why: str = ""


class MeshKind(NamedTuple):
    """The resolved path of a mesh file, the suffix of its name in the description, and whether the mesh is a visual."""

    path: Path
    suffix: str
    visual: bool
