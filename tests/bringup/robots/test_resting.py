"""How an imported robot rests on a floor: what carries it, what must slide, and where its weight lies."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bringup.robots.harness import CASTER, CHASSIS, INERTIA, imported, keys, noticed, rover, wheel


def test_a_caster_that_slides_is_reported_with_its_share_of_the_weight(tmp_path: Path) -> None:
    robot = imported(tmp_path, rover(CASTER))
    material = keys(robot)["materials"]["CasterMaterial"]
    assert material == {"static_friction": 0.0, "dynamic_friction": 0.0, "combine": "min", "bind": ["caster"]}
    (told,) = noticed(robot)
    # 10 kg pull at 0.05 m behind the axle, the caster stands at 0.25 m: 2 kg of 12.
    assert told == "19.7 N, 17% of the weight, rest on caster, which does not roll"


ROLLER = """<link name="roller"><inertial><mass value=".01"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/>
    </inertial><collision><geometry><sphere radius=".05"/></geometry></collision></link>
  <joint name="roller_joint" type="continuous">
    <parent link="base_link"/><child link="roller"/><origin xyz="-.25 0 -.05"/><axis xyz="1 0 0"/>
  </joint><gazebo><plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
    <left_joint>left_joint</left_joint><right_joint>right_joint</right_joint>
    <wheel_separation>.4</wheel_separation><wheel_radius>.1</wheel_radius>
  </plugin></gazebo>"""


@pytest.mark.parametrize("plugin", [True, False])
def test_a_caster_that_rolls_only_sideways_slides_too(tmp_path: Path, plugin: bool) -> None:
    robot = imported(tmp_path, rover(ROLLER if plugin else ROLLER[: ROLLER.index("<gazebo>")]))
    materials = keys(robot)["materials"]
    assert materials["CasterMaterial"]["bind"] == ["roller"]  # type: ignore[index]
    assert materials["WheelMaterial"]["bind"] == ["left_wheel", "right_wheel"]  # type: ignore[index]
    (told,) = noticed(robot)
    # As above, and its own 0.01 kg.
    assert told == "19.8 N, 17% of the weight, rest on roller, which rolls only sideways"


@pytest.mark.parametrize("ahead", [False, True])
def test_an_acceleration_beyond_the_grip_of_the_driven_wheels_is_reported(tmp_path: Path, ahead: bool) -> None:
    """A load of M a h / l shifts to a caster behind the wheels as the robot starts, and to one ahead of them as it stops.

    10 kg of 12 stand on the driven wheels, whose friction is 1. The centre of mass is h above the floor, the caster at l.
    """
    held, height, length = 9.81 * 10 / 12, (10 * 0.15 + 2 * 0.1) / 12, 0.25
    less = held / (1 + height / length)
    chassis, caster = CHASSIS, CASTER
    if ahead:
        chassis, caster = chassis.replace("-.05 0 .05", ".05 0 .05"), caster.replace("-.25", ".25")
        chassis = chassis.replace("-.1 0 .06", ".1 0 .06")
    assert 5.15 < less < 5.25 < 7.0 < held
    plugin = "<max_linear_acceleration>7</max_linear_acceleration></plugin>"
    drive = ROLLER[ROLLER.index("<gazebo>") :].replace("</plugin>", plugin)
    robot = imported(tmp_path, rover(caster, drive, chassis=chassis))
    verb, limit = ("stops", "deceleration") if ahead else ("starts", "acceleration")
    said = f"the driven wheels grip up to 5.2 m/s2 as the robot {verb}, and slip beyond, so it {verb} later than with"
    assert [text for text in noticed(robot) if "slip" in text] == [f"{said} {limit} 7 m/s2"]


@pytest.mark.parametrize(("limit", "told"), [(9.7, 0), (9.9, 2)])
def test_the_driven_wheels_hold_at_most_all_weight(tmp_path: Path, limit: float, told: int) -> None:
    """Four driven wheels carry all weight, in whichever way it shifts."""
    four = [
        wheel(f"{end}_{side}", y).replace('origin xyz="0', f'origin xyz="{x}')
        for end, x in (("front", 0.2), ("rear", -0.2))
        for side, y in (("left", 0.2), ("right", -0.2))
    ]
    names = "".join(
        f"<{side}_joint>{end}_{side}_joint</{side}_joint>" for end in ("front", "rear") for side in ("left", "right")
    )
    plugin = f"""<gazebo><plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">{names}
      <wheel_separation>.4</wheel_separation><wheel_radius>.1</wheel_radius>
      <max_linear_acceleration>{limit}</max_linear_acceleration></plugin></gazebo>"""
    robot = imported(tmp_path, rover(plugin, wheels="".join(four)))
    assert len([text for text in noticed(robot) if text.startswith("the driven wheels grip up to 9.8 m/s2")]) == told


def test_driven_wheels_above_the_floor_are_reported(tmp_path: Path) -> None:
    """The caster reaches 0.15 m down, and the wheels 0.1 m."""
    low = CASTER.replace("-.25 0 -.05", "-.25 0 -.1")
    (told,) = noticed(imported(tmp_path, rover(low, ROLLER[ROLLER.index("<gazebo>") :])))
    assert told == "the driven wheels are 50 mm above the lowest collider, that of caster; they may not reach the floor"


def test_a_caster_that_rolls_forward_keeps_its_grip_along(tmp_path: Path) -> None:
    robot = imported(tmp_path, rover(ROLLER.replace('axis xyz="1 0 0"', 'axis xyz="0 1 0"')))
    assert "CasterMaterial" not in keys(robot)["materials"]
    assert noticed(robot) == []


def test_a_chassis_that_drags_slides_too(tmp_path: Path) -> None:
    low = CHASSIS.replace('xyz="-.1 0 .06"', 'xyz="-.1 0 -.07"')
    robot = imported(tmp_path, rover(chassis=low))
    assert keys(robot)["materials"]["CasterMaterial"]["bind"] == ["base_link"]  # type: ignore[index]
    assert "rest on base_link, which does not roll" in noticed(robot)[0]


def test_an_arm_without_drives_does_not_make_the_base_fall(tmp_path: Path) -> None:
    arm = f"""<link name="arm"><inertial><origin xyz="0 0 .4"/><mass value="2"/>{INERTIA}</inertial>
        <collision><origin xyz="0 0 .4"/><geometry><box size=".05 .05 .8"/></geometry></collision></link>
      <joint name="arm_joint" type="revolute">
        <parent link="base_link"/><child link="arm"/><origin xyz="-.1 0 .1" rpy="0 .2 0"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" effort="5" velocity="1"/>
      </joint>"""
    robot = imported(tmp_path, rover(CASTER, arm))
    assert keys(robot)["materials"]["CasterMaterial"]["bind"] == ["caster"]  # type: ignore[index]


@pytest.mark.parametrize(("y", "told"), [(0.0, False), (0.08, True)])
def test_a_weight_to_one_side_is_reported(tmp_path: Path, y: float, told: bool) -> None:
    robot = imported(tmp_path, rover(CASTER, chassis=CHASSIS.replace('xyz="-.05 0 .05"', f'xyz="-.05 {y} .05"')))
    assert any("centre of mass lies 67 mm to one side" in text for text in noticed(robot)) is told


def test_a_robot_that_falls_over_is_reported(tmp_path: Path) -> None:
    high = CHASSIS.replace('xyz="-.05 0 .05"', 'xyz="-.05 .5 1"')
    assert noticed(imported(tmp_path, rover(chassis=high))) == [
        "on a flat floor the robot does not come to rest on its wheels"
    ]


def test_a_robot_that_leans_is_reported(tmp_path: Path) -> None:
    robot = imported(tmp_path, rover(CASTER.replace("-.25 0 -.05", "-.25 0 -.03")))
    (degrees,) = [float(text.split()[-2]) for text in noticed(robot) if "the robot leans by" in text]
    assert degrees == pytest.approx(4.61, abs=0.15)  # 0.03 cos a + 0.25 sin a = 0.05


def test_nothing_slides_on_a_fixed_base_or_without_wheels(tmp_path: Path) -> None:
    assert "CasterMaterial" not in keys(imported(tmp_path, rover(CASTER), fixed_base=True))["materials"]
    fixed = wheel("left", 0.2, kind="fixed") + wheel("right", -0.2, kind="fixed")
    assert "materials" not in keys(imported(tmp_path, rover(CASTER, wheels=fixed)))


def test_the_same_description_gives_the_same_file(tmp_path: Path) -> None:
    assert imported(tmp_path, rover(CASTER)).files == imported(tmp_path, rover(CASTER)).files


def test_a_wheel_that_hangs_above_the_floor_is_reported(tmp_path: Path) -> None:
    """As in a description from CAD: one of four wheels is 1 mm higher than the others."""
    wheels = "".join(
        wheel(name, y).replace(f'<origin xyz="0 {y} 0"', f'<origin xyz="{x} {y} {z}"')
        for name, x, y, z in (("a", 0.2, 0.2, 0.001), ("b", 0.2, -0.2, 0), ("c", -0.2, 0.2, 0), ("d", -0.2, -0.2, 0))
    )
    told = noticed(imported(tmp_path, rover(wheels=wheels)))[-1]
    assert told.startswith("wheels that carry no weight, as others reach further down: a_wheel; ")


def test_a_robot_without_gravity_has_no_resting_links(tmp_path: Path) -> None:
    links = ("base_link", "left_wheel", "right_wheel")
    tags = [f'<gazebo reference="{link}"><gravity>false</gravity></gazebo>' for link in links]
    robot = imported(tmp_path, rover(ROLLER[ROLLER.index("<gazebo>") :], *tags))
    assert not any("rest on" in told or "grip" in told for told in noticed(robot))
