"""Messages of the interop matrix, filled and read alike by a node of rclpy and by a transport of this project."""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

TYPES = {
    "text": "std_msgs/msg/String",
    "wide": "example_interfaces/msg/WString",
    "bounded": "shape_msgs/msg/SolidPrimitive",
    "unbounded": "trajectory_msgs/msg/JointTrajectory",
    "image": "sensor_msgs/msg/Image",
}
_UMLAUTS = "Grüße 😀"

Array = Callable[[Sequence[float]], Any]
"""Makes the value of a field of type `float64[]`."""


def fill(message: Any, kind: str, number: int, array: Array, make: Callable[[str], Any], data: Any = b"") -> Any:
    """Write a number, the time and values that `read` checks into a message.

    Args:
        message: message of the type that `TYPES` names.
        kind: key of `TYPES`.
        number: number of the message.
        array: makes arrays.
        make: makes messages.
        data: bytes of an image.
    """
    mark = f"{number} {time.monotonic_ns()}"
    match kind:
        case "text":
            message.data = mark
        case "wide":
            message.data = f"{mark} {_UMLAUTS}"
        case "bounded":
            message.type, message.dimensions = 1, array([float(number), time.monotonic(), 3.0])
        case "unbounded":
            message.joint_names = [mark, *(f"joint_{index}" for index in range(20))]
            message.points = [make("trajectory_msgs/msg/JointTrajectoryPoint") for _ in range(10)]
            for point in message.points:
                point.positions = array([0.25 * index for index in range(20)])
        case "image":
            message.header.frame_id, message.data = mark, data
            message.height, message.width, message.step = 1, len(data), len(data)
    return message


def read(message: Any, kind: str, size: int) -> tuple[int, float, bool]:
    """Return number, age (s) and whether all values are as written."""
    now = time.monotonic()
    if kind == "bounded":
        number, sent, last = message.dimensions
        return int(number), now - sent, last == 3.0 and len(message.polygon.points) == 0
    if kind == "image":
        number, stamp = message.header.frame_id.split()
        intact = len(message.data) == size and message.data[0] == message.data[size - 1] == 7
    elif kind == "unbounded":
        number, stamp = message.joint_names[0].split()
        rows = [list(point.positions) for point in message.points]
        intact = len(message.joint_names) == 21 and rows == [[0.25 * index for index in range(20)]] * 10
    else:
        number, stamp, *rest = message.data.split(" ", 2)
        intact = rest == ([_UMLAUTS] if kind == "wide" else [])
    return int(number), now - int(stamp) / 1e9, intact


GREETING = -1
"""Number of a message that only shows that messages arrive."""


class Tally:
    """What a reader received; filled by one thread and read by another."""

    def __init__(self, kind: str, size: int = 0) -> None:
        self._kind, self._size = kind, size
        self._lock = threading.Lock()
        self._numbers: list[int] = []
        self._ages: list[float] = []
        self._broken = 0
        self.greeted = threading.Event()
        """Set when a message with the number `GREETING` has arrived; such messages are not counted."""

    def add(self, message: Any) -> None:
        """Count a message."""
        number, age, intact = read(message, self._kind, self._size)
        if number == GREETING:
            self.greeted.set()
            return
        with self._lock:
            self._numbers.append(number)
            self._ages.append(age)
            self._broken += not intact

    def clear(self) -> None:
        """Forget all messages."""
        with self._lock:
            self._numbers, self._ages, self._broken = [], [], 0

    def report(self) -> dict[str, Any]:
        """Return counts, the first and the last number, and the median and the longest time on the way in ms."""
        with self._lock:
            numbers, ages, broken = list(self._numbers), list(self._ages), self._broken
        return {
            "received": len(set(numbers)),
            "twice": len(numbers) - len(set(numbers)),
            "broken": broken,
            "first": min(numbers, default=-1),
            "last": max(numbers, default=-1),
            "median": 1e3 * statistics.median(ages) if ages else 0.0,
            "longest": 1e3 * max(ages, default=0.0),
        }


def paced(count: int, rate: float, send: Callable[[int], object], first: int = 0) -> float:
    """Call `send` with consecutive numbers at a rate (Hz); return the seconds that it took."""
    begun = time.monotonic()
    for index in range(count):
        time.sleep(max(begun + index / rate - time.monotonic(), 0.0))
        send(first + index)
    return time.monotonic() - begun
