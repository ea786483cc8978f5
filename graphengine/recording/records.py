"""The records of an MCAP file in their order, checked and bounded; the file may be damaged, cut off, or a stranger's."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

import lz4.frame
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.records import Chunk, DataEnd, McapRecord
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from graphengine.diagnostics import RecordingError

MAX_CHUNK_BYTES = 1_000_000_000


class _OtherCompressionError(Exception):
    """A chunk of another program; the argument is how it is packed."""


def read_records(path: Path) -> Iterator[McapRecord]:
    """All records before the index, those in chunks too; they end where the file was cut off.

    Raises:
        RecordingError: the file cannot be read, is no MCAP file, or is damaged.
    """
    try:
        with path.open("rb") as file:
            yield from _records(path, file)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from None


def _records(path: Path, file: BinaryIO) -> Iterator[McapRecord]:
    bounded = _Bounded(file)
    reader = StreamReader(bounded, emit_chunks=True)  # type: ignore[arg-type]  # it asks for nothing but `read`
    records = reader.records
    while True:
        at = file.tell()
        try:
            record = next(records, None)
            inside = breakup_chunk(_unpacked(record), validate_crc=True) if isinstance(record, Chunk) else []
        except InvalidMagic:
            raise RecordingError(f"{path}: this is no MCAP file") from None
        except (EndOfFile, struct.error):  # at the end of the file some bytes of a number are missing, or all
            return
        except CRCValidationError:
            raise RecordingError(f"{path}: damaged: the checksum of the chunk at byte {at} is wrong") from None
        except _OtherCompressionError as error:
            what = f"it is compressed with {str(error)!r}, and what `graphrun run --record` writes is with 'lz4'"
            raise RecordingError(f"{path}: {what}") from None
        except (McapError, ValueError, RuntimeError, OverflowError) as error:
            raise RecordingError(f"{path}: damaged: the record at byte {at} cannot be read: {error}") from None
        if record is None or isinstance(record, DataEnd):
            return
        if isinstance(record, Chunk):
            yield from inside
        else:
            yield record


def _unpacked(chunk: Chunk) -> Chunk:
    """A chunk that is not compressed, of the size that it says.

    Raises:
        ValueError: it is larger than it says, or than any may be.
        _OtherCompressionError: it is packed in another way than recordings are.
    """
    if chunk.uncompressed_size > MAX_CHUNK_BYTES:
        raise ValueError(f"a chunk has {chunk.uncompressed_size} bytes")
    if chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=chunk.uncompressed_size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise _OtherCompressionError(chunk.compression[:20])
    if len(data) != chunk.uncompressed_size:
        raise ValueError("a chunk has not the size that it says")
    return replace(chunk, compression="", data=data)


class _Bounded:
    """A file that is not asked for more than it holds, whatever the lengths in it say."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._size = os.fstat(file.fileno()).st_size

    def read(self, count: int) -> bytes:
        return self._file.read(min(count, self._size))
