"""Gains that an import computes for drives which hold a position, and what an arm does with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.bringup.robots.import_robot import Imported
from graphengine.descriptions.engine import Floats
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.simulation import Simulation
from tests.bringup.robots.arms import EFFORTS, beam, joint, joints_of, limb, robot
from tests.bringup.robots.harness import CASTER, imported, keys, rover
from tests.physics.harness import FLOOR, load

ARM = robot(limb("j", 6))
BENT = np.array([0.4, 0.7, 0.9, -0.6, 0.5, 0.3])
TICK = 1 / 60


def drives(found: Imported) -> dict[str, dict[str, Any]]:
    joints: Any = keys(found)["joints"]
    return {name: each["drive"] for name, each in joints.items() if "drive" in each}


def test_the_full_effort_answers_to_10_mrad_and_damping_is_at_least_critical(tmp_path: Path) -> None:
    found = imported(tmp_path, ARM)
    for name, effort in zip(joints_of(), EFFORTS, strict=True):
        drive, entry = drives(found)[name], found.draft.joints[name]
        assert drive["stiffness"] == pytest.approx(effort / 0.01)
        bandwidth, inertia = float(entry.hint.split()[0]), float(entry.hint.split()[-3])
        assert bandwidth <= 5.0
        assert drive["damping"] == pytest.approx(2 * drive["stiffness"] / (2 * math.pi * bandwidth), rel=0.01)
        assert drive["damping"] >= 1.99 * math.sqrt(drive["stiffness"] * inertia)
        assert drive["interpolate"] is True
        assert drive["gravity_compensation"] is True
    assert max(float(found.draft.joints[name].hint.split()[0]) for name in joints_of()) == 5.0


def test_at_half_its_speed_a_joints_own_losses_cause_an_error_of_2_5_mrad(tmp_path: Path) -> None:
    lossy = robot(limb("j", 6)).replace("</joint>", '<dynamics damping="10" friction="3"/></joint>')
    found = imported(tmp_path, lossy)
    for name, effort in zip(joints_of(), EFFORTS, strict=True):
        speed = found.draft.description.joints[name].velocity
        assert speed is not None
        assert drives(found)[name]["stiffness"] == pytest.approx(max(effort / 0.01, (5 * speed + 3) / 0.0025), rel=1e-3)


def test_gains_use_the_largest_inertia_of_all_poses(tmp_path: Path) -> None:
    # all joints at zero the arm stands upright, and its first joint turns next to nothing
    found = imported(tmp_path, ARM)
    assert float(found.draft.joints["j1"].hint.split()[-3]) > 3.0


def test_the_report_names_guessed_gains(tmp_path: Path) -> None:
    told = "\n".join(remark.text for remark in imported(tmp_path, ARM).draft.guessed)
    assert "gains of position drives: 5.0 Hz, at least critically damped" in told
    assert "gravity_compensation and interpolate" in told


def test_an_arm_that_is_too_weak_for_its_own_weight_is_noticed(tmp_path: Path) -> None:
    weak = imported(tmp_path, robot(limb("j", 6, effort=5)))
    (told,) = [remark.text for remark in weak.draft.noticed if "effort limits below the weight" in remark.text]
    assert "j2 (5 of " in told
    assert told.endswith("; there the joint sinks; max_force of a drive replaces the limit")
    assert "j1" not in told
    assert not [remark for remark in imported(tmp_path, ARM).draft.noticed if "effort limits" in remark.text]


def test_without_effort_limits_gains_follow_from_inertia_and_weight(tmp_path: Path) -> None:
    control = "".join(f'<joint name="{name}"><command_interface name="position"/></joint>' for name in joints_of())
    control = f'<ros2_control name="arm" type="system">{control}</ros2_control>'
    found = imported(tmp_path, robot(limb("j", 6, effort=None), control))
    for name in joints_of():
        inertia = float(found.draft.joints[name].hint.split()[-3])
        assert drives(found)[name]["stiffness"] >= 0.99 * inertia * (2 * math.pi * 5) ** 2
    assert drives(found)["j2"]["stiffness"] > 5000


def test_without_effort_limits_a_light_joint_withstands_the_motion_of_the_others(tmp_path: Path) -> None:
    """Two joints about parallel axes: M12 of the second is larger than its own M22 by m l1 l2 cos q2."""
    control = "".join(f'<joint name="{name}"><command_interface name="position"/></joint>' for name in ("a", "b"))
    control = f'<ros2_control name="arm" type="system">{control}</ros2_control>'
    links = beam("upper", 0.01, 1.0) + beam("lower", 1.0, 0.2)
    limits: dict[str, Any] = {"lower": -0.01, "upper": 0.01, "effort": None}
    joints = joint("a", "base_link", "upper", "0 0 .05", "0 1 0", **limits)
    joints += joint("b", "upper", "lower", "0 0 1", "0 1 0", **limits)
    found = imported(tmp_path, robot(links, joints, control))
    own = 1.0 * 0.1**2 + 1.0 * 0.2**2 / 12 + 1e-4
    coupled = own + 1.0 * 1.0 * 0.1
    assert drives(found)["b"]["stiffness"] == pytest.approx((own + coupled) * (2 * math.pi * 5) ** 2, rel=0.01)
    assert found.draft.joints["b"].hint.startswith("5.0 Hz")


@pytest.mark.parametrize(("velocity", "told"), [(2.0, False), (4.0, True)])
def test_a_joint_that_needs_long_to_stop_from_its_speed_limit_is_noticed(
    tmp_path: Path, velocity: float, told: bool
) -> None:
    """About a vertical axis, with 9 kg of a beam of 1 m and an effort of 30 N m: v2 I / 2 M."""
    turned = beam("arm", 9.0, 1.0).replace('xyz="0 0 0.5"', 'xyz="0.5 0 0"')
    found = imported(
        tmp_path, robot(turned, joint("j", "base_link", "arm", "0 0 .05", "0 0 1", effort=30, velocity=velocity))
    )
    way = velocity**2 * (9.0 * 0.5**2 + 9.0 * 0.03**2 + 1e-4) / (2 * 30.0)
    assert (way > 0.5) is told
    slow = [remark.text for remark in found.draft.noticed if "need a long way to stop" in remark.text]
    assert bool(slow) is told
    assert all(f"j ({way:.2g} from {velocity:g}/s)" in text for text in slow)


def test_wheels_casters_and_mimic_joints_get_no_arm_gains(tmp_path: Path) -> None:
    finger = limb("finger", 1, base="j6_link", effort=5)
    mimic = '<mimic joint="finger1" multiplier="1"/></joint>'
    follower = limb("thumb", 1, base="j6_link", effort=5).replace("</joint>", mimic)
    found = imported(tmp_path, rover(CASTER, limb("j", 6), finger, follower))
    assert set(found.draft.servos) == {*joints_of(), "finger1"}
    assert "gravity_compensation" not in drives(found)["left_joint"]
    assert "thumb1" not in drives(found)


def test_a_robot_with_very_many_joints_is_imported(tmp_path: Path) -> None:
    parts, parent = "", "base_link"
    for index in range(200):
        parts += beam(f"l{index}", 0.1, 0.01) + joint(f"s{index}", parent, f"l{index}", "0 0 .01", "0 1 0")
        parent = f"l{index}"
    assert len(drives(imported(tmp_path, robot(parts)))) == 200


def test_start_positions_of_ros2_control_are_clamped_to_the_limits(tmp_path: Path) -> None:
    state = '<state_interface name="position"><param name="initial_value">{}</param></state_interface>'
    control = "".join(
        f'<joint name="{name}"><command_interface name="position"/>{state.format(value)}</joint>'
        for name, value in (("j1", 0.0), ("j2", -1.2), ("j3", 9.0))
    )
    found = imported(tmp_path, robot(limb("j", 6), f'<ros2_control name="arm">{control}</ros2_control>'))
    joints: Any = keys(found)["joints"]
    assert [joints[name].get("start") for name in ("j1", "j2", "j3")] == [None, -1.2, 2.5]
    assert "joint j3 starts at 2.5, the legal position nearest to 9" in [each.text for each in found.draft.guessed]


class Arm:
    """An imported arm in a scene, commanded once a tick."""

    def __init__(self, folder: Path, payload: float = 0.0) -> None:
        found = imported(folder, ARM)
        for path, text in found.files.items():
            path.write_text(text, encoding="utf-8")
        (folder / "world.xml").write_text(FLOOR, encoding="utf-8")
        scene = "scene: arm\nworld: world.xml\nrobots: {rover: {use: rover.yaml, position: [0, 0, 2]}}\n"
        (folder / "scene.yaml").write_text(scene, encoding="utf-8")
        self.simulation: Simulation = load(folder / "scene.yaml").simulation
        self.joints: Joints = self.simulation.articulation(self.simulation.stage.find("/rover"))
        hand = self.simulation.model.body("rover/j6_link").id
        self.simulation.model.body_mass[hand] += payload  # which the drives do not know of

    def tick(self, positions: Floats, velocities: Floats) -> Floats:
        self.joints.select(joints_of()).command(positions.tolist(), velocities.tolist())
        for _ in range(self.simulation.substeps):
            self.simulation.step()
        return self.joints.positions()


@pytest.mark.parametrize(("payload", "error"), [(0.0, 1e-4), (1.0, 1e-3)])
def test_an_imported_arm_holds_a_bent_pose(tmp_path: Path, payload: float, error: float) -> None:
    arm = Arm(tmp_path, payload)
    errors = [np.abs(arm.tick(BENT, np.zeros(6)) - BENT).max() for _ in range(300)]
    assert max(errors[240:]) < error
    assert errors[0] > 0.1


@pytest.mark.parametrize(("payload", "way", "end"), [(0.0, 5e-3, 1e-3), (1.0, 1e-2, 1e-2)])
def test_an_imported_arm_follows_a_trajectory_of_positions_and_velocities(
    tmp_path: Path, payload: float, way: float, end: float
) -> None:
    # the highest speed is half of the limit of 3 rad/s; a set point is where the joint is to be at the end of the tick
    arm, seconds = Arm(tmp_path, payload), 1.875 * np.abs(BENT).max() / 1.5
    errors, ticks = [], math.ceil(seconds / TICK)
    for tick in range(1, ticks + 30):
        share = min(tick * TICK / seconds, 1.0)
        positions = BENT * (10 * share**3 - 15 * share**4 + 6 * share**5)
        velocities = BENT * (30 * share**2 - 60 * share**3 + 30 * share**4) / seconds
        errors.append(np.abs(arm.tick(positions, velocities) - positions).max())
    assert max(errors) < way
    assert errors[-1] < end
