"""A recording by the word of rosbag2's own reader, in an environment that has it."""

from __future__ import annotations

from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from graphengine.scene.loaded_scene import Options
from tests.recording.harness import CMD_VEL, DRIVE, record
from tests.ros import needs

pytestmark = pytest.mark.ros(needs.module("rosbag2_py"))

TICKS = 125


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[str, str, bytes]]]:
    """A recording that ROS 2's player is to like, and what was heard of it."""
    path = tmp_path_factory.mktemp("drive") / "drive.mcap"
    return path, record(path, TICKS, "dd100_flat", commands=DRIVE, options=Options(robot_state=True)).heard


def opened(path: Path) -> Any:
    rosbag2_py = import_module("rosbag2_py")
    reader = rosbag2_py.SequentialReader()
    reader.open(rosbag2_py.StorageOptions(str(path), "mcap"), rosbag2_py.ConverterOptions("cdr", "cdr"))
    return reader


def messages_of(path: Path) -> list[tuple[str, bytes, int]]:
    """Topic, bytes and time."""
    reader, found = opened(path), []
    while reader.has_next():
        found.append(reader.read_next())
    return found


def test_rosbag2_finds_each_topic_once_with_its_messages_and_profile(
    drive: tuple[Path, list[tuple[str, str, bytes]]],
) -> None:
    path, heard = drive
    metadata = opened(path).get_metadata()
    counts = {found.topic_metadata.name: found.message_count for found in metadata.topics_with_message_count}
    commands = sum(map(len, DRIVE.values()))
    expected = Counter(topic for topic, _, _ in heard)
    assert counts == {**expected, CMD_VEL: commands, "/_graphengine/session": len(DRIVE)}
    assert metadata.message_count == sum(counts.values())
    topics = [found.topic_metadata for found in metadata.topics_with_message_count]
    assert len(topics) == len(counts)
    for topic in topics:
        (offered,) = map(import_module("rosbag2_py").convert_rclcpp_qos_to_rclpy_qos, topic.offered_qos_profiles)
        latched = topic.name.endswith(("tf_static", "robot_description"))
        assert (offered.durability.name == "TRANSIENT_LOCAL") == latched
        assert offered.reliability.name == "RELIABLE"
        assert offered.depth == (1 if latched else 10)


def test_rosbag2_reads_every_message_in_order(drive: tuple[Path, list[tuple[str, str, bytes]]]) -> None:
    path, heard = drive
    found = messages_of(path)
    assert [time for _, _, time in found] == sorted(time for _, _, time in found)
    inputs = (CMD_VEL, "/_graphengine/session")
    assert [(topic, data) for topic, data, _ in found if topic not in inputs] == [(t, data) for t, _, data in heard]


@pytest.mark.parametrize("whole", [1, 2])
def test_rosbag2_reads_a_truncated_file_up_to_its_last_chunk(
    drive: tuple[Path, list[tuple[str, str, bytes]]], tmp_path: Path, whole: int
) -> None:
    path, _ = drive
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    chunks, cut = summary.chunk_indexes, tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: chunks[whole].chunk_start_offset + 100])
    expected = [message for message in messages_of(path) if message[2] <= chunks[whole - 1].message_end_time]
    assert messages_of(cut) == expected
    assert opened(cut).get_metadata().message_count == len(expected)
