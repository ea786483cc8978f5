"""Reads bags: MCAP and SQLite files that graphengine, `ros2 bag record` or rosbags wrote.

Bags may be damaged or hostile. In a folder, all bag files are read and `metadata.yaml` is ignored. Message definitions come from
the bag; if it has none, from ROS 2.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack, contextmanager
from heapq import merge
from itertools import accumulate, chain
from operator import itemgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lz4.frame import LZ4FrameDecompressor
from mcap.records import Header
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader, storage_mcap
from rosbags.rosbag2.storage_mcap import zstd  # type: ignore[attr-defined]  # its module depends on the version of Python

from graphengine.format.errors import GraphError, RecordingError, UsageError
from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages.definitions import Definitions, shipped
from graphengine.messages.distros import DISTROS
from graphengine.messages.interfaces import MessageTypeError, TypeName
from graphengine.recording import mcap_schema
from graphengine.recording.records import MAX_CHUNK_BYTES, read_records

SUFFIXES = (".mcap", ".db3")
MAX_MESSAGE_BYTES = 100_000_000
"""Maximum uncompressed size of an individually compressed message, bytes."""
_SECTION = re.compile(r"^=+\n(?:MSG|IDL): (\S+)\n", re.MULTILINE)
_ZSTD = b"\x28\xb5\x2f\xfd"


class BagFile:
    """An open bag.

    Args:
        path: an MCAP or SQLite file, or a folder of `ros2 bag record` with such files.

    Raises:
        RecordingError: the bag cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stack = ExitStack()
        if not path.exists():
            raise RecordingError(f"{path}: no such file or folder")
        with self._reading():
            files = sorted(path.iterdir()) if path.is_dir() else [path]
            files = [file for file in files if file.suffix in SUFFIXES and file.is_file()]
            if not files:
                what = "expected an .mcap or .db3 file, or a folder with such files; decompress .zstd files first"
                raise RecordingError(f"{path}: {what}")
            self._readers = [self._stack.enter_context(Reader(file)) for file in files]
            for reader in self._readers:
                _check_chunks(getattr(reader.storage, "chunks", ()))
            first = next(read_records(files[0]), None) if files[0].suffix == ".mcap" else None
            self.begin = int(min(reader.start_time for reader in self._readers))
            """Log time of the first message, ns."""
            self.end = int(max(reader.end_time for reader in self._readers)) - 1
            """Log time of the last message, ns."""
        self.is_run = isinstance(first, Header) and first.library.startswith(mcap_schema.LIBRARY)
        """Whether the bag is a recording of graphengine, whose log times are simulation times."""
        self.connections = list(chain.from_iterable(reader.connections for reader in self._readers))

    def close(self) -> None:
        """Close the files."""
        self._stack.close()

    def message_type(self, topic: str) -> tuple[str, Definitions]:
        """Return the message type of a topic, and message definitions that include it.

        Raises:
            UsageError: the bag does not have the topic, or neither the bag nor ROS 2 defines its type.
        """
        found = next((one for one in self.connections if one.topic == topic), None)
        if found is None:
            names = sorted({str(one.topic) for one in self.connections})
            near = did_you_mean(topic, names) or listing(names, "topics")
            raise UsageError(f"the bag has no topic {shown(topic)}\n  {near}")
        with self._reading():
            return found.msgtype, _definitions(topic, found)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[int, str, bytes]]:
        """Yield log time (ns), topic and data of each message of the topics, in order of log time; None means all topics.

        Raises:
            RecordingError: the bag is damaged.
        """
        streams = []
        for reader in self._readers:
            wanted = [one for one in reader.connections if topics is None or one.topic in topics]
            streams += [reader.messages(wanted)] if wanted else []
        with self._reading():
            for connection, time, data in merge(*streams, key=itemgetter(1)):
                if data.startswith(_ZSTD):
                    data = zstd.ZstdDecompressor().decompress(data, MAX_MESSAGE_BYTES)
                yield int(time), connection.topic, data

    @contextmanager
    def _reading(self) -> Iterator[None]:
        try:
            yield
        except (GeneratorExit, GraphError):
            raise
        except Exception as error:  # damaged files fail in many ways inside rosbags
            self.close()
            raise RecordingError(f"{self.path}: cannot be read as a bag: {error or type(error).__name__}") from error


def _check_chunks(chunks: Collection[Any]) -> None:
    """Raise ValueError if chunks that overlap in time are too large together: the reader holds all of them in memory."""
    edges = [(chunk.message_start_time, chunk.uncompressed_size) for chunk in chunks]
    edges += [(chunk.message_end_time, -chunk.uncompressed_size) for chunk in chunks]
    if max(accumulate(size for _, size in sorted(edges)), default=0) > MAX_CHUNK_BYTES:
        raise ValueError(f"chunks of more than {MAX_CHUNK_BYTES} bytes overlap in time")


def _definitions(topic: str, connection: Connection) -> Definitions:
    """Return the definitions in the bag, extended by the first ROS 2 distribution that makes the connection's type complete."""
    given = connection.msgdef.data
    whole, *sections = _SECTION.split(given)
    kind, errors = connection.msgdef.format.name.lower(), []
    with TemporaryDirectory(prefix="graphengine-") as folder:
        for name, text in [(connection.msgtype, whole), *zip(sections[::2], sections[1::2], strict=True)]:
            parsed = TypeName.parse(name if name.count("/") == 2 else name.replace("/", "/msg/"))
            if text.strip() and parsed is not None:
                file = Path(folder, parsed.package, parsed.kind, f"{parsed.name}.{kind}")
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
        for distro in DISTROS:
            definitions = shipped(distro).extended(installed=[Path(folder)])
            try:
                definitions.definition(connection.msgtype)
            except MessageTypeError as error:
                errors.append(error.message.replace(f"{folder}/", ""))
            else:
                return definitions
    if not given:
        errors[0] = (
            f"neither the bag nor ROS 2 defines its type {connection.msgtype}; `ros2 bag convert` to MCAP adds it"
        )
    raise UsageError(f"topic {topic}: {errors[0]}")


def _bounded(decompressor: Callable[[], Any]) -> Callable[[bytes, int], bytes]:
    """Return a function that decompresses a chunk, and stops after its declared size."""

    def decompress(data: bytes, size: int) -> bytes:
        if size > MAX_CHUNK_BYTES:
            raise ValueError(f"a chunk of {size} bytes is too large")
        found: bytes = decompressor().decompress(data, max_length=size + 1)
        return found

    return decompress


# The decompressors of rosbags decompress a whole chunk before they compare its size with the declared size.
storage_mcap.DECOMPRESSORS.update(lz4=_bounded(LZ4FrameDecompressor), zstd=_bounded(zstd.ZstdDecompressor))
