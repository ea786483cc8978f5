"""Wheeled bases as their descriptions tell of them in different ways, and their import."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from graphengine.format.diagnostics import Findings
from graphengine.format.document import load
from graphengine.format.files import Files
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.xml import parse
from graphengine.physics.importing.import_robot import Imported, Origin, import_robot
from tests.physics.bases import MECANUM, SKID, Base, Wheel

DIFFERENTIAL = Base("diff", (Wheel("left", 0.0, 0.15), Wheel("right", 0.0, -0.15)), 0.05, 0.03, 5.0)
CAR = Base(
    "car",
    (
        Wheel("front_left", 0.2, 0.15, steering=-1),
        Wheel("front_right", 0.2, -0.15, steering=-1),
        Wheel("rear_left", -0.2, 0.15),
        Wheel("rear_right", -0.2, -0.15),
    ),
    0.05,
    0.03,
    5.0,
)
"""Its steering axes point down."""
BASES = {"differential": DIFFERENTIAL, "skid": SKID, "mecanum": MECANUM, "car": CAR}
BALLS = "".join(
    f'''<link name="{name}"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="{name}_joint" type="fixed">
  <parent link="base_link"/><child link="{name}"/><origin xyz="{x} 0 -0.03"/>
</joint>'''
    for name, x in (("front_ball", 0.12), ("rear_ball", -0.12))
)
"""Casters, which a base of two wheels needs."""
PLUGIN = """<gazebo><plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
  <left_joint>left_joint</left_joint><right_joint>right_joint</right_joint>
  <wheel_separation>0.3</wheel_separation><wheel_radius>0.05</wheel_radius>
</plugin></gazebo>"""
CONTROLLERS = """controller_manager:
  ros__parameters:
    update_rate: 50
    base_controller: {type: diff_drive_controller/DiffDriveController}
base_controller:
  ros__parameters:
    left_wheel_names: [left_joint]
    right_wheel_names: [right_joint]
    wheel_separation: 0.3
    wheel_radius: 0.05
"""


def interfaces(**kinds: str) -> str:
    """A `<ros2_control>` with one command interface of a kind for each joint; none if the kind is empty."""
    joints = "".join(
        f'<joint name="{joint}">{f"""<command_interface name="{kind}"/>""" if kind else ""}</joint>'
        for joint, kind in kinds.items()
    )
    return f'<ros2_control name="hardware" type="system">{joints}</ros2_control>'


def description(base: Base, *more: str) -> str:
    """The description of a base with more elements."""
    balls = [BALLS] if len(base.wheels) == 2 else []
    return base.urdf().replace("</robot>", "\n".join(["", *balls, *more, "</robot>"]))


def attempt(folder: Path, text: str, controllers: str = "") -> tuple[Imported | None, Findings]:
    """Import a description and controllers from `controllers.yaml`; the robot file is not written."""
    findings = Findings()
    element = parse(text.encode(), "bot.urdf", findings, "S103")
    if element is None:
        return None, findings
    document = None
    if controllers:
        (folder / "controllers.yaml").write_text(controllers, encoding="utf-8")
        document = load(folder / "controllers.yaml", findings, "controllers.yaml")
        if findings.errors:
            return None, findings
    target = folder / "robots" / "bot.yaml"
    files = Files.of(folder / "bot.urdf", (), folder)
    packages = Packages(folder, (), files)
    origin = Origin(element, packages, None, "bot.urdf", target, fixed_base=False, controllers=document)
    return import_robot(origin, findings), findings


def imported(folder: Path, text: str, controllers: str = "") -> Imported:
    """Import a description, which must succeed."""
    found, findings = attempt(folder, text, controllers)
    assert found is not None, findings.items
    return found


def robot_file(found: Imported) -> dict[str, Any]:
    """The data of the robot file that an import writes."""
    data = yaml.safe_load(found.files[max(found.files, key=lambda path: path.suffix == ".yaml")])
    assert isinstance(data, dict)
    return data


def scene(folder: Path, found: Imported) -> Path:
    """Write the files of an import and a scene with the robot on a flat floor."""
    for path, text in found.files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    height = -(found.lowest or 0.0) + 0.001
    robots = f"robots: {{bot: {{use: robots/bot.yaml, position: [0, 0, {height}]}}}}\n"
    text = f"scene: s\nworld: worlds/flat_grid.xml\nsettle: true\n{robots}"
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    return folder / "scene.yaml"


def remarks(found: Imported) -> str:
    """All that an import says, a line for each remark, with its kind."""
    draft = found.draft
    kinds = {"carried": draft.carried, "noticed": draft.noticed, "guessed": draft.guessed, "lost": draft.lost}
    return "\n".join(f"{kind}: {remark.text}" for kind, items in kinds.items() for remark in items)
