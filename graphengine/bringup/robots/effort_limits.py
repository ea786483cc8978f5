"""Finds wheel joints whose effort limit is too low for their own friction and damping."""

from __future__ import annotations

from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Draft, Remark

_FAST = 1.0
"""Speed of a base (m/s) that its wheels should reach within their effort limits."""


def fill(draft: Draft) -> None:
    """Add a remark on driven wheels whose effort limit is too low for a speed of 1 m/s, considering only their own losses."""
    slow: dict[str, list[Joint]] = {}
    for joint in draft.description.moving():
        wheel = draft.wheels.get(joint.name)
        if wheel is None or "drive" not in draft.entry("joints", joint.name).value or joint.effort is None:
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
        draft.noticed.append(Remark(f"wheel joints {names}: {text}", joints[0].element.span))
