"""What an import carries over of joints: soft limits, springs, velocities, where they start."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bringup.robots.harness import CASTER, INERTIA, imported, keys, rover, try_import, wheel

LIFT = f"""<link name="lift"><inertial><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="lift_joint" type="prismatic">
    <parent link="base_link"/><child link="lift"/><axis xyz="0 0 1"/>
    <limit lower="{{lower}}" upper="{{upper}}" effort="50" velocity=".1"/>{{more}}
  </joint>"""


def lift(lower: float = 0.0, upper: float = 0.4, more: str = "", outside: str = "") -> str:
    return rover(CASTER, LIFT.format(lower=lower, upper=upper, more=more), outside)


@pytest.mark.parametrize(
    ("limits", "start"),
    [((0.1, 0.4), 0.1), ((-0.4, -0.1), -0.1), ((0.0, 0.4), None), ((-0.1, 0.1), None)],
)
def test_a_joint_whose_limits_exclude_zero_starts_at_the_nearest_limit(
    tmp_path: Path, limits: tuple[float, float], start: float | None
) -> None:
    robot = imported(tmp_path, lift(*limits))
    assert keys(robot)["joints"]["lift_joint"].get("start") == start  # type: ignore[attr-defined]
    told = [remark for remark in robot.draft.guessed if "lift_joint starts at" in remark.text]
    assert bool(told) is (start is not None)


@pytest.mark.parametrize(
    ("soft", "limits"),
    [
        ('soft_lower_limit="0.05" soft_upper_limit="0.35"', [0.05, 0.35]),
        ('soft_lower_limit="-1" soft_upper_limit="0.35"', [0.0, 0.35]),
        ('soft_lower_limit="0" soft_upper_limit="0"', None),
        ('soft_lower_limit="nan" soft_upper_limit="x"', None),
        ('k_velocity="1"', None),
    ],
)
def test_soft_limits_become_limits_and_count_for_the_start(
    tmp_path: Path, soft: str, limits: list[float] | None
) -> None:
    robot = imported(tmp_path, lift(more=f"<safety_controller {soft}/>"))
    joint = keys(robot)["joints"]["lift_joint"]
    assert joint.get("limits") == limits  # type: ignore[attr-defined]
    assert joint.get("start") == (0.05 if limits == [0.05, 0.35] else None)  # type: ignore[attr-defined]
    moving = robot.robot.description.joints["lift_joint"].limits
    assert moving == (tuple(limits) if limits else (0.0, 0.4))


@pytest.mark.parametrize(
    ("tags", "spring"),
    [
        (
            "<springStiffness>400</springStiffness><springReference>.03</springReference>",
            {"stiffness": 400.0, "rest": 0.03},
        ),
        ("<springStiffness>400</springStiffness>", {"stiffness": 400.0}),
        ("<springStiffness>0</springStiffness>", None),
        ("<springStiffness>many</springStiffness>", None),
    ],
)
def test_springs_of_gazebo_become_springs(tmp_path: Path, tags: str, spring: dict[str, float] | None) -> None:
    gazebo = f'<gazebo reference="lift_joint"><implicitSpringDamper>1</implicitSpringDamper>{tags}</gazebo>'
    robot = imported(tmp_path, lift(outside=gazebo))
    assert keys(robot)["joints"]["lift_joint"].get("spring") == spring  # type: ignore[attr-defined]
    lost = [remark.text for remark in robot.draft.lost if "springStiffness" in remark.text]
    assert bool(lost) is (spring is None)


def test_a_velocity_limit_becomes_the_limit_of_the_drive(tmp_path: Path) -> None:
    more = '<limit effort="5" velocity="12"/>'
    robot = imported(tmp_path, rover(CASTER, wheels=wheel("left", 0.2, more=more) + wheel("right", -0.2)))
    assert keys(robot)["joints"]["left_joint"] == {"drive": {"damping": 589.0, "max_velocity": 12.0}}
    assert keys(robot)["joints"]["right_joint"] == {"drive": {"damping": 589.0}}
    assert "velocity limits of drives: left_joint 12" in [remark.text for remark in robot.draft.carried]


@pytest.mark.parametrize(("text", "fixed"), [("true", True), ("1", True), ("false", False), ("", False)])
def test_a_static_robot_in_gazebo_has_a_fixed_base(tmp_path: Path, text: str, fixed: bool) -> None:
    robot = imported(tmp_path, rover(CASTER, f"<gazebo><static>{text}</static></gazebo>"))
    assert keys(robot).get("fixed_base", False) is fixed
    assert robot.free is not fixed


ODD = ["", "nan", "1e999", "-1e308", "0x10", "1 2", "\u0661", "true", "&lt;a&gt;"]


@pytest.mark.parametrize("value", ODD)
def test_odd_values_end_in_a_robot_or_an_error_and_never_in_a_traceback(tmp_path: Path, value: str) -> None:
    safety = f'<safety_controller soft_lower_limit="{value}" soft_upper_limit="{value}"/>'
    gazebo = f'<gazebo reference="lift_joint"><springStiffness>{value}</springStiffness></gazebo>'
    gazebo += f'<gazebo reference="lift_joint"><springReference>{value}</springReference></gazebo>'
    robot, findings = try_import(tmp_path, lift(more=safety, outside=gazebo))
    assert robot is not None or findings.errors
