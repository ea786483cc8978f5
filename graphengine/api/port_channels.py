"""Sends the values of chosen ports to Foxglove clients after each tick."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from graphengine.runtime.port_values import PortValues, WatchedPort

if TYPE_CHECKING:
    from graphengine.ros.foxglove.foxglove_server import FoxgloveServer


class PortChannels:
    """The channels of chosen ports on a Foxglove server. A channel without clients costs no more than its look-up.

    Args:
        server: the server; close the channels before it.
        ports: the ports.
    """

    def __init__(self, server: FoxgloveServer, ports: PortValues) -> None:
        self._server = server
        self._ports = ports
        self._ticks = 0
        self._channels: dict[WatchedPort, Any] = {}
        self._opened: Sequence[WatchedPort] = ()
        self._open()

    def _open(self) -> None:
        """Close the channels of ports that a reload has removed, and open those of new ports."""
        self._opened = self._ports.ports
        opened = {*self._opened}
        for port in [port for port in self._channels if port not in opened]:
            self._channels.pop(port).close()
        for port in self._opened:
            if port not in self._channels:
                self._channels[port] = self._server.channel(port.channel, port.message_type)

    def after_tick(self, ticks: int) -> None:
        """Send the values of the ports that have subscribers.

        Args:
            ticks: number of ticks of the session; while it waits, this method is called without a tick.
        """
        if ticks == self._ticks:
            return
        self._ticks = ticks
        if self._ports.ports is not self._opened:
            self._open()
        for port, channel in self._channels.items():
            if channel.has_sinks() and (message := port.message()) is not None:
                channel.log(message)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _: type[BaseException] | None, __: BaseException | None, ___: TracebackType | None) -> None:
        for channel in self._channels.values():
            channel.close()
