"""What a description says to Gazebo about links: friction, colours, gravity and collisions go into the robot file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from graphengine.bringup.robots.gazebo_links import COLOURS
from tests.bringup.robots.descriptions import imported, written
from tests.physics.harness import FLOOR, load, steps


def about(link: str, inside: str) -> str:
    """What Gazebo is told about a link."""
    return f'<gazebo reference="{link}">{inside}</gazebo>'


def robot(folder: Path, *gazebo: str) -> dict[str, Any]:
    """The robot file of an import."""
    *_, text = imported(folder, *gazebo).files.values()
    data = yaml.safe_load(text)
    assert isinstance(data, dict)
    return data


def lost(folder: Path, *gazebo: str) -> list[str]:
    """What an import could not carry over."""
    return [remark.text for remark in imported(folder, *gazebo).draft.lost]


ODE = "<collision><surface><friction><ode>{}</ode></friction></surface></collision>"


@pytest.mark.parametrize(
    "inside",
    [
        "<mu1>0.3</mu1><mu2>0.3</mu2>",
        '<mu1 value="0.3"/>',
        "<mu>0.3</mu>",
        ODE.format("<mu>0.3</mu><mu2>0.3</mu2>"),
        "<mu1>0.3</mu1><mu2>0.3</mu2><fdir1>1 0 0</fdir1>",
    ],
)
def test_friction_is_a_material(tmp_path: Path, inside: str) -> None:
    surface = {"static_friction": 0.3, "dynamic_friction": 0.3, "combine": "min", "bind": ["arm"]}
    assert robot(tmp_path, about("arm", inside))["materials"] == {"arm_surface": surface}


def test_links_of_the_same_friction_share_a_material(tmp_path: Path) -> None:
    both = (about(link, "<mu1>0.3</mu1>") for link in ("arm", "base_link"))
    assert robot(tmp_path, *both)["materials"]["arm_surface"]["bind"] == ["arm", "base_link"]


@pytest.mark.parametrize(
    ("inside", "direction", "frame"),
    [
        ('<mu1>1</mu1><mu2>0</mu2><fdir1 gz:expressed_in="base_link">1 -1 0</fdir1>', [1.0, -1.0, 0.0], "base_link"),
        (
            ODE.format('<mu>1</mu><mu2>0</mu2><fdir1 gz:expressed_in="base_link">1 1 0</fdir1>'),
            [1.0, 1.0, 0.0],
            "base_link",
        ),
        ("<mu1>1</mu1><mu2>0</mu2><fdir1>0 1 0</fdir1>", [0.0, 0.0, 1.0], "base_link"),
    ],
)
def test_friction_in_two_directions_has_the_direction_of_the_description(
    tmp_path: Path, inside: str, direction: list[float], frame: str
) -> None:
    material = robot(tmp_path, about("arm", inside))["materials"]["arm_surface"]
    assert (material["dynamic_friction"], material["across"]) == (1.0, 0.0)
    assert (material["direction"], material["expressed_in"]) == (pytest.approx(direction), frame)


@pytest.mark.parametrize(
    ("link", "inside", "reason"),
    [
        ("arm", "<mu1>1</mu1><mu2>0.5</mu2>", "without fdir1, Gazebo takes it along an axis of the world"),
        ("arm", "<mu1>-1</mu1>", "the friction is below zero"),
        ("arm", "<mu1>much</mu1>", "mu1 is not a number: 'much'"),
        ("imu_link", "<mu1>1</mu1>", "friction: it has no collider"),
        (
            "arm",
            "<kp>1e6</kp><kd>1</kd><minDepth>0.001</minDepth>",
            "kp, kd and other settings of Gazebo's contacts",
        ),
        ("arm", "<laserRetro>100</laserRetro>", "the intensity of a lidar follows from colours"),
        ("base_link", "<material>Gazebo/WoodFloor</material>", "material 'Gazebo/WoodFloor' is not a known colour"),
        ("base_link", "<selfCollide>true</selfCollide>", "self-collision can be enabled only for all links of a robot"),
    ],
)
def test_properties_that_a_robot_file_cannot_hold_are_reported_as_lost_with_the_reason(
    tmp_path: Path, link: str, inside: str, reason: str
) -> None:
    (text,) = lost(tmp_path, about(link, inside))
    assert text.startswith(f"link {link}: ")
    assert reason in text


def test_of_two_frictions_of_a_link_the_first_counts(tmp_path: Path) -> None:
    twice = (about("arm", f"<mu1>{friction}</mu1>") for friction in (0.3, 0.4))
    materials = robot(tmp_path, *twice)["materials"]
    assert [material["dynamic_friction"] for material in materials.values()] == [0.3]


def test_carried_over_properties_are_reported(tmp_path: Path) -> None:
    told = imported(tmp_path, about("arm", "<mu1>1</mu1><mu2>0.2</mu2><fdir1>0 1 0</fdir1>")).draft.carried
    assert [remark.text for remark in told] == ["link arm: friction 1 along fdir1, 0.2 across it"]


def test_wheel_slip_is_lost_with_the_reason(tmp_path: Path) -> None:
    wheel = '<wheel link_name="arm"><slip_compliance_lateral>1</slip_compliance_lateral></wheel>'
    plugin = f'<gazebo><plugin filename="gz-sim-wheel-slip-system" name="gz::sim::systems::WheelSlip">{wheel}</plugin></gazebo>'
    (text,) = lost(tmp_path, plugin)
    assert text.startswith("link arm: WheelSlip: ")


@pytest.mark.parametrize(
    "system",
    ["<gazebo><plugin filename='gz-sim-sensors-system' name='gz::sim::systems::Sensors'/></gazebo>"]
    + [
        f"<gazebo reference='scan_joint'><{tag}>true</{tag}></gazebo>"
        for tag in ("preserveFixedJoint", "provideFeedback")
    ],
)
def test_properties_that_always_hold_are_not_reported_as_lost(tmp_path: Path, system: str) -> None:
    assert lost(tmp_path, system) == []


@pytest.mark.parametrize(
    "inside",
    [
        "<material>Gazebo/Orange</material>",
        "<material>Orange</material>",
        "<visual><material><diffuse>1 0.5088 0.0468 1</diffuse></material></visual>",
        "<visual><material><script><name>Gazebo/Orange</name></script></material></visual>",
    ],
)
def test_a_colour_applies_to_visuals_without_their_own(tmp_path: Path, inside: str) -> None:
    folder = written(tmp_path, about("base_link", inside), about("arm", "<material>Gazebo/Blue</material>"))
    data = yaml.safe_load((folder / "robots/bot.yaml").read_text(encoding="utf-8"))
    assert data["links"] == {"base_link": {"colour": list(COLOURS["orange"])}}
    model = simulated(folder).model
    seen = {model.body(model.geom_bodyid[geom]).name: model.geom_rgba[geom] for geom in visuals(model)}
    assert seen["bot/base_link"] == pytest.approx([1.0, 0.5088, 0.0468, 1.0])
    assert seen["bot/arm"] == pytest.approx([1.0, 0.0, 0.0, 1.0])


def visuals(model: mujoco.MjModel) -> Any:
    """The geoms that collide with nothing."""
    return np.flatnonzero((model.geom_contype == 0) & (model.geom_conaffinity == 0))


def simulated(folder: Path) -> Any:
    """The robot in an empty world."""
    (folder / "world.xml").write_text(FLOOR, encoding="utf-8")
    scene = "scene: one\nworld: world.xml\nrobots: {bot: {use: robots/bot.yaml, position: [0, 0, 5]}}\n"
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    return load(folder / "scene.yaml").simulation


@pytest.mark.parametrize("inside", ["<gravity>false</gravity>", "<turnGravityOff>true</turnGravityOff>"])
def test_gravity_does_not_act_on_a_link_without_it(tmp_path: Path, inside: str) -> None:
    folder = written(tmp_path, about("base_link", inside))
    assert "base_link: {gravity: false}" in (folder / "robots/bot.yaml").read_text(encoding="utf-8")
    simulation = simulated(folder)
    heavy = simulated(written(tmp_path / "heavy"))
    for each in (simulation, heavy):
        steps(each, 100)
    assert heavy.data.qvel[2] == pytest.approx(-9.81 * heavy.data.time, rel=1e-3)
    assert simulation.data.qvel[2] > heavy.data.qvel[2] / 2  # two of three kg are without weight


@pytest.mark.parametrize(
    "gazebo",
    [
        ["<gazebo><self_collide>true</self_collide></gazebo>"],
        [about(link, "<selfCollide>1</selfCollide>") for link in ("base_link", "arm")],
    ],
)
def test_self_collision_is_enabled_if_all_links_request_it(tmp_path: Path, gazebo: list[str]) -> None:
    assert robot(tmp_path, *gazebo)["self_collision"] is True
    assert "self_collision" not in robot(tmp_path, about("base_link", "<selfCollide>false</selfCollide>"))
