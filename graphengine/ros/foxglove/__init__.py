"""Shows a run to Foxglove, whatever its transport: a WebSocket server of all its topics, by Foxglove's own SDK."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import Definitions

if TYPE_CHECKING:
    from graphengine.ros.foxglove.foxglove_server import FoxgloveServer

Address = tuple[str, int]
"""Host and port to listen at; port 0 takes any free port."""


def open_server(address: Address, name: str, definitions: Definitions) -> FoxgloveServer:
    """Start a server; `FoxgloveTransport` gives it the topics of a transport.

    Args:
        address: where it listens.
        name: shown to clients.
        definitions: message types.

    Raises:
        TransportError: foxglove-sdk is not installed, or the address cannot be used.
    """
    try:
        from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
    except ImportError as error:
        raise TransportError(f"Foxglove needs foxglove-sdk: {error}\n  pip install 'graphengine[foxglove]'") from None
    return FoxgloveServer(address, name, definitions)
