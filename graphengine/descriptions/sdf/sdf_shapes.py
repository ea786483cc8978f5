"""Reads shapes, colours and surface properties of SDF collisions and visuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from graphengine.descriptions.files.xml import Element, numbers
from graphengine.descriptions.sdf.sdf_frames import SdfFrame, place_of
from graphengine.descriptions.sdf.sdf_values import SdfError, find, leaf, number_at, numbers_at, text_at
from graphengine.descriptions.shapes import Box, Capsule, Colour, Cylinder, Mesh, Solid, Sphere
from graphengine.descriptions.worlds.mjcf_elements import written
from graphengine.devices.rotation import Pose, rotate, unrotate
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import listing, printable

SHAPES = ("box", "cylinder", "sphere", "capsule", "ellipsoid", "mesh", "plane")
_REMEDIES = {
    "heightmap": "use an MJCF world with a height field (<hfield>)",
    "image": "draw the shape as boxes or as a mesh",
    "polyline": "write a mesh, or boxes",
    "cone": "write a mesh, or a cylinder",
}
_SOLVER = ("kp", "kd", "max_vel", "min_depth")
_SLIGHTLY = 1e-12


def shape_of(part: Element) -> Element | None:
    """Return the shape element of a collision or visual; None for `<empty>` or if there is no shape.

    Raises:
        SdfError: the kind of shape is not supported.
    """
    geometry = part.first("geometry")
    shape = next((child for child in geometry.children if ":" not in child.tag), None) if geometry is not None else None
    if shape is None or shape.tag == "empty":
        return None
    if shape.tag not in SHAPES:
        advice = _REMEDIES.get(shape.tag, listing(SHAPES, "known"))
        text = f"{part.tag} {printable(part.get('name'))!r}: a {printable(shape.tag[:40])} is not supported"
        raise SdfError(text, shape.span, advice)
    return shape


def solid_of(shape: Element) -> Solid | None:
    """Return the geometry of a box, cylinder, capsule or sphere; None for other shapes.

    Raises:
        SdfError: a size is not a number.
    """
    match shape.tag:
        case "box":
            x, y, z = numbers_at(shape, "size", default=(1.0, 1.0, 1.0))
            return Box((x, y, z))
        case "cylinder" | "capsule" as tag:
            radius, length = number_at(shape, "radius", default=0.5), number_at(shape, "length", default=1.0)
            return (Cylinder if tag == "cylinder" else Capsule)(radius, length)
        case "sphere":
            return Sphere(number_at(shape, "radius", default=1.0))
    return None


def mesh_of(shape: Element, references: str, findings: Findings) -> Mesh:
    """Return the geometry of an SDF mesh.

    Args:
        shape: SDF `<mesh>` element.
        references: prefix that makes relative references relative to the folder of the main file.
        findings: receives a note if only a submesh is wanted.

    Raises:
        SdfError: the mesh names no file, or its scale is not three numbers.
    """
    uri = shape.first("uri")
    if uri is None or not uri.text:
        raise SdfError("a mesh without <uri>", shape.span)
    if (part := shape.first("submesh")) is not None:
        text = f"submesh {printable(text_at(part, 'name')[:60])!r}: the whole mesh is used, at its position in the file"
        findings.add("N103", text, part.span)
    filename = uri.text if "://" in uri.text or uri.text.startswith("/") else references + uri.text
    x, y, z = numbers_at(shape, "scale", default=(1.0, 1.0, 1.0))
    scale = {"scale": written(x, y, z)} if (x, y, z) != (1.0, 1.0, 1.0) else {}
    return Mesh(filename, (x, y, z), Element("mesh", {"filename": filename, **scale}, uri.span))


def colour_of(visual: Element) -> Colour | None:
    """Return red, green, blue and opacity (0 to 1) of a visual: its diffuse colour, else its ambient colour, else None."""
    for tag in ("diffuse", "ambient"):
        text = text_at(visual, "material", tag)
        values = numbers(text, 4) or numbers(text, 3)
        if values is not None:
            red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in (*values, 1.0)[:4])
            clear = min(max(number_at(visual, "transparency", default=0.0), 0.0), 1.0)
            return red, green, blue, alpha * (1.0 - clear)
    return None


def textured(visual: Element) -> bool:
    """Return whether a visual has a texture (albedo, normal or roughness map)."""
    maps = ("albedo_map", "normal_map", "roughness_map")
    material = visual.first("material")
    return material is not None and any(element.tag in maps and element.text for element in material.walk())


def surface_for_gazebo(link: SdfFrame, frames: Mapping[SdfFrame, Pose]) -> Iterator[Element]:
    """Yield friction and contact elements for the `<gazebo>` element of a link, from its first collision with a `<surface>`.

    Args:
        link: frame of the SDF link.
        frames: pose of each URDF link in the outermost scope, to convert friction directions.
    """
    collision = next((each for each in link.element.all("collision") if each.first("surface") is not None), None)
    surface = find(collision, "surface")
    if collision is None or surface is None:
        return
    for engine in ("ode", "bullet"):
        friction = find(surface, "friction", engine)
        if friction is not None:
            children = [child for child in friction.children if child.tag != "fdir1"]
            children += _direction(friction.first("fdir1"), collision, link, frames)
            inside = Element("friction", {}, friction.span, [Element(engine, {}, friction.span, children)])
            yield Element("collision", {}, surface.span, [Element("surface", {}, surface.span, [inside])])
            break
    contact = find(surface, "contact", "ode")
    if contact is not None:
        yield from (leaf(child.tag, child.text, child.span) for child in contact.children if child.tag in _SOLVER)


def _direction(
    element: Element | None, collision: Element, link: SdfFrame, frames: Mapping[SdfFrame, Pose]
) -> list[Element]:
    """Return the friction direction `fdir1` in the frame of a URDF link, as a list; empty without a direction.

    SDF gives the direction in the frame of the collision, or in the frame that `expressed_in` names.
    """
    given = numbers(element.text, 3) if element is not None else None
    if element is None or given is None or not any(given):
        return []
    named = next((value for key, value in element.attributes.items() if key.endswith("expressed_in")), "")
    base = link.scope.require(named, element) if named else link
    rotation = base.place[1] if named else place_of(collision, link)[1]
    holder = base.link()
    turned = unrotate(frames[holder][1], rotate(rotation, (given[0], given[1], given[2])))
    made = leaf("fdir1", written(*(0.0 if abs(part) < _SLIGHTLY else part for part in turned)), element.span)
    made.attributes |= {"expressed_in": holder.full_name} if named else {}
    return [made]


def friction_of(collision: Element) -> float | None:
    """Return the sliding friction coefficient of a collision; None if the collision does not define it."""
    for engine in ("ode", "bullet"):
        for tag in ("mu", "friction"):
            if text_at(collision, "surface", "friction", engine, tag):
                return max(number_at(collision, "surface", "friction", engine, tag, default=1.0), 0.0)
    return None
