"""A look-alike of a robot arm: six joints, a table's worth of reach, and a gripper whose second finger mimics the first."""

from __future__ import annotations

from collections.abc import Mapping

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
FINGER, FOLLOWER = "finger", "other_finger"
LIMITS = {"shoulder_pan": 3.1, "shoulder_lift": 2.0, "elbow": 2.6, "wrist_1": 3.1, "wrist_2": 3.1}
SPEEDS = dict.fromkeys(JOINTS[:3], 2.0) | dict.fromkeys(JOINTS[3:], 3.0)
BENT = (0.0, -0.6, 1.2, -0.6, 0.5, 0.0)
"""A pose within the limits, rad."""
_PARTS = (
    # joint, axis, place in the parent link (m), mass (kg), length (m)
    ("shoulder_pan", "0 0 1", "0 0 0.1", 3.5, 0.1),
    ("shoulder_lift", "0 1 0", "0 0 0.1", 6.0, 0.4),
    ("elbow", "0 1 0", "0 0 0.4", 3.0, 0.35),
    ("wrist_1", "0 1 0", "0 0 0.35", 1.2, 0.1),
    ("wrist_2", "1 0 0", "0 0 0.1", 1.0, 0.1),
    ("wrist_3", "0 0 1", "0 0 0.1", 0.4, 0.05),
)


def urdf() -> str:
    """The description."""
    parts = ['<robot name="arm">', _link("base_link", 4.0, 0.1)]
    parent = "base_link"
    for name, axis, place, mass, length in _PARTS:
        limit = LIMITS.get(name)
        kind = "revolute" if limit else "continuous"
        edges = f'lower="-{limit}" upper="{limit}"' if limit else ""
        parts.append(_link(f"{name}_link", mass, length))
        bounds = f'<limit {edges} effort="150" velocity="{SPEEDS[name]}"/>'
        parts.append(_joint(name, kind, parent, f"{name}_link", axis, place, bounds))
        parent = f"{name}_link"
    grip = '<limit lower="0" upper="0.04" effort="20" velocity="0.2"/>'
    mimic = f'{grip}<mimic joint="{FINGER}"/>'
    parts += [_link("left", 0.05, 0.05), _joint(FINGER, "prismatic", parent, "left", "0 1 0", "0 0.01 0.05", grip)]
    parts += [
        _link("right", 0.05, 0.05),
        _joint(FOLLOWER, "prismatic", parent, "right", "0 -1 0", "0 -0.01 0.05", mimic),
    ]
    return "\n".join([*parts, "</robot>\n"])


def robot_file(start: Mapping[str, float] | None = None) -> str:
    """The robot file: fixed to the world, with drives as importers write them for arms; the follower has none.

    Args:
        start: positions at the start, rad; by default the bent pose.
    """
    start = start or dict(zip(JOINTS, BENT, strict=True))
    lines = ["format: 1", "robot: arm", "urdf: arm.urdf", "fixed_base: true", "joints:"]
    habits = "gravity_compensation: true, interpolate: true"
    for name, stiffness in zip(JOINTS, (8000, 8000, 4000, 800, 400, 200), strict=True):
        drive = f"{{stiffness: {stiffness}, damping: {stiffness / 20}, {habits}}}"
        lines.append(f"  {name}: {{start: {start[name]}, drive: {drive}}}")
    return "\n".join([*lines, f"  {FINGER}: {{drive: {{stiffness: 2000, damping: 60, {habits}}}}}", ""])


def _link(name: str, mass: float, length: float) -> str:
    across, along = mass * (0.05**2 + length**2 / 12), mass * 0.05**2
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 {length / 2}"/><mass value="{mass}"/>'
        f'<inertia ixx="{across}" iyy="{across}" izz="{along}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _joint(name: str, kind: str, parent: str, child: str, axis: str, place: str, rest: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/><axis xyz="{axis}"/>{rest}</joint>'
    )
