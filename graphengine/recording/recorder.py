"""Records the inputs and outputs of a session."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections import defaultdict, deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from graphengine.format.errors import GraphError, RecordingError, UsageError
from graphengine.format.files import Files
from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.recording import mcap_schema
from graphengine.recording.manifest import describe_run
from graphengine.recording.mcap_schema import PortStream, Stream, TickTimes
from graphengine.recording.seen_messages import SeenMessages
from graphengine.recording.sources import RELOADED, SourceNames, media_type, read_again, sources
from graphengine.recording.writer import RecordingWriter, TimedMessage
from graphengine.ros.network import LiveNetwork
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.port_values import PortValues, WatchedPort
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.loaded_scene import LoadedScene

CHUNK_BYTES = 4_000_000
CHUNK_SECONDS = 1.0
"""Maximum simulation time in a chunk, s; a crash loses at most the last chunk."""


class Recorder(ExternalInputs):
    """Records a session. Create the recorder before the first tick, and close it before the session.

    Args:
        session: session to record.
        network: network of the session.
        scene: scene of the session.
        path: path of the new recording.
        force: whether to overwrite an existing file.
        keep_going: whether the session continues when a node raises an exception.
        modules: additional Python modules with node types.
        ports: ports whose values are recorded; None for no ports.

    Raises:
        RecordingError: the file cannot be written.
        UsageError: the session has already run ticks.
    """

    exact = True

    def __init__(
        self,
        session: SessionCore,
        network: LiveNetwork,
        scene: LoadedScene,
        path: Path,
        *,
        force: bool = False,
        keep_going: bool = False,
        modules: Sequence[str] = (),
        ports: PortValues | None = None,
    ) -> None:
        if session.ticks:
            raise UsageError("start the recording before the first tick of the session")
        self._session = session
        self._times = TickTimes(session.services.world.tick_period)
        self._files = session.services.permissions.files or scene.files
        self._names = SourceNames(self._files)
        self._scene = scene.world.scenery.scene.document.path.absolute() if scene.world is not None else None
        self._definitions = scene.definitions
        self.verdicts: list[tuple[int, str]] = []
        """Tick number and text of each verdict on the run; verdicts are not output of the run."""
        self._tick = self._ended = 0
        self._wall_time = 0.0
        self._commands: list[tuple[str, Any]] = []
        self._arrived: list[tuple[EndpointClaim, Sequence[bytes]]] = []
        self._sent: list[tuple[EndpointClaim, int, bytes]] = []
        self._streams: dict[object, Stream] = {}
        self._ports = ports
        self._port_streams: dict[WatchedPort, PortStream] = {}
        self._network = network
        self._sightings: defaultdict[object, SeenMessages] = defaultdict(SeenMessages)
        self._entries: list[TimedMessage] = []
        self._bytes = 0
        self._chunk_ticks = max(round(CHUNK_SECONDS / session.clock.delta), 1)
        self._digests: dict[str, str] = {}
        """Digest of the last attached version of each file, by the file's name."""
        self._read: dict[str, bytes] = {}
        """Content of each file that the current reload has read, by the file's name."""
        self._places: dict[str, Path] = {}
        """Path of each attached file, by the file's name."""
        self._reloads = 0
        self._exchanged: dict[str, str | None] = {}
        """Name of the attachment with the newest version of each reloaded file; None for a deleted file."""
        self._writer = RecordingWriter(path, scene.definitions, force=force)
        try:
            manifest = describe_run(scene, session, self._names, keep_going, modules)
            self._writer.note(mcap_schema.MANIFEST, manifest.metadata())
            self._attach()
        except BaseException:
            self._writer.abandon()
            raise
        session.inbox = self
        network.sinks.append(self)

    @property
    def recorded_bytes(self) -> int:
        """Size of the file without buffered data, bytes."""
        return self._writer.size

    def mark(self, text: str) -> None:
        """Add a verdict on the run at the current tick; the web page shows the verdict as a mark."""
        self.verdicts.append((max(self._tick, 1), text))

    def begin_tick(self) -> float:
        """Return the wall clock time (s since 1970) that nodes read in the tick."""
        self._tick += 1
        self._wall_time = super().begin_tick()
        return self._wall_time

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Record the messages that a subscription receives in this tick."""
        self._arrived.append((claim, arrived))

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Record a message that a node sent in the current tick."""
        self._sent.append((claim, self._session.clock.frame, data))

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Record a command that the session has executed since the last tick.

        Raises:
            RecordingError: a file that the command read cannot be read again.
        """
        if name == "reload":
            if not self._attach_exchanged() and not arguments["effective"]:
                return
            arguments = {"files": dict(self._exchanged)}
        if name == "spawn":
            arguments = {**arguments, "use": {**arguments["use"], "use": self._reference(arguments["use"]["use"])}}
        self._commands.append((name, arguments))
        self._attach()

    def reading(self, files: Files) -> None:
        """Store the content of each file that a reload has read.

        If a file no longer exists, nothing is stored, because the reload will read the files again.
        """
        places = {self._names.name(path): path for path in files.used}
        with contextlib.suppress(OSError):
            self._read = {name: files.content(path) for name, path in places.items()}
            self._places |= places

    def _attach_exchanged(self) -> bool:
        """Attach the reloaded files that differ from their attached versions; return whether any file was changed or deleted."""
        self._reloads += 1
        digests = {name: _digest(data) for name, data in self._read.items()}
        changed = {name: data for name, data in self._read.items() if self._digests.get(name) != digests[name]}
        unread = [name for name in self._digests if name not in digests]
        gone = [name for name in unread if name in self._places and not self._places[name].exists()]
        places = {name: f"{RELOADED}/{self._reloads}/{name}" for name in changed}
        self._write_attachments({places[name]: data for name, data in changed.items()})
        self._exchanged |= {**places, **dict.fromkeys(gone)}
        self._digests |= digests
        for name in gone:
            del self._digests[name]
        self._read = {}
        return bool(changed or gone)

    def _reference(self, use: str) -> str:
        """Return the path of a robot file relative to the scene file, as in every folder with the extracted recording."""
        if not os.path.isabs(use):
            return use
        assert self._scene is not None  # a robot requires a scene
        return os.path.relpath(self._names.name(Path(use)), os.path.dirname(self._names.name(self._scene)))

    def end_tick(self) -> None:
        """Add the inputs and outputs of the tick to the file.

        Raises:
            RecordingError: earlier data could not be written.
        """
        self._take_down()
        self._ended = self._tick
        if self._bytes >= CHUNK_BYTES or self._tick % self._chunk_ticks == 0:
            self._write_chunk()

    def close(self, error: BaseException | None = None) -> None:
        """End the session, and write the remaining data, including the inputs of an unfinished tick.

        Args:
            error: exception that ended the run. After a RecordingError, nothing more is written.

        Raises:
            RecordingError: the data cannot be written.
        """
        try:
            if not isinstance(error, RecordingError):
                self._finish(mcap_schema.failure_of(error) if isinstance(error, GraphError) else "")
        finally:
            self._writer.abandon()

    def _finish(self, failure: str) -> None:
        if failure or self._tick > self._ended:
            self._sent.clear()
        else:
            self._session.end()
        if self._commands or self._arrived or self._sent:
            self._tick = self._ended + 1
            self._take_down()
        self._write_chunk()
        end = {"ticks": str(self._ended), "failure": failure}
        if self.verdicts:
            end["verdicts"] = json.dumps(self.verdicts)
        dropped = self._session.services.dropped
        if dropped is not None and dropped.ticks:
            end["dropped_values"] = json.dumps(dropped.ticks)
        self._writer.note(mcap_schema.END, end)
        self._writer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _: object, error: BaseException | None, *__: object) -> None:
        self.close(error)

    def _take_down(self) -> None:
        now = self._times.nanoseconds(self._tick)

        def add(stream: Stream | PortStream, published: int, data: bytes) -> None:
            self._entries.append(TimedMessage(stream, now, published, data))
            self._bytes += len(data)

        delivered = merged(self._arrived)
        outside = self._outside(delivered)
        if outside:
            add(mcap_schema.SESSION, now, messages.encode(messages.String(json.dumps(outside))))
        for claims, data in delivered:
            known = self._sightings[self._topic(claims[0])].see([claim.node for claim in claims], data)
            add(self._stream(claims[0], known), now, data)
        read = {subscription.topic for subscription in self._network.subscriptions}
        for claim, frame, data in self._sent:
            if claim.topic in read or claim.qos.durability == "transientLocal":  # a subscriber may join later
                self._sightings[self._topic(claim)].add(data)
            add(self._stream(claim), self._times.nanoseconds(frame), data)
        self._arrived.clear()
        self._sent.clear()
        for port, data in self._ports.changes() if self._ports is not None and self._tick > self._ended else ():
            add(self._port_stream(port), now, data)

    def _port_stream(self, port: WatchedPort) -> PortStream:
        if port not in self._port_streams:
            self._port_streams[port] = PortStream(port.channel, port.message_type, port.unit, port.doc)
        return self._port_streams[port]

    def _outside(self, delivered: Sequence[tuple[Sequence[EndpointClaim], bytes]]) -> dict[str, Any]:
        """Return the external inputs of the tick; the wall clock time is an input only if a node has read it."""
        outside: dict[str, Any] = {}
        if self._commands:
            outside["commands"] = list(self._commands)
            self._commands.clear()
        if delivered:
            outside["delivered"] = [[claim.node for claim in claims] for claims, _ in delivered]
        if any(clock.wall_time_was_read for clock in (self._session.clock, self._session.step_clock)):
            outside["wall_time"] = self._wall_time
        return outside

    def _stream(self, claim: EndpointClaim, known: bool = False) -> Stream:
        key = (self._topic(claim), known)
        if key not in self._streams:
            self._streams[key] = Stream(claim.topic, claim.message_type, self._offered(claim), known)
        return self._streams[key]

    def _offered(self, claim: EndpointClaim) -> QoS:
        """Return the QoS profile for a topic's channel: the profile of the run's publisher, else of `claim`."""
        publishing = (one for one in self._session.services.claims if one.direction == "publish")
        return next((one.qos for one in publishing if self._topic(one) == self._topic(claim)), claim.qos)

    def _topic(self, claim: EndpointClaim) -> object:
        """Return name, message type and transport of a topic, which identify it; each ROS domain has another transport."""
        return claim.topic, claim.message_type, self._network.transport(claim.ros_context)

    def _write_chunk(self) -> None:
        if self._entries:
            self._writer.add(self._entries)
            self._entries, self._bytes = [], 0

    def _attach(self) -> None:
        """Attach the files that were read since the last call."""
        used = sources(self._files, self._definitions, self._names)
        fresh = {name: path for name, path in used.items() if name not in self._digests}
        if fresh:
            contents = read_again(self._files, fresh)
            self._places |= fresh
            self._digests |= {name: _digest(data) for name, data in contents.items()}
            self._write_attachments(contents)

    def _write_attachments(self, contents: Mapping[str, bytes]) -> None:
        if contents:
            self._writer.note(mcap_schema.FILES, {name: _digest(data) for name, data in contents.items()})
        for name, data in contents.items():
            self._writer.attach(name, media_type(name), data)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def merged(arrived: Sequence[tuple[EndpointClaim, Sequence[bytes]]]) -> list[tuple[list[EndpointClaim], bytes]]:
    """Return the received messages in order, each once with all its subscriptions."""
    queues = [(claim, deque(messages)) for claim, messages in arrived]
    found: list[tuple[list[EndpointClaim], bytes]] = []
    while queues:
        first, head = queues[0][0], queues[0][1][0]
        takers = [(claim, queue) for claim, queue in queues if _alike(claim, first) and queue[0] == head]
        found.append(([claim for claim, _ in takers], head))
        for _, queue in takers:
            queue.popleft()
        queues = [(claim, queue) for claim, queue in queues if queue]
    return found


def _alike(one: EndpointClaim, other: EndpointClaim) -> bool:
    return (one.topic, one.message_type, one.ros_context) == (other.topic, other.message_type, other.ros_context)
