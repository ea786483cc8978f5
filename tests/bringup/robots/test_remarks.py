"""What the report of an import says was carried over stands in the robot file, for every section."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bringup.robots.harness import CHASSIS, INERTIA, imported, keys, rover, wheel

PAINTED = CHASSIS.replace("</link>", '<visual><geometry><box size=".1 .1 .1"/></geometry></visual></link>')


def turned(name: str, more: str = "", limits: str = 'lower="-1" upper="1"') -> str:
    """A link on a revolute joint."""
    return f"""<link name="{name}"><inertial><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="{name}_joint" type="revolute">
    <parent link="base_link"/><child link="{name}"/><origin xyz="0 0 .2"/><axis xyz="0 0 1"/>
    <limit {limits} effort="5" velocity="2"/>{more}
  </joint>"""


def control(name: str, start: float) -> str:
    """A joint of a <ros2_control> system that takes positions."""
    state = f'<state_interface name="position"><param name="initial_value">{start}</param></state_interface>'
    return f'<joint name="{name}_joint"><command_interface name="position"/>{state}</joint>'


SKID = "".join(
    wheel(f"{end}_{side}", y).replace('<origin xyz="0 ', f'<origin xyz="{x} ')
    for end, x in (("front", 0.15), ("rear", -0.15))
    for side, y in (("left", 0.2), ("right", -0.2))
)
LIDAR = """<gazebo reference="base_link"><sensor type="lidar" name="laser"><update_rate>10</update_rate><topic>scan</topic>
  <lidar><scan><horizontal><samples>90</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
  <range><min>0.1</min><max>8</max></range></lidar></sensor></gazebo>"""
DRIVE = """<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so"><left_joint>left_joint</left_joint>
  <right_joint>right_joint</right_joint><wheel_separation>0.4</wheel_separation><wheel_diameter>0.2</wheel_diameter>
  </plugin></gazebo>"""
EVERYTHING = rover(
    turned("neck", '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="0.6" k_velocity="1"/>'),
    turned("tail"),
    turned("ear", '<mimic joint="tail_joint"/>'),
    '<gazebo reference="base_link"><mu1>0.5</mu1><mu2>0.5</mu2><gravity>false</gravity>',
    "<material>Gazebo/Red</material></gazebo>",
    '<gazebo reference="left_wheel"><mu1>0.9</mu1><mu2>0.3</mu2><fdir1>1 0 0</fdir1></gazebo>',
    '<gazebo reference="tail_joint"><springStiffness>3</springStiffness></gazebo>',
    f'<ros2_control name="c" type="system">{control("neck", 0.4)}{control("tail", 3.0)}{control("ear", 0.2)}</ros2_control>',
    LIDAR,
    DRIVE,
    chassis=PAINTED,
)

WORDS = ["friction 0.5", "0.3 across it", "a colour", "no gravity", "soft limits -0.5 to 0.6", "a spring with"]
WORDS += ["velocity limits", "start position 0.4", "position drive", "lidar of 90 beams", "base: differential"]


def test_every_remark_on_a_carried_value_matches_the_file(tmp_path: Path) -> None:
    robot = imported(tmp_path, EVERYTHING)
    data, carried = keys(robot), robot.draft.carried
    assert [remark.text for remark in carried if not remark.holds(data)] == []
    assert {"joints", "materials", "links", "sensors", "graphs"} <= data.keys()
    texts = [remark.text for remark in carried]
    for word in WORDS:
        assert any(word in text for text in texts), (word, texts)


@pytest.mark.parametrize("section", ["joints", "materials", "links", "sensors", "graphs"])
def test_a_remark_does_not_hold_in_a_file_without_its_section(tmp_path: Path, section: str) -> None:
    robot = imported(tmp_path, EVERYTHING)
    data = {key: value for key, value in keys(robot).items() if key != section}
    assert any(not remark.holds(data) for remark in robot.draft.carried)


def test_a_start_position_that_is_cut_to_a_limit_or_belongs_to_a_mimic_joint_is_not_carried_over(
    tmp_path: Path,
) -> None:
    robot = imported(tmp_path, EVERYTHING)
    texts = [remark.text for remark in robot.draft.carried]
    assert [text for text in texts if "start position" in text] == ["joint neck_joint: start position 0.4"]
    assert "joint tail_joint starts at 1, the legal position nearest to 3" in [
        each.text for each in robot.draft.guessed
    ]


def test_friction_that_another_material_replaces_is_not_reported(tmp_path: Path) -> None:
    names = ["base_link", *(f"{end}_{side}_wheel" for end in ("front", "rear") for side in ("left", "right"))]
    surfaces = "".join(f'<gazebo reference="{name}"><mu1>0.5</mu1><mu2>0.5</mu2></gazebo>' for name in names)
    text = rover(surfaces, wheels=SKID).replace(
        'name="rover"', 'name="mecanum"'
    )  # whose wheels get the friction of rollers
    robot = imported(tmp_path, text)
    bound = {
        link
        for material in keys(robot)["materials"].values()
        for link in material["bind"]  # type: ignore[index]
        if (material["static_friction"], material.get("across")) == (0.5, None)  # type: ignore[index,attr-defined]
    }
    (told,) = [remark.text for remark in robot.draft.carried if ": friction 0.5" in remark.text]
    assert told == f"link{'s' * (len(bound) > 1)} {', '.join(name for name in names if name in bound)}: friction 0.5"
    assert len(bound) < len(names)
