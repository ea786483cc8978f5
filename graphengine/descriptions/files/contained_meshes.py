"""Meshes that a description itself contains, instead of naming files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graphengine.descriptions.files.mesh_file import MeshFile
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element


def contained(
    shapes: Sequence[tuple[Element, bool]], meshes: Mapping[str, bytes], library: Library
) -> dict[Element, list[MeshFile]]:
    """Add meshes to the assets of a library, and return the mesh files by `mesh` element, as `Library.meshes` does.

    Args:
        shapes: (`mesh` element, whether it belongs to a visual) for each mesh.
        meshes: meshes in MSH by the reference of the elements, which no other mesh has.
        library: receives the meshes.
    """
    library.assets |= meshes
    library.outcomes |= dict.fromkeys(meshes, "unchanged")
    files = {element: MeshFile(element.get("filename")) for element, _ in shapes}
    return {
        element: [files[element]] if visual else library.solid(element, files[element]) for element, visual in shapes
    }
