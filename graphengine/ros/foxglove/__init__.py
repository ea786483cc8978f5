"""Serves all topics of a run to Foxglove over WebSocket, in addition to any transport; uses Foxglove's SDK."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import Definitions

if TYPE_CHECKING:
    from graphengine.ros.foxglove.foxglove_server import FoxgloveServer

Address = tuple[str, int]
"""Host and port to listen on; port 0 selects a free port."""


def open_server(address: Address, name: str, definitions: Definitions) -> FoxgloveServer:
    """Start a server; `FoxgloveTransport` connects it with a transport's topics.

    Args:
        address: host and port to listen on.
        name: name of the run that clients show.
        definitions: message types.

    Raises:
        TransportError: foxglove-sdk is not installed, or the address cannot be used.
    """
    try:
        from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
    except ImportError as error:
        raise TransportError(f"Foxglove needs foxglove-sdk: {error}\n  pip install 'graphengine[foxglove]'") from None
    return FoxgloveServer(address, name, definitions)
