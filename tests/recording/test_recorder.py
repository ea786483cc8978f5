"""What a recording holds, by the word of readers that others wrote."""

from __future__ import annotations

import hashlib
import json
import os
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from graphengine.format.errors import RecordingError, UsageError
from graphengine.format.files import shipped
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim
from graphengine.recording.recorder import Recorder
from graphengine.recording.writer import RecordingWriter
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.run_status import StatusMeter
from graphengine.scene import build
from tests.jobs.harness import Recorder as Listener
from tests.jobs.harness import nanoseconds, twist
from tests.other_process import in_another_process
from tests.recording.harness import CLOCK, CMD_VEL, DRIVE, SYSTEM_CLOCK, Run, at, put, record

TICKS = 125
ECHO = """graph: echo
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Clock: PublishClock
  Heard: ROS2SubscribeClock
  Other: ROS2SubscribeClock
  Context: ROS2Context
connections:
  - Tick.tick -> Clock.execIn
  - Time.simulationTime -> Clock.timeStamp
  - Tick.tick -> Heard.execIn
  - Tick.tick -> Other.execIn
  - Context.context -> Clock.context
"""
SPEAK = messages.Clock(messages.Time(1000, 0))
"""What another program says on /clock."""


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Run]:
    path = tmp_path_factory.mktemp("drive") / "drive.mcap"
    return path, record(path, TICKS, commands=DRIVE)


def read(path: Path, **where: Any) -> list[tuple[Channel, Message, str]]:
    """Messages in the order of the file, with their channels and the names of their types."""
    with path.open("rb") as file:
        found = make_reader(file).iter_messages(log_time_order=False, **where)
        return [(channel, message, schema.name) for schema, channel, message in found if schema]


def outside(path: Path) -> dict[int, Any]:
    """What came from outside, by nanoseconds."""
    found = read(path, topics=["/_graphengine/session"])
    return {m.log_time: json.loads(messages.decode(m.data, kind).data) for _, m, kind in found}


def published(path: Path) -> list[tuple[str, str, bytes]]:
    """Topic, type and bytes of the messages that did not come to nodes."""
    left = {time: len(found.get("delivered", [])) for time, found in outside(path).items()}
    found = []
    for channel, message, kind in read(path):
        if channel.topic != "/_graphengine/session":
            left[message.log_time] = left.get(message.log_time, 0) - 1
            if left[message.log_time] < 0:
                found.append((channel.topic, kind, message.data))
    return found


def metadata(path: Path, name: str) -> dict[str, str]:
    with path.open("rb") as file:
        (found,) = [item.metadata for item in make_reader(file).iter_metadata() if item.name == name]
        return found


def small(folder: Path, text: str = CLOCK) -> Path:
    return put(folder / "hall" / "clock.yaml", text)


# Messages


def test_every_sent_message_is_recorded_in_order(drive: tuple[Path, Run]) -> None:
    path, run = drive
    assert published(path) == run.heard
    assert Counter(topic for topic, _, _ in run.heard)["/dd100_0000/odom"] == TICKS


def test_received_messages_are_recorded_at_the_tick_of_their_delivery(drive: tuple[Path, Run]) -> None:
    path, _ = drive
    found = [(c, m) for c, m, _ in read(path, topics=[CMD_VEL])]
    expected = [(tick, messages.encode(twist(*speeds))) for tick, given in DRIVE.items() for speeds in given]
    assert [(m.log_time, m.data) for _, m in found] == [(tick * 10**9 // 60, data) for tick, data in expected]
    node = "/dd100/Geometry/base_link/chassis_link/cmd_vel/SubscribeTwist"
    assert outside(path) == {tick * 10**9 // 60: {"delivered": [[node]] * len(given)} for tick, given in DRIVE.items()}


def test_times_are_those_of_the_simulation_and_inputs_come_first(drive: tuple[Path, Run]) -> None:
    path, _ = drive
    found = read(path)
    assert [m.log_time for _, m, _ in found] == sorted(m.log_time for _, m, _ in found)
    assert all(m.publish_time == m.log_time for _, m, _ in found)
    for _, message, kind in found:
        if kind == "rosgraph_msgs/msg/Clock":
            stamp = nanoseconds(messages.decode(message.data, kind).clock)
            assert abs(stamp - message.log_time) <= 1
    at_twelve = [channel.topic for channel, m, _ in found if m.log_time == 12 * 10**9 // 60]
    assert at_twelve[:3] == ["/_graphengine/session", CMD_VEL, CMD_VEL]
    assert not {"/_graphengine/session", CMD_VEL} & set(at_twelve[3:])


def test_the_definitions_in_the_file_decode_every_message(drive: tuple[Path, Run]) -> None:
    path, _ = drive
    with path.open("rb") as file:
        schemas = make_reader(file).get_summary().schemas.values()  # type: ignore[union-attr]
    assert {schema.encoding for schema in schemas} == {"ros2msg"}
    for schema in schemas:
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(schema.data.decode(), schema.name))
        for _, message, kind in read(path):
            if kind == schema.name:
                again = bytes(store.serialize_cdr(store.deserialize_cdr(message.data, kind), kind))
                assert message.data == again + bytes(len(message.data) - len(again))


def test_rosbags_reads_a_recording_as_a_bag_of_ros_2(drive: tuple[Path, Run]) -> None:
    path, run = drive
    with Reader(path) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        assert counts == {
            **Counter(topic for topic, _, _ in run.heard),
            CMD_VEL: sum(map(len, DRIVE.values())),
            "/_graphengine/session": len(DRIVE),
        }
        for connection in reader.connections:
            (qos,) = connection.ext.offered_qos_profiles  # type: ignore[union-attr]
            assert (qos.durability.name == "TRANSIENT_LOCAL") == connection.topic.endswith("tf_static")
        store = get_typestore(Stores.ROS2_JAZZY)
        for connection, _, data in reader.messages():
            message: Any = store.deserialize_cdr(data, connection.msgtype)
            assert message.__msgtype__ == connection.msgtype


def test_the_checksums_of_the_file_are_right(drive: tuple[Path, Run]) -> None:
    path, _ = drive
    with path.open("rb") as file:
        chunks = [r for r in StreamReader(file, emit_chunks=True, validate_crcs=True).records if isinstance(r, Chunk)]
    assert len(chunks) == 3
    assert all(chunk.uncompressed_crc and chunk.compression == "lz4" for chunk in chunks)
    assert len(read(path)) > TICKS


# What a replay needs


def test_every_read_file_is_attached_with_its_hash(drive: tuple[Path, Run]) -> None:
    path, _ = drive
    with path.open("rb") as file:
        attached = {a.name: a.data for a in make_reader(file).iter_attachments()}
    assert {name.rpartition("/")[2] for name in attached} >= {
        "dd100_warehouse.yaml",
        "full_warehouse.xml",
        "dd100.yaml",
        "dd100.urdf",
        "clock.yaml",
        "cmd_vel.yaml",
    }
    for name, data in attached.items():
        assert data == (shipped() / name.removeprefix("shipped/")).read_bytes()
    assert metadata(path, "graphengine:files") == {
        name: hashlib.sha256(data).hexdigest() for name, data in attached.items()
    }


def test_the_manifest_describes_the_run(drive: tuple[Path, Run]) -> None:
    path, _ = drive
    told = {key: json.loads(value) for key, value in metadata(path, "graphengine").items()}
    assert told["given"] == "shipped/scenes/dd100_warehouse.yaml"
    assert (told["seed"], told["overrides"], told["period"]) == (0, {}, [1, 60])
    assert {"graphengine", "python", "numpy", "mujoco-core", "processor", "rays"} <= set(told["machine"])
    assert "OpenGL" not in told["machine"]
    assert told["rays"] == told["machine"]["rays"]
    assert metadata(path, "graphengine:end") == {"ticks": str(TICKS), "failure": ""}


def recorded(folder: Path) -> bytes:
    folder.mkdir()
    record(folder / "out.mcap", 70, small(folder))
    return (folder / "out.mcap").read_bytes()


def test_equal_runs_in_different_folders_make_equal_files(tmp_path: Path) -> None:
    made = recorded(tmp_path / "alice")
    assert in_another_process(recorded, tmp_path / "bob") == made
    assert str(tmp_path).encode() not in made


def test_the_wall_clock_is_recorded_only_if_a_node_has_read_it(tmp_path: Path) -> None:
    record(tmp_path / "simulation.mcap", 3, small(tmp_path))
    assert {channel.topic for channel, _, _ in read(tmp_path / "simulation.mcap")} == {"/clock"}
    record(tmp_path / "system.mcap", 3, small(tmp_path, SYSTEM_CLOCK))
    found = read(tmp_path / "system.mcap")
    said = [nanoseconds(messages.decode(m.data, kind).clock) for c, m, kind in found if c.topic == "/clock"]
    assert [int(one["wall_time"] * 1e9) for one in outside(tmp_path / "system.mcap").values()] == said
    assert len(said) == 3


def test_after_a_stop_log_time_continues_and_publish_time_restarts(tmp_path: Path) -> None:
    record(tmp_path / "out.mcap", 5, small(tmp_path), before=at(4, lambda run: run.session.stop()))
    clocks = [message for channel, message, _ in read(tmp_path / "out.mcap") if channel.topic == "/clock"]
    ticks = (1, 2, 3, 4, 4, 5)  # before tick 4, the stop announces time 0
    assert [message.log_time for message in clocks] == [tick * 10**9 // 60 for tick in ticks]
    assert clocks[3].publish_time == 0
    assert [message.publish_time for message in clocks[4:]] == [message.publish_time for message in clocks[:2]]


def test_a_message_for_several_nodes_names_all_of_them(tmp_path: Path) -> None:
    text = """graph: two
nodes:
  Tick: OnPlaybackTick
  One: {type: ROS2SubscribeTwist, inputs: {topicName: /dd100_0000/cmd_vel}}
  Other: {type: ROS2SubscribeTwist, inputs: {topicName: /dd100_0000/cmd_vel}}
connections:
  - Tick.tick -> One.execIn
  - Tick.tick -> Other.execIn
"""
    record(tmp_path / "out.mcap", 10, small(tmp_path, text), commands={3: [(1.0, 0.0)]})
    ((_, message, _),) = read(tmp_path / "out.mcap", topics=[CMD_VEL])
    assert message.log_time == 3 * 10**9 // 60
    assert outside(tmp_path / "out.mcap") == {message.log_time: {"delivered": [["/World/two/One", "/World/two/Other"]]}}


def test_messages_between_nodes_of_the_run_occur_once(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 10, small(tmp_path, ECHO), before=at(5, lambda run: run.transport.inject("/clock", SPEAK)))
    clocks = read(path, topics=["/clock", "/_graphengine/delivered/clock"])
    told = [(c.topic, messages.decode(m.data, kind).clock.sec, m.log_time) for c, m, kind in clocks]
    assert Counter((topic, sec) for topic, sec, _ in told) == {
        ("/clock", 0): 10,
        ("/clock", 1000): 1,
        ("/_graphengine/delivered/clock", 0): 9,
    }
    assert [time for topic, sec, time in told if sec] == [5 * 10**9 // 60]
    nodes = ["/World/echo/Heard", "/World/echo/Other"]
    assert [len(found["delivered"]) for found in outside(path).values()] == [1, 1, 1, 2, 1, 1, 1, 1, 1]
    assert all(readers == nodes for found in outside(path).values() for readers in found["delivered"])
    assert {channel.metadata["topic"] for channel, _, _ in clocks} == {"/clock"}


def test_received_and_published_messages_of_a_topic_share_a_channel(tmp_path: Path) -> None:
    text = ECHO.replace(
        "  Clock: PublishClock\n", "  Clock: {type: PublishClock, inputs: {qosProfile: '{\"depth\": 3}'}}\n"
    )
    before = at(1, lambda run: run.transport.inject("/clock", SPEAK))
    record(tmp_path / "out.mcap", 3, small(tmp_path, text), before=before)
    (channel,) = {c.id: c for c, _, _ in read(tmp_path / "out.mcap", topics=["/clock"])}.values()
    assert "depth: 3\n" in channel.metadata["offered_qos_profiles"]


def test_messages_of_an_interrupted_tick_are_not_recorded(tmp_path: Path) -> None:
    class Interrupting(Listener):
        def write(self, claim: EndpointClaim, data: bytes) -> None:
            raise KeyboardInterrupt

    def interrupt(run: Run) -> None:
        network = run.session.services.network
        assert isinstance(network, LiveNetwork)
        network.sinks.append(Interrupting())

    with pytest.raises(KeyboardInterrupt):
        record(tmp_path / "out.mcap", 5, small(tmp_path), before=at(3, interrupt))
    assert [topic for topic, _, _ in published(tmp_path / "out.mcap")] == ["/clock"] * 2


def test_malformed_received_bytes_are_recorded_unchanged(tmp_path: Path) -> None:
    before = at(2, lambda run: run.transport.inject(CMD_VEL, b"rubbish"))
    record(tmp_path / "out.mcap", 3, "dd100_flat", before=before)
    assert [m.data for c, m, _ in read(tmp_path / "out.mcap", topics=[CMD_VEL])] == [b"rubbish"]


def test_a_recorded_paced_run_waits_for_its_camera_images(tmp_path: Path) -> None:
    paces: list[bool] = []

    def look(tick: int, run: Run) -> None:
        run.session.run(run.session.clock.delta, pace=100.0)
        paces.append(run.session.services.world.realtime)
        run.session.inbox = ExternalInputs()
        run.session.run(run.session.clock.delta, pace=100.0)
        paces.append(run.session.services.world.realtime)

    record(tmp_path / "out.mcap", 1, small(tmp_path), before=look)
    assert paces == [False, True]


def test_a_recording_cannot_begin_after_the_first_tick(tmp_path: Path) -> None:
    assembly = build.load(small(tmp_path))
    network = LiveNetwork(lambda _: MemoryTransport(), 0, print)
    with build.start(assembly, network) as session:
        session.step()
        with pytest.raises(UsageError, match="before the first tick"):
            Recorder(session, network, assembly, tmp_path / "out.mcap")
    assert not (tmp_path / "out.mcap").exists()


# Files that cannot be written


def test_an_existing_file_is_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    path.write_bytes(b"mine")
    with pytest.raises(RecordingError, match="already exists; --force overwrites it"):
        record(path, 1, small(tmp_path))
    assert path.read_bytes() == b"mine"
    record(path, 1, small(tmp_path), force=True)
    assert len(read(path)) == 1


def test_a_file_that_another_run_writes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"

    def interfere(run: Run) -> None:
        with pytest.raises(RecordingError, match="another run is writing its recording"):
            RecordingWriter(path, DEFINITIONS, force=True)

    record(path, 130, small(tmp_path), before=at(70, interfere))
    assert len(read(path)) == 130
    RecordingWriter(path, DEFINITIONS, force=True).close()
    assert read(path) == []


@pytest.mark.parametrize("gone", ["out.mcap", "."])
def test_the_removal_of_the_file_ends_the_run(tmp_path: Path, gone: str) -> None:
    folder = tmp_path / "bags"
    folder.mkdir()

    def remove(run: Run) -> None:
        (folder / "out.mcap").unlink()
        if gone == ".":
            folder.rmdir()

    with pytest.raises(RecordingError, match="the recording cannot be written: the file was removed"):
        record(folder / "out.mcap", 1000, small(tmp_path), before=at(70, remove))


def test_two_simultaneous_recordings_give_equal_files(tmp_path: Path) -> None:
    paths = [tmp_path / "one.mcap", tmp_path / "other.mcap"]
    before = at(30, lambda run: record(paths[1], 130, small(tmp_path)))
    record(paths[0], 130, small(tmp_path), before=before)
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize("place", ["nowhere/out.mcap", "."])
def test_a_path_that_cannot_be_written_is_an_error(tmp_path: Path, place: str) -> None:
    with pytest.raises(RecordingError, match=r"the recording cannot be written|already exists"):
        record(tmp_path / place, 1, small(tmp_path))


def test_a_full_disk_ends_the_run(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="the recording cannot be written: No space left on device"):
        record(Path("/dev/full"), 1000, small(tmp_path), force=True)


@pytest.mark.parametrize("force", [False, True])
def test_a_recording_does_not_follow_a_link(tmp_path: Path, force: bool) -> None:
    path, victim = tmp_path / "out.mcap", tmp_path / "victim"
    victim.write_text("mine", encoding="utf-8")
    path.symlink_to(victim)
    with pytest.raises(RecordingError, match="the recording cannot be written: it is a symbolic link"):
        record(path, 1, small(tmp_path), force=force)
    assert victim.read_text(encoding="utf-8") == "mine"


def test_a_recording_does_not_wait_for_the_reader_of_a_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "out.mcap")
    with pytest.raises(RecordingError, match="the recording cannot be written: No such device or address"):
        record(tmp_path / "out.mcap", 1, small(tmp_path), force=True)


def test_a_large_chunk_is_written_before_its_second_is_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.recording.recorder.CHUNK_BYTES", 100)
    record(tmp_path / "out.mcap", 50, small(tmp_path))
    with (tmp_path / "out.mcap").open("rb") as file:
        chunks = [r for r in StreamReader(file, emit_chunks=True).records if isinstance(r, Chunk)]
    size = len(messages.encode(messages.Clock(messages.Time(0, 0))))
    assert len(chunks) == -(-50 // -(-100 // size))


def test_the_size_of_the_recording_is_shown_while_it_grows(tmp_path: Path) -> None:
    path, sizes = tmp_path / "grows.mcap", list[int]()

    def look(tick: int, run: Run) -> None:
        size = StatusMeter(run.session).read().recorded_bytes
        assert size is not None
        sizes.append(size)

    run = record(path, 600, put(tmp_path / "clock.yaml", CLOCK), before=look)
    assert sizes == sorted(sizes)
    assert 0 <= sizes[0] < sizes[-1] <= path.stat().st_size
    run.session.inbox = ExternalInputs()
    assert StatusMeter(run.session).read().recorded_bytes is None
