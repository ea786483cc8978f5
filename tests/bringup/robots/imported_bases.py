"""Wheeled bases as their descriptions tell of them in different ways, and their import."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from graphengine.bringup.robots.controllers_file import load_parameters
from graphengine.bringup.robots.import_robot import Imported, Origin, import_robot
from graphengine.bringup.robots.robot_source import Wishes, read_source
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import parse
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
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


def slow(text: str, velocity: float) -> str:
    """The description with a velocity limit (rad/s) of all continuous joints."""
    return text.replace(
        '<axis xyz="0 1 0"/></joint>', f'<axis xyz="0 1 0"/><limit effort="50" velocity="{velocity}"/></joint>'
    )


def sdf(base: Base, *more: str) -> str:
    """A base as SDF: the same links and joints, with poses in frames of all kinds, and its wheels given in the model's frame."""
    size = 0.9 * max(abs(wheel.x) for wheel in base.wheels) + 0.1
    inertia = base.mass * size**2 / 3
    content = [_sdf_link("base_link", base.mass, (inertia, inertia, 1.5 * inertia))]
    for wheel in base.wheels:
        mass = 0.05 * base.mass
        about, across = mass * base.radius**2 / 2, mass * (3 * base.radius**2 + base.width**2) / 12
        shape = f"<cylinder><radius>{base.radius}</radius><length>{base.width}</length></cylinder>"
        # the link lies on its side, as wheels in SDF mostly do, and the joint upright at the same place
        pose = f"<pose>{wheel.x} {wheel.y} {base.radius} -1.5707963267948966 0 0</pose>"
        collision = f'<collision name="c"><geometry>{shape}</geometry></collision>'
        content.append(_sdf_link(wheel.name, mass, (across, across, about), pose + collision))
        axis = '<axis><xyz expressed_in="__model__">0 1 0</xyz></axis>'
        content.append(_sdf_joint(f"{wheel.name}_joint", "revolute", "base_link", wheel.name, axis))
    for name, x in (("front_ball", 0.12), ("rear_ball", -0.12)):
        ball = '<collision name="c"><geometry><sphere><radius>0.02</radius></sphere></geometry></collision>'
        pose = f'<pose relative_to="axles">{x} 0 -0.03 0 0 0</pose>'
        content.append(f'<link name="{name}">{pose}<inertial><mass>1e-6</mass></inertial>{ball}</link>')
        content.append(_sdf_joint(f"{name}_joint", "fixed", "base_link", name))
    frame = f'<frame name="axles" attached_to="base_link"><pose relative_to="__model__">0 0 {base.radius} 0 0 0</pose></frame>'
    plugins = [plugin.removeprefix("<gazebo>").removesuffix("</gazebo>") for plugin in more]
    whole = "\n".join([frame, *content, *plugins])
    return f'<sdf version="1.9"><model name="{base.name}">{whole}</model></sdf>'


def _sdf_link(name: str, mass: float, moments: tuple[float, float, float], content: str = "") -> str:
    place = content or '<pose relative_to="axles"/>'
    terms = "".join(f"<{term}>{moment}</{term}>" for term, moment in zip(("ixx", "iyy", "izz"), moments, strict=True))
    return f'<link name="{name}">{place}<inertial><mass>{mass}</mass><inertia>{terms}</inertia></inertial></link>'


def _sdf_joint(name: str, kind: str, parent: str, child: str, content: str = "") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{content}</joint>'


def imported_sdf(folder: Path, text: str) -> Imported:
    """Import a model of SDF, which must succeed."""
    findings, path, target = Findings(), folder / "bot.sdf", folder / "robots" / "bot.yaml"
    path.write_text(text, encoding="utf-8")
    root = parse(text.encode(), "bot.sdf", findings, "S103")
    assert root is not None
    packages = Packages(folder, (), Files.of(path, (), folder))
    source = read_source(path, root, target, Wishes(), packages, findings)
    assert source is not None, [error.render() for error in findings.errors]
    origin = Origin(source.element, packages, None, "bot.sdf", target, fixed_base=False)
    found = import_robot(origin, findings)
    assert found is not None, [error.render() for error in findings.errors]
    return found


def attempt(folder: Path, text: str, controllers: str = "") -> tuple[Imported | None, Findings]:
    """Import a description and controllers from `controllers.yaml`; the robot file is not written."""
    findings = Findings()
    element = parse(text.encode(), "bot.urdf", findings, "S103")
    if element is None:
        return None, findings
    document = None
    if controllers:
        (folder / "controllers.yaml").write_text(controllers, encoding="utf-8")
        document = load_parameters(folder / "controllers.yaml", findings, "controllers.yaml")
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
