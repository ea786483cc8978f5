"""Writes an MCAP file in whole chunks, in a separate thread.

Building, compressing and writing a second of camera images can take longer than a tick. So the session's thread only queues the
data, and waits only if too much data is in the queue because of a slow disk.
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
from graphengine.recording.mcap_schema import ENCODING, LIBRARY, PROFILE, PortStream, Stream

MAX_WAITING = 64_000_000
"""Maximum number of bytes in the queue of the writer thread."""


class TimedMessage(NamedTuple):
    """A message with its log time and publish time in nanoseconds."""

    stream: Stream | PortStream
    log_time: int
    publish_time: int
    data: bytes


class RecordingWriter:
    """Writes a new recording. If the process ends unexpectedly, the file is readable up to the last written chunk.

    Args:
        path: path of the file.
        definitions: definitions of the message types.
        force: whether to overwrite an existing file.

    Raises:
        RecordingError: the file exists, or cannot be written.
    """

    def __init__(self, path: Path, definitions: Definitions, *, force: bool = False) -> None:
        self.path = path
        self._definitions = definitions
        try:
            self._raw = _opened(path, force)
        except FileExistsError:
            raise RecordingError(f"{path}: already exists; --force overwrites it") from None
        except BlockingIOError:
            raise RecordingError(f"{path}: another run is writing its recording to this file") from None
        except OSError as error:
            raise self._failure(error) from None
        self._file = BufferedWriter(self._raw)
        # LZ4: Zstandard compresses at most 140 MB/s of noisy images, and one camera can produce more.
        self._mcap = Writer(self._file, chunk_size=2**62, compression=CompressionType.LZ4)
        self._schemas: dict[str, int] = {}
        self._channels: dict[Stream | PortStream, int] = {}
        self._thread = ThreadPoolExecutor(1, "recording")
        self._waiting: deque[tuple[Future[None], int]] = deque()
        self._waiting_bytes = 0
        self._failed = False
        begin = partial(self._mcap.start, PROFILE, f"{LIBRARY} {__version__}")
        self._waiting.append((self._thread.submit(self._do, begin), 0))

    @property
    def size(self) -> int:
        """Size of the file in bytes; the file must be open."""
        return os.fstat(self._raw.fileno()).st_size

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Queue a metadata record."""
        self._hand_over(partial(self._mcap.add_metadata, name, dict(values)))

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Queue an attachment with the content of a file."""
        self._hand_over(partial(self._mcap.add_attachment, 0, 0, name, media_type, data), len(data))

    def add(self, entries: Sequence[TimedMessage]) -> None:
        """Queue a chunk of messages."""
        self._hand_over(partial(self._add, entries), sum(len(entry.data) for entry in entries))

    def close(self) -> None:
        """Write the remaining data and the index.

        Raises:
            RecordingError: the data cannot be written; the file keeps the data that was written before.
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
        """Close the file without writing the remaining data and the index. Further calls have no effect."""
        self._thread.shutdown(cancel_futures=True)
        with contextlib.suppress(OSError):  # errors were already reported
            self._file.close()
        self._raw.close()

    def _hand_over(self, job: Callable[[], object], size: int = 0) -> None:
        """Queue a job for the writer thread; wait while more than `MAX_WAITING` bytes are queued.

        Raises:
            RecordingError: an earlier job failed.
        """
        self._waiting.append((self._thread.submit(self._do, job), size))
        self._waiting_bytes += size
        self._settle(MAX_WAITING)

    def _settle(self, bound: int) -> None:
        """Remove finished jobs from the queue, and wait until at most `bound` bytes are queued."""
        while self._waiting and (self._waiting[0][0].done() or self._waiting_bytes > bound):
            job, size = self._waiting.popleft()
            self._waiting_bytes -= size
            try:
                job.result()
            except OSError as error:
                raise self._failure(error) from None

    def _do(self, job: Callable[[], object]) -> None:
        if self._failed:  # data after a gap would be unreadable
            return
        try:
            job()
            self._mcap.flush()  # type: ignore[no-untyped-call]
            if not os.fstat(self._raw.fileno()).st_nlink:
                raise FileNotFoundError(errno.ENOENT, "the file was removed")
        except BaseException:
            self._failed = True
            raise

    def _add(self, entries: Sequence[TimedMessage]) -> None:
        for entry in entries:
            channel = self._channels.get(entry.stream) or self._register(entry.stream)
            self._mcap.add_message(channel, entry.log_time, entry.data, entry.publish_time)

    def _register(self, stream: Stream | PortStream) -> int:
        kind = stream.message_type
        if kind not in self._schemas:
            self._schemas[kind] = self._mcap.register_schema(kind, "ros2msg", self._definitions.text(kind).encode())
        metadata = {**stream.metadata(), "topic_type_hash": self._definitions.type_hash(kind)}
        channel = self._mcap.register_channel(stream.channel, ENCODING, self._schemas[kind], metadata)
        self._channels[stream] = channel
        return channel

    def _failure(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path}: the recording cannot be written: {error.strerror or error}")


def _opened(path: Path, force: bool) -> FileIO:
    """Return a new or emptied file with a lock against other recordings, which ends when the file is closed.

    Symbolic links are refused: in a folder of another user, a link could lead to any file of this user.

    Raises:
        BlockingIOError: another run is writing its recording to the file.
        OSError: the file cannot be written, or exists although `force` is false.
    """
    if path.is_symlink():
        raise OSError(errno.ELOOP, "it is a symbolic link; give the name of its target")
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
    """Open or create a file and return its descriptor; symbolic links are refused, and opening a pipe does not block."""
    return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)


def _lock(file: FileIO) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if isinstance(error, BlockingIOError):  # other errors: some file systems have no locks
            raise
