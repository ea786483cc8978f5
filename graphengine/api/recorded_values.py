"""Reads topics and ports of recordings and bags into a table of values over time."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from fnmatch import fnmatchcase
from pathlib import Path

from graphengine.api.expectations.bag_file import BagFile
from graphengine.api.value_table import ValueTable
from graphengine.format.errors import TransportError, UsageError
from graphengine.format.wording import unknown
from graphengine.messages import messages
from graphengine.messages.definitions import Definitions
from graphengine.messages.message_text import TypedValue
from graphengine.recording.replay import Replay
from graphengine.runtime.port_values import CHANNELS, PortValues


def add_recorded(table: ValueTable, path: Path, topics: Sequence[str], ports: Sequence[str]) -> None:
    """Add the messages of topics of a bag, and the values of recorded ports, to a table.

    Args:
        table: the table. Its times are log times: of a recording of graphengine simulation times, of other bags times since the
            first message.
        path: an MCAP or SQLite file, or the folder of `ros2 bag record`.
        topics: topics, whose names may be globs; `/odom.pose.pose` selects a field.
        ports: addresses of ports in channels of the recording, whose parts may be globs.

    Raises:
        RecordingError: the bag cannot be read.
        UsageError: the bag has no such topic or port.
    """
    with closing(BagFile(path)) as bag:
        names = [str(one.topic) for one in bag.connections]
        chosen = _chosen([name for name in names if not name.startswith("/_")], topics)
        chosen |= {name: ["data"] for name in names if any(_is_port(name, port) for port in ports)}
        kinds = {topic: bag.message_type(topic) for topic in chosen}
        begin = 0 if bag.is_run else bag.begin
        for time, topic, data in bag.messages(chosen):
            _add(table, time - begin, topic, chosen[topic], data, *kinds[topic])


def has_ports(path: Path, ports: Sequence[str]) -> bool:
    """Return whether a bag has a channel for each of the given addresses of ports; other ports need a replay."""
    with closing(BagFile(path)) as bag:
        return all(any(_is_port(str(one.topic), port) for one in bag.connections) for port in ports)


def add_replayed(table: ValueTable, replay: Replay, topics: Sequence[str], ports: Sequence[str]) -> None:
    """Replay a recording, and add recorded messages of topics and the values of ports after each tick to a table.

    Raises:
        UsageError: the recording has no such topic, or the session no such port.
    """
    values, definitions = PortValues(replay.session, ports), replay.network.definitions
    chosen: dict[str, list[str]] = {}
    seen: dict[str, None] = {}
    for tick in replay.recording.ticks():
        replay.repeat(tick)
        time = replay.recording.times.nanoseconds(tick.number)
        for stream, data in [*((stream, data) for stream, _, data in tick.delivered if not stream.known), *tick.sent]:
            if stream.topic not in seen:
                seen[stream.topic] = None
                chosen |= _chosen([stream.topic], topics, required=False)
            if stream.topic in chosen:
                _add(table, time, stream.topic, chosen[stream.topic], data, stream.message_type, definitions)
        for port, _ in values.changes() if tick.whole else ():
            table.add(time, port.address, port.value, held=True)
    _chosen([*seen], topics)


def _add(
    table: ValueTable,
    time: int,
    topic: str,
    fields: Sequence[str],
    data: bytes,
    message_type: str,
    definitions: Definitions,
) -> None:
    """Add the fields of a message to a table; the values of ports hold until the next message."""
    message = TypedValue.of(messages.decode(data, message_type, definitions), definitions)
    port = topic.startswith(f"{CHANNELS}/")
    table.begin_message(time, topic)
    for field in fields:
        name = topic.removeprefix(f"{CHANNELS}/") if port else ".".join(filter(None, (topic, field)))
        try:
            value = message.find(field)
        except TransportError as error:
            raise UsageError(f"{topic}: {error}") from None
        table.add(time, name, value, held=port)


def _chosen(names: Sequence[str], patterns: Sequence[str], *, required: bool = True) -> dict[str, list[str]]:
    """Return the topics that match the patterns, each with its selected fields; an empty field is the whole message.

    Raises:
        UsageError: `required` is set, and no topic matches a pattern.
    """
    chosen: dict[str, list[str]] = {}
    for pattern in patterns:
        topic, _, field = pattern.partition(".")
        found = sorted({name for name in names if fnmatchcase(name, topic)})
        if required and not found:
            raise UsageError(f"{unknown('topic', topic, names)}")
        for name in found:
            chosen.setdefault(name, []).append(field)
    return chosen


def _is_port(channel: str, pattern: str) -> bool:
    """Return whether a channel has the values of a port that a pattern matches, as `find_ports` compares them."""
    address = channel.removeprefix(f"{CHANNELS}/")
    parts, wanted = address.split("/"), pattern.split("/")
    ends = zip(reversed(parts), reversed(wanted), strict=False)
    return address != channel and len(wanted) <= len(parts) and all(fnmatchcase(part, glob) for part, glob in ends)
