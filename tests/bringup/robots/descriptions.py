"""Robots with what Gazebo reads in them, and their import."""

from __future__ import annotations

from pathlib import Path

from graphengine.bringup.robots.import_robot import Imported, Origin, import_robot
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import parse
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files

INERTIA = '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>'
BODY = f"""<robot name="bot" xmlns:gz="http://gazebosim.org/schema">
  <link name="base_footprint"/>
  <link name="base_link">
    <inertial><mass value="2"/>{INERTIA}</inertial>
    <visual><geometry><box size=".2 .2 .1"/></geometry></visual>
    <collision><geometry><box size=".2 .2 .1"/></geometry></collision>
  </link>
  <joint name="base_joint" type="fixed">
    <parent link="base_footprint"/><child link="base_link"/><origin xyz="0 0 .05"/>
  </joint>
  <link name="arm">
    <inertial><mass value="1"/>{INERTIA}</inertial>
    <visual><geometry><sphere radius=".04"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>
    <collision><geometry><sphere radius=".04"/></geometry></collision>
  </link>
  <joint name="arm_joint" type="revolute">
    <parent link="base_link"/><child link="arm"/><origin xyz="0 .2 0" rpy="1.5707963267948966 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="0"/>
  </joint>
  <link name="base_scan"/>
  <joint name="scan_joint" type="fixed">
    <parent link="base_link"/><child link="base_scan"/><origin xyz="-.1 0 .2"/>
  </joint>
  <link name="imu_link"/>
  <joint name="imu_joint" type="fixed"><parent link="base_link"/><child link="imu_link"/></joint>
  <link name="camera_link"/>
  <joint name="camera_joint" type="fixed">
    <parent link="base_link"/><child link="camera_link"/><origin xyz=".1 0 .1"/>
  </joint>
  <link name="camera_optical_frame"/>
  <joint name="camera_optical_joint" type="fixed">
    <parent link="camera_link"/><child link="camera_optical_frame"/>
    <origin rpy="-1.5707963267948966 0 -1.5707963267948966"/>
  </joint>
"""
"""Without the end tag; 18 links and joints of a small robot with places for sensors."""
SCAN = """<scan><horizontal><samples>360</samples><resolution>1</resolution>
  <min_angle>0</min_angle><max_angle>6.28</max_angle></horizontal></scan>
  <range><min>0.12</min><max>3.5</max><resolution>0.015</resolution></range>"""


def sensor(link: str, kind: str, inside: str, name: str = "eye") -> str:
    """A sensor of a link, for Gazebo."""
    return f'<gazebo reference="{link}"><sensor name="{name}" type="{kind}">{inside}</sensor></gazebo>'


def attempt(folder: Path, *gazebo: str) -> tuple[Imported | None, Findings]:
    """Import the robot with elements for Gazebo; its robot file is not written."""
    findings = Findings()
    text = "\n".join([BODY, *gazebo, "</robot>"])
    element = parse(text.encode(), "bot.urdf", findings, "S103")
    if element is None:
        return None, findings
    target = folder / "robots" / "bot.yaml"
    files = Files.of(target, (), folder)
    origin = Origin(element, Packages(folder, (), files), None, "bot.urdf", target, fixed_base=False)
    return import_robot(origin, findings), findings


def imported(folder: Path, *gazebo: str) -> Imported:
    """Import the robot, which must succeed."""
    found, findings = attempt(folder, *gazebo)
    assert found is not None, findings.items
    return found


def written(folder: Path, *gazebo: str) -> Path:
    """Import the robot and write its files; the folder of scenes."""
    for path, text in imported(folder, *gazebo).files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder
