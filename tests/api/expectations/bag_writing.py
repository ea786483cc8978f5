"""Writes bags with rosbags: 5 s of a robot that drives at 0.5 m/s, with a lidar at 9.5 Hz."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

SECOND = 10**9
BEGIN = 1_750_000_000 * SECOND + 123_456_789  # ns since 1970
SPEED, SCAN_RATE, LENGTH, DELAY = 0.5, 9.5, 5.0, 30_000_000  # m/s, Hz, s, ns
LEVEL = "acme_msgs/msg/Level"

Entry = tuple[float, str, Any]
"""Time from the beginning, s, topic and message."""


def typestore() -> Typestore:
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg("float64 level\nacme_msgs/Unit unit\n", LEVEL))
    store.register(get_types_from_msg("string name\n", "acme_msgs/msg/Unit"))
    return store


STORE = typestore()


def made(message_type: str, **fields: Any) -> Any:
    return STORE.types[message_type](**fields)


def time_of(nanoseconds: int) -> Any:
    return made("builtin_interfaces/msg/Time", sec=nanoseconds // SECOND, nanosec=nanoseconds % SECOND)


def stamped(at: float, delay: int = DELAY) -> Any:
    """A std_msgs/Header, `delay` ns before the message arrives."""
    stamp = time_of(BEGIN + round(at * SECOND) - delay)
    return made("std_msgs/msg/Header", stamp=stamp, frame_id="odom")


def point(at: float, x: float = 0.0, topic: str = "/position", header: Any = None) -> Entry:
    position = made("geometry_msgs/msg/Point", x=x, y=0.0, z=0.0)
    return at, topic, made("geometry_msgs/msg/PointStamped", header=header or stamped(at), point=position)


def driving() -> list[Entry]:
    times = [number / SCAN_RATE for number in range(int(LENGTH * SCAN_RATE) + 1)]
    unit = made("acme_msgs/msg/Unit", name="m")
    return [
        *(point(number / 10, SPEED * number / 10) for number in range(int(LENGTH * 10) + 1)),
        *(point(at, topic="/range") for at in times),
        *((number, "/level", made(LEVEL, level=float(number), unit=unit)) for number in range(int(LENGTH) + 1)),
    ]


def write_bag(
    folder: Path,
    entries: Iterable[Entry],
    storage: StoragePlugin = StoragePlugin.MCAP,
    compression: CompressionMode = CompressionMode.NONE,
    change: Callable[[str, bytes], bytes] = lambda topic, data: data,
) -> Path:
    """Write a bag; `change` gets topic and data of each message."""
    with_compression = compression != CompressionMode.NONE
    writer = Writer(folder, version=9, storage_plugin=storage)
    if with_compression:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections: dict[str, Any] = {}
        for at, topic, message in sorted(entries, key=lambda entry: entry[0]):
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            data = change(topic, bytes(STORE.serialize_cdr(message, kind)))
            writer.write(connections[topic], BEGIN + round(at * SECOND), data)
    return folder
