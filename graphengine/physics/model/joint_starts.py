"""Determines the start positions of joints from robot files, scenes and keyframes, and checks them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.robot_spec import JointSpec
from graphengine.format.spec import JointStartSpec, RobotUse
from graphengine.format.wording import did_you_mean, listing
from graphengine.physics.description.mjcf_model import Keyframe
from graphengine.physics.description.urdf import Urdf, UrdfJoint


def check_keyframe(name: str, urdf: Urdf, span: Span | None, findings: Findings) -> None:
    """Add an error to `findings` if the robot's MuJoCo model does not have a keyframe of this name."""
    known = urdf.mjcf.keyframes if urdf.mjcf is not None else {}
    if name not in known:
        near = did_you_mean(name, known) or listing(known, "keyframes")
        findings.add("S104", f"the robot has no keyframe {name!r}", span, near)


def joint_starts(
    moving: Iterable[UrdfJoint],
    joints: Mapping[str, JointSpec],
    use: RobotUse,
    keyframe: Keyframe | None = None,
) -> dict[str, float]:
    """Return the start position (rad or m) of each moving joint for which one is known, by the joint's name.

    A mimic joint that has no start position itself gets the position that follows from the start position of its leader.

    Args:
        moving: the joints of the robot that move.
        joints: the entries in `joints` of the robot file; their start positions override those of the keyframe.
        use: the robot's entry in the scene; its start positions override those of the robot file.
        keyframe: keyframe in which the robot starts.
    """
    known = {joint.name: joint for joint in moving}
    coordinates = keyframe.coordinates if keyframe is not None else {}
    stated = {name: coordinates[name][0] for name in known if name in coordinates}
    stated |= {name: joint.start for name, joint in joints.items() if joint.start is not None}
    stated |= {name: joint.start for name, joint in use.joints.items()}
    starts = {name: stated[name] for name in known if name in stated}
    pending = [joint for joint in known.values() if joint.mimic is not None and joint.name not in starts]
    while followers := [joint for joint in pending if joint.mimic is not None and joint.mimic.leader in starts]:
        for joint in followers:
            assert joint.mimic is not None
            starts[joint.name] = joint.mimic.multiplier * starts[joint.mimic.leader] + joint.mimic.offset
        pending = [joint for joint in pending if joint.name not in starts]
    return starts


def check_starts(
    joints: Mapping[str, JointStartSpec | JointSpec],
    places: Mapping[str, Span],
    urdf: Urdf,
    disabled: Collection[str],
    findings: Findings,
) -> None:
    """Add an error to `findings` for each start position that a joint cannot have.

    Args:
        joints: the entries of a robot file or scene about joints, by the joint's name.
        places: place of each start position in that file, by the joint's name.
        urdf: robot description with the joints.
        disabled: names of the disabled joints.
        findings: receives the errors.
    """
    for name, span in places.items():
        start, joint = joints[name].start, urdf.joints.get(name)
        if start is None:
            continue
        if joint is None:
            near = did_you_mean(name, urdf.joints) or listing(urdf.joints, "joints")
            findings.add("S104", f"the robot has no joint {name!r}", span, near)
        elif not joint.moves or name in disabled:
            findings.add("S104", f"joint {name!r} does not move, so it cannot have a start position", span)
        elif joint.mimic is not None:
            leader = joint.mimic.leader
            findings.add(
                "S104",
                f"joint {name!r} mimics {leader!r}, which determines its start position",
                span,
                f"give the start position of {leader} instead",
            )
        elif joint.limits is not None and not joint.limits[0] <= start <= joint.limits[1]:
            unit = "m" if joint.type == "prismatic" else "rad"
            legal = f"legal: {joint.limits[0]:g} to {joint.limits[1]:g} {unit}"
            findings.add(
                "G109", f"joint {name!r} cannot start at {start:g} {unit}, which is outside its limits", span, legal
            )
