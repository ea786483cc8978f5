"""Expectations over bags that rosbags wrote, and over recordings of runs."""

from __future__ import annotations

import sqlite3
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin, storage_mcap

import graphengine as ge
from graphengine.api.expectations import bag_file
from graphengine.api.expectations.bags import Bag
from graphengine.api.expectations.expectations import Expectation, ExpectationCheck
from graphengine.api.expectations.readings import WORLD, readings_of
from graphengine.format.errors import ExpectationError, RecordingError, UsageError
from graphengine.recording import records
from tests.api.expectations.bag_writing import (
    DELAY,
    LENGTH,
    SECOND,
    driving,
    made,
    point,
    time_of,
    write_bag,
)

X = "message('/position').point.x"


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("bags") / "drive", driving())


def judged(path: Path, expectation: Expectation) -> ExpectationCheck:
    with closing(Bag(path)) as bag:
        check = bag.expect(expectation)
        bag.play()
    return check


@pytest.mark.parametrize(
    ("expectation", "outcome", "decided", "robustness", "time"),
    [
        (ge.always(f"{X} < 2"), "failed", 4.0, -0.5, 5.0),  # x = 0.5 t, at 10 Hz
        (ge.always(f"{X} < 2.6"), "passed", 5.0, 0.1, 5.0),
        (ge.within(3.0, f"{X} > 1.2"), "passed", 2.5, 0.3, 3.0),
        (ge.within(2.4, f"{X} > 1.2"), "failed", 2.5, 0.0, 2.4),
        (ge.until(f"{X} < 2", f"{X} >= 1.5"), "passed", 3.0, 0.25, None),
        (ge.holds(2.0, f"{X} > 1.2"), "passed", 4.5, 0.5, 5.0),
        (ge.settles(2.0, f"{X} >= 1"), "passed", 5.0, 0.0, 2.0),
        (ge.count(f"{X} > 1", at_least=2), "failed", 5.0, -1.0, 5.0),
        (ge.rate("/range", at_least=9.5, at_most=9.5, over=2.0), "passed", 4.0, 0.0, 2.0),  # 19 messages in (0 s, 2 s]
        (ge.rate("/range", at_least=9.6, over=2.0), "failed", 2.0, -0.1, 2.0),
        (ge.rate("/level", at_least=1.0), "passed", 5.0, 0.0, 1.0),
        (ge.latency("/range", 0.031), "passed", 47 / 9.5, 0.001, None),
        (ge.latency("/range", 0.029), "failed", 0.0, -0.001, None),
        (ge.always("message('/level').level + 0.5 > time"), "passed", 5.0, 0.5, None),
        (ge.always("message('/level').unit.name == 'm'"), "passed", 5.0, None, None),
        (ge.within(3.0, "time > 2"), "passed", 2.1, 1.0, 3.0),
    ],
)
def test_each_operator_judges_a_bag_by_its_log_times(
    drive: Path,
    expectation: Expectation,
    outcome: str,
    decided: float,
    robustness: float | None,
    time: float | None,
) -> None:
    check = judged(drive, expectation)
    assert check.outcome == outcome, check.report()
    assert check.verdict.decided == pytest.approx(decided)
    if robustness is not None:
        assert check.verdict.robustness == pytest.approx(robustness, abs=1e-9)
    if time is not None:
        assert check.verdict.time == pytest.approx(time)


def test_a_condition_of_two_topics_is_evaluated_after_the_messages_of_both(drive: Path) -> None:
    behind = judged(drive, ge.never(f"message('/level').level - {X} * 2 < -0.85"))  # 10 Hz against 1 Hz
    assert behind.outcome == "failed"
    assert behind.verdict.decided == pytest.approx(0.9)


def test_a_topic_that_falls_silent_has_a_rate_of_zero(tmp_path: Path) -> None:
    entries = [entry for entry in driving() if entry[1] != "/level" or entry[0] < 2.5]
    check = judged(write_bag(tmp_path / "bag", entries), ge.rate("/level", at_least=1.0))
    assert (check.outcome, check.verdict.robustness) == ("failed", -1.0)
    assert check.verdict.decided == pytest.approx(3.0)


def test_a_bag_is_judged_up_to_the_given_time(drive: Path) -> None:
    with closing(Bag(drive)) as bag:
        check = bag.expect(ge.always(f"{X} < 2"))
        bag.play(3.5)
    assert (check.outcome, check.verdict.decided) == ("passed", 3.5)


KINDS = [(storage, compression) for storage in StoragePlugin for compression in ("NONE", "MESSAGE", "STORAGE")]
KINDS.remove((StoragePlugin.SQLITE3, "STORAGE"))  # which rosbag2 does not have


@pytest.mark.parametrize(("storage", "compressed"), KINDS)
def test_folders_and_files_of_each_storage_are_read(tmp_path: Path, storage: StoragePlugin, compressed: str) -> None:
    folder = write_bag(tmp_path / "bag", driving(), storage, CompressionMode[compressed])
    (folder / "metadata.yaml").unlink()
    (file,) = folder.iterdir()
    for path in (folder, file):
        assert ge.judge_bag(path, ge.within(3.0, f"{X} > 1.2"))[0].verdict.decided == pytest.approx(2.5)


def test_a_bag_that_is_compressed_as_a_whole_is_refused(tmp_path: Path) -> None:
    folder = write_bag(tmp_path / "bag", driving(), StoragePlugin.SQLITE3, CompressionMode.FILE)
    with pytest.raises(RecordingError, match="decompress"):
        ge.judge_bag(folder, ge.always("time < 9"))


def test_a_bag_with_a_clock_topic_uses_the_times_of_the_clock(tmp_path: Path) -> None:
    """The simulation runs at half the speed of the recorder's clock, and begins at 100 s."""

    def simulated(at: float, delay: int = 0) -> Any:
        return time_of(100 * SECOND + round(at * SECOND / 2) - delay)

    times = [number / 100 for number in range(int(LENGTH * 100) + 1)]
    clocks = [(at, "/clock", made("rosgraph_msgs/msg/Clock", clock=simulated(at))) for at in times]
    ranges = [
        point(at, topic="/range", header=made("std_msgs/msg/Header", stamp=simulated(at, DELAY), frame_id=""))
        for at, topic, _ in driving()
        if topic == "/range"
    ]
    bag = write_bag(tmp_path / "bag", [*clocks, *driving()[:51], *ranges])
    reached, slow, fresh = ge.judge_bag(
        bag,
        ge.within(3.0, f"{X} > 1.2"),
        ge.rate("/range", at_least=19.0, at_most=19.0),
        ge.latency("/range", 0.03 + 0.005),  # the clock has steps of 5 ms
    )
    assert reached.verdict.decided == pytest.approx(1.25)
    assert slow.verdict.robustness == 0.0
    assert 0.005 - 1e-9 <= fresh.verdict.robustness <= 0.01


def test_a_reset_of_the_simulation_restarts_the_judgement(tmp_path: Path) -> None:
    clocks = [
        (number / 10, "/clock", made("rosgraph_msgs/msg/Clock", clock=time_of((number % 25) * SECOND // 10)))
        for number in range(50)
    ]
    check = judged(write_bag(tmp_path / "bag", [*clocks, *driving()[:51]]), ge.always(f"time < 2.2 or {X} > 1.3"))
    assert check.outcome == "passed"
    assert check.verdict.decided == pytest.approx(2.4)
    first = judged(tmp_path / "bag", ge.always("time < 2.2"))
    assert first.outcome == "failed"


def test_the_recording_of_a_run_has_the_verdicts_of_the_run(tmp_path: Path) -> None:
    odom, scan = "/dd100_0000/odom", "/dd100_0000/sim_lidar/scan"
    expectations = (
        ge.within(3.0, f"message('{odom}').pose.pose.position.x > 0.5"),
        ge.always(f"abs(message('{odom}').twist.twist.linear.x) < 0.4"),
        ge.rate(scan, at_least=15.0),
        ge.latency(scan, 0.001),
        ge.settles(1.0, f"message('{odom}').twist.twist.linear.x > 0.3"),
    )
    with ge.load("dd100_flat").session(record=tmp_path / "run.mcap") as sim:
        ran = sim.expect(*expectations)
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        sim.run(2.5)
        for check in ran:
            check.end()
    for in_run, expectation in zip(ran, expectations, strict=True):
        again = judged(tmp_path / "run.mcap", expectation)
        assert again.outcome == in_run.outcome
        assert again.verdict.decided == pytest.approx(in_run.verdict.decided)
        assert again.verdict.robustness == pytest.approx(in_run.verdict.robustness, abs=1e-12)
    assert {check.outcome for check in ran} == {"passed", "failed"}


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        *((f"{name}('dd100') < 1", f"{name}: a bag has only topics; use a message") for name in WORLD),
        ("message('/positoin').x < 1", "the bag has no topic '/positoin'\n  did you mean '/position'?"),
        ("rate('/range', 0) < 1", "expected an interval of more than 0 s"),
        ("rate('/range', 1e-9) < 1", "the bag has 5e+09 intervals of 1e-09 s, more than 1000000"),
    ],
)
def test_a_condition_that_a_bag_cannot_evaluate_is_refused_at_once(drive: Path, condition: str, message: str) -> None:
    with pytest.raises(UsageError) as refused:
        ge.judge_bag(drive, ge.always(condition))
    assert message in str(refused.value)


def test_a_session_has_the_readings_of_topics_and_of_the_world() -> None:
    with ge.load("dd100_flat").session() as sim:
        assert {*readings_of(sim)} == {"time", "message", "age", "rate", *WORLD}


def test_unmet_expectations_raise_an_error_that_reports_each(drive: Path) -> None:
    with pytest.raises(ExpectationError) as raised:
        ge.judge_bag(drive, ge.always(f"{X} < 2"), ge.always("message('/level').leve > 1"), ge.within(9, "time > 1"))
    text = str(raised.value)
    assert f"failed: always {X} < 2\n  decided at 4.000 s\n  robustness -0.5, at 5.000 s" in text
    assert "the attribute 'leve' of a acme_msgs__msg__Level is not allowed" in text
    assert "within" not in text


def test_a_type_without_a_definition_is_refused(tmp_path: Path) -> None:
    folder = write_bag(tmp_path / "bag", driving(), StoragePlugin.SQLITE3)
    (file,) = folder.glob("*.db3")
    with closing(sqlite3.connect(file)) as database:
        database.execute("DELETE FROM message_definitions")
        database.commit()
    ge.judge_bag(folder, ge.within(3.0, f"{X} > 1.2"))  # ROS 2 defines this type
    with pytest.raises(
        UsageError, match="topic /level: neither the bag nor ROS 2 defines its type acme_msgs/msg/Level"
    ):
        ge.judge_bag(folder, ge.always("message('/level').level < 9"))


def test_a_message_that_cannot_be_decoded_is_an_error_of_its_expectation(tmp_path: Path) -> None:
    cut = write_bag(tmp_path / "bag", driving(), change=lambda topic, data: data[:9] if topic == "/level" else data)
    broken = judged(cut, ge.always("message('/level').level < 9"))
    assert broken.outcome == "error"
    assert "9 bytes cannot be decoded as acme_msgs/msg/Level" in broken.report()


@pytest.mark.parametrize("storage", StoragePlugin)
def test_a_damaged_bag_is_refused_or_judged_without_a_traceback(tmp_path: Path, storage: StoragePlugin) -> None:
    (file,) = (path for path in write_bag(tmp_path / "bag", driving(), storage).iterdir() if path.suffix != ".yaml")
    whole = file.read_bytes()
    outcomes: set[str] = set()
    for number in range(60):
        at = len(whole) * number // 60
        for damaged in (
            whole[:at],
            whole[:at] + bytes(40) + whole[at + 40 :],
            whole[:at] + b"\xff" * 9 + whole[at + 9 :],
        ):
            file.write_bytes(damaged)
            try:
                outcomes.add(judged(file, ge.always(f"{X} < 9")).outcome)
            except (RecordingError, UsageError) as error:
                outcomes.add(type(error).__name__)
    assert {"RecordingError", "passed"} <= outcomes <= {"RecordingError", "UsageError", "passed", "failed", "error"}


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE messages SET timestamp = 'soon'",
        "UPDATE messages SET timestamp = 'soon' WHERE id = 9",
        "UPDATE messages SET timestamp = -5 WHERE id = 9",
        "UPDATE messages SET data = 'text'",
        "UPDATE messages SET data = 5 WHERE id = 9",
        "UPDATE topics SET name = x'00ff'",
        "UPDATE topics SET type = x'00ff'",
        "UPDATE topics SET type = '../../etc/passwd'",
        "UPDATE message_definitions SET encoded_message_definition = '../a/B x'",
        "UPDATE message_definitions SET topic_type = 5",
        "DROP TABLE topics",
    ],
)
def test_a_database_with_illegal_values_is_refused_or_judged_as_an_error(tmp_path: Path, change: str) -> None:
    folder = write_bag(tmp_path / "bag", driving(), StoragePlugin.SQLITE3)
    (file,) = folder.glob("*.db3")
    with closing(sqlite3.connect(file)) as database:
        database.execute(change)
        database.commit()
    for condition in (f"{X} < 9", "rate('/level') > 0", "time < 9"):
        with suppress(RecordingError, UsageError):
            assert judged(folder, ge.always(condition)).outcome in ("passed", "failed", "error")


@pytest.mark.parametrize("kind", ["lz4", "zstd"])
def test_decompression_stops_at_the_declared_size_of_a_chunk(kind: str) -> None:
    packed = {"lz4": lz4.frame.compress, "zstd": storage_mcap.zstd.compress}[kind](bytes(10_000_000))  # type: ignore[attr-defined]
    assert len(storage_mcap.DECOMPRESSORS[kind](packed, 100)) == 101
    assert len(storage_mcap.DECOMPRESSORS[kind](packed, 10_000_000)) == 10_000_000
    with pytest.raises(ValueError, match="too large"):
        storage_mcap.DECOMPRESSORS[kind](packed, records.MAX_CHUNK_BYTES + 1)


def test_the_total_size_of_overlapping_chunks_is_limited(drive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_file, "MAX_CHUNK_BYTES", 1000)
    with pytest.raises(RecordingError, match="overlap in time"):
        ge.judge_bag(drive)


def test_the_size_of_a_compressed_message_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bag = write_bag(tmp_path / "bag", driving(), compression=CompressionMode.MESSAGE)
    monkeypatch.setattr(bag_file, "MAX_MESSAGE_BYTES", 10)
    assert "10 bytes cannot be decoded" in judged(bag, ge.always(f"{X} < 9")).report()


def test_files_that_are_not_bags_are_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.mcap").write_text("no bag")
    (tmp_path / "empty").mkdir()
    for name, message in (
        ("notes.mcap", "cannot be read as a bag"),
        ("empty", "expected an .mcap"),
        ("none", "no such file"),
    ):
        with pytest.raises(RecordingError, match=message):
            ge.judge_bag(tmp_path / name)
