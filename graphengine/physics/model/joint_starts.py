"""Start positions of joints, from robot files, scenes and keyframes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.robot_spec import JointSpec
from graphengine.format.spec import JointStartSpec, RobotUse
from graphengine.format.wording import did_you_mean, listing
from graphengine.physics.description.mjcf_model import Keyframe
from graphengine.physics.description.urdf import Urdf, UrdfJoint


def check_keyframe(name: str, urdf: Urdf, span: Span | None, findings: Findings) -> None:
    """Report a keyframe that a robot does not have."""
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
    """Return the start position (rad or m) of each moving joint that has one, by name.

    A mimic joint without a start position of its own gets the position that follows from its leader's.

    Args:
        moving: the joints of the robot that move.
        joints: `joints` of the robot file; their start positions override the keyframe.
        use: the robot's entry in the scene, which overrides the robot file.
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
    """Report positions at the start that joints cannot have.

    Args:
        joints: what a file says about joints.
        places: of the positions at the start in the file, by joint.
        urdf: has the joints.
        disabled: names of joints that do not move.
        findings: takes the errors.
    """
    for name, span in places.items():
        start, joint = joints[name].start, urdf.joints.get(name)
        if start is None:
            continue
        if joint is None:
            near = did_you_mean(name, urdf.joints) or listing(urdf.joints, "joints")
            findings.add("S104", f"the robot has no joint {name!r}", span, near)
        elif not joint.moves or name in disabled:
            findings.add("S104", f"joint {name!r} does not move, so it has no position at the start", span)
        elif joint.mimic is not None:
            leader = joint.mimic.leader
            findings.add("S104", f"joint {name!r} starts where {leader!r} puts it", span, f"give the start of {leader}")
        elif joint.limits is not None and not joint.limits[0] <= start <= joint.limits[1]:
            unit = "m" if joint.type == "prismatic" else "rad"
            legal = f"legal: {joint.limits[0]:g} to {joint.limits[1]:g} {unit}"
            findings.add(
                "G109", f"joint {name!r} cannot start at {start:g} {unit}, which is outside its limits", span, legal
            )
