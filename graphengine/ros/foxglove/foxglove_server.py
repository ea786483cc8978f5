"""A WebSocket server that sends the topics of a run to Foxglove clients, and can receive messages that clients publish.

The SDK sends messages and calls the methods `on_…` in threads that the SDK starts. The SDK keeps no messages for late
subscribers; so this module keeps the messages of latched topics.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from foxglove import Context, Schema, StatusLevel, _foxglove_py, start_server
from foxglove.websocket import ChannelView, Client, ServerListener

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.message_input import full_type
from graphengine.messages.qos import settled
from graphengine.ros.foxglove.publish_gate import PublishGate
from graphengine.ros.network_graph import Endpoint
from graphengine.ros.transport import Deliver

Address = tuple[str, int]
"""Host and port to listen on; port 0 selects a free port."""

ENCODING = "cdr"
BACKLOG = 256
"""Maximum number of messages queued for a client; a slow client misses the oldest messages."""
CLOSING = 1.0
"""Maximum wait for clients at `close`, s; without this limit, the SDK waits forever for a client that does not read."""
MAX_KEPT = 1000
"""Maximum number of latched messages kept for an endpoint with the history keepAll."""
MAX_NAMES = 1000
"""Maximum total length of topic name and message type in a client's advertisement, characters."""
MAX_PUBLISHED = 1000
"""Maximum number of topics that all clients together may advertise."""


class ServedEnd:
    """A writer or reader of the run whose messages Foxglove clients can receive.

    Args:
        topic: full name.
        message_type: as in `nav_msgs/msg/Odometry`.
        qos: profile of the endpoint; a latched endpoint keeps as many messages for late subscribers as the profile's depth.
    """

    def __init__(self, topic: str, message_type: str, qos: QoS) -> None:
        self.key = (topic, message_type)
        self.qos = settled(qos)
        depth = self.qos.depth if self.qos.history == "keepLast" else MAX_KEPT
        self.kept: deque[bytes] = deque(maxlen=depth if self.qos.durability == "transientLocal" else 0)
        self.served: ServedTopic | None = None
        """The server's topic to which `FoxgloveServer.enter` added this endpoint; None before `enter` and after `leave`."""

    @property
    def wanted(self) -> bool:
        """Whether a client subscribes to the topic."""
        return self.served is not None and self.served.channel.has_sinks()

    def show(self, data: bytes) -> None:
        """Send a message to all subscribed clients; never blocks."""
        if (served := self.served) is not None:
            served.show(self, data)


class ServedReader(ServedEnd):
    """A reader of the run that also receives messages from clients.

    Args:
        topic: full name.
        message_type: as in `nav_msgs/msg/Odometry`.
        qos: profile of the reader.
        deliver: called with each message, by one thread at a time.
    """

    def __init__(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> None:
        super().__init__(topic, message_type, qos)
        self.malformed = 0
        """Number of clients' messages that were dropped because decoding failed."""
        self._deliver = deliver
        self._delivering = threading.RLock()

    def hear(self, data: bytes) -> None:
        """Deliver a message from the network or a client, unless the reader was closed."""
        with self._delivering:
            if self.served is not None:
                self._deliver(data)
                self.show(data)

    def wait(self) -> None:
        """Wait until no other thread is delivering a message."""
        with self._delivering:
            pass


def open_channel(context: Context, name: str, message_type: str, definitions: Definitions) -> Any:
    """Return a new channel of a server for messages in CDR."""
    schema = Schema(name=message_type, encoding="ros2msg", data=definitions.text(message_type).encode())
    # foxglove.Channel would do the same, and keep every channel until the process ends.
    return context._create_channel(name, message_encoding=ENCODING, schema=schema)


class ServedTopic:
    """A topic name with a message type. Clients see one channel for both, as long as the run has an endpoint on the topic."""

    def __init__(self, context: Context, key: tuple[str, str], definitions: Definitions) -> None:
        topic, message_type = key
        self.channel = open_channel(context, topic, message_type, definitions)
        self.writers: list[ServedEnd] = []
        self.readers: list[ServedReader] = []
        self._lock = threading.Lock()

    def alike(self, end: ServedEnd) -> list[Any]:
        """Return the list for endpoints of this kind: `readers` or `writers`."""
        return self.readers if isinstance(end, ServedReader) else self.writers

    def show(self, end: ServedEnd, data: bytes) -> None:
        """Send an endpoint's message to clients, unless clients receive the same message from another endpoint."""
        if not self._is_shown(end):
            return
        if end.kept.maxlen:
            with self._lock:
                end.kept.append(data)
        if self.channel.has_sinks():
            self.channel.log(data)

    def repeat(self) -> None:
        """Send all latched messages to all clients of the topic; the SDK cannot send them only to a new subscriber."""
        with self._lock:
            for end in (*self.writers, *self.readers):
                for data in end.kept if self._is_shown(end) else ():
                    self.channel.log(data)

    def _is_shown(self, end: ServedEnd) -> bool:
        """Return whether clients receive an endpoint's messages: True for writers, and without writers for the first reader."""
        return not isinstance(end, ServedReader) or (not self.writers and self.readers[:1] == [end])


class FoxgloveServer(ServerListener):
    """A Foxglove server that runs until `close`.

    Args:
        address: host and port to listen on.
        name: name of the run, for display in clients.
        definitions: message types.
        publish: whether clients with the token, which `url` then contains, may publish.

    Raises:
        TransportError: the address cannot be used.
    """

    def __init__(self, address: Address, name: str, definitions: Definitions, *, publish: bool = False) -> None:
        self._definitions = definitions
        self._closed = False
        self._lock = threading.RLock()
        self._topics: dict[tuple[str, str], ServedTopic] = {}
        """Served topics by name and type."""
        self._published: dict[tuple[int, int], Endpoint] = {}
        """Publisher for each client id and id of a channel of this client."""
        self._context = Context()
        self._gate: PublishGate | None = None
        host, port = address
        try:
            with self._lock:
                self._server = start_server(
                    name=name,
                    host="127.0.0.1" if publish else host,
                    port=0 if publish else port,
                    server_listener=self,
                    supported_encodings=[ENCODING],
                    context=self._context,
                    message_backlog_size=BACKLOG,
                )
        except RuntimeError as error:
            why = str(error).rpartition("bind port: ")[2]
            raise TransportError(f"Foxglove cannot be served at {_shown(host)}:{port}: {why}") from None
        # Logging could deadlock: a thread of the SDK that logs would hold a lock of the SDK and wait for Python's GIL, while
        # `close` of a channel holds the GIL and waits for the same lock.
        _foxglove_py.disable_logging()
        self.url = f"ws://{_shown(host)}:{self._server.port}"
        if publish:
            try:
                self._gate = PublishGate(host, port, f"ws://127.0.0.1:{self._server.port}", self)
            except OSError as error:
                self.close()
                text = f"Foxglove cannot be served at {_shown(host)}:{port}: {error.strerror or error}"
                raise TransportError(text) from None
            self.url = f"ws://{_shown(host)}:{self._gate.port}/?token={self._gate.token}"

    def enter(self, end: ServedEnd) -> None:
        """Start to send the messages of an endpoint to clients; the first endpoint of a topic creates the topic's channel.

        Raises:
            MessageTypeError: the type is unknown.
        """
        with self._lock:
            if end.key not in self._topics:
                self._topics[end.key] = ServedTopic(self._context, end.key, self._definitions)
            end.served = self._topics[end.key]
            end.served.alike(end).append(end)

    def channel(self, name: str, message_type: str) -> Any:
        """Return a new channel that is not a topic of the run; the caller closes it."""
        return open_channel(self._context, name, message_type, self._definitions)

    def leave(self, end: ServedEnd) -> None:
        """Stop sending an endpoint's messages, and close the channel after the topic's last endpoint. Safe to call twice."""
        with self._lock:
            served, end.served = end.served, None
            if served is None:
                return
            served.alike(end).remove(end)
            if not served.readers and not served.writers:
                del self._topics[end.key]
                served.channel.close()

    def endpoints(self) -> list[Endpoint]:
        """Return the clients' publishers on topics that the run reads, each with the QoS of the topic's first reader."""
        with self._lock:
            read = self._read()
            return [replace(end, qos=read[end.topic]) for end in self._published.values() if end.topic in read]

    def _read(self) -> dict[str, QoS]:
        """Return the topics that the run reads, each with the QoS of its first reader."""
        return {topic: served.readers[0].qos for (topic, _), served in self._topics.items() if served.readers}

    def close(self) -> None:
        """Stop the server; safe to call twice."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        stopping = threading.Thread(target=self._server.stop, name="foxglove", daemon=True)
        stopping.start()
        if self._gate is not None:
            self._gate.close()
        stopping.join(CLOSING)

    # Called by the SDK

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Send the latched messages of the channel to which a client has subscribed."""
        with self._lock:
            for served in self._topics.values():
                if served.channel.id() == channel.id:
                    served.repeat()

    # Called by the gate

    def announce(self, client: int, told: Mapping[str, Any]) -> bool:
        """Add or remove publishers of a client; return False if the client's message does neither."""
        match told:
            case {"op": "advertise", "channels": [*channels]}:
                for channel in channels:
                    self._advertise(client, channel)
            case {"op": "unadvertise", "channelIds": [*ids]}:
                gone = {(client, number) for number in ids if isinstance(number, int)}
                with self._lock:
                    self._published = {key: end for key, end in self._published.items() if key not in gone}
            case _:
                return False
        return True

    def _advertise(self, client: int, channel: object) -> None:
        """Accept a client's publisher; warn if no graph of the run reads the topic."""
        match channel:
            case {"id": int(number), "topic": str(topic), "encoding": encoding, "schemaName": str(schema)} if (
                0 <= number < 2**32 and len(topic + schema) <= MAX_NAMES and (topic + schema).isprintable()
            ):
                gid = b"foxglove" + (client % 2**32).to_bytes(4, "big") + number.to_bytes(4, "big")
                published = Endpoint(gid, "publish", topic, full_type(schema), QoS(), node="foxglove", namespace="/")
            case _:
                self._warn("a channel needs an id, a topic, an encoding and a schema name, in printable characters")
                return
        with self._lock:
            if encoding != ENCODING:
                self._warn(f"{topic}: messages in {encoding} are not accepted, only in {ENCODING}")
            elif len(self._published) >= MAX_PUBLISHED:
                self._warn(f"{topic}: clients publish more than {MAX_PUBLISHED} topics")
            else:
                self._published[client, number] = published
                if topic not in self._read():
                    self._warn(f"{topic}: no graph of the run reads it")

    def forget(self, client: int) -> None:
        """Remove all publishers of a client that has disconnected."""
        with self._lock:
            self._published = {key: end for key, end in self._published.items() if key[0] != client}

    def receive(self, client: int, channel: int, data: bytes) -> None:
        """Deliver a client's message to the readers of the topic and type; drop and count a message that cannot be decoded."""
        with self._lock:
            published = self._published.get((client, channel))
            served = self._topics.get((published.topic, published.message_type)) if published else None
            readers = tuple(served.readers) if served else ()
        if published and readers:
            try:
                messages.decode(data, published.message_type, self._definitions)
            except TransportError:
                for reader in readers:
                    reader.malformed += 1
                return
            for reader in readers:
                reader.hear(data)

    def _warn(self, text: str) -> None:
        """Show a warning in all clients; the SDK cannot address a single client."""
        self._server.publish_status(text, StatusLevel.Warning)


def _shown(host: str) -> str:
    """Return a host as URLs write it: an IPv6 address in brackets."""
    return f"[{host}]" if ":" in host else host
