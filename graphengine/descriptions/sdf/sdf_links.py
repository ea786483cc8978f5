"""Reads the links of SDF models, and writes `<gazebo>` elements for properties that URDF lacks.

As in URDF, the frame of a link is the frame of its parent joint, so all poses in an SDF link are converted to that frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.robot_description import Link
from graphengine.descriptions.sdf.sdf_frames import SdfFrame, place_of
from graphengine.descriptions.sdf.sdf_inertia import inertial_of, is_mere_frame
from graphengine.descriptions.sdf.sdf_shapes import colour_of, mesh_of, shape_of, solid_of, surface_for_gazebo, textured
from graphengine.descriptions.sdf.sdf_values import SdfError, find, flag_at, leaf, reported, seen_from, text_at
from graphengine.descriptions.shapes import Geometry, Shape
from graphengine.descriptions.worlds.mjcf_elements import written
from graphengine.devices.rotation import NOWHERE, Pose, to_rpy
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import printable

_CONVERTED = ("pose", "inertial", "collision", "visual", "sensor", "gravity", "self_collide")
_NO_EFFECT = ("must_be_base_link", "enable_wind", "velocity_decay", "kinematic", "frame")


@dataclass(slots=True)
class LinkReader:
    """Reads the links of one model.

    Attributes:
        frames: a dict from SDF links to the pose of the link's frame in the description, in the outermost scope.
        findings: receives errors and notes.
        images: visuals with textures, among those read; the textures are not drawn.
        mere_frames: links with neither inertial nor shapes, among those read.
    """

    frames: Mapping[SdfFrame, Pose]
    findings: Findings
    images: list[Element] = field(default_factory=list)
    mere_frames: list[SdfFrame] = field(default_factory=list)

    def link(self, link: SdfFrame) -> Link:
        """Return an SDF link as a link of a robot; errors are added to `findings`."""
        shapes: list[Shape] = []
        made = Link(link.full_name, Element("link", {"name": link.full_name}, link.element.span), None, shapes)
        if is_mere_frame(link):
            self.mere_frames.append(link)
            return made
        with reported(self.findings):
            made.inertial = inertial_of(link, self.frames[link])
        for part in link.element.children:
            if part.tag in ("collision", "visual"):
                with reported(self.findings):
                    shape = self._shape(part, link, f"{made.name}.{len(shapes) + 1}")
                    shapes += [shape] if shape is not None else []
        return made

    def _shape(self, part: Element, link: SdfFrame, name: str) -> Shape | None:
        """Return the shape of a collision or visual; None for a visual that cannot be drawn, after adding a note."""
        try:
            shape = shape_of(part)
            geometry = self._geometry(part, shape, link) if shape is not None else None
        except SdfError as error:
            if part.tag == "collision":
                raise
            self.findings.add("N103", f"not drawn: {error.message}", error.span, *error.help)
            return None
        if shape is None or geometry is None:
            return None
        pose, visual = seen_from(self.frames[link], place_of(part, link)), part.tag == "visual"
        element = Element(part.tag, {"name": part.get("name")}, part.span)
        self.images += [part] if visual and textured(part) else []
        return Shape(name, visual, geometry, pose, colour_of(part) if visual else None, element, shape.span)

    def _geometry(self, part: Element, shape: Element, link: SdfFrame) -> Geometry:
        if shape.tag == "mesh":
            return mesh_of(shape, link.scope.references, self.findings)
        if (solid := solid_of(shape)) is not None:
            return solid
        text = f"{part.tag} {printable(part.get('name'))!r}: a link of a robot cannot have the shape {shape.tag!r}"
        raise SdfError(text, shape.span, "write a sphere or a mesh" if shape.tag == "ellipsoid" else "write a box")

    def for_gazebo(self, link: SdfFrame) -> Element:
        """Return a `<gazebo>` element with the properties of a link that URDF lacks."""
        made = Element("gazebo", {"reference": link.full_name}, link.element.span)
        with reported(self.findings):
            made.children += surface_for_gazebo(link, self.frames)
        for tag, name in (("gravity", "gravity"), ("self_collide", "selfCollide")):
            if (value := flag_at(link.element, tag)) is not None:
                made.children.append(leaf(name, str(value).lower(), link.element.span))
        made.children += _scripted_colour(link.element)
        for child in link.element.children:
            if child.tag == "sensor":
                with reported(self.findings):
                    made.children.append(self._sensor(child, link))
            elif child.tag not in (*_CONVERTED, *_NO_EFFECT):
                made.children.append(child)
        return made

    def _sensor(self, sensor: Element, link: SdfFrame) -> Element:
        """Return a copy of a `<sensor>` with its pose in the frame of the URDF link."""
        pose = seen_from(self.frames[link], place_of(sensor, link))
        children = [child for child in sensor.children if child.tag != "pose"]
        if pose != NOWHERE:
            given = sensor.first("pose")
            span = given.span if given is not None else sensor.span
            children.insert(0, leaf("pose", written(*pose[0], *to_rpy(pose[1])), span))
        return Element("sensor", dict(sensor.attributes), sensor.span, children, sensor.text)


def _scripted_colour(link: Element) -> Iterator[Element]:
    """Yield a `<visual>` with the material script of a link's first visual that has such a script and no colour.

    A material script names one of Gazebo's materials, e.g. `Gazebo/Red`.
    """
    for visual in link.all("visual"):
        script = find(visual, "material", "script")
        if script is not None and text_at(script, "name") and colour_of(visual) is None:
            name = leaf("name", text_at(script, "name"), script.span)
            inside = Element("material", {}, script.span, [Element("script", {}, script.span, [name])])
            yield Element("visual", {}, visual.span, [inside])
            return
