"""Descriptions to import: a small base with wheels, whose parts a test may replace."""

from __future__ import annotations

import math
from pathlib import Path

import yaml

from graphengine.bringup.robots.import_robot import Imported, Origin, import_robot
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import parse
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files

INERTIA = '<inertia ixx=".02" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/>'
CHASSIS = f"""<link name="base_link">
    <inertial><origin xyz="-.05 0 .05"/><mass value="10"/>{INERTIA}</inertial>
    <collision><origin xyz="-.1 0 .06"/><geometry><box size=".4 .3 .06"/></geometry></collision>
  </link>"""
CYLINDER = '<origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius=".1" length=".04"/></geometry>'
MESH = '<geometry><mesh filename="wheel.obj"/></geometry>'
CASTER = """<link name="caster">
    <collision><geometry><sphere radius=".05"/></geometry></collision>
  </link>
  <joint name="caster_joint" type="fixed">
    <parent link="base_link"/><child link="caster"/><origin xyz="-.25 0 -.05"/>
  </joint>"""


def wheel(name: str, y: float, collision: str = CYLINDER, *, kind: str = "continuous", more: str = "") -> str:
    """A wheel of radius 0.1 m beside the chassis."""
    return f"""<link name="{name}_wheel">
    <inertial><mass value="1"/>{INERTIA}</inertial><collision>{collision}</collision>
  </link>
  <joint name="{name}_joint" type="{kind}">
    <parent link="base_link"/><child link="{name}_wheel"/><origin xyz="0 {y} 0"/><axis xyz="0 1 0"/>{more}
  </joint>
"""


def rover(*parts: str, chassis: str = CHASSIS, wheels: str = "") -> str:
    wheels = wheels or wheel("left", 0.2) + wheel("right", -0.2)
    return f'<robot name="rover">{chassis}{wheels}{"".join(parts)}</robot>'


def drum(corners: int, radius: float = 0.1, width: float = 0.04, offset: float = 0.0) -> str:
    """An OBJ file of a prism about the y axis."""
    angles = [2 * math.pi * corner / corners for corner in range(corners)]
    points = [
        (radius * math.cos(angle), y, radius * math.sin(angle))
        for y in (offset - width / 2, offset + width / 2)
        for angle in angles
    ]
    rim = [(i, (i + 1) % corners) for i in range(corners)]
    sides = [face for i, j in rim for face in ((i, j, corners + j), (i, corners + j, corners + i))]
    ends = [face for i, j in rim[1:-1] for face in ((0, j, i), (corners, corners + i, corners + j))]
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    return "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in (*sides, *ends))]) + "\n"


def imported(folder: Path, text: str, *, fixed_base: bool = False) -> Imported:
    """Import a description that lies in a folder."""
    found, findings = try_import(folder, text, fixed_base=fixed_base)
    assert found is not None, "\n".join(finding.render() for finding in findings.errors)
    return found


def try_import(folder: Path, text: str, *, fixed_base: bool = False) -> tuple[Imported | None, Findings]:
    findings, path = Findings(), folder / "rover.urdf"
    path.write_text(text, encoding="utf-8")
    root = parse(text.encode(), str(path), findings, "S103")
    if root is None:
        return None, findings
    packages = Packages(folder, (), Files((folder.resolve(),)))
    return import_robot(
        Origin(root, packages, path, "rover.urdf", folder / "rover.yaml", fixed_base), findings
    ), findings


def keys(robot: Imported) -> dict[str, dict[str, object]]:
    """What the robot file says."""
    data = yaml.safe_load(list(robot.files.values())[-1])
    assert isinstance(data, dict)
    return data


def noticed(robot: Imported) -> list[str]:
    return [remark.text for remark in robot.draft.noticed]
