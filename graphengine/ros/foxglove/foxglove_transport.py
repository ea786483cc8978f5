"""Wraps a transport, so that Foxglove clients can also read and write the transport's topics, but not use its services."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

from graphengine.messages.endpoints import QoS
from graphengine.ros.foxglove.foxglove_server import FoxgloveServer, ServedEnd, ServedReader
from graphengine.ros.network_graph import Direction, NetworkGraph
from graphengine.ros.transport import Deliver, Reader, Transport, Writer


class FoxgloveTransport:
    """A transport that also sends messages to Foxglove clients, and delivers messages that Foxglove clients publish.

    Args:
        inner: transport that carries the messages; `close` closes it too.
        server: Foxglove server, which several transports may share; the caller closes it.
    """

    def __init__(self, inner: Transport, server: FoxgloveServer) -> None:
        self._inner = inner
        self._server = server
        self._ends: set[ServedEnd] = set()
        # As in the inner transport; Foxglove clients cannot call services.
        self.identity, self.node, self.log = inner.identity, inner.node, inner.log
        self.server, self.client = inner.server, inner.client
        self.save, self.restore = inner.save, inner.restore

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """Create a writer on a topic; the writer is also matched while a Foxglove client subscribes to the topic."""
        writer = _Writer(self._inner.writer(topic, message_type, qos), self, ServedEnd(topic, message_type, qos))
        self._enter(writer.end)
        return writer

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> Reader:
        """Create a reader on a topic; threads of the Foxglove server also deliver messages of Foxglove clients to the reader."""
        end = ServedReader(topic, message_type, qos, deliver)
        self._enter(end)
        try:
            return _Reader(self._inner.reader(topic, message_type, qos, end.hear), self, end)
        except BaseException:
            self.leave(end)
            raise

    def _enter(self, end: ServedEnd) -> None:
        self._server.enter(end)
        self._ends.add(end)

    def leave(self, end: ServedEnd) -> None:
        """Stop sending the messages of an endpoint to Foxglove clients; safe to call twice."""
        self._server.leave(end)
        self._ends.discard(end)

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return the inner transport's graph; publishers of Foxglove clients are added as writers of the node `/foxglove`."""
        found, published = self._inner.graph(asked), self._server.endpoints()
        return found.with_endpoints(published) if published else found

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of malformed messages dropped on each topic or service, including messages of Foxglove clients."""
        counts = Counter(self._inner.malformed)
        for end in tuple(self._ends):
            counts[end.key[0]] += end.malformed if isinstance(end, ServedReader) else 0
        return +counts

    def close(self) -> None:
        """Close all endpoints and the inner transport; safe to call twice."""
        for end in tuple(self._ends):
            self.leave(end)
        self._inner.close()

    # As in the inner transport

    @property
    def description(self) -> str:
        """Description of the inner transport."""
        return self._inner.description

    @property
    def notices(self) -> Sequence[str]:
        """Notices of the inner transport."""
        return self._inner.notices

    @property
    def spin_time(self) -> float:
        """Typical time that the discovery of existing peers takes, s."""
        return self._inner.spin_time

    @property
    def source(self) -> bytes:
        """GID of the network writer whose message is being delivered; meaningless for messages of Foxglove clients."""
        return self._inner.source

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """A warning for each service with incompatible peers, by the service's name."""
        return self._inner.foreign_services

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of the inner transport that another program also offers."""
        return self._inner.rival_services


class _Writer:
    """A writer of the inner transport that also sends its messages to Foxglove clients."""

    def __init__(self, inner: Writer, transport: FoxgloveTransport, end: ServedEnd) -> None:
        self._inner = inner
        self._transport = transport
        self.end = end

    @property
    def matched(self) -> int:
        """Number of matched readers; all subscribed Foxglove clients together count as one reader."""
        return self._inner.matched + self.end.wanted

    @property
    def dropped(self) -> int:
        """Number of messages dropped because a reader on the network was too slow."""
        return self._inner.dropped

    def write(self, data: bytes) -> None:
        """Send a message to the network and to subscribed Foxglove clients."""
        self._inner.write(data)
        self.end.show(data)

    def close(self) -> None:
        """Close the writer; safe to call twice."""
        self._transport.leave(self.end)
        self._inner.close()


class _Reader:
    """A reader of the inner transport that also delivers messages of Foxglove clients."""

    def __init__(self, inner: Reader, transport: FoxgloveTransport, end: ServedReader) -> None:
        self._inner = inner
        self._transport = transport
        self._end = end

    def close(self) -> None:
        """Close the reader; safe to call twice."""
        self._transport.leave(self._end)
        self._inner.close()
        self._end.wait()
