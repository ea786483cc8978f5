"""What the contract tests of services share: one service, and ends of it that keep what they hear."""

from __future__ import annotations

from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import decode, encode
from graphengine.ros.transport import TransportClient, TransportServer
from tests.ros.contract import AnyTransport

NAME = "/robot/add"
TYPE = "diagnostic_msgs/srv/AddDiagnostics"  # text in requests, and in answers
SERVICES = QoS()


def question(text: str) -> bytes:
    request = DEFINITIONS.initial(f"{TYPE}_Request")
    request.load_namespace = text
    return encode(request)


def reply(text: str) -> bytes:
    response = DEFINITIONS.initial(f"{TYPE}_Response")
    response.message = text
    return encode(response)


class Server:
    """A server, and what it was asked."""

    def __init__(self, transport: AnyTransport, name: str = NAME, qos: QoS = SERVICES, node: str = "") -> None:
        self.asked: list[tuple[bytes, str]] = []
        self.end: TransportServer = transport.server(name, TYPE, qos, self.take, node)

    def take(self, request_id: bytes, data: bytes) -> None:
        assert type(request_id) is type(data) is bytes
        self.asked.append((request_id, decode(data, f"{TYPE}_Request").load_namespace))

    @property
    def texts(self) -> list[str]:
        return [text for _, text in self.asked]

    def answer(self, number: int) -> None:
        """Answer the n-th request."""
        request_id, text = self.asked[number]
        self.end.answer(request_id, reply(f"{text}!"))


class Client:
    """A client, and what it was answered."""

    def __init__(self, transport: AnyTransport, name: str = NAME, qos: QoS = SERVICES) -> None:
        self.answers: dict[int, str] = {}
        self.end: TransportClient = transport.client(name, TYPE, qos, self.take)

    def take(self, number: int, data: bytes) -> None:
        assert type(data) is bytes
        assert number not in self.answers
        self.answers[number] = decode(data, f"{TYPE}_Response").message

    def call(self, text: str) -> int:
        return self.end.call(question(text))


def foreign(transport: AnyTransport) -> list[str]:
    """How warnings about services begin."""
    return [text.split(": ")[1] for text in transport.foreign_services.values()]
