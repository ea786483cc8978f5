"""Playing recordings: any tick that was replayed can be shown again, as it was, and what happened on the way is marked."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import graphengine as ge
from graphengine.format.errors import NodeError
from graphengine.format.files import shipped
from graphengine.format.spec import RobotUse
from graphengine.recording import player as player_module
from graphengine.recording.player import RecordingPlayer
from graphengine.runtime.commands import parse
from graphengine.runtime.entity_commands import Spawn
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.loaded_scene import Options
from tests.jobs.harness import Recorder as Listener
from tests.recording.harness import (
    CLOCK,
    DIVIDES,
    NOISY_ROBOT,
    NOISY_SCENE,
    SYSTEM_CLOCK,
    Run,
    at,
    playing,
    put,
    record,
    rewritten,
)

TICKS = 130
COMMANDS: dict[int, tuple[str, dict[str, Any]]] = {
    15: ("set", {"address": "DiffController.maxLinearSpeed", "value": 0.3}),
    20: ("checkpoint", {"name": "mine"}),
    30: ("push", {"entity": "dd100", "impulse": [0.0, 20.0, 0.0]}),
    45: ("restore", {"name": "mine"}),
    60: ("checkpoint", {"name": "mine"}),
    75: ("restore", {"name": "mine"}),
    90: ("reset", {}),
    110: ("stop", {}),
}
"""Commands by the tick that comes after them."""
DRIVE = {5: [(0.6, 0.5)], 50: [(0.4, -0.3)], 95: [(0.5, 0.0)]}


@dataclass
class Straight:
    """A recording, and what the run was after each of its ticks."""

    path: Path
    states: list[dict[str, Any]] = field(default_factory=list, repr=False)
    sent: list[list[tuple[str, str, bytes]]] = field(default_factory=list, repr=False)


def state_of(session: SessionCore) -> dict[str, Any]:
    """Time, poses, and the values of all numbers of ports, in bits."""
    numbers = {
        f"{run.name}/{instance.id}.{port.field}": repr(value)
        for run in session.graphs
        for instance, node in zip(run.executor.graph.instances, run.executor.nodes, strict=True)
        for port in instance.cls.fields.values()
        if isinstance(value := getattr(node, port.field, None), int | float | tuple)
    }
    return {"time": session.time, "poses": session.services.world.poses().tobytes(), "numbers": numbers}


@pytest.fixture(scope="module")
def straight(tmp_path_factory: pytest.TempPathFactory) -> Straight:
    """A drive of a robot with a noisy lidar through commands, checkpoints and resets."""
    folder = tmp_path_factory.mktemp("straight")
    put(folder / "noisy_robot.yaml", NOISY_ROBOT)
    scene = put(folder / "scene.yaml", NOISY_SCENE)
    found = Straight(folder / "out.mcap")
    heard = 0

    def before(tick: int, run: Run) -> None:
        nonlocal heard
        found.states.append(state_of(run.session))
        if tick > 1:
            found.sent.append(run.heard[heard:])
        heard = len(run.heard)
        if tick in COMMANDS:
            parse(*COMMANDS[tick]).apply(run.session)

    record(found.path, TICKS, scene, commands=DRIVE, before=before, options=Options(seed=5))
    return found


@pytest.fixture(scope="module")
def played(straight: Straight) -> Iterator[RecordingPlayer]:
    """A player that has replayed all, with checkpoints so near that each seek begins at another one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(player_module, "SPACING", 0.2)
        with playing(straight.path) as player:
            player.build()
            yield player


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(tick=st.integers(0, TICKS - 1))
def test_after_a_seek_the_state_equals_that_of_the_run(straight: Straight, played: RecordingPlayer, tick: int) -> None:
    played.show(tick)
    assert (played.position, played.complete, played.difference) == (tick, True, None)
    assert state_of(played.session) == straight.states[tick]


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(begin=st.integers(0, TICKS - 12))
def test_after_a_seek_the_same_bytes_are_sent(straight: Straight, played: RecordingPlayer, begin: int) -> None:
    listener = Listener()
    played.show(begin)
    played.replay.network.sinks.append(listener)
    for tick in range(begin + 1, begin + 11):
        listener.stream.clear()
        played.show(tick)
        assert listener.stream == straight.sent[tick - 1]
    played.replay.network.sinks.remove(listener)


@settings(max_examples=3, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(moves=st.lists(st.tuples(st.integers(1, 40), st.integers(0, TICKS)), min_size=3, max_size=8))
def test_the_displayed_state_stays_while_the_replay_continues(straight: Straight, moves: list[tuple[int, int]]) -> None:
    with playing(straight.path) as player:
        for built, (ticks, tick) in zip(itertools.accumulate(ticks for ticks, _ in moves), moves, strict=True):
            for _ in range(ticks):
                player.build(0.0)
            position = player.position
            player.show(position)
            if position < TICKS - 1:
                assert state_of(player.session) == straight.states[position]
            player.show(tick)
            assert player.position == min(tick, built, TICKS)
        player.build()
        assert (player.built, player.difference) == (TICKS, None)


def test_a_seek_without_enough_time_stops_at_an_earlier_tick(played: RecordingPlayer) -> None:
    played.show(0)
    played.show(7, 0.0)
    assert 0 < played.position < 7
    played.show(7)
    assert played.position == 7


def test_of_many_checkpoints_every_second_one_is_kept(straight: Straight, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(player_module, "SPACING", 0.1)
    monkeypatch.setattr(player_module, "MAX_CHECKPOINTS", 4)
    with playing(straight.path) as player:
        player.build()
        assert [kept.tick for kept in player._checkpoints] == [0, 48, 96]
        player.show(70)
        assert state_of(player.session) == straight.states[70]


def test_commands_and_resets_are_marked(played: RecordingPlayer) -> None:
    marks = {mark.tick: mark for mark in played.marks.all}
    assert set(marks) == set(COMMANDS)
    assert {tick for tick, mark in marks.items() if mark.kind == "reset"} == {45, 75, 90, 110}
    assert marks[20].text == "checkpoint name mine"
    assert marks[30].text.startswith("push entity dd100, force (0, 1200, 0), duration 0.01667")


def test_a_contact_of_a_robot_is_marked_at_its_beginning(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    into = parse("move", {"entity": "dd100", "position": [-7.4, 6.0, 0.025], "force": True})
    record(path, 60, "dd100_warehouse", before=at(10, lambda run: into.apply(run.session)))
    with playing(path) as player:
        player.build()
        contacts = [(mark.tick, mark.text) for mark in player.marks.all if mark.kind == "contact"]
        assert contacts == [(10, "dd100 touches rack_04")]


def test_a_seek_restores_spawned_and_deleted_robots(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    use = RobotUse(use=str(shipped() / "scenes/robots/dd100.yaml"), position=(3.0, 0.0, 0.025), namespace="late")

    def before(tick: int, run: Run) -> None:
        if tick == 20:
            Spawn(name="late", use=use).apply(run.session)

    record(path, 30, "dd100_flat", before=before)
    with playing(path) as player:
        player.build()
        for tick, robots in ((10, ["dd100"]), (25, ["dd100", "late"]), (5, ["dd100"])):
            player.show(tick)
            assert [prim.entity_name for prim in player.session.services.stage.prims("robot")] == robots
        assert player.marks.all[0].text.startswith("spawn ")


def test_a_robot_spawned_after_a_seek_reads_the_files_of_this_tick(tmp_path: Path) -> None:
    folder, path = tmp_path / "hall", tmp_path / "out.mcap"
    put(
        folder / "scene.yaml",
        "scene: hall\nworld: worlds/flat_grid.xml\ngraphs: {clock: {use: clock.yaml, at: /World/clock}}\n",
    )
    clock = put(folder / "clock.yaml", CLOCK)
    put(folder / "late.yaml", "robot: late\nextends: robots/dd100.yaml\ngraphs: {clock: {use: clock.yaml}}\n")
    use = RobotUse(use="late.yaml", position=(3.0, 0.0, 0.025), namespace="late")

    def before(tick: int, run: Run) -> None:
        if tick in (20, 25):
            topic = f"  Clock: {{type: PublishClock, inputs: {{topicName: clock_{tick}}}}}\n"
            put(clock, CLOCK.replace("  Clock: PublishClock\n", topic))
            run.session.reload()
        if tick == 70:
            Spawn(name="late", use=use).apply(run.session)

    record(path, 80, folder / "scene.yaml", before=before)
    with playing(path) as player:
        while player.built < 60:
            player.build(0.0)
        player.show(21)
        player.build()
        assert (player.difference, player.failure, player.built) == (None, "", 80)


def test_a_replay_continues_after_the_first_difference_and_reports_it(straight: Straight) -> None:
    with playing(rewritten(straight.path, manifest={"seed": "6"})) as player:
        player.build()
        assert str(player.difference) == "different in tick 1, t = 0.016667 s: /dd100_0000/sim_lidar/scan"
        assert (player.built, player.complete, player.failure) == (TICKS, True, "")
        assert ("error", 1) in [(mark.kind, mark.tick) for mark in player.marks.all]


@pytest.fixture
def failed(tmp_path: Path) -> Path:
    """A recording whose run ends with an error in its fifth tick."""
    path = tmp_path / "out.mcap"
    with pytest.raises(NodeError):
        record(path, 10, put(tmp_path / "divides.yaml", DIVIDES), bad_values="stop")
    return path


def test_a_replay_ends_with_the_failed_tick(failed: Path) -> None:
    with playing(failed) as player:
        assert player.length == 5
        player.build()
        assert (player.built, player.length, player.difference) == (5, 5, None)
        assert "node Ratio (omni.graph.nodes.Divide) raised BadValueError" in player.failure
        assert [(mark.tick, mark.kind) for mark in player.marks.all] == [(5, "error")]
        for tick, state in ((5, "failed"), (3, "paused"), (5, "failed"), (4, "paused")):
            player.show(tick)
            assert (player.position, player.session.state) == (tick, state)


def test_an_error_that_the_run_survived_is_marked_at_its_beginning(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    put(tmp_path / "divides.yaml", DIVIDES)
    with ge.load(tmp_path / "divides.yaml").session(record=path, keep_going=True, bad_values="stop") as sim:
        sim.run(0.2)
    with playing(path) as player:
        player.build()
        assert [(mark.tick, mark.kind) for mark in player.marks.all] == [(5, "error")]
        assert (player.built, player.failure, player.difference) == (12, "", None)


def test_a_truncated_recording_is_replayed_to_its_end(straight: Straight, tmp_path: Path) -> None:
    whole = straight.path.read_bytes()
    with playing(put_bytes(tmp_path / "out.mcap", whole[: whole.index(b"graphengine:end") - 20])) as player:
        assert 0 < player.length <= TICKS
        player.build()
        assert (player.built, player.recording.cut_off, player.difference) == (player.length, True, None)


def test_a_damaged_recording_can_be_shown_up_to_the_damage(straight: Straight, tmp_path: Path) -> None:
    data = bytearray(straight.path.read_bytes())
    data[data.index(b"graphengine:end") - 1000] ^= 0xFF
    with playing(put_bytes(tmp_path / "out.mcap", bytes(data))) as player:
        assert player.length == TICKS
        player.build()
        assert "damaged: " in player.failure
        assert 0 < player.built < TICKS
        player.show(player.built)
        assert state_of(player.session) == straight.states[player.built]


def test_a_file_with_an_end_years_later_is_not_replayed_until_this_end(tmp_path: Path) -> None:
    path = put(tmp_path / "hall" / "graph.yaml", CLOCK)
    record(tmp_path / "out.mcap", 3, path)
    with playing(rewritten(tmp_path / "out.mcap", end={"ticks": str(10**12)})) as player:
        player.build()
        assert "no message for more than 10000000 ticks" in player.failure
        assert player.built <= 3


def test_a_failing_command_ends_the_replay(tmp_path: Path) -> None:
    path = put(tmp_path / "hall" / "graph.yaml", CLOCK)
    record(tmp_path / "out.mcap", 3, path)
    commands = json.dumps({"commands": [["move", {"entity": "nobody", "position": [0, 0, 0]}]]})
    with playing(rewritten(tmp_path / "out.mcap", commands=commands)) as player:
        player.build()
        assert (player.built, player.complete) == (0, True)
        assert "nobody" in player.failure
        player.show(3)
        assert player.position == 0


def test_a_command_that_nests_too_deeply_ends_the_replay(tmp_path: Path) -> None:
    record(tmp_path / "out.mcap", 3, put(tmp_path / "hall" / "graph.yaml", CLOCK))
    commands = f'{{"commands": [["set", {{"address": "a", "value": {"[" * 700}{"]" * 700}}}]]}}'
    with playing(rewritten(tmp_path / "out.mcap", commands=commands)) as player:
        player.build()
        assert (player.built, player.complete) == (0, True)
        assert "tick 1 cannot be read: " in player.failure
        assert "nested more than 40 levels deep" in player.failure


def test_the_wall_clock_of_each_tick_is_kept(tmp_path: Path) -> None:
    times: list[float] = []
    path = put(tmp_path / "hall" / "graph.yaml", SYSTEM_CLOCK)
    record(tmp_path / "out.mcap", 12, path, before=lambda tick, run: times.append(run.session.clock.wall_time))
    with playing(tmp_path / "out.mcap") as player:
        player.build()
        for tick in (11, 3, 7):
            player.show(tick)
            assert player.session.clock.wall_time == times[tick]


def put_bytes(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path
