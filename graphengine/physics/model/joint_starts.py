"""Checks the start positions of joints in robot files and scenes, and the names of keyframes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from graphengine.descriptions.robot_description import RobotDescription
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import did_you_mean, listing


def check_known(kind: str, name: str, legal: Iterable[str], span: Span | None, findings: Findings) -> None:
    """Add an error if a name is not one of the legal names; The message calls the named element `kind`, for example "link"."""
    names = list(legal)
    if name not in names:
        near = did_you_mean(name, names) or listing(names, f"{kind}s")
        findings.add("S104", f"the robot has no {kind} {name!r}", span, near)


def check_starts(
    starts: Mapping[str, tuple[float, Span]],
    description: RobotDescription,
    disabled: Collection[str],
    findings: Findings,
) -> None:
    """Add an error for each start position that a joint cannot have.

    Args:
        starts: a dict from joint name to start position (rad or m) and its source location in a robot file or scene.
        description: robot description with the joints.
        disabled: names of disabled joints, which do not move.
        findings: receives the errors.
    """
    for name, (start, span) in starts.items():
        joint = description.joints.get(name)
        if joint is None:
            check_known("joint", name, description.joints, span, findings)
        elif not joint.moves or name in disabled:
            findings.add("S104", f"joint {name!r} does not move, so it cannot have a start position", span)
        elif joint.mimic is not None:
            leader = joint.mimic.leader
            text = f"joint {name!r} mimics {leader!r}, so its start position follows from that joint"
            findings.add("S104", text, span, f"give {leader} a start position instead")
        elif joint.limits is not None and not joint.limits[0] <= start <= joint.limits[1]:
            unit = "m" if joint.type == "prismatic" else "rad"
            legal = f"legal: {joint.limits[0]:g} to {joint.limits[1]:g} {unit}"
            text = f"joint {name!r} cannot start at {start:g} {unit}, which is outside of its limits"
            findings.add("G109", text, span, legal)
