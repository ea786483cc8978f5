"""`graphrun replay` on files that are no recordings, damaged ones, and those of strangers."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from graphengine.cli import main
from graphengine.messages import messages
from graphengine.scene.loaded_scene import Options
from tests.cli.harness import Graphrun
from tests.recording.harness import CLOCK, NOISY_ROBOT, NOISY_SCENE, put, record, rewritten


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "not a recording made by"),
        (b"scene: a\n", "not an MCAP file"),
        (b"\x89MCAP0\r\n", "not a recording made by"),
        (b"\x89MCAP0\r\n" + b"\xff" * 100, "damaged: the record at byte"),
    ],
    ids=["empty", "text", "magic", "rubbish"],
)
def test_a_file_that_is_no_recording_is_refused(
    graphrun: Graphrun, tmp_path: Path, content: bytes, expected: str
) -> None:
    path = tmp_path / "out.mcap"
    path.write_bytes(content)
    result = graphrun("replay", str(path), code=2, out="")
    assert result.err.startswith(f"graphrun replay: {path}: {expected}")


def test_a_missing_file_is_refused(graphrun: Graphrun, tmp_path: Path) -> None:
    result = graphrun("replay", str(tmp_path / "out.mcap"))
    assert (result.code, result.err) == (
        2,
        f"graphrun replay: no file {str(tmp_path / 'out.mcap')!r}\n",
    )
    assert graphrun("replay", str(tmp_path)).err == f"graphrun replay: {tmp_path}: a folder, not a file\n"


def test_a_bag_of_another_program_is_refused(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    writer = Writer(str(path), compression=CompressionType.NONE)
    writer.start("ros2")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    channel = writer.register_channel("/chatter", "cdr", schema)
    writer.add_message(channel, 0, messages.encode(messages.String("a")), 0)
    writer.finish()  # type: ignore[no-untyped-call]
    result = graphrun("replay", str(path), code=2)
    assert "not a recording made by `graphrun run --record`" in result.err


def test_a_changed_byte_in_a_chunk_is_reported(graphrun: Graphrun, clock: Path, tmp_path: Path) -> None:
    record(tmp_path / "out.mcap", 3, clock)
    plain = rewritten(tmp_path / "out.mcap", compression=CompressionType.NONE).read_bytes()
    at = plain.rindex(messages.encode(messages.Clock(messages.Time(0, 50_000_000))))
    path = tmp_path / "out.mcap"
    path.write_bytes(plain[: at + 8] + b"\0" + plain[at + 9 :])
    result = graphrun("replay", str(path), code=2, out="")
    assert "damaged: the checksum of the chunk at byte " in result.err


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_recording_shows_no_traceback(clock_recording: bytes, tmp_path: Path, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(clock_recording) - 1))
    changed = bytearray(clock_recording)
    if data.draw(st.booleans()):
        del changed[at:]
    else:
        changed[at] ^= 1 << data.draw(st.integers(0, 7))
    path = tmp_path / "damaged.mcap"
    path.write_bytes(changed)
    assert main(["replay", str(path)]) in (0, 1, 2)


@pytest.fixture(scope="module")
def clock_recording(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("clock")
    record(folder / "out.mcap", 130, put(folder / "hall" / "clock.yaml", CLOCK))
    return (folder / "out.mcap").read_bytes()


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"manifest": {"format": "2"}}, "it has format '2'; this version reads 1"),
        ({"manifest": {"seed": '"x"'}}, "its seed is invalid"),
        ({"manifest": {"period": "[1, 0]"}}, "its period.1 is invalid"),
        ({"manifest": {"domain_from_environment": "233"}}, "its domain_from_environment is invalid"),
        ({"manifest": {"seed": "{"}}, "its metadata on the run cannot be read"),
        ({"manifest": {"given": '"project/../../etc/passwd"'}}, "is not a legal name for a file of a recording"),
        ({"attachments": {"project/hall/clock.yaml": b"graph: other"}}, "the checksum of its file"),
        ({"end": {"ticks": "many"}}, "its number of ticks is invalid: 'many'"),
        ({"commands": '{"commands": [["format", null]]}'}, "has an unknown command 'format'"),
        ({"commands": '{"commands": [["spawn", {"name": 1}]]}'}, "the recorded command 'spawn' is invalid"),
        ({"manifest": {"modules": '["os; rm -rf /"]'}}, "its modules.0 is invalid"),
        ({"commands": f'{{"wall_time": {"9" * 400}}}'}, "the external inputs of tick 1 cannot be read"),
        ({"commands": '{"wall_time": "x"}'}, "the external inputs of tick 1 cannot be read"),
        ({"commands": '{"delivered": [1]}'}, "the external inputs of tick 1 cannot be read"),
        ({"commands": "[1]"}, "the external inputs of tick 1 cannot be read"),
        (
            {"compression": CompressionType.ZSTD},
            "it is compressed with 'zstd', but recordings made by `graphrun run --record` with 'lz4'",
        ),
    ],
    ids=str,
)
def test_illegal_values_in_a_recording_are_reported(
    graphrun: Graphrun, clock: Path, tmp_path: Path, change: dict[str, object], expected: str
) -> None:
    record(tmp_path / "out.mcap", 3, clock)
    result = graphrun("replay", str(rewritten(tmp_path / "out.mcap", **change)))  # type: ignore[arg-type]
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("graphrun replay: ")
    assert expected in result.err


def test_a_tick_of_very_many_messages_is_refused(
    graphrun: Graphrun, clock: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphengine.recording.reader.MAX_MESSAGES", 0)
    record(tmp_path / "out.mcap", 3, clock)
    assert "it has more than 0 messages in tick 1" in graphrun("replay", str(tmp_path / "out.mcap")).err


def test_the_scene_of_a_stranger_reads_nothing_else(graphrun: Graphrun, tmp_path: Path) -> None:
    secret = put(tmp_path / "secret" / "robot.yaml", NOISY_ROBOT)
    put(tmp_path / "hall" / "noisy_robot.yaml", NOISY_ROBOT)
    scene = put(tmp_path / "hall" / "scene.yaml", NOISY_SCENE.replace("noisy_robot.yaml", str(secret)))
    record(tmp_path / "out.mcap", 2, scene, options=Options(allowed=[secret.parent]))
    result = graphrun("replay", str(tmp_path / "out.mcap"), code=1)
    assert "lies outside the folder of the file you gave" in result.err
