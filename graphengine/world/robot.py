"""A robot of a scene: its description with what the robot file changes about it, every name checked, no physics yet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from graphengine.context import Quaternion, Vector3
from graphengine.diagnostics import Findings, Span, did_you_mean, listing
from graphengine.files import Files, NotFoundError
from graphengine.rotation import rotate
from graphengine.spec import RobotSpec, RobotUse
from graphengine.world import urdf as descriptions
from graphengine.world.drives import Drive, drive_of
from graphengine.world.robotfile import RobotFile
from graphengine.world.sensors.profiles import SensorProfile, read_profiles
from graphengine.world.urdf import Joint, Urdf, shape_of
from graphengine.world.xmlfile import write

NEGLIGIBLE = 0.01
"""Share of a robot's mass that may hang on a disabled joint: it stays welded, where PhysX would let it fall off."""


@dataclass(slots=True, eq=False, repr=False)
class Robot:
    """One robot of a scene.

    Attributes:
        name: in the scene; the prefix of its names in the physics model, and its prim below the root.
        use: what the scene says about it.
        file: the robot file with what it extends; `file.spec.graphs` are its graphs, `file.folder(…)` where their paths begin.
        urdf: the description, origins of the robot file applied.
        profiles: of its sensors, by name.
        moving: the joints of the articulation, in order.
        drives: of moving joints that have one, by joint.
        disabled: names of the joints that the file disables.
    """

    name: str
    use: RobotUse
    file: RobotFile
    urdf: Urdf
    profiles: dict[str, SensorProfile]
    moving: tuple[Joint, ...]
    drives: dict[str, Drive]
    disabled: tuple[str, ...]

    @property
    def spec(self) -> RobotSpec:
        """The merged robot file."""
        return self.file.spec

    @property
    def prim_path(self) -> str:
        """Path of the robot's prim."""
        return f"/{self.name}"

    @property
    def articulation_root(self) -> str:
        """Link that graphs address the robot by."""
        return self.spec.articulation_root or self.spec.base_link

    @property
    def urdf_text(self) -> str:
        """The description for robot_state_publisher, with the origins that the robot file gives."""
        return '<?xml version="1.0"?>\n' + write(self.urdf.element)[0] + "\n"

    @property
    def fixed_transforms(self) -> tuple[tuple[str, str, Vector3, Quaternion], ...]:
        """Parent frame, child frame, translation (m) and rotation of every fixed joint, in order of the description."""
        fixed = [joint for joint in self.urdf.joints.values() if not joint.moves]
        return tuple((joint.parent, joint.child, *joint.pose) for joint in fixed)

    @property
    def wheel_radii(self) -> dict[str, float]:
        """Radius (m) of the wheel on each moving joint that carries one."""
        return {joint.name: wheel[0] for joint in self.moving if (wheel := self.urdf.wheel(joint))}

    @property
    def wheel_distance(self) -> float | None:
        """Distance (m) along the axle between the centres of the two driven wheels; None unless there are two."""
        driven = [joint for joint in self.moving if joint.name in self.drives and self.urdf.wheel(joint)]
        if len(driven) != 2:
            return None
        axle = rotate(self.urdf.pose_in_root(driven[0].child)[1], driven[0].axis)
        one, other = (wheel[1] for joint in driven if (wheel := self.urdf.wheel(joint)))
        return abs(sum((a - b) * c for a, b, c in zip(one, other, axle, strict=True)))


def load_robot(name: str, use: RobotUse, file: RobotFile, files: Files, findings: Findings) -> Robot | None:
    """Check a robot file against its description; what is wrong goes to `findings`."""
    spec = file.spec
    if not spec.urdf:
        findings.add(
            "G107", "missing key 'urdf'", file.chain[0].document.span().part(0, 1), "the file of the description"
        )
        return None
    try:
        path = files.find(spec.urdf, file.folder("urdf"))
    except NotFoundError as error:
        findings.add("S101", error.message, file.span("urdf"), *error.help)
        return None
    urdf = descriptions.load(Path(path), findings)
    profiles = read_profiles(file, files, findings)
    if urdf is None:
        return None
    before = len(findings.errors)
    _check_names(file, urdf, findings)
    if len(findings.errors) > before:
        return None
    mimics = [joint for joint in urdf.joints.values() if joint.element.first("mimic") is not None]
    if mimics:
        names = listing([joint.name for joint in mimics], "joints")
        findings.add("N103", "<mimic> is not simulated: these joints move freely", mimics[0].element.span, names)
    drives = _apply_joints(file, urdf, findings)
    disabled = _disabled(file, urdf, findings)
    _check_colliders(file, urdf, findings)
    return Robot(name, use, file, urdf, profiles, tuple(urdf.moving()), drives, disabled)


def _known(what: str, name: str, legal: Iterable[str], span: Span, findings: Findings) -> None:
    names = list(legal)
    if name not in names:
        near = did_you_mean(name, names) or listing(names, f"{what}s")
        findings.add("S104", f"the robot has no {what} {name!r}", span, near)


def _check_names(file: RobotFile, urdf: Urdf, findings: Findings) -> None:
    spec = file.spec
    if spec.base_link != urdf.root:
        span = file.span("base_link")
        findings.add(
            "S104", f"{spec.base_link!r} is not the description's root link", span, f"write base_link: {urdf.root}"
        )
    if spec.articulation_root:
        _known("link", spec.articulation_root, urdf.links, file.span("articulation_root"), findings)
    for joint in spec.joints:
        _known("joint", joint, urdf.joints, file.key_span("joints", joint), findings)
    for index, joint in enumerate(spec.keep_only_joints):
        _known("joint", joint, urdf.joints, file.span("keep_only_joints", index), findings)
    for link in spec.wheel_colliders:
        _known("link", link, urdf.links, file.key_span("wheel_colliders", link), findings)
    bound: dict[str, Span] = {}
    for name, material in spec.materials.items():
        for index, link in enumerate(material.bind):
            span = file.span("materials", name, "bind", index)
            _known("link", link, urdf.links, span, findings)
            if link in bound:
                findings.add("S105", f"link {link!r} has two materials", span, related=[(bound[link], "first here")])
            bound[link] = span


def _apply_joints(file: RobotFile, urdf: Urdf, findings: Findings) -> dict[str, Drive]:
    """Move the joints that the file moves; the drives of those that have one."""
    drives: dict[str, Drive] = {}
    for name, spec in file.spec.joints.items():
        joint = urdf.joints[name]
        if spec.position is not None:
            joint.put(spec.position)
        drive = drive_of(spec, prismatic=joint.type == "prismatic")
        if drive is None:
            continue
        key = "drive" if spec.drive is not None else "usd_drive"
        span = file.key_span("joints", name, key)
        if not joint.moves:
            findings.add("S104", f"joint {name!r} is fixed: a drive has nothing to move", span, "remove the drive")
            continue
        drives[name] = drive
        if spec.usd_drive is not None and joint.type != "prismatic":
            gains = f"damping {drive.damping:g} N m s/rad, target {drive.target_velocity:g} rad/s"
            findings.add("N103", f"joint {name!r}: per degree in USD, in SI {gains}", span)
    return drives


def _disabled(file: RobotFile, urdf: Urdf, findings: Findings) -> tuple[str, ...]:
    """Joints that the file disables; those that a robot cannot do without are errors.

    PhysX lets fall what a disabled joint held. Here it stays where it is, as long as one side of the joint has no collider and
    next to no mass, which is what the extra joints of a description hold: frames, mounts, an inertial unit.
    """
    spec = file.spec
    off = {name: file.span("joints", name, "enabled") for name, joint in spec.joints.items() if not joint.enabled}
    if spec.keep_only_joints:
        span = file.span("keep_only_joints")
        off = {name: off.get(name, span) for name in urdf.joints if name not in spec.keep_only_joints or name in off}
    for name, span in off.items():
        joint = urdf.joints[name]
        below = list(urdf.depth_first(joint.child))
        names = {link.name for link in below}
        above = [link for link in urdf.links.values() if link.name not in names]
        if joint.moves:
            what, remedy = "moves: without it a link would fall off", "make it fixed in the description, or keep it"
        elif all(_matters(side, urdf) for side in (below, above)):
            what, remedy = f"holds {joint.child!r}, which has mass or a collider and would fall off", "keep the joint"
        else:
            continue
        findings.add("S106", f"joint {name!r} cannot be disabled: it {what}", span, remedy)
    if off:
        span = next(iter(off.values()))
        text = "disabled joints stay welded, as nothing that collides or weighs 1 % of the robot hangs on them"
        findings.add("N103", text, span, listing(off, "joints"))
    return tuple(off)


def _matters(links: Sequence[descriptions.Link], urdf: Urdf) -> bool:
    return any(link.colliders for link in links) or sum(link.mass for link in links) > NEGLIGIBLE * urdf.mass


def _check_colliders(file: RobotFile, urdf: Urdf, findings: Findings) -> None:
    for link, shape in file.spec.wheel_colliders.items():
        tags = [geometry.tag for collider in urdf.links[link].colliders if (geometry := shape_of(collider)) is not None]
        if shape == "ellipsoid" and tags != ["cylinder"]:
            what = listing(tags, "its colliders")
            span = file.key_span("wheel_colliders", link)
            findings.add("S106", f"link {link!r} is no wheel: an ellipsoid replaces one cylinder", span, what)
    for name, material in file.spec.materials.items():
        for index, link in enumerate(material.bind):
            if not urdf.links[link].colliders:
                span = file.span("materials", name, "bind", index)
                findings.add("S104", f"link {link!r} has no collider to bind a material to", span)
