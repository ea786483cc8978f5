"""Replays a recording: delivers the recorded inputs of each tick, and compares the sent messages byte by byte, in order."""

from __future__ import annotations

import fnmatch
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.errors import GraphError, RecordingError, UsageError
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.qos import settled
from graphengine.recording.difference import differences
from graphengine.recording.mcap_schema import Stream, failure_of, node_of
from graphengine.recording.reader import Recording, Tick
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport, MemoryWriter
from graphengine.ros.transports.memory.memory_services import MemoryClient
from graphengine.runtime.commands import COMMANDS, parse
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.session_core import SessionCore

MAX_FIELDS = 8
"""Maximum number of reported fields that differ between a message and the recorded message."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference between a replay and its recording.

    Attributes:
        tick: number of the tick, from 1.
        time: time of the tick, s.
        topic: topic of the message that differs, is missing or is additional; empty if the ends of the runs differ.
        node: prim path of the publishing node; empty if no node publishes the message.
        lines: description of the difference.
        at_end: whether the session sent the message at its end, after the last tick.
    """

    tick: int
    time: float
    topic: str
    node: str
    lines: tuple[str, ...]
    at_end: bool = False

    def __str__(self) -> str:
        when = f"{'at the end, after' if self.at_end else 'in'} tick {self.tick}, t = {self.time:.6f} s"
        return f"different {when}{f': {self.topic}' if self.topic else ''}"


class SilentTransport(MemoryTransport):
    """A transport without peers: nodes receive only recorded messages, and the messages of nodes are discarded.

    Args:
        identity: identity of the recorded session on its network.
        definitions: message types.
    """

    def __init__(self, identity: bytes = b"", definitions: Definitions = DEFINITIONS) -> None:
        super().__init__(definitions=definitions)
        self.identity = identity

    def send(self, writer: MemoryWriter, data: bytes) -> None:
        """Discard the message."""

    def client(self, service: str, service_type: str, qos: QoS, deliver: Callable[[int, bytes], None]) -> SilentClient:
        """Return a service client that receives only recorded responses."""
        return SilentClient(self._services, service, service_type, settled(qos), deliver, self.new_gid())


class SilentClient(MemoryClient):
    """A service client that receives only recorded responses."""

    @property
    def ready(self) -> bool:
        """True: the client needs no server."""
        return True

    def call(self, request: bytes) -> int:
        """Discard the request."""
        return 0


@dataclass(eq=False)
class Replay(ExternalInputs):
    """Replays a recording in a session. Create it before the first tick.

    Args:
        session: session of the recorded scene, or of another scene to compare with the recording.
        network: network of the session, over a `SilentTransport`.
        recording: recording to replay.
        ignored: globs of topics that are not compared.
        warn: receives warnings about recorded inputs that no node reads.
    """

    exact = True
    replays = True

    session: SessionCore
    network: LiveNetwork
    recording: Recording
    ignored: Sequence[str] = ()
    warn: Callable[[str], None] = lambda text: None
    ticks: int = 0
    """Number of ticks without a difference."""
    messages: int = 0
    """Number of messages without a difference."""
    idle_patterns: set[str] = field(init=False)
    """Patterns of `ignored` that match no topic."""
    _unread: set[str] = field(default_factory=set)
    _wall_time: float = 0.0
    _sent: list[tuple[EndpointClaim, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.idle_patterns = set(self.ignored)
        self.session.inbox = self
        if (dropped := self.session.services.dropped) is not None:
            dropped.drops_set_values = self.recording.manifest.drops_set_values
        self.network.sinks.append(self)

    def begin_tick(self) -> float:
        """Return the wall clock time (s since 1970) of the recorded run."""
        return self._wall_time

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Do nothing: received messages come from the recording, and need no comparison."""

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Store a sent message for the comparison with the recording."""
        self._sent.append((claim, data))

    def run(self) -> Difference | None:
        """Replay all ticks up to the first difference; return this difference, or None if the runs are equal.

        Raises:
            RecordingError: the recording is damaged.
        """
        for tick in self.recording.ticks():
            found = self.compare(tick, self.repeat(tick))
            if found is not None:
                return found
        return None

    def repeat(self, tick: Tick) -> GraphError | None:
        """Deliver the inputs of a tick, then run the tick or the end of the session; return an error that ended the run, or None.

        Raises:
            GraphError: a command of the tick cannot be carried out.
        """
        self._sent.clear()  # before commands: a stop may send messages
        for name, arguments in tick.commands:
            if name == "reload":
                self.recording.workspace.exchange(_exchanged(arguments))
                arguments = {}
            _command(self.session, name, arguments)
        if tick.wall_time is not None:
            self._wall_time = tick.wall_time
        for stream, nodes, data in tick.delivered:
            self._bring(stream, nodes, data)
        try:
            if tick.whole or self.recording.failure:
                self.session.step()
            else:
                self.session.end()
        except GraphError as error:
            return error
        return None

    def compare(self, tick: Tick, error: GraphError | None) -> Difference | None:
        """Compare the last executed tick with the recorded tick; return the first difference, or None if the ticks are equal.

        Args:
            tick: the recorded tick.
            error: result of `repeat`.
        """
        failed = not tick.whole and bool(self.recording.failure)
        found = self._compare_failures(tick, error) if failed or error is not None else self._compare_sent(tick)
        if found is None:
            self.ticks += tick.whole
        return found

    def _bring(self, stream: Stream, nodes: Sequence[str], data: bytes) -> None:
        """Deliver a message to its recorded receivers; if none of them subscribes now, to all subscribers of the topic."""
        reading = [one for one in self.network.hearing if _takes(one.claim, stream)]
        meant = [end for end in reading if end.claim.node in nodes] or reading
        for end in meant:
            end.follow({stream.message_type})
            end.deliver(data)
        if not meant and stream.topic not in self._unread:
            self._unread.add(stream.topic)
            self.warn(f"messages of {stream.topic} ({stream.message_type}) were recorded, but no node reads them")

    def _counts(self, topic: str) -> bool:
        patterns = [pattern for pattern in self.ignored if fnmatch.fnmatchcase(topic, pattern)]
        self.idle_patterns.difference_update(patterns)
        return not patterns

    def _compare_sent(self, tick: Tick) -> Difference | None:
        recorded = [(stream, data) for stream, data in tick.sent if self._counts(stream.topic)]
        replayed = [(claim, data) for claim, data in self._sent if self._counts(claim.topic)]
        for index, ((stream, before), (claim, now)) in enumerate(zip(recorded, replayed, strict=False)):
            if stream.topic != claim.topic:
                return self._astray(tick, recorded[index:], replayed[index:])
            if stream.message_type != claim.message_type:
                lines = (f"recorded as {stream.message_type}, replayed as {claim.message_type}",)
                return self._difference(tick, claim.topic, claim.node, lines)
            if before != now:
                return self._difference(tick, claim.topic, claim.node, self._fields(before, now, claim.message_type))
        if len(recorded) != len(replayed):
            common = min(len(recorded), len(replayed))
            return self._astray(tick, recorded[common:], replayed[common:])
        self.messages += len(replayed)
        return None

    def _fields(self, before: bytes, now: bytes, message_type: str) -> list[str]:
        found = [str(field) for field in differences(before, now, message_type, self.network.definitions)]
        more = len(found) - MAX_FIELDS
        return [*found[:MAX_FIELDS], f"and {more} more fields"] if more > 0 else found

    def _astray(
        self, tick: Tick, recorded: Sequence[tuple[Stream, bytes]], replayed: Sequence[tuple[EndpointClaim, bytes]]
    ) -> Difference:
        """Return the difference of two sequences with different first topics: a missing or additional message, or the order."""
        before = Counter(stream.topic for stream, _ in recorded)
        now = Counter(claim.topic for claim, _ in replayed)
        if replayed and now[replayed[0][0].topic] > before[replayed[0][0].topic]:
            claim = replayed[0][0]
            return self._difference(tick, claim.topic, claim.node, ("the recording has no such message",))
        topic = recorded[0][0].topic
        if before[topic] > now[topic]:
            claims = [*self.session.services.claims, *(end.claim for end in self.network.hearing)]
            nodes = [claim.node for claim in claims if claim.topic == topic and claim.direction != "subscribe"]
            what = "the replay sends no such message" + ("" if nodes else ", and no node publishes it")
            return self._difference(tick, topic, ", ".join(nodes), (what,))
        claim = replayed[0][0]
        lines = (f"the order differs: the recording has a message of {topic} at this place",)
        return self._difference(tick, claim.topic, claim.node, lines)

    def _compare_failures(self, tick: Tick, error: GraphError | None) -> Difference | None:
        recorded = "" if tick.whole else self.recording.failure
        if error is not None and self._alike(failure_of(error), recorded):
            return None
        lines = (f"recorded: {recorded or 'the run goes on'}", f"replayed: {error or 'the run goes on'}")
        return self._difference(tick, "", "", lines)

    def _alike(self, replayed: str, recorded: str) -> bool:
        """Return whether two failures are equal; for a recording without `bad_values`, whether they name the same node."""
        if "bad_values" in self.recording.manifest.model_fields_set:
            return replayed == recorded
        return node_of(replayed) == node_of(recorded)

    def _difference(self, tick: Tick, topic: str, node: str, lines: Sequence[str]) -> Difference:
        at_end = not tick.whole and not self.recording.failure
        number = tick.number - at_end
        return Difference(number, self.recording.times.seconds(number), topic, node, tuple(lines), at_end)


def _takes(claim: EndpointClaim, stream: Stream) -> bool:
    return claim.topic == stream.topic and stream.message_type in (claim.message_type, *claim.alternatives)


def _exchanged(arguments: Any) -> Mapping[str, str | None]:
    """Return the files that a recorded reload replaced, as a dict from old to new names; None stands for a deleted file.

    Raises:
        RecordingError: the arguments are invalid.
    """
    files = arguments.get("files") if isinstance(arguments, dict) else None
    if not isinstance(files, dict) or not all(isinstance(other, str | None) for other in files.values()):
        raise RecordingError("a recorded reload has no valid list of files")
    return files


def _command(session: SessionCore, name: str, arguments: Any) -> None:
    """Execute a recorded command.

    Raises:
        RecordingError: the command is unknown or its arguments are invalid.
    """
    if name not in COMMANDS or not COMMANDS[name].recorded:
        raise RecordingError(f"the recording has an unknown command {name[:40]!r}")
    try:
        command = parse(name, arguments)
    except UsageError as error:
        raise RecordingError(f"the recorded command {name!r} is invalid: {error}") from None
    command.apply(session)
