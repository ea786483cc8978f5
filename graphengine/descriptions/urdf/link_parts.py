"""Reads the parts of a link in URDF: mass and inertia, colliders and visuals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from graphengine.descriptions.files.xml import Element, number, numbers
from graphengine.descriptions.robot_description import TERMS, Inertial
from graphengine.descriptions.shapes import Box, Capsule, Colour, Cylinder, Geometry, Mesh, Shape, Sphere
from graphengine.devices.rotation import NOWHERE, Pose, Vector3, from_rpy
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing

MADE: Mapping[str, tuple[dict[str, int], Callable[..., Geometry]]] = {
    "box": ({"size": 3}, lambda x, y, z: Box((x, y, z))),
    "cylinder": ({"radius": 1, "length": 1}, Cylinder),
    "sphere": ({"radius": 1}, Sphere),
    "capsule": ({"radius": 1, "length": 1}, Capsule),
}
"""For each shape but a mesh: the attributes with their counts of numbers, and a function from these numbers to the geometry."""
SHAPES = (*MADE, "mesh")


def triple(text: str) -> Vector3 | None:
    """Return the three numbers of a text; None for any other text."""
    values = numbers(text, 3)
    return (values[0], values[1], values[2]) if values is not None else None


def origin_of(element: Element) -> Pose | None:
    """Return the pose in the `origin` of an element, identity without an `origin`; None if a value is not a number."""
    position, angles = (triple(element.at("origin", name, "0 0 0")) for name in ("xyz", "rpy"))
    return (position, from_rpy(*angles)) if position is not None and angles is not None else None


def inertial_of(link: Element, findings: Findings) -> Inertial | None:
    """Return mass and moments of inertia of a `link` element; None if it has no mass. Errors are added to `findings`."""
    inertial = link.first("inertial")
    weight = inertial.first("mass") if inertial is not None else None
    if inertial is None or weight is None:
        return None
    mass = number(weight.get("value"))
    if mass is None or mass < 0:
        text = f"mass {weight.get('value')!r} is not a number of at least 0 (kg)"
        findings.add("S103", text, weight.place("value"))
        return None
    pose, inertia = origin_of(inertial) or NOWHERE, inertial.first("inertia")
    terms = numbers(" ".join(inertial.at("inertia", term, "0") for term in TERMS), len(TERMS))
    if inertia is None or (terms is None and not mass):  # a massless link may have illegal moments, which are not used
        return Inertial(mass, None, pose)
    if terms is None:
        text = f"link {link.get('name')!r}: the inertia must have six numbers, in kg m2"
        findings.add("S103", text, inertia.span)
        return None
    xx, yy, zz, xy, xz, yz = terms
    return Inertial(mass, (xx, yy, zz, xy, xz, yz), pose)


def colours_by_name(root: Element) -> dict[str, Colour]:
    """Return a dict from material names to colours. Materials of the root element take precedence over those of visuals."""
    materials = [*root.all("material"), *(element for element in root.walk() if element.tag == "material")]
    found: dict[str, Colour] = {}
    for material in materials:
        if (colour := _own_colour(material)) is not None:
            found.setdefault(material.get("name"), colour)
    return found


def _own_colour(material: Element) -> Colour | None:
    values = numbers(material.at("color", "rgba"), 4)
    return (values[0], values[1], values[2], values[3]) if values is not None else None


def shapes_of(link: Element, colours: Mapping[str, Colour], findings: Findings) -> Iterator[Shape]:
    """Yield the colliders and visuals of a `link` element, in order of the file. Errors are added to `findings`.

    Args:
        link: element of the link.
        colours: colours by material name.
        findings: receives the errors.
    """
    name = link.get("name")
    for index, part in enumerate(link.children):
        shape = _shape_of(part, name, findings) if part.tag in ("collision", "visual") else None
        geometry = _geometry(shape, name, findings) if shape is not None else None
        material = part.first("material")
        colour = _own_colour(material) or colours.get(material.get("name")) if material is not None else None
        if shape is not None and geometry is not None:
            pose, visual = origin_of(part) or NOWHERE, part.tag == "visual"
            yield Shape(f"{name}.{index}", visual, geometry, pose, colour, part, shape.span)


def _shape_of(part: Element, link: str, findings: Findings) -> Element | None:
    """Return the element of the shape of a `collision` or `visual`; None after an error."""
    holder = part.first("geometry")
    if holder is None or not holder.children:
        text = f"link {link!r}: a {part.tag} without a shape in its <geometry>"
        findings.add("S103", text, part.span, listing(SHAPES))
        return None
    shape = holder.children[0]
    if shape.tag not in SHAPES:
        near = did_you_mean(shape.tag, SHAPES) or listing(SHAPES)
        findings.add("S103", f"link {link!r}: unknown shape {shape.tag[:40]!r}", shape.span, near)
        return None
    return shape


def _geometry(shape: Element, link: str, findings: Findings) -> Geometry | None:
    """Return the geometry of the element of a shape; None after an error."""
    if shape.tag == "mesh":
        scale = triple(shape.get("scale", "1 1 1"))
        return Mesh(shape.get("filename"), scale, shape) if scale is not None else None
    attributes, made = MADE[shape.tag]
    if absent := [attribute for attribute in attributes if attribute not in shape.attributes]:
        text = f"link {link!r}: <{shape.tag}> has no attribute {absent[0]!r}"
        findings.add("S103", text, shape.span, f'write {absent[0]}="…", in m')
        return None
    sizes = numbers(" ".join(map(shape.get, attributes)), sum(attributes.values()))
    return made(*sizes) if sizes is not None else None
