"""Writes a robot description onto an MjSpec.

The values are those of MuJoCo's own reader of URDF, to the last bit; links that are only frames, and visuals, are kept. `info`
of each element holds its place in the user's file, which MuJoCo's errors repeat.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files.bounds import PART, memory_of_file
from graphengine.descriptions.files.contained_meshes import contained
from graphengine.descriptions.files.mesh_file import MeshFile
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.inertia import inertials
from graphengine.descriptions.robot_description import WORLD, Inertial, Joint, RobotDescription
from graphengine.descriptions.shapes import Box, Capsule, Colour, Cylinder, Mesh, Shape, Sphere, sizes_of
from graphengine.devices.rotation import NOWHERE, Pose, Quaternion, Vector3, relative
from graphengine.format.diagnostics import Findings

_GEOM = mujoco.mjtGeom
_VISUAL_GROUP = 1
"""Geom group of visuals in MuJoCo's reader of URDF."""
_TYPES: Mapping[type, mujoco.mjtGeom] = {
    Box: _GEOM.mjGEOM_BOX,
    Sphere: _GEOM.mjGEOM_SPHERE,
    Cylinder: _GEOM.mjGEOM_CYLINDER,
    Capsule: _GEOM.mjGEOM_CAPSULE,
}
_FROM_GEOMS = {
    "false": mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE,
    "true": mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE,
    "auto": mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO,
}
_SETTINGS: Mapping[str, tuple[Callable[[str], object], str]] = {
    "balanceinertia": ({"true": True, "false": False}.get, "true or false"),
    "boundmass": (number, "a number"),
    "boundinertia": (number, "a number"),
    "inertiafromgeom": (_FROM_GEOMS.get, "true, false or auto"),
}
"""For each setting of `<mujoco><compiler>` that is applied: the function that reads the value, and the legal values."""

Part = tuple[Shape, MeshFile | None, int]
"""A shape; for a mesh, the file with the triangles of one colour; and the number of this file among those of the mesh."""
Meshes = dict[str, dict[Vector3, mujoco.MjsMesh]]
"""Meshes: a dict from names of files to dicts from scales to meshes."""


def write_robot(
    description: RobotDescription,
    name: str,
    library: Library,
    findings: Findings,
    *,
    free_link: str | None,
    colours: Mapping[str, tuple[float, float, float]],
    more: float,
) -> mujoco.MjSpec | None:
    """Return a description as an MjSpec with a body for each link; None after an error.

    Args:
        description: robot description; it is not changed.
        name: name of the robot.
        library: reads the meshes and keeps their data.
        findings: receives errors, and notes on changed masses and inertias and on shapes that are left out.
        free_link: link that becomes the topmost body, by default the root; only topmost bodies can move freely in MuJoCo. Fixed
            joints must connect the link to the root.
        colours: colour (red, green, blue from 0 to 1) of visuals without a material, by link name.
        more: memory that the robot takes in addition, bytes.
    """
    before = len(findings.errors)
    spec = mujoco.MjSpec()
    spec.modelname, spec.compiler.degree = name, False
    _set_compiler(spec, description, findings)
    masses = inertials(description, free=free_link is not None, findings=findings)
    every = (shape for link in description.links.values() for shape in link.shapes)
    meshes = [(mesh.element, shape.visual) for shape in every if isinstance(mesh := shape.geometry, Mesh)]
    if description.usd is not None:
        files = contained(meshes, description.usd.meshes, library)
    else:
        files = library.meshes(meshes, description.packages)
    shapes = {name: list(_parts(link.shapes, files, findings)) for name, link in description.links.items()}
    if len(findings.errors) > before or not library.add_memory(_memory(description, shapes, library, more), "S103"):
        return None
    spec.assets = library.assets
    bodies = _add_bodies(spec, description, free_link or description.root)
    drawn = {name: (*colour, 1.0) for name, colour in colours.items()}
    made: Meshes = {}
    for link in description.links.values():
        body = bodies[link.name]
        body.info = str(link.element.span)
        if link.name in masses:
            _weigh(body, masses[link.name])
        _add_geoms(spec, body, shapes[link.name], drawn.get(link.name), made)
    for joint in description.joints.values():
        if joint.moves:
            _add_joint(bodies[joint.child], joint)
    return spec


def _set_compiler(spec: mujoco.MjSpec, description: RobotDescription, findings: Findings) -> None:
    """Apply the settings on inertias in the `<mujoco><compiler>` elements of a description; all others are ignored."""
    settings = [compiler for each in description.element.all("mujoco") for compiler in each.all("compiler")[:1]]
    given = {key: compiler for compiler in settings for key in _SETTINGS if key in compiler.attributes}
    for key, compiler in given.items():
        read, legal = _SETTINGS[key]
        value = read(compiler.get(key))
        if value is None:
            text = f"<compiler>: {key} must be {legal}, not {compiler.get(key)[:60]!r}"
            findings.add("S103", text, compiler.place(key), "correct it, or remove it: MuJoCo's default then applies")
        else:
            setattr(spec.compiler, key, value)


def _parts(shapes: Sequence[Shape], files: Mapping[Element, Sequence[MeshFile]], findings: Findings) -> Iterator[Part]:
    """Yield the parts of shapes that become geoms: one for each colour of a mesh, none for a shape with a size of 0."""
    for shape in shapes:
        geometry = shape.geometry
        if isinstance(geometry, Mesh):
            yield from ((shape, file, index) for index, file in enumerate(files.get(geometry.element, ())))
        elif 0.0 in sizes_of(geometry):  # some descriptions use such shapes as placeholders
            findings.add("N103", "a shape with a size of 0 is left out", shape.place)
        else:
            yield shape, None, 0


def _memory(
    description: RobotDescription, shapes: Mapping[str, Sequence[Part]], library: Library, more: float
) -> Iterator[tuple[Element, float]]:
    """Yield the estimated memory (bytes) of each part of a robot, with its element; a mesh counts once for each scale."""
    yield description.element, more
    shared: set[tuple[str, Vector3]] = set()
    for link in description.links.values():
        yield link.element, PART
        for shape, file, _ in shapes[link.name]:
            yield shape.element, PART
            mesh = shape.geometry
            if file is not None and isinstance(mesh, Mesh) and (file.key, mesh.scale) not in shared:
                shared.add((file.key, mesh.scale))
                yield mesh.element, memory_of_file("mesh", library.assets[file.key])
    for joint in description.joints.values():
        yield joint.element, PART


def _add_bodies(spec: mujoco.MjSpec, description: RobotDescription, top: str) -> dict[str, mujoco.MjsBody]:
    """Add a body for each link below the body of link `top`, depth first; return them by link name.

    The fixed joints between `top` and the root are turned round. A link named `world` is the world itself.
    """
    chain = {joint.name: joint for joint in description.carriers(top)}
    turned: dict[str, Pose] = {joint.parent: relative(joint.pose, NOWHERE) for joint in chain.values()}
    if chain:
        turned[top] = description.pose_in_root(top)
    poses: dict[str, Pose] = {}
    below: dict[str, list[str]] = {name: [] for name in description.links}
    for joint in description.joints.values():
        parent, child = (joint.child, joint.parent) if joint.name in chain else (joint.parent, joint.child)
        below[parent].append(child)
        if joint.name not in chain:
            poses[child] = joint.pose
    bodies: dict[str, mujoco.MjsBody] = {}
    pending = [(spec.worldbody, top)]
    while pending:
        parent_body, name = pending.pop()
        body = parent_body.add_body(name=name) if name != WORLD else spec.worldbody
        if name in turned:
            body.pos, (x, y, z, w) = turned[name]
            body.quat = (w, x, y, z)
        else:
            body.pos, body.quat = _at(poses.get(name, NOWHERE))
        bodies[name] = body
        pending.extend((body, child) for child in reversed(below[name]))
    return bodies


def _at(pose: Pose) -> tuple[Vector3, Quaternion]:
    """Return the position and the quaternion (w, x, y, z) of a pose; in the quaternion, -0.0 becomes 0.0, as in MuJoCo."""
    position, (x, y, z, w) = pose
    return position, (w + 0.0, x + 0.0, y + 0.0, z + 0.0)


def _weigh(body: mujoco.MjsBody, inertial: Inertial) -> None:
    """Set mass and inertia of a body; moments that are all 0 stay undefined."""
    body.explicitinertial, body.mass = True, inertial.mass
    body.ipos, body.iquat = _at(inertial.pose)
    if inertial.moments is not None and any(inertial.moments):
        body.fullinertia = inertial.moments


def _add_geoms(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, parts: Sequence[Part], otherwise: Colour | None, made: Meshes
) -> None:
    """Add the geoms of a link. A visual without a colour, and a collider, get the colour of the visual before it.

    Args:
        spec: receives the meshes.
        body: body of the link.
        parts: parts of the shapes of the link.
        otherwise: colour of visuals without a material.
        made: meshes that were added; new ones are added.
    """
    colour: Colour | None = None
    for shape, file, index in parts:
        position, rotation = _at(shape.pose)
        geom = body.add_geom(name=f"{shape.name}.{index}", pos=position, quat=rotation)
        geom.info = str(shape.element.span)
        if shape.visual:
            geom.contype = geom.conaffinity = 0
            geom.group, geom.density = _VISUAL_GROUP, 0.0
            own = shape.colour or (file.colour if file is not None else None) or otherwise
            colour = own or colour
        if isinstance(shape.geometry, Mesh) and file is not None:
            geom.type, geom.meshname = _GEOM.mjGEOM_MESH, _mesh(spec, shape.geometry, file.key, made)
        else:
            geom.type, sizes = _TYPES[type(shape.geometry)], sizes_of(shape.geometry)
            geom.size[: len(sizes)] = sizes
        if colour is not None and colour[0] >= 0:
            geom.rgba = colour


def _mesh(spec: mujoco.MjSpec, mesh: Mesh, key: str, made: Meshes) -> str:
    """Return the name of the mesh for a file and a scale; add a missing mesh. Names for further scales end with a number."""
    name = key.rpartition(".")[0] or key
    known = made.setdefault(name, {})
    if mesh.scale not in known:
        called = f"{name}{len(known)}" if known else name
        known[mesh.scale] = spec.add_mesh(name=called, file=key, scale=mesh.scale)
    found = known[mesh.scale]
    found.info = str(mesh.element.span)
    return str(found.name)


def _add_joint(body: mujoco.MjsBody, joint: Joint) -> None:
    kind = mujoco.mjtJoint.mjJNT_SLIDE if joint.type == "prismatic" else mujoco.mjtJoint.mjJNT_HINGE
    made = body.add_joint(name=joint.name, type=kind, axis=joint.stated_axis)
    made.info = str(joint.element.span)
    made.damping[0], made.frictionloss = joint.losses
    lower, upper = joint.bounds.lower, joint.bounds.upper
    if joint.type != "continuous":
        made.range = 0.0 if lower is None else lower, 0.0 if upper is None else upper
        if (lower is None) != (upper is None) or made.range[0] > made.range[1]:
            made.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    if joint.bounds.effort:
        made.actfrcrange = -abs(joint.bounds.effort), abs(joint.bounds.effort)
