"""Descriptions of arms to import."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

BASE = '<link name="{}"><inertial><mass value="4"/><inertia ixx=".02" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial>'
BASE += '<collision><geometry><cylinder radius=".08" length=".1"/></geometry></collision></link>'
EFFORTS = (150.0, 150.0, 100.0, 28.0, 28.0, 20.0)
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0")
MASSES = (4.0, 8.0, 3.0, 1.5, 1.5, 0.5)
LENGTHS = (0.15, 0.4, 0.35, 0.1, 0.1, 0.08)


def joint(name: str, parent: str, child: str, at: str, axis: str, kind: str = "revolute", **limit: Any) -> str:
    limit = {"lower": -2.5, "upper": 2.5, "effort": 50, "velocity": 3} | limit
    limits = " ".join(f'{key}="{value}"' for key, value in limit.items() if value is not None)
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{at}"/><axis xyz="{axis}"/><limit {limits}/></joint>"""


def beam(name: str, mass: float, length: float) -> str:
    """A link along its z axis."""
    side, end = mass * length**2 / 12 + 1e-4, mass * 0.03**2 + 1e-4
    return f"""<link name="{name}"><inertial><origin xyz="0 0 {length / 2}"/><mass value="{mass}"/>
    <inertia ixx="{side}" iyy="{side}" izz="{end}" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 {length / 2}"/><geometry><box size=".05 .05 {length}"/></geometry></collision></link>"""


def limb(name: str, count: int, base: str = "base_link", at: str = "0 0 .05", down: bool = False, **limit: Any) -> str:
    """A chain of joints `NAME1`, `NAME2`, …, each with a link `NAME1_link`, …"""
    parts, parent = [], base
    for index, (mass, length, axis) in enumerate(list(zip(MASSES, LENGTHS, AXES, strict=True))[:count], 1):
        parts += [beam(f"{name}{index}_link", mass, -length if down else length)]
        own = {"effort": EFFORTS[index - 1]} | limit
        parts += [joint(f"{name}{index}", parent, f"{name}{index}_link", at, axis, **own)]
        parent, at = f"{name}{index}_link", f"0 0 {-length if down else length}"
    return "".join(parts).replace('size=".05 .05 -', 'size=".05 .05 ')


def robot(*parts: str, base: str = "base_link") -> str:
    return f'<robot name="arm">{BASE.format(base)}{"".join(parts)}</robot>'


def joints_of(count: int = 6, name: str = "j") -> Sequence[str]:
    return [f"{name}{index}" for index in range(1, count + 1)]
