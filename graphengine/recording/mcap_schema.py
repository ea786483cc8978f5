"""Channels, metadata and time stamps of a recording's MCAP file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import settled

PROFILE = "ros2"
LIBRARY = "graphengine"
"""Beginning of the `library` field in the MCAP header of a recording."""
ENCODING = "cdr"
MANIFEST = "graphengine"
"""Name of the metadata record with the manifest."""
FILES = "graphengine:files"
"""Name of the metadata record that precedes attachments and has the SHA-256 of each attachment, by name."""
END = "graphengine:end"
"""Name of the last metadata record, which a recording lacks if it was not closed."""

HIDDEN = "/_graphengine"
"""Namespace of channels that are not topics of the run; ROS 2 hides names that begin with an underscore."""
DEFAULT_QOS = QoS()

# rmw's numbers of the QoS policies, because some ROS 2 distributions do not read names of policies.
_NUMBERS: Mapping[str, int] = {
    "keepLast": 1,
    "keepAll": 2,
    "reliable": 1,
    "bestEffort": 2,
    "transientLocal": 1,
    "volatile": 2,
    "automatic": 1,
    "manualByTopic": 3,
}
_FOREVER_NS = 2**63 - 1
_PLACE = re.compile(r"\A.*?:\d+:\d+: ")


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """The messages of one channel.

    Attributes:
        topic: full name of the topic.
        message_type: full name of the type, such as `nav_msgs/msg/Odometry`.
        qos: profile that the run's publisher offers, or that its subscription requests if the run does not publish the topic.
        known: whether the topic's own channel also has these messages; bag players then must not publish this channel.
    """

    topic: str
    message_type: str
    qos: QoS = DEFAULT_QOS
    known: bool = False

    @property
    def channel(self) -> str:
        """Name of the channel: the topic, or a hidden name if the topic's own channel has the same messages."""
        return f"{HIDDEN}/delivered{self.topic}" if self.known else self.topic

    def metadata(self) -> dict[str, str]:
        """Return the MCAP metadata of the channel: the QoS profile and the topic."""
        return {"offered_qos_profiles": offered_qos(self.qos), "topic": self.topic}

    @classmethod
    def of_channel(cls, channel: str, message_type: str, metadata: Mapping[str, str]) -> Stream | None:
        """Return the stream of a channel; None if another program wrote the channel."""
        topic = metadata.get("topic")
        return None if topic is None else cls(topic, message_type, known=topic != channel)


@dataclass(frozen=True, slots=True)
class PortStream:
    """The values of one port. Replays ignore this channel, because its metadata have no topic.

    Attributes:
        channel: name of the channel, such as `/_graph/dd100/joint_states/ComputeOdom.position`.
        message_type: type of the messages, from std_msgs.
        unit: unit of the values; empty without one.
        doc: description of the port.
    """

    channel: str
    message_type: str
    unit: str
    doc: str

    def metadata(self) -> dict[str, str]:
        """Return the MCAP metadata of the channel: a QoS profile, the unit and the description."""
        return {"offered_qos_profiles": offered_qos(DEFAULT_QOS), "unit": self.unit, "doc": self.doc}


SESSION = Stream(f"{HIDDEN}/session", "std_msgs/msg/String")
"""The stream of external inputs other than messages: commands, wall clock time, and receivers of messages."""


@dataclass(frozen=True, slots=True)
class TickTimes:
    """Converts ticks to nanoseconds and back.

    Attributes:
        period: seconds between two ticks as numerator and denominator.
    """

    period: tuple[int, int]

    def nanoseconds(self, tick: int) -> int:
        """Return the time of a tick in whole nanoseconds, truncated like the stamps of messages."""
        numerator, denominator = self.period
        return tick * numerator * 10**9 // denominator

    def tick(self, nanoseconds: int) -> int:
        """Return the number of the first tick at or after a time in nanoseconds."""
        numerator, denominator = self.period
        return -(-nanoseconds * denominator // (numerator * 10**9))

    def seconds(self, tick: int) -> float:
        """Return the time of a tick, s."""
        return tick * self.period[0] / self.period[1]


def failure_of(error: BaseException) -> str:
    """Return the first line of an error message without the file position, which differs between machines."""
    return _PLACE.sub("", str(error).partition("\n")[0])


def node_of(failure: str) -> str:
    """Return the text of a failure message that names the node; a message without a node is returned unchanged."""
    return failure.partition(" raised ")[0]


def offered_qos(qos: QoS) -> str:
    """Return a QoS profile in rosbag2's format: a YAML list with one element."""
    known = settled(qos)
    lines = [
        f"- history: {_NUMBERS[known.history]}",
        f"  depth: {known.depth}",
        f"  reliability: {_NUMBERS[known.reliability]}",
        f"  durability: {_NUMBERS[known.durability]}",
        *_duration("deadline", known.deadline),
        *_duration("lifespan", known.lifespan),
        f"  liveliness: {_NUMBERS[known.liveliness]}",
        *_duration("liveliness_lease_duration", known.lease_duration),
        "  avoid_ros_namespace_conventions: false",
    ]
    return "\n".join(lines)


def _duration(name: str, seconds: float) -> tuple[str, str, str]:
    """Return the YAML lines of a duration; 0 s means unlimited and becomes the largest number, as in rosbag2."""
    whole, rest = divmod(math.floor(seconds * 1e9) if 0 < seconds * 1e9 < _FOREVER_NS else _FOREVER_NS, 10**9)
    return f"  {name}:", f"    sec: {whole}", f"    nsec: {rest}"
