"""Reads the records of an MCAP file in order, within limits; the file may be damaged, truncated or untrusted."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import MAGIC_SIZE, CRCValidationError, StreamReader, get_chunk_data_stream

from graphengine.format.errors import RecordingError
from graphengine.format.regular_files import open_regular

MAX_CHUNK_BYTES = 500_000_000
"""Maximum size of an uncompressed chunk, bytes; recorders write chunks of 4 MB, plus at most one tick."""


_HEAD = struct.Struct("<BQ")
"""Header of a record: type and length."""
_TIMES = struct.Struct("<QQ")
"""Header of a chunk: first and last log time, ns."""


class _OtherCompressionError(Exception):
    """A chunk has a compression that recordings do not use; the argument is the name of the compression."""


def read_records(path: Path, moved: Callable[[int, int], None] = lambda at, size: None) -> Iterator[McapRecord]:
    """Yield all records before the index, including records in chunks, up to the end of a truncated file.

    Args:
        path: path of the file.
        moved: called after each read with the number of bytes read until then and the size of the file.

    Raises:
        RecordingError: the file cannot be read, is not an MCAP file, or is damaged.
    """
    try:
        with open_regular(path) as file:
            yield from _records(path, file, moved)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from None


def read_extent(path: Path) -> tuple[int, Metadata]:
    """Return the last log time (ns) and the last metadata of a recording without unpacking chunks.

    The metadata has an empty name and no values if the file has none or is damaged there.

    Raises:
        RecordingError: the file cannot be read.
    """
    last, metadata = 0, b""
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            file.seek(MAGIC_SIZE)
            while len(head := file.read(_HEAD.size)) == _HEAD.size:
                opcode, length = _HEAD.unpack(head)
                begin = file.tell()
                if begin + length > size or opcode == Opcode.DATA_END:
                    break
                if opcode == Opcode.CHUNK:
                    last = max(last, *_TIMES.unpack(file.read(_TIMES.size).ljust(_TIMES.size, b"\0")))
                elif opcode == Opcode.METADATA:
                    metadata = file.read(length)
                file.seek(begin + length)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return last, Metadata.read(ReadDataStream(BytesIO(metadata)))
    except (EndOfFile, struct.error, ValueError):
        return last, Metadata(name="", metadata={})


def _records(path: Path, file: BinaryIO, moved: Callable[[int, int], None]) -> Iterator[McapRecord]:
    bounded = _Bounded(file)
    reader = StreamReader(bounded, emit_chunks=True)  # type: ignore[arg-type]  # it uses only `read`
    records, at = reader.records, 0
    try:
        while (record := next(records, None)) is not None and not isinstance(record, DataEnd):
            moved(file.tell(), bounded.size)
            if isinstance(record, Chunk):
                yield from _inside(record)
            else:
                yield record
            at = file.tell()
    except InvalidMagic:
        raise RecordingError(f"{path}: not an MCAP file") from None
    except (EndOfFile, struct.error):  # a truncated number at the end of the file
        return
    except CRCValidationError:
        raise RecordingError(f"{path}: damaged: the checksum of the chunk at byte {at} is wrong") from None
    except _OtherCompressionError as error:
        what = f"it is compressed with {str(error)!r}, but recordings made by `graphrun run --record` with 'lz4'"
        raise RecordingError(f"{path}: {what}") from None
    except (McapError, ValueError, RuntimeError, OverflowError) as error:
        raise RecordingError(f"{path}: damaged: the record at byte {at} cannot be read: {error}") from None


def _inside(chunk: Chunk) -> Iterator[McapRecord]:
    """Yield the records of a chunk one by one: even a small chunk can contain very many records.

    Raises:
        ValueError: a record is truncated, the checksum is wrong, or `_record` or `_unpacked` raises the error.
    """
    stream, size = get_chunk_data_stream(_unpacked(chunk), validate_crc=True)
    try:
        while stream.count < size:
            yield _record(stream)
    except (EndOfFile, struct.error):
        raise ValueError("a record of the chunk is truncated") from None


def _record(stream: ReadDataStream) -> McapRecord:
    """Return the next record of a chunk.

    Raises:
        ValueError: a chunk must not contain a record of this type, or the length of the record is wrong.
    """
    opcode, length = stream.read1(), stream.read8()
    end = stream.count + length
    record: McapRecord
    if opcode == Opcode.MESSAGE:
        record = Message.read(stream, length)
    elif opcode == Opcode.CHANNEL:
        record = Channel.read(stream)
    elif opcode == Opcode.SCHEMA:
        record = Schema.read(stream)
    else:
        raise ValueError(f"a chunk must not contain a record of type {opcode}")
    if stream.count != end:
        raise ValueError("the length of a record in a chunk is wrong")
    return record


def _unpacked(chunk: Chunk) -> Chunk:
    """Return the chunk in uncompressed form after a check of its size.

    Raises:
        ValueError: the size differs from the declared size, or is too large.
        _OtherCompressionError: the chunk uses a compression that recordings do not use.
    """
    if chunk.uncompressed_size > MAX_CHUNK_BYTES:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes is too large")
    if chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=chunk.uncompressed_size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise _OtherCompressionError(chunk.compression[:20])
    if len(data) != chunk.uncompressed_size:
        raise ValueError("the size of a chunk is wrong")
    return replace(chunk, compression="", data=data)


class _Bounded:
    """A file whose `read` requests at most as many bytes as the file has, even if a record declares a larger length."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.size = os.fstat(file.fileno()).st_size

    def read(self, count: int) -> bytes:
        return self._file.read(min(count, self.size))
