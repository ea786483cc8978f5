"""Combines and checks the start positions of joints in robot files, scenes and keyframes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from graphengine.descriptions.urdf.urdf import Urdf
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import did_you_mean, listing

if TYPE_CHECKING:
    from graphengine.physics.model.robot import RobotInstance


def check_keyframe(name: str, urdf: Urdf, span: Span | None, findings: Findings) -> None:
    """Add an error if a robot does not have the keyframe."""
    known = urdf.mjcf.keyframes if urdf.mjcf is not None else {}
    if name not in known:
        near = did_you_mean(name, known) or listing(known, "keyframes")
        findings.add("S104", f"the robot has no keyframe {name!r}", span, near)


def joint_starts(robot: RobotInstance) -> dict[str, float]:
    """Return the start position (rad or m) of each moving joint of a robot that has one, by name.

    The scene overrides the robot file, which overrides the keyframe. A mimic joint without a start position of its own gets the
    position that follows from its leader's.
    """
    known, keyframe = {joint.name: joint for joint in robot.moving}, robot.keyframe
    coordinates = keyframe.coordinates if keyframe is not None else {}
    stated = {name: coordinates[name][0] for name in known if name in coordinates}
    stated |= {name: joint.start for name, joint in robot.spec.joints.items() if joint.start is not None}
    stated |= {name: joint.start for name, joint in robot.placement.use.joints.items()}
    starts = {name: stated[name] for name in known if name in stated}
    pending = {name: joint.mimic for name, joint in known.items() if joint.mimic is not None and name not in starts}
    while followers := [name for name, mimic in pending.items() if mimic.leader in starts]:
        for name in followers:
            mimic = pending.pop(name)
            starts[name] = mimic.multiplier * starts[mimic.leader] + mimic.offset
    return starts


def check_starts(
    starts: Mapping[str, tuple[float, Span]], urdf: Urdf, disabled: Collection[str], findings: Findings
) -> None:
    """Add an error for each start position that a joint cannot have.

    Args:
        starts: start positions (rad or m) in a robot file or scene with their source locations, by joint name.
        urdf: robot description with the joints.
        disabled: names of disabled joints, which do not move.
        findings: receives the errors.
    """
    for name, (start, span) in starts.items():
        joint = urdf.joints.get(name)
        if joint is None:
            near = did_you_mean(name, urdf.joints) or listing(urdf.joints, "joints")
            findings.add("S104", f"the robot has no joint {name!r}", span, near)
        elif not joint.moves or name in disabled:
            findings.add("S104", f"joint {name!r} does not move, so it cannot have a start position", span)
        elif joint.mimic is not None:
            leader = joint.mimic.leader
            findings.add(
                "S104",
                f"joint {name!r} mimics {leader!r}, so its start position follows from that joint",
                span,
                f"give {leader} a start position instead",
            )
        elif joint.limits is not None and not joint.limits[0] <= start <= joint.limits[1]:
            unit = "m" if joint.type == "prismatic" else "rad"
            legal = f"legal: {joint.limits[0]:g} to {joint.limits[1]:g} {unit}"
            findings.add(
                "G109", f"joint {name!r} cannot start at {start:g} {unit}, which is outside of its limits", span, legal
            )
