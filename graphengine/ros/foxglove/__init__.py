"""Serves all topics of a run to Foxglove clients over WebSocket with Foxglove's SDK, beside any transport."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphengine.format.distribution import install_command
from graphengine.format.errors import TransportError
from graphengine.messages.definitions import Definitions

if TYPE_CHECKING:
    from graphengine.ros.foxglove.foxglove_server import Address, FoxgloveServer


def open_server(address: Address, name: str, definitions: Definitions, *, publish: bool = False) -> FoxgloveServer:
    """Start and return a Foxglove server; a `FoxgloveTransport` adds the topics of a transport to it.

    Args:
        address: host and port to listen on.
        name: name of the run, for display in clients.
        definitions: message types.
        publish: whether clients that have the token may publish; the server's URL then contains the token.

    Raises:
        TransportError: foxglove-sdk or websockets is not installed, or the address cannot be used.
    """
    try:
        from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
    except ImportError as error:
        what = f"Foxglove needs foxglove-sdk and websockets: {error}"
        raise TransportError(f"{what}\n  {install_command('foxglove')}") from None
    return FoxgloveServer(address, name, definitions, publish=publish)
