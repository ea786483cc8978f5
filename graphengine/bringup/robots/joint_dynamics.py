"""Converts limits, springs and start positions of joints in a description, and finds effort limits that are too low."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Claim, Draft
from graphengine.format.wording import printable

_FAST = 1.0
"""Speed of a base (m/s) that its wheels should reach within their effort limits."""


def add_joint_dynamics(draft: Draft) -> None:
    """Add soft limits, springs, velocity limits of drives, and start positions within the limits to the draft."""
    joints = {joint.name: joint for joint in draft.description.moving()}
    for gazebo in draft.description.element.all("gazebo"):
        if gazebo.get("reference") in joints:
            _spring(draft, joints[gazebo.get("reference")], gazebo)
    for joint in joints.values():
        _soft_limits(draft, joint)
        _start(draft, joint)
    _velocities(draft, list(joints.values()))


def _soft_limits(draft: Draft, joint: Joint) -> None:
    """Add the soft limits of a `<safety_controller>` within the joint's limits; an empty range such as 0 to 0 has no effect."""
    safety, limits = joint.element.first("safety_controller"), _limits(draft, joint)
    if safety is None or limits is None:
        return
    lower, upper = (number(safety.get(f"soft_{end}_limit")) for end in ("lower", "upper"))
    if lower is None or upper is None or lower >= upper:
        return
    draft.use(safety)
    low, high = max(lower, limits[0]), min(upper, limits[1])
    if (low, high) != limits and low < high:
        draft.joints[joint.name].value["limits"] = [low, high]
        claim: Claim = {("joints", joint.name, "limits"): [low, high]}
        draft.carry(f"joint {joint.name}: soft limits {low:g} to {high:g}", safety.span, claim)


def _limits(draft: Draft, joint: Joint) -> tuple[float, float] | None:
    """Return the limits of a joint in the robot file, else in the description; None without limits."""
    low, high = draft.joints[joint.name].value.get("limits") or joint.limits or (None, None)
    return (low, high) if low is not None and high is not None else None


def _spring(draft: Draft, joint: Joint, gazebo: Element) -> None:
    """Add the spring that a `<gazebo>` element gives a joint, e.g. for a wheel drop sensor."""
    stiffness, rest = gazebo.first("springStiffness"), gazebo.first("springReference")
    force = number(stiffness.text) if stiffness is not None else None
    if stiffness is None or force is None or force <= 0:
        return
    spring = {"stiffness": force}
    if rest is not None and (at := number(rest.text)) is not None:
        spring["rest"] = at
    draft.joints[joint.name].value["spring"] = spring
    claim: Claim = {("joints", joint.name, "spring"): spring}
    draft.carry(f"joint {joint.name}: a spring with stiffness {force:g}", stiffness.span, claim)
    draft.use_parts(gazebo, "springStiffness", "springReference", "implicitSpringDamper", "provideFeedback")


def _start(draft: Draft, joint: Joint) -> None:
    """Set a start position outside of the joint's limits, by default zero, to the nearest limit."""
    limits, entry = _limits(draft, joint), draft.joints[joint.name]
    if joint.mimic is not None or limits is None:
        return
    wanted = entry.value.get("start", 0.0)
    start = min(max(wanted, limits[0]), limits[1])
    if start != wanted:
        entry.value["start"] = start
        text = f"joint {joint.name} starts at {start:g}, the legal position nearest to {f'{wanted:g}' if wanted else 'zero'}"
        draft.guess(text, joint.element.span)


def _velocities(draft: Draft, joints: Sequence[Joint]) -> None:
    """Add the velocity limits of the description to drives; joints without a drive have no set point to limit."""
    bounded: dict[str, tuple[float, Element]] = {}
    for joint in joints:
        limit, drive = joint.element.first("limit"), draft.joints[joint.name].value.get("drive")
        if limit is None or drive is None or joint.velocity is None:
            continue
        draft.use(limit)
        if "max_velocity" not in drive:
            drive["max_velocity"] = joint.velocity
            bounded[joint.name] = (joint.velocity, limit)
    if bounded:
        told = ", ".join(f"{printable(name)} {fastest:g}" for name, (fastest, _) in bounded.items())
        claim: Claim = {("joints", name, "drive", "max_velocity"): each[0] for name, each in bounded.items()}
        span = next(iter(bounded.values()))[1].span
        draft.carry(f"velocity limits of drives: {told}", span, claim)


def report_weak_wheels(draft: Draft) -> None:
    """Add a remark on driven wheels that their own losses keep below 1 m/s within their effort limits."""
    slow: dict[str, list[Joint]] = {}
    for joint in draft.description.moving():
        wheel = draft.wheels.get(joint.name)
        if wheel is None or "drive" not in draft.joints[joint.name].value or joint.effort is None:
            continue
        damping, friction = joint.losses
        speed = (joint.effort - friction) / damping * wheel.radius if damping > 0 else _FAST
        if joint.effort <= friction:
            speed = 0.0
        if speed < _FAST:
            own = f"its friction of {friction:g} N m and damping of {damping:g} N m s/rad"
            text = f"the effort limit of {joint.effort:g} N m, less {own}, is enough for at most {speed:.2g} m/s"
            slow.setdefault(text, []).append(joint)
    for text, joints in slow.items():
        names = ", ".join(joint.name for joint in joints)
        draft.notice(f"wheel joints {names}: {text}", joints[0].element.span)
