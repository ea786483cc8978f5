"""Disables joints according to a robot file.

PhysX releases the child of a disabled joint. Users disable mostly joints that carry only frames or light links; here, such
joints become fixed. A joint whose child would fall off is an error, unless the file also welds the joint.

If all mass is below a disabled joint, the joint's child moves freely, and the links above the joint become frames on it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from graphengine.descriptions.robot_description import Joint, Link, RobotDescription
from graphengine.descriptions.robot_files.robot_file import RobotFile
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing

NEGLIGIBLE = 0.01
"""A disabled joint becomes fixed if the links on one side of it have at most this fraction of the robot's mass."""


@dataclass(frozen=True, slots=True)
class Disabled:
    """The joints that a robot file disables, and the link that moves freely as a result.

    Attributes:
        joints: names of the disabled joints; parents come before their children.
        free_link: name of the link that moves freely and carries all other links; None if the base is fixed.
    """

    joints: tuple[str, ...]
    free_link: str | None


def disable_joints(file: RobotFile, description: RobotDescription, findings: Findings) -> Disabled:
    """Check the joints that a robot file disables, weld joints in the description, and return the result.

    Args:
        file: robot file with `joints` and `keep_only_joints`.
        description: robot description; a moving joint that is welded becomes fixed.
        findings: receives errors, and notes on joints that become fixed.
    """
    off = _disabled(file, description)
    free_link = description.root if description.moves_freely and not file.spec.fixed_base else None
    staying: list[str] = []
    for name, span in off.items():
        joint = description.joints[name]
        below = list(description.depth_first(joint.child))
        inside = {link.name for link in below}
        above = [link for link in description.links.values() if link.name not in inside]
        held = free_link is None or _matters(above, description)
        if joint.moves or (held and _matters(below, description)):
            if name in file.spec.joints and file.spec.joints[name].weld:
                _weld(joint, below, off, description, findings, span)
            else:
                _refuse(joint, below, findings, span)
        elif not held and not any(link.mass or link.colliders for link in above):
            free_link = joint.child
            text = f"joint {name!r} is disabled: {joint.child!r} moves freely, and {description.root!r} becomes a frame on it"
            root = "" if file.spec.articulation_root else "it is the articulation root, as the robot file names none"
            findings.add("N103", text, span, root)
        else:
            staying.append(name)
    if staying:
        text = "disabled joints stay welded, as one side of each has no collider and less than 1 % of the mass"
        findings.add("N103", text, off[staying[0]], listing(staying, "joints"))
    for name, spec in file.spec.joints.items():
        if spec.weld and name not in off:
            text = f"joint {name!r} is not disabled, and weld applies only to disabled joints"
            findings.add("G109", text, file.span("joints", name, "weld"), "also write enabled: false")
    return Disabled(tuple(off), free_link)


def _disabled(file: RobotFile, description: RobotDescription) -> dict[str, Span]:
    """Return a dict from each disabled joint to the source location that disables it; parents come before children."""
    spec = file.spec
    off: dict[str, Span] = {}
    for link in description.depth_first():
        name = link.carrier.name if link.carrier is not None else ""
        if name in spec.joints and not spec.joints[name].enabled:
            off[name] = file.span("joints", name, "enabled")
        elif name and spec.keep_only_joints and name not in spec.keep_only_joints:
            off[name] = file.span("keep_only_joints")
    return off


def _matters(links: Sequence[Link], description: RobotDescription) -> bool:
    return any(link.colliders for link in links) or sum(link.mass for link in links) > NEGLIGIBLE * description.mass


def _described(links: Sequence[Link]) -> str:
    """Return the name of the first link and the mass of all given links, as text for messages."""
    mass = sum(link.mass for link in links)
    return f"{links[0].name!r} ({mass:g} kg)"


def _refuse(joint: Joint, below: Sequence[Link], findings: Findings, span: Span) -> None:
    held = f"it {'moves' if joint.moves else 'holds'} {_described(below)}, which would fall off"
    remedy = f"{joint.name}: {{enabled: false, weld: true}} below joints: keeps it in place; or leave the joint enabled"
    findings.add("S106", f"joint {joint.name!r} cannot be disabled: {held}", span, remedy)


def _weld(
    joint: Joint,
    below: Sequence[Link],
    off: Collection[str],
    description: RobotDescription,
    findings: Findings,
    span: Span,
) -> None:
    followers = [
        other.name
        for other in description.joints.values()
        if other.name not in off and other.mimic is not None and other.mimic.leader == joint.name
    ]
    if followers:
        text = f"joint {joint.name!r} cannot be welded, because other joints mimic it"
        findings.add("S106", text, span, listing(followers, "joints"), "disable these joints, too")
    place = ", where it is with the joint at zero" if joint.moves else ""
    findings.add("N103", f"joint {joint.name!r} is disabled and welded: {_described(below)} stays{place}", span)
    joint.type, joint.mimic = "fixed", None
