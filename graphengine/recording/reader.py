"""Reads a recording as ticks, and extracts its files to a folder."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

from mcap.records import Attachment, Channel, Header, McapRecord, Message, Metadata, Schema

from graphengine.format import bounded_json
from graphengine.format.errors import RecordingError
from graphengine.messages import messages
from graphengine.recording import mcap_schema
from graphengine.recording.manifest import Manifest
from graphengine.recording.mcap_schema import Stream, TickTimes
from graphengine.recording.records import read_extent, read_records
from graphengine.recording.sources import Workspace

MAX_MESSAGES = 1_000_000
"""Maximum number of messages in a tick."""
MAX_INPUTS = 64_000_000
"""Maximum size of the external inputs of a tick, bytes."""
MAX_SILENCE = 10_000_000
"""Maximum number of successive ticks without a message.

Without this limit, the replay of a file with one wrong time stamp could take years.
"""
MAX_DIGITS = 18
"""Maximum number of digits in the number of ticks that a file states."""


@dataclass(slots=True)
class Tick:
    """The inputs and outputs of a tick.

    Attributes:
        number: number of the tick, from 1.
        readers: names of the receiving nodes for each message of `delivered`; known before the messages are read.
        delivered: received messages, each with its stream and the names of the receiving nodes. In the file, the received
            messages of a tick precede the sent messages.
        sent: published messages in order.
        commands: name and arguments of the commands executed before the tick.
        wall_time: wall clock time (s since 1970) that nodes read; None if no node read the wall clock.
        whole: whether the tick is complete; False for a failed tick, and for the end of the session after the last tick.
    """

    number: int
    readers: list[tuple[str, ...]] = field(default_factory=list)
    delivered: list[tuple[Stream, tuple[str, ...], bytes]] = field(default_factory=list)
    sent: list[tuple[Stream, bytes]] = field(default_factory=list)
    commands: list[tuple[str, Any]] = field(default_factory=list)
    wall_time: float | None = None
    whole: bool = True


class Recording:
    """Reads a recording once, from beginning to end.

    Args:
        path: path of the recording.
        workspace: folder to which the recorded files are extracted.

    Raises:
        RecordingError: the file is not a recording, or is damaged.
    """

    def __init__(self, path: Path, workspace: Workspace) -> None:
        self.path = path
        self.workspace = workspace
        self.cut_off = True
        """Whether the recording was not closed, because the run was killed; valid after all ticks are read."""
        self.failure = ""
        """Error that ended the run in its last tick; empty without an error. Valid after all ticks are read."""
        self._ended = 0
        self._hashes: dict[str, str] = {}
        self._types: dict[int, str] = {}
        self._streams: dict[int, Stream | None] = {}
        self._first = self._at = self._size = 0
        """`_first`: offset of the first message; `_at`: current offset; `_size`: size of the file, bytes."""
        self._records = read_records(path, self._move)
        manifest: Manifest | None = None
        begun = False
        for record in self._records:
            if isinstance(record, Header):
                begun = record.library.startswith(mcap_schema.LIBRARY)
            elif isinstance(record, Metadata) and record.name == mcap_schema.MANIFEST:
                manifest = self._manifest(record)
            elif isinstance(record, Message):
                self._records = chain((record,), self._records)
                self._first = self._at
                break
            self._take(record)
        else:
            if self.cut_off and (begun or manifest is not None):
                raise self._bad("it was cut off before the first tick")
        if manifest is None:
            raise self._bad("not a recording made by `graphrun run --record`")
        self.manifest = manifest
        self.times = TickTimes(manifest.period)

    def _move(self, at: int, size: int) -> None:
        self._at, self._size = at, size

    @property
    def share_read(self) -> float:
        """Fraction of the recording's message data that has been read, 0 to 1."""
        return (self._at - self._first) / max(self._size - self._first, 1)

    def ticks(self) -> Iterator[Tick]:
        """Yield all ticks of the run in order, including ticks without messages.

        Unless the recording was cut off, a last tick has the end of the run.

        Raises:
            RecordingError: the file is damaged.
        """
        tick = Tick(1)
        for record in self._records:
            self._take(record)
            stream = self._streams.get(record.channel_id) if isinstance(record, Message) else None
            if stream is None or not isinstance(record, Message):
                continue
            number = self.times.tick(record.log_time)
            if number < tick.number:
                raise self._bad("its messages are not in the order of the run")
            if number - tick.number > MAX_SILENCE:
                raise self._bad(f"it has no message for more than {MAX_SILENCE} ticks after tick {tick.number}")
            while tick.number < number:
                yield tick
                tick = Tick(tick.number + 1)
            self._add(tick, stream, record.data)
        last = tick.number if self.cut_off else self._ended
        if last - tick.number > MAX_SILENCE:
            raise self._bad(f"it has no message for more than {MAX_SILENCE} ticks before its end")
        while tick.number <= last:
            yield tick
            tick = Tick(tick.number + 1)
        if not self.cut_off:
            tick.whole = False
            yield tick

    def length(self) -> int:
        """Return the number of ticks, including a failed tick, without reading the ticks.

        Raises:
            RecordingError: the file cannot be read.
        """
        last, end = read_extent(self.path)
        told = end.metadata if end.name == mcap_schema.END else {}
        text = told.get("ticks", "")
        if text.isdecimal() and len(text) <= MAX_DIGITS:
            return int(text) + bool(told.get("failure"))
        return self.times.tick(last)

    def verdicts(self) -> Mapping[int, list[str]]:
        """Return the verdicts on the run by tick number; empty if the file has no verdicts or is damaged there."""
        _, end = read_extent(self.path)
        told = end.metadata.get("verdicts", "") if end.name == mcap_schema.END else ""
        found: dict[int, list[str]] = {}
        with suppress(ValueError, TypeError, RecordingError):
            for tick, text in bounded_json.parse(told) if told else ():
                found.setdefault(int(tick), []).append(str(text))
        return found

    def _take(self, record: McapRecord) -> None:
        """Process a schema, channel, metadata or attachment record; ignore all other records."""
        if isinstance(record, Schema):
            self._types[record.id] = record.name
        elif isinstance(record, Channel):
            kind = self._types.get(record.schema_id, "")
            self._streams[record.id] = Stream.of_channel(record.topic, kind, record.metadata)
        elif isinstance(record, Metadata) and record.name == mcap_schema.FILES:
            self._hashes |= record.metadata
        elif isinstance(record, Attachment):
            self._lay_out(record)
        elif isinstance(record, Metadata) and record.name == mcap_schema.END:
            self.cut_off = False
            self.failure = record.metadata.get("failure", "")
            text = record.metadata.get("ticks", "")
            if not text.isdecimal() or len(text) > MAX_DIGITS:
                raise self._bad(f"its number of ticks is invalid: {text[:20]!r}")
            self._ended = int(text)

    def _lay_out(self, attachment: Attachment) -> None:
        if attachment.name not in self._hashes:  # added by another program
            return
        if hashlib.sha256(attachment.data).hexdigest() != self._hashes[attachment.name]:
            raise self._bad(f"the checksum of its file {attachment.name!r} is wrong")
        self.workspace.add(attachment.name, attachment.data)

    def _add(self, tick: Tick, stream: Stream, data: bytes) -> None:
        if len(tick.sent) + len(tick.delivered) >= MAX_MESSAGES:
            raise self._bad(f"it has more than {MAX_MESSAGES} messages in tick {tick.number}")
        if stream.topic == mcap_schema.SESSION.topic:
            self._add_outside(tick, data)
        elif len(tick.delivered) < len(tick.readers):
            tick.delivered.append((stream, tick.readers[len(tick.delivered)], data))
        else:
            tick.sent.append((stream, data))

    def _add_outside(self, tick: Tick, data: bytes) -> None:
        try:
            outside = bounded_json.parse(messages.decode(data, mcap_schema.SESSION.message_type).data, MAX_INPUTS)
            tick.commands = [(str(name), arguments) for name, arguments in outside.get("commands", [])]
            tick.readers = [tuple(map(str, nodes)) for nodes in outside.get("delivered", [])]
            tick.wall_time = float(outside["wall_time"]) if "wall_time" in outside else None
        except (messages.MessageError, ValueError, TypeError, AttributeError, ArithmeticError) as error:
            raise self._bad(f"the external inputs of tick {tick.number} cannot be read: {error}") from None

    def _manifest(self, record: Metadata) -> Manifest:
        try:
            return Manifest.from_metadata(record.metadata)
        except RecordingError as error:
            raise self._bad(str(error)) from None

    def _bad(self, why: str) -> RecordingError:
        return RecordingError(f"{self.path}: {why}")
