"""Converts a URDF description so that MuJoCo accepts it: meshes it can decode, valid colours, possible inertias."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphengine.descriptions.files.mesh_file import MeshFile
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, numbers
from graphengine.descriptions.urdf.inertia import inertials
from graphengine.descriptions.urdf.urdf import Urdf, UrdfLink, shape_of
from graphengine.format.diagnostics import Findings

_COMPILER = {"fusestatic": "false", "discardvisual": "false", "strippath": "true"}
"""Compiler settings that replace MuJoCo's defaults for URDF, which merge links at fixed joints and discard visuals."""
_PASSED_ON = ("balanceinertia", "boundmass", "boundinertia", "inertiafromgeom")
"""Settings of the <mujoco><compiler> element of a description that are passed on to MuJoCo; others are ignored."""
_JOINT_PARTS = ("origin", "parent", "child", "axis", "limit", "dynamics")


def for_mujoco(
    urdf: Urdf,
    name: str,
    library: Library,
    findings: Findings,
    *,
    free: bool,
    colours: Mapping[str, tuple[float, float, float]],
) -> Element:
    """Return a copy of a description in the dialect of URDF that MuJoCo reads.

    Args:
        urdf: robot description; it is not changed.
        name: name of the robot.
        free: whether the root link can move.
        colours: colour (red, green, blue from 0 to 1) of visuals without a material, by link name.
        library: reads the meshes and keeps their data.
        findings: receives errors of masses and inertias, and notes on changed values.
    """
    compiler = Element("compiler", dict(_COMPILER), urdf.element.span)
    for settings in urdf.element.all("mujoco"):
        own = settings.first("compiler")
        compiler.attributes |= {key: own.get(key) for key in _PASSED_ON if own is not None and key in own.attributes}
    root = Element("robot", {"name": name}, urdf.element.span)
    root.children.append(Element("mujoco", {}, urdf.element.span, [compiler]))
    named, masses = _colours(urdf), inertials(urdf, free=free, findings=findings)
    files = library.meshes(list(_meshes(urdf)), urdf.packages)
    for link in urdf.links.values():
        copied = Element("link", {"name": link.name}, link.element.span)
        if link.name in masses:
            copied.children.append(_copy(masses[link.name]))
        given = colours.get(link.name)
        otherwise = " ".join(map(repr, (*given, 1.0))) if given is not None else ""
        copied.children += _geoms(link, files, named, otherwise, findings)
        root.children.append(copied)
    root.children += [_copy(joint.element, _JOINT_PARTS) for joint in urdf.joints.values()]
    return root


def _copy(element: Element, parts: tuple[str, ...] = ()) -> Element:
    """Return a deep copy of an element. If `parts` is not empty, only children with these tags are copied."""
    children = [_copy(child) for child in element.children if not parts or child.tag in parts]
    return Element(element.tag, dict(element.attributes), element.span, children)


def _parts(link: UrdfLink) -> Iterator[tuple[int, Element, Element | None]]:
    """Yield index, element and shape of each collider and visual of a link; the index counts all children of the link."""
    for index, part in enumerate(link.element.children):
        if part.tag in ("collision", "visual"):
            yield index, part, shape_of(part)


def _meshes(urdf: Urdf) -> Iterator[tuple[Element, bool]]:
    """Yield each `mesh` element of a robot, and whether it belongs to a visual."""
    for link in urdf.links.values():
        for _, part, shape in _parts(link):
            if shape is not None and shape.tag == "mesh":
                yield shape, part.tag == "visual"


def _geoms(
    link: UrdfLink,
    files: Mapping[Element, Sequence[MeshFile]],
    colours: Mapping[str, str],
    otherwise: str,
    findings: Findings,
) -> Iterator[Element]:
    """Yield the colliders and visuals of a link for MuJoCo. A mesh with several colours is split into one part per colour."""
    for index, part, shape in _parts(link):
        meant: Sequence[MeshFile | None] = (None,)
        if shape is not None and shape.tag == "mesh":
            meant = files.get(shape, ())
        elif shape is not None and _is_nothing(shape):
            findings.add("N103", "a shape with a size of 0 is left out", shape.span)
            continue
        for number, file in enumerate(meant):
            geom = _geom(part, shape, file, colours, otherwise if part.tag == "visual" else "")
            geom.attributes["name"] = f"{link.name}.{index}.{number}"
            yield geom


def _is_nothing(shape: Element) -> bool:
    """Return whether a dimension of a shape is 0; some descriptions use such shapes as placeholders."""
    sizes = " ".join(shape.get(key, "1") for key in ("size", "radius", "length"))
    return 0.0 in (numbers(sizes, len(sizes.split())) or ())


def _geom(
    part: Element, shape: Element | None, file: MeshFile | None, colours: Mapping[str, str], otherwise: str
) -> Element:
    copied = Element(part.tag, {}, part.span, [_copy(origin) for origin in part.all("origin")])
    if shape is not None:
        geometry = Element(shape.tag, dict(shape.attributes), shape.span)
        if file is not None:
            geometry.attributes["filename"] = file.key
        copied.children.append(Element("geometry", {}, shape.span, [geometry]))
    material = part.first("material")
    colour = _own_colour(material) or colours.get(material.get("name"), "") if material is not None else ""
    if not colour and file is not None and file.colour is not None:
        colour = " ".join(map(repr, file.colour))
    colour = colour or otherwise
    if colour:
        # MuJoCo keeps the first of two materials of one name, so the colour is the name.
        span = material.span if material is not None else part.span
        element = Element("material", {"name": colour}, span, [Element("color", {"rgba": colour}, span)])
        copied.children.append(element)
    return copied


def _own_colour(material: Element) -> str:
    colour = material.first("color")
    return colour.get("rgba") if colour is not None else ""


def _colours(urdf: Urdf) -> dict[str, str]:
    """Return colours (four numbers as text) by material name. Materials of the robot element precede those of visuals."""
    root = urdf.element
    materials = [*root.all("material"), *(element for element in root.walk() if element.tag == "material")]
    found: dict[str, str] = {}
    for material in materials:
        if colour := _own_colour(material):
            found.setdefault(material.get("name"), colour)
    return found
