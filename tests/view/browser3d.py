"""A browser of which only the 3D part is played: what it sends, in viser's messages."""

from __future__ import annotations

from typing import Any

import msgspec
from viser import _messages
from websockets.sync.client import ClientConnection, connect

from graphengine.devices.rotation import ORIGIN
from tests.view.harness import socket_of


class Browser3D:
    """A viewer of the 3D part.

    Args:
        url: of the page, with its token.
        tab: name of the tab that the viewer's page has.
    """

    def __init__(self, url: str, tab: str = "tab") -> None:
        self.socket: ClientConnection = connect(
            socket_of(url, "/3d", tab),
            subprotocols=["viser-v1.1.1"],  # type: ignore[list-item]
            max_size=None,
            close_timeout=0.5,  # s; what was not read holds the closing up
        )
        self.look((0.0, -5.0, 3.0), ORIGIN)

    def send(self, message: Any) -> None:
        """Send one of viser's messages."""
        self.socket.send(msgspec.msgpack.encode(message.as_serializable_dict()))

    def look(self, position: Any, look_at: Any) -> None:
        """Turn the camera."""
        turn, up = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
        self.send(_messages.ViewerCameraMessage(turn, position, 1.0, 0.01, 1000.0, 400, 600, look_at, up))

    def click(self, node: str) -> None:
        """Click on the first shape of a node."""
        self.send(_messages.SceneNodeClickMessage(node, 0, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.5, 0.5), None))

    def drag(self, phase: Any, to: tuple[float, float, float], grip: tuple[float, float, float] = ORIGIN) -> None:
        """Pull at a point of the first robot."""
        screen = (0.5, 0.5)
        pull = _messages.SceneNodeDragMessage(phase, "/robots/0", 0, grip, screen, to, screen, "left", "cmd/ctrl")
        self.send(pull)
