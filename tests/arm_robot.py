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


def urdf(*, shapes: bool = False) -> str:
    """The description.

    Args:
        shapes: whether the links have shapes, which cameras see and nothing touches.
    """
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
    description = "\n".join([*parts, "</robot>\n"])
    return _with_shapes(description) if shapes else description


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


LIGHT, DARK, ACCENT = "0.85 0.87 0.9 1", "0.18 0.2 0.23 1", "0.95 0.45 0.08 1"
_ALONG, _ACROSS = "0 0 0", "1.5708 0 0"
_SHAPES: Mapping[str, tuple[tuple[str, str, str, str], ...]] = {
    # shape, place of its middle (m), orientation (rad), colour
    "base_link": (("r.09 l.1", "0 0 .05", _ALONG, DARK),),
    "shoulder_pan_link": (("r.075 l.1", "0 0 .05", _ALONG, LIGHT),),
    "shoulder_lift_link": (
        ("r.07 l.17", "0 0 0", _ACROSS, ACCENT),
        ("r.05 l.4", "0 0 .2", _ALONG, LIGHT),
    ),
    "elbow_link": (("r.06 l.15", "0 0 0", _ACROSS, ACCENT), ("r.042 l.35", "0 0 .175", _ALONG, LIGHT)),
    "wrist_1_link": (("r.045 l.11", "0 0 0", _ACROSS, ACCENT), ("r.038 l.1", "0 0 .05", _ALONG, LIGHT)),
    "wrist_2_link": (("r.04 l.09", "0 0 0", "0 1.5708 0", DARK), ("r.036 l.1", "0 0 .05", _ALONG, LIGHT)),
    "wrist_3_link": (("r.04 l.05", "0 0 .02", _ALONG, DARK), (".05 .14 .02", "0 0 .05", _ALONG, DARK)),
    "left": ((".03 .015 .09", "0 .01 .055", _ALONG, LIGHT),),
    "right": ((".03 .015 .09", "0 -.01 .055", _ALONG, LIGHT),),
}
"""Cylinders (radius and length, m) and boxes (sides, m) of each link."""


def _with_shapes(description: str) -> str:
    for link, shapes in _SHAPES.items():
        visuals = ""
        for shape, place, turn, colour in shapes:
            radius, _, length = shape.removeprefix("r").partition(" l")
            cylinder = f'<cylinder radius="{radius}" length="{length}"/>'
            form = cylinder if shape.startswith("r") else f'<box size="{shape}"/>'
            material = f'<material name="{colour}"><color rgba="{colour}"/></material>'
            visuals += f'<visual><origin xyz="{place}" rpy="{turn}"/><geometry>{form}</geometry>{material}</visual>'
        description = description.replace(f'<link name="{link}">', f'<link name="{link}">{visuals}')
    return description


def _joint(name: str, kind: str, parent: str, child: str, axis: str, place: str, rest: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/><axis xyz="{axis}"/>{rest}</joint>'
    )
