"""The values of chosen ports after each tick, as messages of std_msgs for recordings and Foxglove."""

from __future__ import annotations

import contextlib
import json
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from graphengine.compiler.graph import settled_type
from graphengine.format.errors import UsageError
from graphengine.node.types import POINTER
from graphengine.runtime.addresses import NodePort, find_ports
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.session_core import SessionCore

CHANNELS = "/_graph"
"""Namespace of the channels of ports; ROS 2 hides names that begin with an underscore."""
MAX_ELEMENTS = 1000
"""Maximum number of elements of an array; ports with longer arrays, such as images, are left out."""
MAX_PORTS = 10_000
"""Maximum number of chosen ports."""
_NOTHING = object()
_CDR = b"\0\1\0\0"
"""Header of a message in CDR, little endian."""
_float, _whole, _natural = (struct.Struct(f"<4s{code}").pack for code in "dqQ")


def _text(value: Any) -> bytes:
    """Encode a text, or any other value as JSON text."""
    data = (value if isinstance(value, str) else json.dumps(value, default=str)).encode() + b"\0"
    return struct.pack(f"<4sI{len(data)}s", _CDR, len(data), data)


def _array(code: str) -> Callable[[Any], bytes]:
    """Return a function that encodes an array of numbers, with an empty layout; the elements are aligned to 8 bytes."""

    def encode(value: Any) -> bytes:
        numbers = value.ravel().tolist() if isinstance(value, np.ndarray) else value
        count = min(len(numbers), MAX_ELEMENTS)
        return struct.pack(f"<4s4I{count}{code}", _CDR, 0, 0, count, 0, *numbers[:count])

    return encode


_ENCODERS: Mapping[str, Callable[[Any], bytes]] = MappingProxyType(
    {
        "Bool": lambda value: _CDR + (b"\1" if value else b"\0"),
        "Float64": lambda value: _float(_CDR, value),
        "Float64MultiArray": _array("d"),
        "Int64": lambda value: _whole(_CDR, value),
        "Int64MultiArray": _array("q"),
        "String": _text,
        "UInt64": lambda value: _natural(_CDR, value),
    }
)
"""Functions that encode values, by the name of the message type in std_msgs."""


@dataclass(slots=True, eq=False)
class WatchedPort:
    """A port whose values are read after each tick.

    Attributes:
        address: full address of the port.
        unit: unit of the values; empty without one.
        doc: description of the port.
        message_type: type of the messages with the values.
    """

    address: str
    unit: str
    doc: str
    message_type: str
    _node: Any = field(repr=False)
    _field: str = field(repr=False)
    _encode: Callable[[Any], bytes] = field(repr=False)
    _before: Any = field(default=_NOTHING, repr=False)

    @property
    def channel(self) -> str:
        """Name of the channel, such as `/_graph/dd100/joint_states/ComputeOdom.position`."""
        return f"{CHANNELS}/{self.address}"

    @property
    def value(self) -> Any:
        """Present value of the port."""
        return getattr(self._node, self._field)

    def message(self) -> bytes | None:
        """Return the present value as a message in CDR; None if the port's message type cannot have this value."""
        return self._encoded(getattr(self._node, self._field))

    def new_message(self) -> bytes | None:
        """Return the present value as `message` does, or None if it equals the value at the last call; an array counts as new."""
        before = self._before
        self._before = value = getattr(self._node, self._field)
        if value is before and not isinstance(value, np.ndarray):  # the elements of an array may have changed
            return None
        return None if type(value) is float and value == before else self._encoded(value)

    def _encoded(self, value: Any) -> bytes | None:
        try:
            return self._encode(value)
        except (struct.error, TypeError, ValueError, OverflowError):  # for example None, or an integer over 64 bits
            return None


class PortValues:
    """The chosen ports of a session; after a reload, those of the changed graphs.

    Args:
        session: session with the ports.
        patterns: addresses, whose parts may be globs, such as `*/ComputeOdom.*`.

    Raises:
        UsageError: a pattern matches no port, none of the ports has a suitable value, or too many ports match.
    """

    def __init__(self, session: SessionCore, patterns: Sequence[str]) -> None:
        self._session = session
        self._patterns = patterns
        self._graphs: Sequence[GraphRun] = session.graphs
        found = {port.address: port for pattern in patterns for port in find_ports(self._graphs, pattern)}
        if len(found) > MAX_PORTS:
            raise UsageError(f"{len(found)} ports match the addresses; choose at most {MAX_PORTS}")
        self._ports = _watched_ports(found.values())
        if not self._ports:
            raise UsageError(f"{', '.join(patterns)}: none of these ports has a number, a text or a short array")

    @property
    def ports(self) -> list[WatchedPort]:
        """All chosen ports with suitable values, at most `MAX_PORTS`. A change of the graphs replaces the list."""
        if self._graphs is not self._session.graphs:
            self._graphs = self._session.graphs
            found: dict[str, NodePort] = {}
            for pattern in self._patterns:
                # A reload or a removed robot can take away all ports of a pattern.
                with contextlib.suppress(UsageError):
                    found |= {port.address: port for port in find_ports(self._graphs, pattern)}
            self._ports = _watched_ports([*found.values()][:MAX_PORTS])
        return self._ports

    def changes(self) -> Iterator[tuple[WatchedPort, bytes]]:
        """Yield each port whose value is new since the last call, with its message; the first call yields all ports."""
        for port in self.ports:
            if (message := port.new_message()) is not None:
                yield port, message


def _watched_ports(found: Iterable[NodePort]) -> list[WatchedPort]:
    return [port for one in found if (port := _watched(one)) is not None]


def _watched(found: NodePort) -> WatchedPort | None:
    """Return the port with the type of its messages; None if its value is no number, text or short array, or is a pointer."""
    kind = _kind(found.value)
    instance, port = found.executor.graph.instances[found.index], found.port
    settled = settled_type(instance, port)
    if kind is None or settled == POINTER:
        return None
    if kind == "Int64" and str(settled) == "uint64":
        kind = "UInt64"
    node = found.executor.nodes[found.index]
    return WatchedPort(found.address, port.unit, port.doc, f"std_msgs/msg/{kind}", node, port.field, _ENCODERS[kind])


def _kind(value: Any) -> str | None:
    """Return the name of the message type for a value, without its package; None for a value that is not sent."""
    if isinstance(value, np.ndarray):
        suitable = value.size <= MAX_ELEMENTS and (value.dtype.kind in "bif" or value.dtype in (np.uint8, np.uint32))
        return ("Float64MultiArray" if value.dtype.kind == "f" else "Int64MultiArray") if suitable else None
    if isinstance(value, tuple):
        numbers = bool(value) and all(isinstance(part, float) for part in value)
        return ("Float64MultiArray" if numbers else "String") if len(value) <= MAX_ELEMENTS else None
    return {bool: "Bool", int: "Int64", float: "Float64", str: "String"}.get(type(value))
