"""Sensors read from Python: samples of every kind, their times, and that nobody else notices who reads them."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import graphengine as ge
from graphengine.cli import main
from graphengine.format.kinds import DEVICES
from tests.physics.pictures.harness import needs_opengl

MASS, HAND, WALL, HEIGHT = 5.0, 1.0, 2.0, 0.5  # kg, kg, m ahead, m above the base
INERTIA = '<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'
FILES = {
    "bot.urdf": f"""<robot name="bot"><link name="base_link">
<inertial><mass value="{MASS}"/>{INERTIA}</inertial>
<collision><geometry><box size=".4 .4 .2"/></geometry></collision></link>
<link name="hand"><inertial><mass value="{HAND}"/>{INERTIA}</inertial></link>
<joint name="wrist" type="fixed"><parent link="base_link"/><child link="hand"/></joint></robot>""",
    "world.xml": f"""<mujoco><worldbody><geom type="plane" size="0 0 1"/>
<geom type="box" size=".1 9 9" pos="{WALL + 0.1} 0 1"/></worldbody></mujoco>""",
    "scene.yaml": "scene: s\nworld: world.xml\nrobots: {bot: {use: bot.yaml, position: [0, 0, 0.1]}}\n",
}
PROFILES = {
    "lidar": "lidar_360",
    "camera": "camera",
    "imu": "imu",
    "range": "hc_sr04",
    "radar": "radar_77ghz",
    "contact": "contact",
    "raycast": "raycast",
    "light_beam": "light_beam",
    "navsat": "{rate: 10.0}",
    "force_torque": "force_torque",
    "surface_gripper": "surface_gripper",
}
ON_BASE, PARENT = "parent: base_link", {"force_torque": "parent: hand"}


def write(folder: Path, *kinds: str) -> Path:
    """Write a scene: a box on the floor before a wall, with a sensor of each kind, called as its kind is."""
    sensors = [
        f"  {kind}: {{type: {kind}, profile: {PROFILES[kind]}, {PARENT.get(kind, ON_BASE)}, position: [0, 0, {HEIGHT}]}}"
        for kind in kinds
    ]
    for name, text in {**FILES, "bot.yaml": "\n".join(["robot: bot", "urdf: bot.urdf", "sensors:", *sensors])}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "scene.yaml"


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[ge.Session]:
    kinds = [kind for kind in PROFILES if kind != "camera"]
    with ge.load(write(tmp_path, *kinds), rays="mujoco").session() as sim:
        yield sim


def test_the_first_samples_are_those_of_the_first_tick(watched: ge.Session) -> None:
    watched.run(0.5)  # the box has come to rest
    sensors = [watched.robots["bot"].sensors[name] for name in ("contact", "force_torque", "imu")]
    assert [sensor.sample() for sensor in sensors] == [None] * 3
    watched.step()
    contact, wrench, imu = (sensor.sample() for sensor in sensors)
    assert contact.force == pytest.approx((MASS + HAND) * 9.81, rel=1e-6)
    assert wrench.force == pytest.approx((0.0, 0.0, -HAND * 9.81), abs=1e-6)
    assert imu.time == pytest.approx(watched.time, abs=0.02)


def test_every_kind_of_sensor_has_samples(watched: ge.Session) -> None:
    sensors = watched.robots["bot"].sensors
    assert {sensor.kind for sensor in sensors.values()} == {*PROFILES} - {"camera", "surface_gripper"}
    assert {kind for kind, device in DEVICES.all.items() if device.sample is None} == {"surface_gripper"}
    assert all(sensor.sample() is None for sensor in sensors.values())
    watched.run(0.5)
    found = {name: sensor.sample() for name, sensor in sensors.items()}
    assert found["contact"].force == pytest.approx((MASS + HAND) * 9.81, rel=1e-6)
    assert found["imu"].gravity == pytest.approx((0.0, 0.0, 9.81))
    assert found["range"].range == pytest.approx(WALL, abs=5 * 0.003)  # the deviation of its noise, m
    assert found["raycast"].depths[0] == pytest.approx(WALL, abs=1e-4)
    assert found["light_beam"].hits.all()
    assert found["navsat"].altitude == pytest.approx(0.1 + HEIGHT, abs=1e-3)
    assert found["force_torque"].force == pytest.approx((0.0, 0.0, -HAND * 9.81), abs=1e-6)
    assert found["radar"].points[:, 0] == pytest.approx(WALL, abs=0.1 * 5)
    ahead = np.argmin(found["lidar"].ranges)
    assert found["lidar"].points[ahead] == pytest.approx((WALL, 0.0, 0.0), abs=1e-4)
    assert np.isnan(found["lidar"].points[0]).all()  # behind, where no surface is
    assert all(sample.time == 0.5 for sample in found.values())
    for sample, name in (("lidar", "ranges"), ("radar", "points"), ("raycast", "depths"), ("light_beam", "hits")):
        with pytest.raises(ValueError, match="read-only"):
            getattr(found[sample], name)[:] = 0
    with pytest.raises(AttributeError):
        found["contact"].force = 0.0


def test_sample_n_is_of_the_first_tick_at_or_after_n_periods(watched: ge.Session) -> None:
    lidar = watched.robots["bot"].sensors["lidar"]
    lidar.sample()
    rate, ticks = 10.0, 60  # Hz, as its profile says, and ticks a second
    for tick in range(1, ticks + 1):
        watched.step()
        sample = lidar.sample()
        number = math.floor(tick * rate / ticks)
        assert sample.index == number
        assert sample.time == pytest.approx(max(1, math.ceil(number * ticks / rate)) / ticks)


def test_a_sensor_read_first_between_two_samples_waits_for_the_next(watched: ge.Session) -> None:
    watched.step(8)
    lidar = watched.robots["bot"].sensors["lidar"]
    for _ in range(4):  # ticks 8 to 11; the next sample is of tick 12
        assert lidar.sample() is None
        watched.step()
    assert lidar.sample().time == pytest.approx(12 / 60)


@pytest.mark.parametrize("scopes", [["time"], ["state"], []])
def test_after_a_reset_there_is_no_sample(watched: ge.Session, scopes: list[Literal["time", "state"]]) -> None:
    lidar = watched.robots["bot"].sensors["lidar"]
    lidar.sample()
    watched.run(0.5)
    watched.reset(*scopes)
    assert lidar.sample() is None
    watched.step(6)
    assert lidar.sample().time == watched.time


def test_a_checkpoint_brings_back_the_sample_and_a_sensor_wanted_later_has_none(watched: ge.Session) -> None:
    sensors = watched.robots["bot"].sensors
    sensors["lidar"].sample()
    watched.run(0.3)
    mark, before = watched.checkpoint(), sensors["lidar"].sample()
    sensors["raycast"].sample()
    watched.run(0.3)
    watched.restore(mark)
    assert sensors["lidar"].sample() is before
    assert sensors["raycast"].sample() is None
    watched.step()
    assert sensors["raycast"].sample().time == watched.time


def test_unknown_and_removed_sensors_are_named(watched: ge.Session) -> None:
    sensors = watched.robots["bot"].sensors
    with pytest.raises(ge.UnknownEntityError, match="no sensor 'ldar'\n  did you mean 'lidar'"):
        sensors["ldar"]
    sensors["lidar"].sample()
    watched.remove("bot")
    watched.step()
    with pytest.raises(ge.UnknownEntityError, match="no sensor '/bot/Geometry/base_link/lidar/Lidar': it was removed"):
        sensors["lidar"].sample()


def test_reading_a_sensor_changes_no_byte_of_what_graphs_send(tmp_path: Path) -> None:
    """The scan of the dd100 is read by its graph at 20 Hz; the program reads it, and sensors that no graph reads, between."""

    def digest(name: str, *, reading: bool) -> str:
        path = tmp_path / f"{name}.mcap"
        with ge.load("dd100_flat", rays="mujoco").session(record=path) as sim:
            scan = sim.subscribe("/dd100_0000/sim_lidar/scan")
            sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.4}, "angular": {"z": 0.5}}, every=0.1)
            sim.step(10)
            for _ in range(50):
                if reading:
                    for sensor in ("sim_lidar", "sim_camera/RSD455/Imu_Sensor"):
                        sim.robots["dd100"].sensors[sensor].sample()
                sim.step()
        assert main(["replay", str(path)]) == 0
        return hashlib.sha256(b"".join(message.ranges.tobytes() for message in scan)).hexdigest()

    assert digest("read", reading=True) == digest("unread", reading=False)


@needs_opengl
def test_a_picture_arrives_its_latency_after_its_time(tmp_path: Path) -> None:
    latency, rate, ticks = 0.1, 30.0, 60  # s, Hz, ticks a second
    with ge.load(write(tmp_path, "camera"), rays="mujoco").session() as sim:
        camera = sim.robots["bot"].sensors["camera"]
        camera.sample()
        sim.step(round(latency * ticks))
        assert camera.sample() is None
        sim.step()
        assert camera.sample().time == 1 / ticks
        sim.step(30)
        picture = camera.sample()
        height, width = picture.depth.shape
        assert picture.rgb.shape == (height, width, 3)
        assert picture.depth[height // 2, width // 2] == pytest.approx(WALL, abs=1e-3)
        assert 0.0 <= sim.time - latency - picture.time < 1 / rate
        assert not picture.rgb.flags.writeable
