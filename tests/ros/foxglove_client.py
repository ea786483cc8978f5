"""A client of a Foxglove server: a WebSocket that speaks the subprotocol foxglove.sdk.v1, without Foxglove's own code."""

from __future__ import annotations

import json
import struct
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Self

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from tests.waiting import eventually

_SUBPROTOCOL = Subprotocol("foxglove.sdk.v1")
_MESSAGE_DATA = 1
"""Opcode of binary messages in both directions."""


class FoxgloveClient:
    """Keeps what the server sends; use it as a context manager.

    Args:
        url: of the server.
    """

    def __init__(self, url: str) -> None:
        self.info: dict[str, Any] = {}
        """What the server says of itself."""
        self.channels: dict[str, dict[str, Any]] = {}
        """Channels that are advertised, by topic."""
        self.messages: defaultdict[str, list[bytes]] = defaultdict(list)
        """Messages that arrived, by topic."""
        self.warnings: list[str] = []
        self.closed = False
        self._topics: dict[int, str] = {}
        """Topics by the number of their subscription, which is that of the channel too."""
        self._published = 0
        self._closing = ExitStack()
        self._socket = self._closing.enter_context(
            connect(url, subprotocols=[_SUBPROTOCOL], max_size=None, compression=None, close_timeout=0.2)
        )
        assert self._socket.subprotocol == _SUBPROTOCOL
        assert self.until(lambda: self.info)

    def until(self, condition: Callable[[], object], meanwhile: Callable[[], object] = lambda: None) -> bool:
        """Wait until a condition holds, and read what arrives."""

        def go_on() -> None:
            self.read()
            meanwhile()

        return eventually(condition, go_on)

    def read(self) -> None:
        """Read what has arrived."""
        try:
            while True:
                self._take(self._socket.recv(timeout=0.001))
        except TimeoutError:
            pass
        except ConnectionClosed:
            self.closed = True

    def _take(self, data: str | bytes) -> None:
        if isinstance(data, bytes):
            opcode, subscription, _ = struct.unpack_from("<BIQ", data)
            assert opcode == _MESSAGE_DATA
            self.messages[self._topics[subscription]].append(data[13:])
            return
        message = json.loads(data)
        match message["op"]:
            case "serverInfo":
                self.info = message
            case "advertise":
                self.channels |= {channel["topic"]: channel for channel in message["channels"]}
            case "unadvertise":
                gone = message["channelIds"]
                self.channels = {topic: one for topic, one in self.channels.items() if one["id"] not in gone}
            case "status":
                self.warnings.append(message["message"])

    def send(self, message: dict[str, Any] | str | bytes) -> None:
        """Send a message of the protocol, or what is none."""
        self._socket.send(json.dumps(message) if isinstance(message, dict) else message)

    def subscribe(self, *topics: str) -> None:
        """Subscribe to topics, once they are advertised."""
        assert self.until(lambda: self.channels.keys() >= {*topics})
        numbers = {self.channels[topic]["id"]: topic for topic in topics}
        self._topics |= numbers
        self.send({"op": "subscribe", "subscriptions": [{"id": one, "channelId": one} for one in numbers]})

    def unsubscribe(self, topic: str) -> None:
        """End a subscription."""
        self.send({"op": "unsubscribe", "subscriptionIds": [self.channels[topic]["id"]]})

    def advertise(self, topic: str, schema: str, encoding: str = "cdr") -> Callable[[bytes], None]:
        """Advertise a topic of the client; what is returned publishes a message there."""
        self._published += 1
        number = self._published
        channel = {"id": number, "topic": topic, "encoding": encoding, "schemaName": schema}
        self.send({"op": "advertise", "channels": [channel]})
        return lambda data: self.send(struct.pack("<BI", _MESSAGE_DATA, number) + data)

    def close(self) -> None:
        """Disconnect."""
        self._closing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
