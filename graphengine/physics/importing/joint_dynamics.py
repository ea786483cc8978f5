"""What a description says of joints besides their drives: limits of velocity and position, springs, where they start."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.format.wording import printable
from graphengine.physics.description.urdf import UrdfJoint
from graphengine.physics.files.xml import Element, numbers
from graphengine.physics.importing.draft import Draft, Remark


def fill(draft: Draft) -> None:
    """Carry over soft limits, springs and velocity limits of drives; start each joint at a legal position."""
    joints = {joint.name: joint for joint in draft.urdf.moving()}
    for gazebo in draft.urdf.element.all("gazebo"):
        if gazebo.get("reference") in joints:
            _spring(draft, joints[gazebo.get("reference")], gazebo)
        elif not gazebo.get("reference"):
            _static(draft, gazebo)
    for joint in joints.values():
        limits = _soft_limits(draft, joint) or joint.limits
        _start(draft, joint, limits)
    _velocities(draft, list(joints.values()))


def _soft_limits(draft: Draft, joint: UrdfJoint) -> tuple[float, float] | None:
    """Limits of a safety controller, which stops a joint before its own limits do; 0 to 0 stands for none."""
    safety = joint.element.first("safety_controller")
    if safety is None or joint.limits is None:
        return None
    lower, upper = (_number(safety, f"soft_{end}_limit") for end in ("lower", "upper"))
    if lower is None or upper is None or lower >= upper:
        return None
    low, high = max(lower, joint.limits[0]), min(upper, joint.limits[1])
    draft.use(safety)
    if (low, high) == joint.limits or low >= high:
        return None
    entry = draft.entry("joints", joint.name)
    entry.value["limits"] = [low, high]
    draft.carried.append(Remark(f"joint {joint.name}: soft limits {low:g} to {high:g}", safety.span))
    return low, high


def _spring(draft: Draft, joint: UrdfJoint, gazebo: Element) -> None:
    """The spring that Gazebo gives a joint, such as that of a wheel drop."""
    stiffness, rest = gazebo.first("springStiffness"), gazebo.first("springReference")
    force = numbers(stiffness.text, 1) if stiffness is not None else None
    if stiffness is None or force is None or force[0] <= 0:
        return
    spring = {"stiffness": force[0]}
    if rest is not None and (at := numbers(rest.text, 1)) is not None:
        spring["rest"] = at[0]
    draft.entry("joints", joint.name).value["spring"] = spring
    draft.carried.append(Remark(f"joint {joint.name}: a spring of {force[0]:g}", stiffness.span))
    for part in gazebo.children:
        if part.tag in ("springStiffness", "springReference", "implicitSpringDamper", "provideFeedback"):
            draft.use(part)


def _start(draft: Draft, joint: UrdfJoint, limits: tuple[float, float] | None) -> None:
    """A joint whose limits leave out zero starts at the nearest legal position."""
    entry = draft.entry("joints", joint.name)
    if joint.mimic is not None or limits is None or "start" in entry.value or limits[0] <= 0 <= limits[1]:
        return
    start = limits[0] if limits[0] > 0 else limits[1]
    entry.value["start"] = start
    text = f"joint {joint.name} starts at {start:g}, the legal position nearest to zero"
    draft.guessed.append(Remark(text, joint.element.span))


def _velocities(draft: Draft, joints: Sequence[UrdfJoint]) -> None:
    """Limits of velocity become those of drives; a joint without a drive has no set point to limit."""
    bounded: dict[str, Element] = {}
    for joint in joints:
        limit, drive = joint.element.first("limit"), draft.entry("joints", joint.name).value.get("drive")
        fastest = _number(limit, "velocity") if limit is not None else None
        if limit is None or drive is None or fastest is None or fastest <= 0:
            continue
        draft.use(limit)
        if "max_velocity" not in drive:
            drive["max_velocity"] = fastest
            bounded[f"{joint.name} {fastest:g}"] = limit
    if bounded:
        told = ", ".join(map(printable, bounded))
        draft.carried.append(Remark(f"limits of velocity: {told}", next(iter(bounded.values())).span))


def _static(draft: Draft, gazebo: Element) -> None:
    static = gazebo.first("static")
    if static is not None and static.text.strip().lower() in ("true", "1"):
        draft.fixed_base = True
        draft.use(static)
        draft.carried.append(Remark("the base is fixed: static", static.span))


def _number(element: Element, attribute: str) -> float | None:
    """A number that an attribute holds; None without one."""
    values = numbers(element.get(attribute), 1)
    return values[0] if values is not None else None
