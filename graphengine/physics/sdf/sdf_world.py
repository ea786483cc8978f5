"""Converts a world of SDF to MJCF: scenery, loose objects, lights and gravity.

A static model becomes bodies that do not move, any other without moving joints becomes bodies that do. A model with joints that
move is a robot, which a scene names itself: it is left out with a warning.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.devices.rotation import Pose, Quaternion, Vector3, multiply, relative, rotate
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing, printable
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.references import Library, MeshFile
from graphengine.physics.files.xml import Element, numbers
from graphengine.physics.sdf.sdf_files import SdfFiles
from graphengine.physics.sdf.sdf_frames import Frame, Scope, place_of
from graphengine.physics.sdf.sdf_inertia import mass_of, turned
from graphengine.physics.sdf.sdf_joints import fastened, is_moving
from graphengine.physics.sdf.sdf_shapes import colour_of, friction_of, shape_of, textured, urdf_mesh
from graphengine.physics.sdf.sdf_values import (
    SdfError,
    flag_at,
    number_at,
    numbers_at,
    reported,
    text_at,
    to_rpy,
    written,
)

_PICTURES, _RAYS = "2", "3"
"""Groups of geoms: of visuals before a collider, and of colliders behind visuals."""
_GREY = (0.7, 0.7, 0.7, 1.0)
_GRAVITY = (0.0, 0.0, -9.8)
"""That of SDF, m/s2."""
_UP: Vector3 = (0.0, 0.0, 1.0)
_CONVERTED = ("model", "include", "light", "gravity", "frame", "scene")
_LEFT_OUT = "a model with joints that move is a robot: this world leaves it out"


def read_world(path: Path, root: Element, library: Library, findings: Findings) -> Element | None:
    """Return the world of an SDF file as MJCF whose files are in the library; errors are added to `findings`.

    Args:
        path: of the file.
        root: of the file, parsed.
        library: reads meshes.
        findings: receives errors and notes.
    """
    before = len(findings.errors)
    made: Element | None = None
    with reported(findings, "S102"):
        packages = Packages(path.parent, (), library.files)
        files = SdfFiles(packages, findings)
        file = files.main(path, root)
        worlds = root.all("world")
        if len(worlds) != 1:
            advice = "use a model as a robot or an object: robots: {NAME: {use: FILE}}" if root.all("model") else ""
            raise SdfError(f"a world is a file with one <world>, not {len(worlds)}", root.span, *filter(None, [advice]))
        world = files.scope(worlds[0], file)
        made = _WorldWriter(world, library, packages, findings, path).mjcf()
    return made if len(findings.errors) == before else None


@dataclass(slots=True)
class _WorldWriter:
    """Writes a world as MJCF."""

    world: Scope
    library: Library
    packages: Packages
    findings: Findings
    path: Path
    meshes: dict[Element, Element] = field(default_factory=dict)
    """URDF's `<mesh>` of each mesh of a collision or visual."""
    files: Mapping[Element, list[MeshFile]] = field(default_factory=dict)
    assets: dict[tuple[str, str], Element] = field(default_factory=dict)
    """Meshes of MJCF by key of the file and scale."""

    def mjcf(self) -> Element:
        """Return the whole world."""
        span, world = self.world.element.span, self.world
        models = [model for scope in (world, *world.merges) for model in scope.models.values()]
        scenery = [model for model in models if not self._is_robot(model)]
        self._load_meshes(scenery)
        body = Element("worldbody", {}, span)
        body.children += [made for light in world.element.all("light") if (made := self._light(light)) is not None]
        for model in scenery:
            with reported(self.findings, "S102"):
                body.children += self._bodies(model)
        gravity = written(*numbers_at(world.element, "gravity", default=_GRAVITY))
        compiler = {"angle": "radian", "autolimits": "true", "balanceinertia": "true"}
        asset = Element("asset", {}, span, [_sky(world.element), *self.assets.values()])
        parts = [
            Element("compiler", compiler, span),
            Element("option", {"gravity": gravity}, span),
            Element("statistic", {"extent": "1", "center": "0 0 0.5", "meansize": "0.2"}, span),
            _look(world.element),
            asset,
            body,
        ]
        self._tell_unused()
        return Element("mujoco", {"model": world.name or "world"}, span, parts)

    def _is_robot(self, model: Scope) -> bool:
        """Return whether a model is to be used as a robot, with a warning on how."""
        joints = [joint for scope in model.walk() for joint in scope.joints.values() if is_moving(joint)]
        if model.static or not joints:
            return False
        where = "its place is unknown"
        with reported(self.findings, "S102"):
            (x, y, z), rotation = _root(model).place
            where = f"position: [{x:.6g}, {y:.6g}, {z:.6g}]"
            angles = [math.degrees(angle) for angle in to_rpy(rotation)]
            if any(abs(angle) > 1e-6 for angle in angles):
                where += f", orientation: {{rpy_deg: [{', '.join(f'{angle:.6g}' for angle in angles)}]}}"
        name = printable(model.name)
        self.findings.add(
            "W302",
            f"model {name!r}: {_LEFT_OUT}",
            model.element.span,
            f"make a robot file: graphrun import-urdf {self.path.name} --model {name} -o robots/NAME.yaml",
            f"and add it to the scene: robots: {{NAME: {{use: robots/NAME.yaml, {where}}}}}",
        )
        return True

    def _load_meshes(self, models: list[Scope]) -> None:
        shapes: list[tuple[Element, bool]] = []
        for link in (link for model in models for scope in model.walk() for link in scope.links.values()):
            for part in (each for each in link.element.children if each.tag in ("collision", "visual")):
                with reported(self.findings, "S102"):
                    shape = _drawable(part, self.findings)
                    if shape is not None and shape.tag == "mesh":
                        self.meshes[shape] = urdf_mesh(shape, link.scope.references, self.findings)
                        shapes.append((self.meshes[shape], part.tag == "visual"))
        self.files = self.library.meshes(shapes, self.packages)

    def _bodies(self, model: Scope) -> Iterator[Element]:
        """Yield the bodies of a model: one without a joint if it is static, else one that moves for each rigid group of links."""
        links = [link for scope in model.walk() for link in scope.links.values()]
        if model.static:
            frame = Element("body", _placed(model.frame.place, name=model.name), model.element.span)
            frame.children += [self._body(link, model, model.frame.place, alone=False) for link in links]
            yield frame
            return
        for group, bolted in _rigid(model, links):
            first, *others = group
            body = self._body(first, model, None, alone=len(links) == 1)
            if not bolted:
                body.children[:0] = [Element("freejoint", {}, first.element.span), _inertial(first)]
            for link in others:
                made = self._body(link, model, first.place, alone=False)
                body.children.append(made)
                made.children[:0] = [] if bolted else [_inertial(link)]
            yield body

    def _body(self, link: Frame, model: Scope, parent: Pose | None, *, alone: bool) -> Element:
        """Return the body of a link with its geoms; in a frame of the world, or in the world."""
        name = model.name if alone else f"{model.name}::{link.full_name}"
        place = relative(parent, link.place) if parent is not None else link.place
        body = Element("body", _placed(place, name=name), link.element.span)
        geoms: dict[str, list[Element]] = {"collision": [], "visual": []}
        for part in link.element.children:
            if part.tag in geoms:
                with reported(self.findings, "S102"):
                    geoms[part.tag] += self._geoms(part, link, link.place, model)
        floors = [geom for geom in geoms["collision"] if geom.get("type") == "plane"]
        plates = [geom for geom in geoms["visual"] if geom.get("type") == "plane"]
        if floors:  # one plane is both: two in one place would flicker
            geoms["visual"] = [geom for geom in geoms["visual"] if geom not in plates]
            floors[0].attributes |= {key: geom.get(key) for geom in plates[:1] for key in ("rgba",)}
        for geom in geoms["collision"]:
            geom.attributes["group"] = _RAYS if geoms["visual"] and geom not in floors else "0"
        body.children += [*geoms["collision"], *geoms["visual"]]
        return body

    def _geoms(self, part: Element, link: Frame, frame: Pose, model: Scope) -> Iterator[Element]:
        """Yield a collision or a visual; a mesh of several colours gives one geom for each."""
        shape = _drawable(part, None)
        if shape is None:
            return
        pose = relative(frame, place_of(part, link))
        if shape.tag == "plane" and not model.static:
            raise SdfError("a plane must belong to a static model", shape.span, "write <static>true</static>")
        if shape.tag == "plane":
            pose = (pose[0], multiply(pose[1], _towards(shape)))
        colour = colour_of(part) or _GREY
        made = Element("geom", _placed(pose) | _size(shape, part) | {"rgba": written(*colour)}, part.span)
        if part.tag == "visual":
            made.attributes |= {"contype": "0", "conaffinity": "0", "group": _PICTURES, "mass": "0"}
        elif (friction := friction_of(part)) is not None:
            made.attributes["friction"] = f"{written(friction)} 0.005 0.0001"
        if shape.tag != "mesh":
            yield made
            return
        for file in self.files.get(self.meshes[shape], ()) if shape in self.meshes else ():
            own = colour_of(part) is None and file.colour is not None
            look = {"rgba": written(*file.colour)} if own and file.colour is not None else {}
            mesh = self._asset(file, self.meshes[shape])
            yield Element("geom", made.attributes | {"mesh": mesh} | look, part.span)

    def _asset(self, file: MeshFile, mesh: Element) -> str:
        key = (file.key, mesh.get("scale", "1 1 1"))
        if key not in self.assets:
            attributes = {"name": f"mesh_{len(self.assets)}", "file": file.key, "scale": key[1], "inertia": "shell"}
            self.assets[key] = Element("mesh", attributes, mesh.span)
        return self.assets[key].get("name")

    def _light(self, light: Element) -> Element | None:
        with reported(self.findings, "S102"):
            return _light(light, self.world.frame)
        return None

    def _tell_unused(self) -> None:
        tags = dict.fromkeys(child.tag for child in self.world.element.children if child.tag not in _CONVERTED)
        if tags:
            what = listing(map(printable, tags), "of the world, not used")
            self.findings.add("N103", "the scene file has physics, plugins and more", self.world.element.span, what)
        scopes = [scope for scope in self.world.walk() if not scope.is_world]
        visuals = [visual for scope in scopes for link in scope.links.values() for visual in link.element.all("visual")]
        if images := [visual for visual in visuals if textured(visual)]:
            self.findings.add("N103", "images on visuals are not drawn; their diffuse colours are", images[0].span)


def _drawable(part: Element, findings: Findings | None) -> Element | None:
    """Return the shape of a collision or visual; None for a visual that cannot be drawn, with a note if `findings` is given."""
    try:
        return shape_of(part)
    except SdfError as error:
        if part.tag == "collision":
            raise
        if findings is not None:
            findings.add("N103", f"not drawn: {error.message}", error.span, *error.help)
        return None


def _root(model: Scope) -> Frame:
    """Return the link of a robot that no joint carries."""
    links = [link for scope in model.walk() for link in scope.links.values()]
    carried = {fastened(joint)[1] for scope in model.walk() for joint in scope.joints.values()}
    return next((link for link in links if link not in carried), model.frame)


def _rigid(model: Scope, links: list[Frame]) -> Iterator[tuple[list[Frame], bool]]:
    """Yield the links of a model in groups that joints hold together, and whether they are fixed to the world."""
    group = {link: {link} for link in links}
    bolted: set[Frame] = set()
    for joint in (joint for scope in model.walk() for joint in scope.joints.values()):
        parent, child = fastened(joint)
        if parent is None:
            bolted.add(child)
        elif group[parent] is not group[child]:
            group[parent] |= group[child]
            for link in group[child]:
                group[link] = group[parent]
    for link in links:
        members = [each for each in links if each in group[link]]
        if members[0] is link:
            yield members, bool(bolted.intersection(members))


def _inertial(link: Frame) -> Element:
    mass = mass_of(link)
    centre, rotation = relative(link.place, mass.pose)
    values = {
        "pos": written(*centre),
        "mass": written(mass.mass),
        "fullinertia": written(*turned(mass.moments, rotation)),
    }
    return Element("inertial", values, link.element.span)


def _placed(pose: Pose, **more: str) -> dict[str, str]:
    """Return a pose as attributes of MJCF, after others."""
    x, y, z, w = pose[1]
    return {**more, "pos": written(*pose[0]), "quat": written(w, x, y, z)}


def _size(shape: Element, part: Element) -> dict[str, str]:
    """Return type and size of a shape as attributes of MJCF."""
    if shape.tag == "box":
        return _geom("box", *(side / 2.0 for side in numbers_at(shape, "size", default=(1.0, 1.0, 1.0))))
    if shape.tag == "sphere":
        return _geom("sphere", number_at(shape, "radius", default=1.0))
    if shape.tag in ("cylinder", "capsule"):
        radius, length = number_at(shape, "radius", default=0.5), number_at(shape, "length", default=1.0)
        return _geom(shape.tag, radius, length / 2.0)
    if shape.tag == "ellipsoid":
        return _geom("ellipsoid", *numbers_at(shape, "radii", default=(1.0, 1.0, 1.0)))
    if shape.tag == "plane":
        width, length = numbers_at(shape, "size", default=(1.0, 1.0)) if part.tag == "visual" else (0.0, 0.0)
        return _geom("plane", width / 2.0, length / 2.0, 1.0)
    return {"type": "mesh"}


def _geom(kind: str, *size: float) -> dict[str, str]:
    return {"type": kind, "size": written(*size)}


def _towards(plane: Element) -> Quaternion:
    """Return the rotation of the z axis to a plane's normal."""
    x, y, z = numbers_at(plane, "normal", default=_UP)
    length = math.hypot(x, y, z)
    if not length:
        raise SdfError("the normal of a plane has a direction", plane.span)
    x, y, z = x / length, y / length, z / length
    if z < -1.0 + 1e-12:
        return 1.0, 0.0, 0.0, 0.0
    scale = math.sqrt(2.0 * (1.0 + z))
    return -y / scale, x / scale, 0.0, scale / 2.0


def _light(light: Element, frame: Frame) -> Element:
    """Return a light of the world."""
    position, rotation = place_of(light, frame)
    x, y, z = numbers_at(light, "direction", default=(0.0, 0.0, -1.0))
    kind = light.get("type") or "point"
    if kind not in ("point", "directional", "spot"):
        raise SdfError(f"unknown light of type {printable(kind[:40])!r}", light.place("type"))
    strength = number_at(light, "intensity", default=1.0)
    attributes = {
        "type": kind,
        "pos": written(*position),
        "dir": written(*rotate(rotation, (x, y, z))) if x or y or z else "0 0 -1",
        "diffuse": _colour(light, "diffuse", (1.0, 1.0, 1.0), strength),
        "specular": _colour(light, "specular", (0.1, 0.1, 0.1), strength),
        "castshadow": str(flag_at(light, "cast_shadows") is True).lower(),
    }
    if name := light.get("name"):
        attributes["name"] = name
    if kind != "directional" and light.first("attenuation") is not None:
        terms = (("constant", 1.0), ("linear", 0.0), ("quadratic", 0.0))
        given = (number_at(light, "attenuation", term, default=usual) for term, usual in terms)
        attributes["attenuation"] = written(*given)
    if kind == "spot":
        angle = math.degrees(number_at(light, "spot", "outer_angle", default=math.pi / 2.0)) / 2.0
        attributes["cutoff"] = written(min(max(angle, 0.0), 90.0))
    return Element("light", attributes, light.span)


def _colour(element: Element, tag: str, usual: Vector3, strength: float = 1.0) -> str:
    text = text_at(element, tag)
    values = numbers(text, 4) or numbers(text, 3) or usual
    return written(*(min(max(value * strength, 0.0), 1.0) for value in values[:3]))


def _look(world: Element) -> Element:
    """Return MJCF's `<visual>`: the light from everywhere is that of the scene."""
    scene = world.first("scene") or world
    span: Span = world.span
    headlight = {"ambient": _colour(scene, "ambient", (0.4, 0.4, 0.4)), "diffuse": "0.2 0.2 0.2", "specular": "0 0 0"}
    children = [
        Element("map", {"znear": "0.02", "zfar": "120"}, span),
        Element("quality", {"offsamples": "0"}, span),
        Element("global", {"offwidth": "1280", "offheight": "800"}, span),
        Element("headlight", headlight, span),
    ]
    return Element("visual", {}, span, children)


def _sky(world: Element) -> Element:
    colour = _colour(world.first("scene") or world, "background", (0.7, 0.7, 0.7))
    attributes = {"name": "sky", "type": "skybox", "builtin": "gradient", "width": "64", "height": "384"}
    return Element("texture", attributes | {"rgb1": colour, "rgb2": colour}, world.span)
