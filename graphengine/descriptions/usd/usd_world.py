"""Converts a USD stage to the MJCF of a world: scenery, loose objects, lights, cameras and gravity.

Shapes that belong to no rigid body stand still, bodies that joints do not move against each other are free bodies. Bodies with
moving joints are robots, which must be listed in the scene.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.descriptions.engine import PICTURES, RAYS
from graphengine.descriptions.files.contained_meshes import contained
from graphengine.descriptions.files.mesh_file import MeshFile
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.shapes import Mesh, sizes_of
from graphengine.descriptions.usd.articulations import Articulation, articulations
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd.stage_files import StageChoice
from graphengine.descriptions.usd.usd_links import geometry_of, named
from graphengine.descriptions.usd.usd_masses import inertial_of
from graphengine.descriptions.usd.usd_reader import meshes_of, read_physics
from graphengine.descriptions.usd_model import PhysicsContents, StageBody, StageShape
from graphengine.descriptions.worlds.mesh_pieces import MeshPieces
from graphengine.descriptions.worlds.mjcf_elements import AMBIENT, placed, world_element, written
from graphengine.devices.rotation import NOWHERE, Pose, relative, rotate
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.prim_paths import at_or_below
from graphengine.format.wording import listing, printable, quoted

_GRAVITY = (0.0, 0.0, -9.81)
_GREY = (0.7, 0.7, 0.7, 1.0)
_FRICTION = 0.5
"""Friction of a PhysX collider without a material."""
_ROUND = 0.01
"""Moments of inertia of a body of 1 kg whose stage gives no shape, kg m2."""
_BRIGHTNESS = 0.7
"""Brightness of all lights together, because those of a stage suit the exposure of a camera."""


def read_usd_world(path: Path, library: Library, robots: Collection[str], choice: StageChoice) -> Element | None:
    """Convert the world of a stage to MJCF; return its root element, or None after an error.

    Args:
        path: path of the stage.
        library: receives the meshes, and has the findings.
        robots: prim paths of the robots of the scene, which are not missing in the world.
        choice: variants, and places of assets.
    """
    contents = read_physics(path, library.files, library.findings, choice)
    if contents is None:
        return None
    spans = PrimSpans(path)
    writer = _WorldWriter(contents, spans, library, MeshPieces(library, library.findings))
    for tree in articulations(contents):
        if tree.moves and not any(at_or_below(robot, tree.prim) for robot in robots):
            _tell_robot(tree, contents, spans.of(tree.prim), path, library.findings)
    return writer.mjcf(path.stem)


def world_names(contents: PhysicsContents) -> dict[str, str]:
    """Return the names of the loose and fixed bodies of a world, by path of their prim."""
    return named(path for tree in articulations(contents) if not tree.moves for path in tree.bodies if path)


def _tell_robot(tree: Articulation, contents: PhysicsContents, span: Span, path: Path, findings: Findings) -> None:
    x, y, z = contents.bodies[tree.root].pose[0] if tree.root else (0.0, 0.0, 0.0)
    prim = printable(tree.prim)
    findings.add(
        "W302",
        f"{prim} is left out: it has moving joints, so it is a robot, and robots must be listed in the scene",
        span,
        f"make a project of the whole stage: graphrun new DIR --from {quoted(path)}",
        f"or add its robot file to the scene: robots: {{NAME: {{use: FILE, at: {prim}, position: [{x:g}, {y:g}, {z:g}]}}}}",
    )


def _stands(tree: Articulation, bodies: Iterable[StageBody]) -> bool:
    """Return whether a group of bodies stands still."""
    return not tree.root or tree.holder is not None or any(body.kinematic for body in bodies)


@dataclass(slots=True)
class _WorldWriter:
    """Converts the parts of one stage to MJCF."""

    contents: PhysicsContents
    spans: PrimSpans
    library: Library
    pieces: MeshPieces
    _names: list[str] = field(default_factory=list)
    _data: list[bytes] = field(default_factory=list)
    _meshes: dict[tuple[str, bool], tuple[Mesh, list[MeshFile]]] = field(default_factory=dict)
    """Mesh and mesh files for each name of a mesh, and whether it is a visual."""

    def mjcf(self, name: str) -> Element:
        """Return the root element of the MJCF world."""
        contents = self.contents
        self._names, self._data = meshes_of(contents)
        groups = [tree for tree in articulations(contents) if not tree.moves and self._is_solid(tree)]
        body = Element("worldbody", {}, self.spans.start)
        lamps, ambient = self._lights()
        body.children += [*lamps, *self._cameras(), *self._geoms(contents.shapes, NOWHERE, fixed=True)]
        names = world_names(contents)
        body.children += [made for tree in groups for made in self._bodies(tree, names)]
        self._tell_unused(groups)
        meshes = [mesh for made in self.pieces.assets.values() for mesh in made]
        return world_element(name, contents.gravity or _GRAVITY, meshes, body, ambient=ambient)

    def _is_solid(self, tree: Articulation) -> bool:
        """Return whether a group of bodies has colliders, or does not move; if not, it would fall forever."""
        bodies = [self.contents.bodies[path] for path in tree.bodies if path]
        solid = _stands(tree, bodies) or any(shape.solid for body in bodies for shape in body.shapes)
        if not solid:
            self._lose(tree.root, "without colliders it would fall forever")
        return solid

    def _bodies(self, tree: Articulation, names: Mapping[str, str]) -> Iterator[Element]:
        """Yield the MJCF bodies of a group: fixed bodies, or one free body that carries the others."""
        bodies = [self.contents.bodies[path] for path in tree.bodies if path]
        fixed = _stands(tree, bodies)
        first: Element | None = None
        for body in bodies:
            parent = bodies[0].pose if first is not None else NOWHERE
            values = placed(relative(parent, body.pose), name=names[body.path])
            made = Element("body", values, self.spans.of(body.path))
            made.children = [] if fixed else self._inertia(body, free=first is None)
            made.children += self._geoms(body.shapes, body.pose, fixed=fixed)
            if fixed:
                yield made
            elif first is None:
                first = made
            else:
                first.children.append(made)
        if first is not None:
            yield first

    def _inertia(self, body: StageBody, *, free: bool) -> list[Element]:
        """Return the joint of a free body, and its inertia if it has one."""
        span = self.spans.of(body.path)
        made = [Element("freejoint", {}, span)] if free else []
        inertial = inertial_of(body, NOWHERE, self._data)
        if inertial is not None:
            moments = inertial.moments or (inertial.mass * _ROUND,) * 3
            values = placed(inertial.pose, mass=written(inertial.mass), diaginertia=written(*moments[:3]))
            made.append(Element("inertial", values, span))
        return made

    def _geoms(self, shapes: Iterable[StageShape], frame: Pose, *, fixed: bool) -> list[Element]:
        return [geom for shape in shapes for geom in self._geom(shape, frame, fixed=fixed)]

    def _geom(self, shape: StageShape, frame: Pose, *, fixed: bool) -> Iterator[Element]:
        """Yield the geoms of a shape; several for a concave mesh that stands still."""
        span = self.spans.of(shape.path)
        geometry = geometry_of(shape, self._names, span)
        sizes = sizes_of(geometry) if geometry is not None else (0.0, 0.0, 1.0)
        if 0.0 in sizes and geometry is not None:
            self._lose(shape.path, "it has no volume")
            return
        if geometry is None and not fixed:
            self._lose(shape.path, "an endless plane must stand still")
            return
        values = placed(relative(frame, shape.pose), rgba=written(*(shape.colour or _GREY)))
        if shape.solid:
            material = self.contents.materials.get(shape.material)
            values["friction"] = f"{written(material.dynamic_friction if material else _FRICTION)} 0.005 0.0001"
            values["group"] = str(RAYS)
        else:
            values |= {"contype": "0", "conaffinity": "0", "group": str(PICTURES), "mass": "0"}
        if not isinstance(geometry, Mesh):
            kind = {"type": shape.kind, "size": written(*sizes)}
            yield Element("geom", values | kind, span)
            return
        exact = fixed and shape.solid and shape.approximation != "convexHull"
        mesh, files = self._mesh(geometry, visual=not shape.solid)
        for file in files:
            for piece in self.pieces.of(file, mesh, exact=exact):
                yield Element("geom", values | {"type": "mesh", "mesh": piece.get("name")}, span)

    def _mesh(self, mesh: Mesh, *, visual: bool) -> tuple[Mesh, list[MeshFile]]:
        key = (mesh.filename, visual)
        if key not in self._meshes:
            data = {mesh.filename: self._data[self._names.index(mesh.filename)]}
            self._meshes[key] = mesh, contained([(mesh.element, visual)], data, self.library)[mesh.element]
        return self._meshes[key]

    def _lights(self) -> tuple[list[Element], str]:
        """Return the lights that have a place or direction, and the colour of the ambient light."""
        lamps, domes = (
            [light for light in self.contents.lights if (light.kind == "ambient") == ambient]
            for ambient in (False, True)
        )
        made: list[Element] = []
        names = named(light.path for light in lamps)
        for light in lamps:
            position, orientation = light.pose
            values = {"name": names[light.path], "type": light.kind, "pos": written(*position)}
            values["dir"] = written(*rotate(orientation, (0.0, 0.0, -1.0)))
            values["diffuse"] = written(*(min(max(part, 0.0), 1.0) * _BRIGHTNESS / len(lamps) for part in light.colour))
            values["castshadow"] = str(not made).lower()
            made.append(Element("light", values, self.spans.of(light.path)))
        ambient = written(*(min(max(part, 0.0), 1.0) * 0.4 for part in domes[0].colour)) if domes else AMBIENT
        return made, ambient

    def _cameras(self) -> Iterator[Element]:
        cameras = {each.path: each for each in self.contents.sensors if each.type == "camera" and not each.body}
        for path, name in named(cameras).items():
            camera = cameras[path]
            if camera.focal > 0 < camera.aperture[1]:
                high = math.degrees(2 * math.atan(camera.aperture[1] / (2 * camera.focal)))
                yield Element("camera", placed(camera.pose, name=name, fovy=written(high)), self.spans.of(path))

    def _tell_unused(self, groups: Iterable[Articulation]) -> None:
        bodies = {path for tree in groups for path in tree.bodies}
        for sensor in self.contents.sensors:
            if sensor.body in bodies or (not sensor.body and sensor.type != "camera"):
                self._lose(sensor.path, f"the {sensor.type} belongs to no robot")
        for tree in groups:
            for joint in [*(each.joint for each in tree.joints), *tree.loops]:
                if joint.kind != "fixed":
                    self._lose(
                        joint.path, f"{joint.kind} joints are not simulated, and its bodies are rigidly connected"
                    )
        lost = [path for path, material in self.contents.materials.items() if material.combine != "average"]
        used = {shape.material for shape in self.contents.shapes}
        if lost := [path for path in lost if path in used]:
            text = "combine modes of physics materials of the world have no effect: robots choose their own"
            names = listing(map(printable, lost), "materials")
            self.library.findings.add("N103", text, self.spans.of(lost[0]), names)

    def _lose(self, path: str, why: str) -> None:
        self.library.findings.add("W302", f"{printable(path)} is left out: {why}", self.spans.of(path))
