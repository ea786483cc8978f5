"""Faults of sensors and topics: silence, delay and dropouts, their end, recordings and replays."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.cli import main
from tests.api.test_sensors import PROFILES, write
from tests.physics.pictures.harness import needs_opengl

SCAN, ODOM, CMD_VEL = "/dd100_0000/sim_lidar/scan", "/dd100_0000/odom", "/dd100_0000/cmd_vel"
LIDAR = "dd100/sim_lidar"
KINDS = [kind for kind in PROFILES if kind not in ("camera", "surface_gripper")]


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("dd100_flat", rays="mujoco")


@pytest.fixture
def sim(scene: ge.Scene) -> Iterator[ge.Session]:
    with scene.session() as session:
        yield session


def stamps(messages: list[Any]) -> list[float]:
    return [message.header.stamp.sec + message.header.stamp.nanosec / 1e9 for message in messages]


def arrivals(sim: ge.Session, topic: str, ticks: int) -> list[tuple[int, int]]:
    """The ticks in which messages arrive, each with the tick of its stamp."""
    found, heard = [], sim.subscribe(topic)
    for _ in range(ticks):
        sim.step()
        found += [(sim.tick, round(60 * stamp)) for stamp in stamps(heard.messages)]
        heard.clear()
    heard.close()
    return found


def test_a_lidar_that_is_silent_for_two_seconds_sends_no_scans_during_the_fault_and_all_after_it(
    sim: ge.Session,
) -> None:
    scans = sim.subscribe(SCAN)
    sim.run(1.0)
    sim.fault(sensor=LIDAR, silent=True, duration=2.0)
    sim.run(3.0)
    assert stamps(scans.messages) == pytest.approx(
        [1 / 60, *(k / 20 for k in range(1, 21)), *(k / 20 for k in range(61, 81))]
    )


def test_the_scans_of_a_delayed_lidar_arrive_later_with_their_own_stamps(sim: ge.Session) -> None:
    sim.step(60)
    lidar = sim.robots["dd100"].sensors["sim_lidar"]
    lidar.fault(delay=0.3)
    assert arrivals(sim, SCAN, 60) == [(tick, tick - 18) for tick in range(81, 121, 3)]
    lidar.mend()
    assert arrivals(sim, SCAN, 9) == [(123, 123), (126, 126), (129, 129)]


def test_a_delayed_scan_is_that_of_a_run_without_the_fault(scene: ge.Scene) -> None:
    found = []
    for delay in (None, 0.1):
        with scene.session(seed=3) as sim:
            scans = sim.subscribe(SCAN)
            sim.publish(CMD_VEL, {"angular": {"z": 0.5}}, every=0.1)
            if delay:
                sim.fault(sensor=LIDAR, delay=delay)
            sim.run(1.0)
            found.append(dict(zip(stamps(scans.messages), [scan.ranges.tobytes() for scan in scans], strict=True)))
    plain, delayed = found
    assert len(delayed) == 19
    assert delayed.items() <= plain.items()


def test_dropouts_repeat_with_the_seed(scene: ge.Scene) -> None:
    found = []
    for seed in (1, 1, 2):
        with scene.session(seed=seed) as sim:
            scans = sim.subscribe(SCAN)
            sim.fault(sensor=LIDAR, dropout=0.3)
            sim.run(10.0)
            found.append(stamps(scans.messages))
    assert found[0] == found[1] != found[2]
    assert all(140 - 20 < len(times) < 140 + 20 for times in found)  # of 201; the deviation is 6.5


@pytest.mark.parametrize("kind", [*KINDS, pytest.param("camera", marks=needs_opengl)])
def test_every_kind_of_sensor_can_be_late_and_silent(kind: str, tmp_path: Path) -> None:
    with ge.load(write(tmp_path, kind), rays="mujoco").session() as sim:
        sensor = sim.robots["bot"].sensors[kind]
        sensor.sample()
        sim.step(60)
        latency = round(60 * (1.0 - sensor.sample().time))
        sensor.fault(delay=0.5)
        sim.step(60)
        assert sensor.sample().time == pytest.approx(1.5 - latency / 60, abs=1e-6)
        sensor.fault(silent=True)
        sim.step(60)
        assert sensor.sample().time <= 2.0
        sensor.mend()
        sim.step(60)
        assert sensor.sample().time == pytest.approx(4.0 - latency / 60, abs=1e-6)


def test_a_topic_that_a_graph_publishes_is_lost_or_late(sim: ge.Session) -> None:
    sim.fault(topic=ODOM, delay=0.1, duration=0.5)
    assert arrivals(sim, ODOM, 33) == [*((tick, tick - 6) for tick in range(7, 31)), (31, 31), (32, 32), (33, 33)]
    sim.fault(topic=ODOM, silent=True)
    assert arrivals(sim, ODOM, 60) == []
    sim.mend(topic=ODOM)
    assert arrivals(sim, ODOM, 2) == [(94, 94), (95, 95)]


def test_a_topic_that_a_graph_reads_is_lost_or_late(sim: ge.Session) -> None:
    address = "dd100/cmd_vel/DiffController.linearVelocity"
    sim.fault(topic=CMD_VEL, delay=0.2)
    sim.publish(CMD_VEL, {"linear": {"x": 0.5}})  # arrives in tick 1
    sim.step(12)
    assert sim.value(address) == 0.0
    sim.step()
    assert sim.value(address) == 0.5
    sim.fault(topic=CMD_VEL, silent=True)
    sim.publish(CMD_VEL, {"linear": {"x": 0.1}})
    sim.step(5)
    assert sim.value(address) == 0.5
    assert sim._runner.network.overwritten[CMD_VEL] == 0  # the run does not report what a fault loses


def fail(sim: ge.Session) -> None:
    """Let a sensor and topics of both directions fail, while the robot drives."""
    drive = sim.publish(CMD_VEL, {"linear": {"x": 0.5}, "angular": {"z": 0.4}}, every=0.1)
    sim.fault(sensor=LIDAR, dropout=0.4, delay=0.1)
    sim.fault(topic=CMD_VEL, dropout=0.5, delay=0.05)
    sim.run(1.0)
    sim.fault(topic=ODOM, dropout=0.5, duration=0.4)
    sim.run(1.0)
    drive.close()
    sim.mend()
    sim.run(0.5)


def test_faults_are_recorded_and_replayed_to_the_same_bytes(scene: ge.Scene, tmp_path: Path) -> None:
    with scene.session(record=tmp_path / "run.mcap", seed=5) as sim:
        fail(sim)
    assert main(["replay", str(tmp_path / "run.mcap")]) == 0


def test_a_checkpoint_contains_the_faults_and_the_delayed_data(sim: ge.Session) -> None:
    sim.fault(sensor=LIDAR, delay=0.2, dropout=0.2)
    sim.fault(topic=ODOM, delay=0.1)
    sim.step(40)
    mark = sim.checkpoint()
    first = arrivals(sim, SCAN, 60), arrivals(sim, ODOM, 20)
    sim.mend()
    sim.step(10)
    sim.restore(mark)
    assert (arrivals(sim, SCAN, 60), arrivals(sim, ODOM, 20)) == first
    assert len(first[0]) < 20


def test_a_reset_of_the_time_ends_all_faults(sim: ge.Session) -> None:
    before = arrivals(sim, SCAN, 12), arrivals(sim, ODOM, 3)
    sim.fault(sensor=LIDAR, silent=True)
    sim.fault(topic=ODOM, silent=True)
    sim.step(30)
    sim.reset()
    assert (arrivals(sim, SCAN, 12), arrivals(sim, ODOM, 3)) == before


def test_the_state_of_a_run_lists_its_faults(sim: ge.Session) -> None:
    sim.fault(sensor=LIDAR, silent=True)
    sim.fault(topic=ODOM, silent=True, duration=0.1)
    state = sim.submit("state")
    sim.step()
    assert state.result()["faults"] == [sim.robots["dd100"].sensors["sim_lidar"].prim_path, ODOM]
    sim.step(6)
    state = sim.submit("state")
    sim.step()
    assert len(state.result()["faults"]) == 1


def test_mistakes_are_reported_with_legal_values(sim: ge.Session) -> None:
    for wrong, message in (
        ({"sensor": "dd100/sim_lida", "silent": True}, "no sensor 'dd100/sim_lida'\n  did you mean 'dd100/sim_lidar'?"),
        ({"topic": "/dd100_0000/odo", "silent": True}, f"no topic '/dd100_0000/odo'\n  did you mean '{ODOM}'?"),
        ({"silent": True}, "fault: give a sensor or a topic"),
        ({"sensor": LIDAR, "topic": ODOM, "silent": True}, "fault: give a sensor or a topic"),
        ({"sensor": LIDAR}, "fault: give silent, or a dropout, a delay or both"),
        ({"sensor": LIDAR, "silent": True, "delay": 1.0}, "fault: give silent, or a dropout, a delay or both"),
        ({"sensor": LIDAR, "dropout": 1.5}, "fault: dropout: expected a value ≤ 1, got 1.5"),
    ):
        with pytest.raises(ge.UsageError) as error:
            sim.fault(**wrong)
        assert message in str(error.value)
    with pytest.raises(ge.UsageError, match="mend: give a sensor or a topic, or neither for all faults"):
        sim.mend(sensor=LIDAR, topic=ODOM)
