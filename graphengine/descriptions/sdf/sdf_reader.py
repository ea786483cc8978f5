"""Reads a model of an SDF file as the description of a robot, with `<gazebo>` elements for properties that URDF lacks."""

from __future__ import annotations

from pathlib import Path

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.link_tree import assembled
from graphengine.descriptions.robot_description import WORLD, Joint, Link, RobotDescription
from graphengine.descriptions.sdf.sdf_files import SdfFiles
from graphengine.descriptions.sdf.sdf_frames import Scope, SdfFrame
from graphengine.descriptions.sdf.sdf_joints import fastened, is_moving, parts_of
from graphengine.descriptions.sdf.sdf_links import LinkReader
from graphengine.descriptions.sdf.sdf_values import SdfError, flag_at, leaf, reported
from graphengine.descriptions.urdf.urdf_writer import as_urdf
from graphengine.devices.rotation import Pose
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing, printable

_CONVERTED = ("link", "joint", "frame", "model", "include", "pose", "static", "self_collide")
_NO_EFFECT = ("allow_auto_disable", "enable_wind")


def read_sdf(
    path: Path, root: Element, packages: Packages, findings: Findings, name: str = ""
) -> RobotDescription | None:
    """Return the links and joints of a model of an SDF file; None after an error.

    Args:
        path: path of the file.
        root: root element of the file.
        packages: find models and meshes.
        findings: receives errors and notes.
        name: name of the model. Default: the only model with moving joints, else the only model that is not static, else the
            only model.
    """
    before = len(findings.errors)
    chosen: Scope | None = None
    with reported(findings):
        files = SdfFiles(packages, findings)
        file = files.main(path, root)
        written = [model for holder in (root, *root.all("world")) for model in holder.all("model")]
        given = next((model for model in written if name and model.get("name") == name), None)
        if given is not None:  # other includes of its world need not be read
            chosen = files.scope(given, file)
        else:
            models = [files.scope(model, file) for model in root.all("model")]
            for world in root.all("world"):
                for model in files.scope(world, file).models.values():
                    model.outer = None  # a robot has no fixed pose in the world
                    models.append(model)
            chosen = _chosen(models, root, name)
    return _robot(chosen, packages, findings, before) if chosen is not None else None


def _chosen(models: list[Scope], root: Element, name: str) -> Scope:
    """Return the model with the given name.

    Without a name, the first rule that one model alone meets decides: it has moving joints; it is not static; it is in the file.

    Raises:
        SdfError: no model has the name, or the choice is ambiguous.
    """
    names = [model.name for model in models]
    if name:
        if name not in names:
            near = did_you_mean(name, names) or listing(map(printable, names), "its models")
            raise SdfError(f"the file has no model {printable(name)!r}", root.span, near)
        return models[names.index(name)]
    loose = [model for model in models if not model.static]
    robots = [model for model in loose if any(map(is_moving, model.all_joints()))] or loose or models
    if len(robots) != 1:
        known = listing((printable(robot.name) for robot in robots), "its models")
        what = "the file has more than one model" if robots else "the file has no model"
        raise SdfError(what, root.span, known, "choose one by --model NAME on import" if robots else "")
    return robots[0]


def _robot(model: Scope, packages: Packages, findings: Findings, before: int) -> RobotDescription | None:
    """Return the links and joints of a model; None if `findings` then has more than `before` errors."""
    joints, links = model.all_joints(), model.all_links()
    carriers: dict[SdfFrame, SdfFrame] = {}
    carries: dict[SdfFrame, SdfFrame] = {}
    bolted = False
    for joint in joints:
        with reported(findings):
            parent, child = fastened(joint)
            carriers.setdefault(child, joint)
            if parent is not None:
                carries[parent] = joint
            bolted = bolted or parent is None
    frames: dict[SdfFrame, Pose] = {}
    for link in links:
        with reported(findings):
            frames[link] = carriers[link].place if link in carriers else link.place
    if len(findings.errors) > before:
        return None
    reader, span = LinkReader(frames, findings), model.element.span
    parts: list[Link | Joint | Element] = []
    if bolted:
        parts.append(Link(WORLD, Element("link", {"name": WORLD}, span), None, ()))
    parts += [reader.link(link) for link in links]
    for joint in joints:
        with reported(findings):
            parts += parts_of(joint, frames, carries, findings)
    parts += [*map(reader.for_gazebo, links), *map(_for_gazebo, model.walk())]
    _tell(reader, findings)
    found = [part for part in parts if isinstance(part, Link)]
    made = [part for part in parts if isinstance(part, Joint)]
    others = [part for part in parts if isinstance(part, Element) and part.children]
    document = as_urdf(model.name, found, made, span, others)
    return assembled(document, packages, found, made, findings, before)


def _tell(reader: LinkReader, findings: Findings) -> None:
    """Add notes on links that become frames, and on textures."""
    if reader.mere_frames:
        text = "links without inertial and shapes become frames without mass; in SDF, each has a mass of 1 kg"
        names = listing((printable(link.full_name) for link in reader.mere_frames), "links")
        findings.add("N103", text, reader.mere_frames[0].element.span, names)
    if reader.images:
        findings.add("N103", "textures of visuals are not drawn; their diffuse colours are used", reader.images[0].span)


def _for_gazebo(scope: Scope) -> Element:
    """Return a `<gazebo>` element with the properties of a model: plugins, `static`, self-collision and others."""
    made = Element("gazebo", {}, scope.element.span)
    if scope.outer is None:
        for tag, name in (("static", "static"), ("self_collide", "selfCollide")):
            if flag_at(scope.element, tag):
                made.children.append(leaf(name, "true", scope.element.span))
    known = {*scope.joints, *scope.links} if scope.prefix else set()
    for child in scope.element.children:
        if child.tag == "plugin":
            made.children.append(_prefixed(child, scope.prefix, known))
        elif child.tag not in (*_CONVERTED, *_NO_EFFECT):
            made.children.append(child)
    return made


def _prefixed(element: Element, prefix: str, known: set[str]) -> Element:
    """Return a copy of a plugin in which the known names have a prefix.

    Links and joints of a nested model have such a prefix in the outermost model, as in `A::wheel`.
    """
    text = f"{prefix}{element.text}" if element.text in known else element.text
    children = [_prefixed(child, prefix, known) for child in element.children]
    return Element(element.tag, dict(element.attributes), element.span, children, text)
