"""Shapes, colours and surfaces of SDF's collisions and visuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from graphengine.devices.rotation import Pose, rotate, unrotate
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import listing, printable
from graphengine.physics.files.xml import Element, numbers
from graphengine.physics.sdf.sdf_frames import SdfFrame, place_of
from graphengine.physics.sdf.sdf_values import SdfError, find, leaf, number_at, numbers_at, text_at, written

SHAPES = ("box", "cylinder", "sphere", "capsule", "ellipsoid", "mesh", "plane")
_REMEDIES = {
    "heightmap": "an MJCF world has height fields: <hfield>",
    "image": "draw the shape as boxes or as a mesh",
    "polyline": "write a mesh, or boxes",
    "cone": "write a mesh, or a cylinder",
}
_SOLVER = ("kp", "kd", "max_vel", "min_depth")
_SLIGHTLY = 1e-12


def shape_of(part: Element) -> Element | None:
    """Return the element of a collision's or visual's shape; None for `<empty>` or if there is no shape.

    Raises:
        SdfError: the kind of shape is not simulated here.
    """
    geometry = part.first("geometry")
    shape = next((child for child in geometry.children if ":" not in child.tag), None) if geometry is not None else None
    if shape is None or shape.tag == "empty":
        return None
    if shape.tag not in SHAPES:
        advice = _REMEDIES.get(shape.tag, listing(SHAPES, "known"))
        raise SdfError(
            f"{part.tag} {_name(part)}: a {printable(shape.tag[:40])} is not simulated here", shape.span, advice
        )
    return shape


def urdf_shape(part: Element, shape: Element, references: str, findings: Findings) -> Element:
    """Return a shape in URDF's `<geometry>`.

    Raises:
        SdfError: its size is no number, or URDF has no such shape.
    """
    made = Element(shape.tag, {}, shape.span)
    if shape.tag == "box":
        made.attributes["size"] = written(*numbers_at(shape, "size", default=(1.0, 1.0, 1.0)))
    elif shape.tag in ("cylinder", "capsule"):
        made.attributes["radius"] = written(number_at(shape, "radius", default=0.5))
        made.attributes["length"] = written(number_at(shape, "length", default=1.0))
    elif shape.tag == "sphere":
        made.attributes["radius"] = written(number_at(shape, "radius", default=1.0))
    elif shape.tag == "mesh":
        made = urdf_mesh(shape, references, findings)
    else:
        advice = "write a sphere or a mesh" if shape.tag == "ellipsoid" else "write a box"
        raise SdfError(f"{part.tag} {_name(part)}: a robot's link cannot be of shape {shape.tag!r}", shape.span, advice)
    return Element("geometry", {}, shape.span, [made])


def urdf_mesh(shape: Element, references: str, findings: Findings) -> Element:
    """Return a mesh as URDF's `<mesh>`, its file named from the folder of the main file.

    Raises:
        SdfError: it names no file, or its scale is no number.
    """
    uri = shape.first("uri")
    if uri is None or not uri.text:
        raise SdfError("a mesh without <uri>", shape.span)
    if (part := shape.first("submesh")) is not None:
        text = f"submesh {printable(text_at(part, 'name')[:60])!r}: the whole mesh is used, at its position in the file"
        findings.add("N103", text, part.span)
    attributes = {"filename": uri.text if "://" in uri.text or uri.text.startswith("/") else references + uri.text}
    scale = numbers_at(shape, "scale", default=(1.0, 1.0, 1.0))
    if scale != (1.0, 1.0, 1.0):
        attributes["scale"] = written(*scale)
    return Element("mesh", attributes, uri.span)


def colour_of(visual: Element) -> tuple[float, float, float, float] | None:
    """Return red, green, blue and opacity of a visual's diffuse colour, 0 to 1; None if it has none."""
    for tag in ("diffuse", "ambient"):
        text = text_at(visual, "material", tag)
        values = numbers(text, 4) or numbers(text, 3)
        if values is not None:
            red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in (*values, 1.0)[:4])
            clear = min(max(number_at(visual, "transparency", default=0.0), 0.0), 1.0)
            return red, green, blue, alpha * (1.0 - clear)
    return None


def textured(visual: Element) -> bool:
    """Return whether a visual has an image on it."""
    maps = ("albedo_map", "normal_map", "roughness_map")
    material = visual.first("material")
    return material is not None and any(element.tag in maps and element.text for element in material.walk())


def surface_for_gazebo(link: SdfFrame, frames: Mapping[SdfFrame, Pose]) -> Iterator[Element]:
    """Yield friction and contact elements for a link's `<gazebo>` in URDF, from its first collision with a `<surface>`.

    Args:
        link: whose collisions are meant.
        frames: of the URDF's links in the outermost scope, for directions of friction.
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
    """Return a direction of friction in the frame of a URDF's link; none for a zero vector.

    SDF gives it in the frame of the collision, with which it turns, or of a link that it names.
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
    """Return the sliding friction coefficient of a collision; None if it gives none."""
    for engine in ("ode", "bullet"):
        for tag in ("mu", "friction"):
            if text_at(collision, "surface", "friction", engine, tag):
                return max(number_at(collision, "surface", "friction", engine, tag, default=1.0), 0.0)
    return None


def _name(part: Element) -> str:
    return repr(printable(part.get("name")))
