"""Subscriptions and publications by which a program exchanges messages with the graphs of a session."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any, Generic, TypeVar

from graphengine.api.after_tick import AfterTick
from graphengine.api.guards import HasRunner, acting
from graphengine.api.runner import Runner
from graphengine.format.errors import UsageError
from graphengine.format.wording import did_you_mean, listing
from graphengine.messages import messages
from graphengine.messages.checked_encoder import CheckedEncoder
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.message_input import full_type
from graphengine.messages.names import check_topic
from graphengine.messages.qos import settled
from graphengine.ros.transport import Reader, Transport, Writer

M = TypeVar("M")

MessageType = str | type[Any] | None
"""A message type: its name, such as `nav_msgs/msg/Odometry`, a class of `graphengine.messages.messages`, or None for the type
that the graphs use."""


class Subscription(Generic[M]):
    """A subscription and its received messages, which are decoded when they are read. `Session.subscribe` returns it.

    The messages stay readable after a reset and after the session is closed.

    Attributes:
        topic: full name of the topic.
        type: message type, such as `nav_msgs/msg/Odometry`.
        definitions: definitions of the message type and of its fields.
    """

    def __init__(self, runner: Runner, topic: str, type: MessageType, keep: int) -> None:
        if keep < 1:
            raise UsageError(f"keep: expected at least 1 message, got {keep}")
        self.topic, transport, claims, self.type = find_end(runner, topic, type, ("publish", "subscribe"))
        self.definitions = runner.scene.definitions
        self._kept: deque[bytes] = deque(maxlen=keep)
        self._arrived = 0
        offered = [settled(claim.qos) for claim in claims if claim.direction == "publish"]
        reliable = bool(offered) and all(qos.reliability == "reliable" for qos in offered)
        latched = bool(offered) and all(qos.durability == "transientLocal" for qos in offered)
        qos = QoS(
            depth=keep,
            reliability="reliable" if reliable else "bestEffort",
            durability="transientLocal" if latched else "volatile",
        )
        self._reader: Reader = transport.reader(self.topic, self.type, qos, self._deliver)

    def _deliver(self, data: bytes) -> None:
        self._kept.append(data)
        self._arrived += 1

    def _decode(self, data: bytes) -> M:
        message: M = messages.decode(data, self.type, self.definitions)
        return message

    @property
    def latest(self) -> M | None:
        """The newest message; None before the first message. The arrays in a message are read-only."""
        return self._decode(self._kept[-1]) if self._kept else None

    @property
    def latest_data(self) -> bytes | None:
        """The newest message as serialized CDR data; None before the first message."""
        return self._kept[-1] if self._kept else None

    @property
    def messages(self) -> list[M]:
        """The newest messages, at most `keep`, oldest first. The arrays in the messages are read-only."""
        return [self._decode(data) for data in tuple(self._kept)]

    def newest_data(self, count: int) -> list[bytes]:
        """Return the newest messages as CDR data, at most `count` of those that are kept, oldest first."""
        return list(self._kept)[-count:] if count else []

    @property
    def received(self) -> int:
        """Number of messages that have arrived, including messages that have been discarded."""
        return self._arrived

    @property
    def dropped(self) -> int:
        """Number of messages that were discarded because more than `keep` messages arrived."""
        return max(self._arrived - len(self._kept), 0)

    def clear(self) -> None:
        """Discard the received messages, for example after `Session.restore`."""
        self._kept.clear()
        self._arrived = 0

    def __iter__(self) -> Iterator[M]:
        return map(self._decode, tuple(self._kept))

    def __len__(self) -> int:
        return len(self._kept)

    def close(self) -> None:
        """Destroy the subscription. Messages that were received stay readable. Safe to call twice."""
        self._reader.close()

    def __repr__(self) -> str:
        dropped = f", {self.dropped} dropped" if self.dropped else ""
        return f"<Subscription {self.topic} ({self.type}): {len(self)} messages{dropped}>"


@acting
def open_subscription(user: HasRunner, topic: str, type: MessageType, keep: int) -> Subscription[Any]:
    """Return a new subscription in the session that `user` belongs to. The other arguments are those of `Session.subscribe`."""
    return Subscription(user._runner, topic, type, keep)


class Publication(AfterTick):
    """A message sent once or periodically. `Session.publish` returns it.

    Attributes:
        topic: full name of the topic.
        type: message type, such as `geometry_msgs/msg/Twist`.
        every: period in simulation time, s; None if the message is sent once.
    """

    kept = ("_begin", "_last", "_sent")

    def __init__(self, runner: Runner, topic: str, message: Any, every: float | None, type: MessageType) -> None:
        if every is not None and not every > 0.0:
            raise UsageError(f"every: expected a time above 0 s, got {every!r}")
        given = messages.message_type(message) if type is None and not isinstance(message, dict) else type
        self.topic, transport, claims, self.type = find_end(
            runner, topic, given, ("subscribe", "publish"), known=type is None
        )
        self.every = every
        self._data = encoded(runner, message, self.type)
        self._writer = _writer(runner, self.topic, self.type, transport, claims)
        self._runner = runner
        self._begin = self._last = runner.session.clock.frame
        self._sent = 0
        self._writer.write(self._data)
        if every is not None:
            runner.after_ticks[self] = self

    def after_tick(self, frame: int) -> None:
        """Send the message if its period has passed. The session calls this method after each tick.

        Args:
            frame: number of ticks since the start or since the last reset of the time.
        """
        if frame < self._last:  # time was reset
            self._begin, self._sent = frame, -1
        self._last = frame
        assert self.every is not None
        due = int((frame - self._begin) * self._runner.session.clock.delta / self.every + 1e-9)
        if due > self._sent:
            self._sent = due
            self._writer.write(self._data)

    def close(self) -> None:
        """Stop sending the message. Safe to call twice."""
        self._runner.after_ticks.pop(self, None)

    def __repr__(self) -> str:
        return f"<Publication {self.topic} ({self.type}), {f'every {self.every:g} s' if self.every else 'once'}>"


def encoded(runner: Runner, message: Any, message_type: str) -> bytes:
    """Return a message as CDR data; `message` is a message object or a mapping of its fields.

    Raises:
        MessageError: the message does not match the type.
    """
    if message_type not in runner.encoders:
        runner.encoders[message_type] = CheckedEncoder(message_type, runner.scene.definitions)
    return runner.encoders[message_type].encode(message)


def _writer(
    runner: Runner, topic: str, message_type: str, transport: Transport, claims: Sequence[EndpointClaim]
) -> Writer:
    """Return the writer that all publications on a topic share. Its QoS is compatible with every subscription in the graphs."""
    key = (topic, message_type, transport)
    if key not in runner.writers:
        read = [settled(claim.qos) for claim in claims if claim.direction == "subscribe"]
        latched = any(qos.durability == "transientLocal" for qos in read)
        qos = QoS(durability="transientLocal" if latched else "volatile")
        runner.writers[key] = transport.writer(topic, message_type, qos)
        for end in runner.network.subscriptions:
            if end.topic == topic:
                end.follow({message_type})
    return runner.writers[key]


def find_end(
    runner: Runner, name: str, given: MessageType, directions: Sequence[str], *, known: bool = False
) -> tuple[str, Transport, list[EndpointClaim], str]:
    """Return the full name of a topic or service, its transport, the claims of nodes that use it, and its type.

    Args:
        runner: runner of the session.
        name: absolute name of the topic or service; the leading slash may be left out.
        given: type given by the user, or None.
        directions: directions of claims to consider, such as `publish`. If `given` is None, a claim with the first of these
            directions decides the type.
        known: whether a graph must use the topic or service even if the type is given.

    Raises:
        UsageError: no graph uses the topic or service, or the graphs use another type.
    """
    full = name if name.startswith("/") else f"/{name}"
    check_topic(full, given=name)
    every = [claim for claim in runner.session.services.claims if claim.direction in directions]
    claims = sorted(
        (claim for claim in every if claim.topic == full), key=lambda claim: directions.index(claim.direction)
    )
    if not claims and (given is None or known):
        names = list(dict.fromkeys(claim.topic for claim in every))
        same = [other for other in names if other.rpartition("/")[2] == full.rpartition("/")[2]]
        near = f"did you mean {' or '.join(map(repr, same[:5]))}?" if same else did_you_mean(full, names)
        what = "service" if "serve" in directions else "topic"
        hint = near or listing(names, f"{what}s that graphs use")
        raise UsageError(f"no graph uses {what} {full!r}\n  {hint}\n  or give its type: type='package/…/Name'")
    wanted = full_type(given) if isinstance(given, str) else getattr(given, "__msgtype__", "")
    if given is not None and not wanted:
        raise UsageError(f"type: expected a message type such as 'nav_msgs/msg/Odometry', or its class, got {given!r}")
    types = list(dict.fromkeys(kind for claim in claims for kind in (claim.message_type, *claim.alternatives)))
    if wanted and types and wanted not in types:
        raise UsageError(f"{full} has the type {' or '.join(types)}, not {wanted}")
    transport = runner.network.transport(claims[0].ros_context if claims else 0)
    return full, transport, claims, wanted or types[0]
