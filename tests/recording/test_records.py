"""Chunks that say other sizes than they have, and records that say other lengths."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import lz4.frame
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk, Header, Message, Metadata
from mcap.writer import MCAP0_MAGIC

from graphengine.format.errors import RecordingError
from graphengine.recording import records
from graphengine.recording.records import read_extent, read_records


def messages_of(count: int) -> bytes:
    builder = RecordBuilder()
    for number in range(count):
        Message(channel_id=1, log_time=number, data=bytes(100), publish_time=0, sequence=0).write(builder)
    return builder.end()  # type: ignore[no-any-return, no-untyped-call]


def file_of(folder: Path, chunk: Chunk) -> Path:
    builder = RecordBuilder()
    Header("ros2", "test").write(builder)
    chunk.write(builder)
    path = folder / "out.mcap"
    path.write_bytes(MCAP0_MAGIC + builder.end())  # type: ignore[no-untyped-call]
    return path


def chunk_of(data: bytes, *, size: int | None = None, compression: str = "lz4", crc: int | None = None) -> Chunk:
    packed = lz4.frame.compress(data) if compression == "lz4" else data
    size = len(data) if size is None else size
    return Chunk(compression, packed, 0, 0, zlib.crc32(data) if crc is None else crc, size)


@pytest.mark.parametrize("compression", ["lz4", ""])
def test_the_messages_of_a_chunk_are_read_in_order(tmp_path: Path, compression: str) -> None:
    found = list(read_records(file_of(tmp_path, chunk_of(messages_of(5), compression=compression))))
    assert [record.log_time for record in found if isinstance(record, Message)] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("size", [0, 1, 10_000_000])
def test_a_chunk_with_a_wrong_size_is_damaged(tmp_path: Path, size: int) -> None:
    path = file_of(tmp_path, chunk_of(messages_of(50), size=size))
    with pytest.raises(RecordingError, match=r"damaged: .* the size of a chunk is wrong"):
        list(read_records(path))


def test_a_chunk_beyond_the_maximum_size_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(records, "MAX_CHUNK_BYTES", 1000)
    with pytest.raises(RecordingError, match="a chunk of 13100 bytes is too large"):
        list(read_records(file_of(tmp_path, chunk_of(messages_of(100)))))


def test_a_chunk_with_a_wrong_checksum_is_damaged(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="damaged: the checksum of the chunk at byte 33 is wrong"):
        list(read_records(file_of(tmp_path, chunk_of(messages_of(3), crc=7))))


def test_a_chunk_that_ends_within_a_record_is_damaged_from_this_record_on(tmp_path: Path) -> None:
    found = read_records(file_of(tmp_path, chunk_of(messages_of(3)[:-7])))
    assert [type(next(found)) for _ in range(3)] == [Header, Message, Message]
    with pytest.raises(RecordingError, match=r"damaged: .* the length of a record in a chunk is wrong"):
        next(found)


def test_a_chunk_with_records_other_than_messages_channels_and_schemas_is_damaged(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"damaged: .* a chunk must not contain a record of type 0"):
        list(read_records(file_of(tmp_path, chunk_of(messages_of(1) + bytes(900)))))


@given(data=st.data())
@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_truncated_file_is_read_up_to_its_end(tmp_path: Path, data: st.DataObject) -> None:
    builder = RecordBuilder()
    Header("ros2", "test").write(builder)
    sizes = [builder.count]
    for _ in range(3):
        chunk_of(messages_of(4)).write(builder)
        sizes.append(builder.count)
    whole = MCAP0_MAGIC + builder.end()  # type: ignore[no-untyped-call]
    end = data.draw(st.integers(len(MCAP0_MAGIC), len(whole)))
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[:end])
    chunks = sum(len(MCAP0_MAGIC) + size <= end for size in sizes[1:])
    assert sum(isinstance(found, Message) for found in read_records(path)) == 4 * chunks


def test_a_length_beyond_the_end_of_the_file_takes_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    attachment = struct.pack("<QQIIQ", 0, 0, 0, 0, 2**62)
    path.write_bytes(MCAP0_MAGIC + struct.pack("<BQ", 9, len(attachment)) + attachment)
    assert list(read_records(path)) == []


def test_the_extent_of_a_file_is_its_last_log_time_and_metadata(tmp_path: Path) -> None:
    builder = RecordBuilder()
    Header("ros2", "test").write(builder)
    sizes = [builder.count]
    for record in (
        Chunk("lz4", b"", 3, 70, 0, 0),
        Metadata("a", {"ticks": "5"}),
        Chunk("zstd", bytes(9), 71, 90, 0, 5),
    ):
        record.write(builder)
        sizes.append(builder.count)
    whole = MCAP0_MAGIC + builder.end()  # type: ignore[no-untyped-call]
    path = tmp_path / "out.mcap"
    found = []
    for size in sizes:
        path.write_bytes(whole[: len(MCAP0_MAGIC) + size + 5])
        last, metadata = read_extent(path)
        found.append((last, metadata.metadata))
    assert found == [(0, {}), (70, {}), (70, {"ticks": "5"}), (90, {"ticks": "5"})]


@given(data=st.binary(max_size=200), kind=st.sampled_from([0, 6, 12, 15]))
@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_reading_the_extent_of_any_bytes_raises_no_error(tmp_path: Path, data: bytes, kind: int) -> None:
    path = tmp_path / "out.mcap"
    path.write_bytes(MCAP0_MAGIC + struct.pack("<BQ", kind, len(data)) + data + data)
    last, _ = read_extent(path)
    assert 0 <= last < 2**64
