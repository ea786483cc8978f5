"""Models of SDF in a folder, their frames, and the URDF that they become."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import parse
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.sdf.sdf_files import SdfFiles
from graphengine.descriptions.sdf.sdf_frames import Scope, SdfFrame
from graphengine.descriptions.sdf.sdf_reader import read_sdf
from graphengine.devices.rotation import Pose, to_rpy
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files

BALL = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
INERTIA = "<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>"


def document(content: str, version: str = "1.9") -> str:
    """An SDF file."""
    return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{content}\n</sdf>\n'


def model(content: str, name: str = "m", more: str = "") -> str:
    """A model, with more attributes."""
    return f'<model name="{name}"{more}>{content}</model>'


def link(name: str, content: str = "", mass: float = 1.0) -> str:
    """A link with a mass, whose collisions and pose are given."""
    return f'<link name="{name}"><inertial><mass>{mass}</mass>{INERTIA}</inertial>{content}</link>'


def pose(*numbers: float, relative_to: str = "") -> str:
    """A pose; missing numbers are zero."""
    text = " ".join(map(repr, [*numbers, *[0.0] * (6 - len(numbers))]))
    return f'<pose relative_to="{relative_to}">{text}</pose>' if relative_to else f"<pose>{text}</pose>"


def joint(name: str, parent: str, child: str, content: str = "", kind: str = "fixed") -> str:
    """A joint."""
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{content}</joint>'


def scope(folder: Path, text: str) -> tuple[Scope, Findings]:
    """The names of the only model or world of a file in a folder."""
    findings = Findings()
    root = parse(text.encode(), str(folder / "main.sdf"), findings, "S103")
    assert root is not None
    files = SdfFiles(packages(folder), findings)
    return files.scope(root.children[0], files.main(folder / "main.sdf", root)), findings


def packages(folder: Path) -> Packages:
    """What a file in a folder can refer to."""
    return Packages(folder, (), Files.of(folder / "main.sdf", (), folder))


def frame(within: Scope, name: str) -> SdfFrame:
    """A frame by its name."""
    found = within.find(name)
    assert found is not None, name
    return found


def six(place: Pose) -> tuple[float, ...]:
    """A pose as the six numbers of `<pose>`."""
    return (*place[0], *to_rpy(place[1]))


def place(within: Scope, name: str) -> object:
    """Where a frame lies in the outermost scope, within 1e-9."""
    return pytest.approx(six(frame(within, name).place), abs=1e-9)


def converted(folder: Path, text: str, name: str = "") -> tuple[RobotDescription | None, Findings]:
    """A model of a file in a folder as links and joints."""
    findings = Findings()
    root = parse(text.encode(), str(folder / "main.sdf"), findings, "S103")
    assert root is not None, findings.items
    return read_sdf(folder / "main.sdf", root, packages(folder), findings, name), findings


def urdf(folder: Path, text: str, name: str = "") -> RobotDescription:
    """A model of a file in a folder as links and joints; it must have no errors."""
    found, findings = converted(folder, text, name)
    assert found is not None, [error.render() for error in findings.errors]
    return found


def errors(folder: Path, text: str, name: str = "") -> list[str]:
    """The errors of a file, each with its line."""
    found, findings = converted(folder, text, name)
    assert found is None
    return [f"{error.span.line if error.span else 0}: {error.message}" for error in findings.errors]
