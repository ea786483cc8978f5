"""Connects the links and joints of a description to one tree, and checks names, types, limits and mimic laws."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TypeVar

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.joint_units import check_degrees, swapped_limits
from graphengine.descriptions.robot_description import MOVING, Joint, Link, Mimic, RobotDescription
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing

Part = TypeVar("Part", Link, Joint)
LEGAL = (*MOVING, "fixed")
MAX_LINKS = 2000
"""Maximum number of links of a description, and maximum number of its joints."""


def assembled(
    element: Element,
    packages: Packages,
    all_links: Iterable[Link],
    all_joints: Iterable[Joint],
    findings: Findings,
    before: int,
) -> RobotDescription | None:
    """Return the description that consists of the given links and joints; None after an error.

    Args:
        element: root element of the description as URDF.
        packages: find the meshes.
        all_links: links in order of the description.
        all_joints: joints in order of the description.
        findings: receives errors, warnings and notes.
        before: number of errors before the description was read.
    """
    links, joints = _by_name(all_links, "link", findings), _by_name(all_joints, "joint", findings)
    for joint in joints.values():
        _connect(joint, links, findings)
    top = _tree(element, links, findings) if len(findings.errors) == before else ""
    if not top:
        return None
    top = _release(top, links, joints, findings)
    for joint in joints.values():
        if joint.type not in LEGAL:
            _not_simulated(joint, findings)
        if joint.mimic is not None:
            _check_mimic(joint, joint.mimic, joints, findings)
    check_limits(joints.values(), findings)
    return RobotDescription(element, packages, links, joints, top) if len(findings.errors) == before else None


def _connect(joint: Joint, links: Mapping[str, Link], findings: Findings) -> None:
    """Connect the two links of a joint. Add an error if one of the links is missing, or if another joint carries the child."""
    for tag, link in (("parent", joint.parent), ("child", joint.child)):
        if link not in links:
            end, near = joint.element.first(tag), did_you_mean(link, links) or listing(links, "links")
            span = end.place("link") if end is not None else joint.element.span
            findings.add("S103", f"joint {joint.name!r}: no {tag} link {link!r}", span, near)
            return
    child = links[joint.child]
    if child.carrier is not None:
        first = (child.carrier.element.span, "first here")
        findings.add("S103", f"link {child.name!r} has two parents", joint.element.span, related=[first])
        return
    child.carrier = joint
    links[joint.parent].below.append(joint)


def check_limits(joints: Iterable[Joint], findings: Findings) -> None:
    """Add warnings on limits that are probably swapped or in degrees, and a note on joints without limits."""
    joints = list(joints)
    for joint in joints:
        check_degrees(joint, findings)
    boundless = [joint for joint in joints if joint.type in ("revolute", "prismatic") and joint.limits is None]
    boundless = [joint for joint in boundless if not swapped_limits(joint, findings)]
    if boundless:
        names = listing((joint.name for joint in boundless), "joints")
        text = "joints without limits, or with equal limits, move freely"
        findings.add("N103", text, boundless[0].element.span, names)


def _by_name(parts: Iterable[Part], tag: str, findings: Findings) -> dict[str, Part]:
    """Return a dict from names to links or joints; add errors for missing and repeated names, and for more than `MAX_LINKS`."""
    found: dict[str, Part] = {}
    for part in parts:
        element = part.element
        if not part.name:
            findings.add("S103", f"a {tag} without a name", element.span)
        elif part.name in found:
            first = (found[part.name].element.span, "first here")
            findings.add("S105", f"two {tag}s named {part.name!r}", element.place("name"), related=[first])
        elif len(found) == MAX_LINKS:
            findings.add("S103", f"more than {MAX_LINKS} {tag}s", element.span)
            break
        else:
            found[part.name] = part
    return found


def _tree(root: Element, links: dict[str, Link], findings: Findings) -> str:
    """Return the name of the root link; empty if the links do not form a single tree, after adding an error."""
    if not links:
        findings.add("S103", "the description has no link", root.span)
        return ""
    tops = [link for link in links.values() if link.carrier is None]
    if len(tops) != 1:
        what = listing([link.name for link in tops], "links without a parent")
        findings.add("S103", "the links do not form one tree", root.span, what, "connect them with joints")
        return ""
    reached = [tops[0]]
    for link in reached:
        reached.extend(links[joint.child] for joint in link.below)
    if len(reached) != len(links):
        lost = listing(links.keys() - {link.name for link in reached}, "links in a closed loop of joints")
        findings.add("S103", "the links do not form one tree", root.span, lost)
        return ""
    return tops[0].name


def _release(top: str, links: dict[str, Link], joints: dict[str, Joint], findings: Findings) -> str:
    """Remove an empty root link whose only joint is floating, and this joint. Return the name of the root link after that.

    The joint is superfluous, because the simulator lets every robot move freely.
    """
    joint = links[top].below[0] if len(links[top].below) == 1 else None
    if joint is None or joint.type != "floating" or not links[top].empty:
        return top
    text = f"joint {joint.name!r} and link {top!r} are left out: the robot moves freely without them"
    findings.add("N103", text, joint.element.span)
    del links[top], joints[joint.name]
    links[joint.child].carrier = None
    return joint.child


def _not_simulated(joint: Joint, findings: Findings) -> None:
    remedies = {
        "planar": "write two prismatic joints and a continuous one, with an empty link between each",
        "floating": "only the joint between an empty root link and the rest of the robot can be floating",
    }
    text = f"joint {joint.name!r}: type {joint.type!r} is not supported"
    findings.add("S103", text, joint.element.place("type"), remedies[joint.type])


def _check_mimic(joint: Joint, mimic: Mimic, joints: Mapping[str, Joint], findings: Findings) -> None:
    """Add an error if the leader of a joint is not a moving joint or follows this joint, or if the law is not numeric."""
    leader, span = mimic.leader, mimic.element.place("joint")
    if leader not in joints or not joints[leader].moves:
        near = did_you_mean(leader, joints) or listing((j.name for j in joints.values() if j.moves), "moving joints")
        findings.add("S103", f"joint {joint.name!r} mimics {leader!r}, which is not a moving joint", span, near)
    elif not (math.isfinite(mimic.multiplier) and math.isfinite(mimic.offset)):
        text = f"joint {joint.name!r}: multiplier and offset of <mimic> must be numbers"
        findings.add("S103", text, mimic.element.span)
    elif _follows(leader, joint.name, joints):
        findings.add("S103", f"joint {joint.name!r} mimics itself", span)


def _follows(follower: str, leader: str, joints: Mapping[str, Joint]) -> bool:
    """Return whether joint `follower` mimics joint `leader`, directly or through further joints."""
    seen: set[str] = set()
    while follower not in seen:
        if follower == leader:
            return True
        seen.add(follower)
        mimic = joints[follower].mimic if follower in joints else None
        follower = mimic.leader if mimic is not None else follower
    return False
