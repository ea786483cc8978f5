"""Converts an SDF world to MJCF: scenery, loose objects, actors, lights, gravity and the place on Earth.

A static model becomes fixed bodies; any other model without moving joints becomes free bodies. A model with moving joints is
treated as a robot: it is left out with a warning, because robots must be listed in the scene file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.sdf.sdf_actors import actors_at
from graphengine.descriptions.sdf.sdf_earth import earth_at
from graphengine.descriptions.sdf.sdf_files import SdfFiles
from graphengine.descriptions.sdf.sdf_frames import Scope, SdfFrame
from graphengine.descriptions.sdf.sdf_geoms import GeomWriter
from graphengine.descriptions.sdf.sdf_inertia import mass_of, turned
from graphengine.descriptions.sdf.sdf_joints import fastened, is_moving
from graphengine.descriptions.sdf.sdf_lights import ambient_and_background, light_of
from graphengine.descriptions.sdf.sdf_shapes import textured
from graphengine.descriptions.sdf.sdf_values import SdfError, numbers_at, reported
from graphengine.descriptions.worlds.mesh_pieces import MeshPieces
from graphengine.descriptions.worlds.mjcf_elements import placed, world_element, written
from graphengine.devices.rotation import Pose, relative, to_rpy
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import listing, printable, quoted

_GRAVITY = (0.0, 0.0, -9.8)
"""SDF's default gravity, m/s2."""
_CONVERTED = ("model", "include", "light", "gravity", "frame", "scene", "spherical_coordinates", "actor")
_LEFT_OUT = "it has moving joints, so it is a robot, and robots must be listed in the scene"


def read_world(path: Path, root: Element, library: Library, findings: Findings) -> Element | None:
    """Convert the world of an SDF file to MJCF; return its root element, or None after an error.

    Args:
        path: path of the file.
        root: root element of the file.
        library: reads mesh files, and keeps them under the keys to which the MJCF refers.
        findings: receives errors, warnings and notes.
    """
    before = len(findings.errors)
    made: Element | None = None
    with reported(findings, "S102"):
        packages = Packages(path.parent, (), library.files)
        files = SdfFiles(packages, findings)
        file = files.main(path, root)
        worlds = root.all("world")
        if len(worlds) != 1:
            advice = "to use a model as a robot or object, write robots: {NAME: {use: FILE}}"
            text = f"the file of a world must contain one <world>, not {len(worlds)}"
            raise SdfError(text, root.span, advice if root.all("model") else "")
        writer = GeomWriter(library, findings, MeshPieces(library, findings))
        made = _WorldWriter(files.scope(worlds[0], file), writer, findings, path).mjcf(packages)
    return made if len(findings.errors) == before else None


@dataclass(frozen=True, slots=True)
class _WorldWriter:
    """Converts one SDF world to MJCF."""

    world: Scope
    writer: GeomWriter
    findings: Findings
    path: Path

    def mjcf(self, packages: Packages) -> Element:
        """Return the root element of the MJCF world; errors are added to `findings`."""
        span, element = self.world.element.span, self.world.element
        scopes = (self.world, *self.world.merges)
        scenery = [model for scope in scopes for model in scope.models.values() if not self._is_robot(model)]
        self.writer.load_meshes((link for model in scenery for link in model.all_links()), packages)
        body = Element("worldbody", {}, span)
        for light in element.all("light"):
            with reported(self.findings, "S102"):
                body.children.append(light_of(light, self.world.frame))
        for model in scenery:
            with reported(self.findings, "S102"):
                body.children += self._bodies(model)
        meshes = [mesh for made in self.writer.pieces.assets.values() for mesh in made]
        others = [*earth_at(element, self.findings), *actors_at(element, self.findings)]
        look = ambient_and_background(element)
        self._tell_unused(scenery)
        x, y, z = numbers_at(element, "gravity", default=_GRAVITY)
        return world_element(self.world.name, (x, y, z), meshes, body, others, *look)

    def _is_robot(self, model: Scope) -> bool:
        """Return whether a model must be used as a robot; if so, add a warning that explains how."""
        if model.static or not any(map(is_moving, model.all_joints())):
            return False
        where = ""
        with reported(self.findings, "S102"):
            (x, y, z), rotation = _root(model).place
            where = f"position: [{x:.6g}, {y:.6g}, {z:.6g}]"
            angles = [round(math.degrees(angle), 6) + 0.0 for angle in to_rpy(rotation)]
            if any(angles):
                where += f", orientation: {{rpy_deg: [{', '.join(f'{angle:.6g}' for angle in angles)}]}}"
        name = printable(model.name)
        command = f"graphrun import-robot {quoted(self.path)} --model {quoted(name)} -o robots/NAME.yaml"
        addition = f"and add to the scene: robots: {{NAME: {{use: robots/NAME.yaml, {where}}}}}"
        text = f"model {name!r} is left out: {_LEFT_OUT}"
        self.findings.add("W302", text, model.element.span, f"create a robot file: {command}", addition)
        return True

    def _bodies(self, model: Scope) -> Iterator[Element]:
        """Yield the MJCF bodies of a model: fixed bodies if it is static, else one body for each rigid group of links.

        The body of a rigid group can move freely unless a joint fixes the group to the world.
        """
        links = model.all_links()
        if model.static and len(links) != 1:
            frame = Element("body", placed(model.frame.place, name=model.name), model.element.span)
            frame.children += [self._body(link, model, model.frame.place) for link in links]
            yield frame
            return
        for (first, *others), bolted in _rigid(model, links):
            fixed = bolted or model.static
            body = self._body(first, model, None, model.name if len(links) == 1 else "")
            body.children[:0] = [] if fixed else [Element("freejoint", {}, first.element.span), _inertial(first)]
            for link in others:
                made = self._body(link, model, first.place)
                made.children[:0] = [] if fixed else [_inertial(link)]
                body.children.append(made)
            yield body

    def _body(self, link: SdfFrame, model: Scope, parent: Pose | None, name: str = "") -> Element:
        """Return the MJCF body of a link with its geoms.

        Args:
            link: frame of the SDF link.
            model: model that contains the link.
            parent: pose of the parent body in the world; None if the body belongs directly to the world.
            name: name of the body, by default composed from model and link.
        """
        place = relative(parent, link.place) if parent is not None else link.place
        values = placed(place, name=name or f"{model.name}::{link.full_name}")
        return Element("body", values, link.element.span, self.writer.geoms(link, static=model.static))

    def _tell_unused(self, models: list[Scope]) -> None:
        element = self.world.element
        if tags := dict.fromkeys(child.tag for child in element.children if child.tag not in _CONVERTED):
            text = "only models, actors, lights, gravity and the place on Earth of the world are used"
            self.findings.add("N103", text, element.span, listing(map(printable, tags), "not used"))
        visuals = (visual for model in models for link in model.all_links() for visual in link.element.all("visual"))
        if image := next(filter(textured, visuals), None):
            self.findings.add("N103", "textures of visuals are not drawn; their diffuse colours are used", image.span)


def _root(model: Scope) -> SdfFrame:
    """Return the first link of a model that is not the child of a joint, by default the frame of the model."""
    carried = {fastened(joint)[1] for joint in model.all_joints()}
    return next((link for link in model.all_links() if link not in carried), model.frame)


def _rigid(model: Scope, links: list[SdfFrame]) -> Iterator[tuple[list[SdfFrame], bool]]:
    """Yield each group of links that joints connect, in order of the links, and whether a joint fixes it to the world.

    Moving joints are treated like fixed joints.
    """
    groups = {link: [link] for link in links}
    bolted: set[SdfFrame] = set()
    for joint in model.all_joints():
        parent, child = fastened(joint)
        if parent is None:
            bolted.add(child)
            continue
        smaller, larger = sorted((groups[parent], groups[child]), key=len)
        if smaller is not larger:
            larger += smaller
            groups.update((link, larger) for link in smaller)
    order = {link: number for number, link in enumerate(links)}
    for group in {id(group): group for group in groups.values()}.values():
        yield sorted(group, key=order.__getitem__), not bolted.isdisjoint(group)


def _inertial(link: SdfFrame) -> Element:
    mass = mass_of(link)
    centre, rotation = relative(link.place, mass.pose)
    values = {"pos": written(*centre), "mass": written(mass.mass)}
    values["fullinertia"] = written(*turned(mass.moments, rotation))
    return Element("inertial", values, link.element.span)
