"""Writes an MCAP file in whole chunks, by a thread of its own.

To build, compress and write a second of pictures takes longer than a tick may. So the thread that ticks hands over lists of
entries, and waits only when a slow disk has left too many of them behind.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import stat
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from io import BufferedWriter, FileIO
from pathlib import Path
from typing import NamedTuple

from mcap.writer import CompressionType, Writer

from graphengine.format.errors import RecordingError
from graphengine.format.version import __version__
from graphengine.messages.definitions import Definitions
from graphengine.recording.mcap_schema import ENCODING, LIBRARY, PROFILE, Stream

MAX_WAITING = 64_000_000
"""Bytes that may wait to be written."""


class TimedMessage(NamedTuple):
    """A message and its times in nanoseconds."""

    stream: Stream
    log_time: int
    publish_time: int
    data: bytes


class RecordingWriter:
    """A new recording. It can be read up to the last chunk that was written, whatever becomes of the process.

    Args:
        path: of the file.
        definitions: of the messages.
        force: write over a file that is there.

    Raises:
        RecordingError: there is a file, or none can be written there.
    """

    def __init__(self, path: Path, definitions: Definitions, *, force: bool = False) -> None:
        self.path = path
        self._definitions = definitions
        try:
            self._raw = _opened(path, force)
        except FileExistsError:
            raise RecordingError(f"{path}: already exists; --force overwrites it") from None
        except BlockingIOError:
            raise RecordingError(f"{path}: another run is being recorded there") from None
        except OSError as error:
            raise self._failure(error) from None
        self._file = BufferedWriter(self._raw)
        # LZ4: of noisy pictures Zstandard packs no more than 140 MB/s, and a single camera may make more.
        self._mcap = Writer(self._file, chunk_size=2**62, compression=CompressionType.LZ4)
        self._schemas: dict[str, int] = {}
        self._channels: dict[Stream, int] = {}
        self._thread = ThreadPoolExecutor(1, "recording")
        self._waiting: deque[tuple[Future[None], int]] = deque()
        self._waiting_bytes = 0
        self._failed = False
        self._waiting.append((self._thread.submit(self._do, self._begin), 0))

    @property
    def size(self) -> int:
        """Number of bytes in the file, which must be open."""
        return os.fstat(self._raw.fileno()).st_size

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Add metadata."""
        self._hand_over(partial(self._mcap.add_metadata, name, dict(values)))

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Add a file."""
        self._hand_over(partial(self._mcap.add_attachment, 0, 0, name, media_type, data), len(data))

    def add(self, entries: Sequence[TimedMessage]) -> None:
        """Add a chunk."""
        self._hand_over(partial(self._add, entries), sum(len(entry.data) for entry in entries))

    def close(self) -> None:
        """Write what is still to be written, and the index.

        Raises:
            RecordingError: it cannot be written; what was written before is still there.
        """
        try:
            self._hand_over(self._mcap.finish)
            self._settle(-1)
            self._thread.shutdown()
            self._file.close()
        except OSError as error:
            raise self._failure(error) from None
        finally:
            self.abandon()

    def abandon(self) -> None:
        """Leave the file as it is, without an index; safe to call twice."""
        self._thread.shutdown(cancel_futures=True)
        with contextlib.suppress(OSError):  # what it could not write is told by then
            self._file.close()
        self._raw.close()

    def _hand_over(self, job: Callable[[], object], size: int = 0) -> None:
        """Have the thread do a job, after those before it.

        Raises:
            RecordingError: an earlier one failed.
        """
        self._waiting.append((self._thread.submit(self._do, job), size))
        self._waiting_bytes += size
        self._settle(MAX_WAITING)

    def _settle(self, bound: int) -> None:
        """See to the jobs that are done, and wait until no more than some bytes wait."""
        while self._waiting and (self._waiting[0][0].done() or self._waiting_bytes > bound):
            job, size = self._waiting.popleft()
            self._waiting_bytes -= size
            try:
                job.result()
            except OSError as error:
                raise self._failure(error) from None

    def _do(self, job: Callable[[], object]) -> None:
        if self._failed:  # what follows a gap could not be read
            return
        try:
            job()
            self._mcap.flush()  # type: ignore[no-untyped-call]
            if not os.fstat(self._raw.fileno()).st_nlink:
                raise FileNotFoundError(errno.ENOENT, "the file was removed")
        except BaseException:
            self._failed = True
            raise

    def _begin(self) -> None:
        self._mcap.start(PROFILE, f"{LIBRARY} {__version__}")

    def _add(self, entries: Sequence[TimedMessage]) -> None:
        for entry in entries:
            channel = self._channels.get(entry.stream) or self._register(entry.stream)
            self._mcap.add_message(channel, entry.log_time, entry.data, entry.publish_time)

    def _register(self, stream: Stream) -> int:
        kind = stream.message_type
        if kind not in self._schemas:
            self._schemas[kind] = self._mcap.register_schema(kind, "ros2msg", self._definitions.text(kind).encode())
        metadata = {**stream.metadata(), "topic_type_hash": self._definitions.type_hash(kind)}
        channel = self._mcap.register_channel(stream.channel, ENCODING, self._schemas[kind], metadata)
        self._channels[stream] = channel
        return channel

    def _failure(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path}: it cannot be recorded there: {error.strerror or error}")


def _opened(path: Path, force: bool) -> FileIO:
    """An empty file that no other recording may be written to; the lock ends with the file, whatever becomes of the process.

    A symbolic link is refused: in a stranger's folder it may lead to any file of the user's.

    Raises:
        BlockingIOError: another one is.
        OSError: it cannot be written, or is there and must not be.
    """
    if path.is_symlink():
        raise OSError(errno.ELOOP, "a symbolic link; write the name of the file that it leads to")
    file = open(path, "ab" if force else "xb", buffering=0, opener=_create)  # noqa: SIM115  # it is returned
    try:
        _lock(file)
        if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            file.truncate(0)
    except BaseException:
        file.close()
        raise
    return file


def _create(path: str, flags: int) -> int:
    """Open a file, but no symbolic link, and without waiting for the reader of a pipe."""
    return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)


def _lock(file: FileIO) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # some file systems have no locks
        pass
