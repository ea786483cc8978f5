"""Converts collisions and visuals in SDF worlds to MJCF geoms."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from graphengine.descriptions.engine import PICTURES, RAYS, RAYS_AND_PICTURES
from graphengine.descriptions.files.mesh_file import MeshFile
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.sdf.sdf_frames import SdfFrame, place_of
from graphengine.descriptions.sdf.sdf_shapes import colour_of, friction_of, mesh_of, shape_of, solid_of
from graphengine.descriptions.sdf.sdf_values import SdfError, numbers_at, reported
from graphengine.descriptions.shapes import Mesh, sizes_of
from graphengine.descriptions.worlds.mesh_pieces import MeshPieces
from graphengine.descriptions.worlds.mjcf_elements import placed, written
from graphengine.devices.rotation import Quaternion, Vector3, multiply, relative
from graphengine.format.diagnostics import Findings

_GREY = (0.7, 0.7, 0.7, 1.0)
_UP: Vector3 = (0.0, 0.0, 1.0)


@dataclass(slots=True)
class GeomWriter:
    """Creates the MJCF geoms of one world, and the MJCF meshes that these geoms use.

    Attributes:
        library: reads the mesh files.
        findings: receives errors, warnings and notes.
        pieces: creates the MJCF meshes.
    """

    library: Library
    findings: Findings
    pieces: MeshPieces
    _meshes: dict[Element, Mesh] = field(default_factory=dict)
    """Mesh for each SDF `<mesh>` element of a collision or visual."""
    _files: Mapping[Element, list[MeshFile]] = field(default_factory=dict)

    def load_meshes(self, links: Iterable[SdfFrame], packages: Packages) -> None:
        """Read the mesh files of the given links; call this once, before `geoms`. Errors are added to `findings`."""
        shapes: list[tuple[Element, bool]] = []
        for link in links:
            for part in (each for each in link.element.children if each.tag in ("collision", "visual")):
                with reported(self.findings, "S102"):
                    shape = _drawable(part, self.findings)
                    if shape is not None and shape.tag == "mesh":
                        self._meshes[shape] = mesh_of(shape, link.scope.references, self.findings)
                        shapes.append((self._meshes[shape].element, part.tag == "visual"))
        self._files = self.library.meshes(shapes, packages)

    def geoms(self, link: SdfFrame, *, static: bool) -> list[Element]:
        """Return the geoms of a link: first colliders, then visuals. Errors are added to `findings`.

        Args:
            link: frame of the link, which is also the frame of the MJCF body.
            static: whether the link belongs to a static model.
        """
        found: dict[str, list[Element]] = {"collision": [], "visual": []}
        for part in link.element.children:
            if part.tag in found:
                with reported(self.findings, "S102"):
                    found[part.tag] += self._geoms(part, link, static=static)
        solid, seen = found["collision"], found["visual"]
        floors = [geom for geom in solid if geom.get("type") == "plane"]
        if floors:  # a collider and a visual plane in the same place would flicker, so one plane is used as both
            drawn = [geom for geom in seen if geom.get("type") == "plane"]
            seen = [geom for geom in seen if geom not in drawn]
            floors[0].attributes["rgba"] = (drawn or floors)[0].get("rgba")
        for geom in solid:
            geom.attributes["group"] = str(RAYS if seen and geom not in floors else RAYS_AND_PICTURES)
        return [*solid, *seen]

    def _geoms(self, part: Element, link: SdfFrame, *, static: bool) -> Iterator[Element]:
        """Yield the geoms of a collision or visual; several for a mesh with several colours, or for a non-convex collider."""
        shape = _drawable(part, None)
        if shape is None:
            return
        pose, visual = relative(link.place, place_of(part, link)), part.tag == "visual"
        if shape.tag == "plane" and not static:
            remedy = "write <static>true</static> in the model"
            raise SdfError("a plane must belong to a static model", shape.span, remedy)
        if shape.tag == "plane":
            pose = (pose[0], multiply(pose[1], _towards(shape)))
        colour = colour_of(part)
        values = placed(pose) | _size(shape, part) | {"rgba": written(*(colour or _GREY))}
        if visual:
            values |= {"contype": "0", "conaffinity": "0", "group": str(PICTURES), "mass": "0"}
        elif (friction := friction_of(part)) is not None:
            values["friction"] = f"{written(friction)} 0.005 0.0001"
        if shape.tag != "mesh":
            yield Element("geom", values, part.span)
            return
        mesh = self._meshes.get(shape)
        if mesh is None:
            return
        for file in self._files.get(mesh.element, ()):
            own = {"rgba": written(*file.colour)} if colour is None and file.colour is not None else {}
            for piece in self.pieces.of(file, mesh, exact=static and not visual):
                yield Element("geom", values | own | {"mesh": piece.get("name")}, part.span)


def _drawable(part: Element, findings: Findings | None) -> Element | None:
    """Return the shape of a collision or visual; None if it has no shape, or for a visual that cannot be drawn.

    If `findings` is given, it receives a note about a visual that cannot be drawn.

    Raises:
        SdfError: the shape of a collision is not supported.
    """
    try:
        return shape_of(part)
    except SdfError as error:
        if part.tag == "collision":
            raise
        if findings is not None:
            findings.add("N103", f"not drawn: {error.message}", error.span, *error.help)
        return None


def _size(shape: Element, part: Element) -> dict[str, str]:
    """Return the type and size of a shape as attributes of an MJCF geom."""
    if (solid := solid_of(shape)) is not None:
        return _geom(shape.tag, *sizes_of(solid))
    if shape.tag == "ellipsoid":
        return _geom("ellipsoid", *numbers_at(shape, "radii", default=(1.0, 1.0, 1.0)))
    if shape.tag == "plane":  # a collider is endless
        width, length = numbers_at(shape, "size", default=(1.0, 1.0)) if part.tag == "visual" else (0.0, 0.0)
        return _geom("plane", width / 2.0, length / 2.0, 1.0)
    return {"type": "mesh"}


def _geom(kind: str, *size: float) -> dict[str, str]:
    return {"type": kind, "size": written(*size)}


def _towards(plane: Element) -> Quaternion:
    """Return the rotation (x, y, z, w) that turns the z axis to the normal of a plane."""
    x, y, z = numbers_at(plane, "normal", default=_UP)
    length = math.hypot(x, y, z)
    if not length:
        raise SdfError("the normal of a plane must not be zero", plane.span)
    x, y, z = x / length, y / length, z / length
    if z < -1.0 + 1e-12:
        return 1.0, 0.0, 0.0, 0.0
    scale = math.sqrt(2.0 * (1.0 + z))
    return -y / scale, x / scale, 0.0, scale / 2.0
