"""The process of the page: `python -m graphengine.view.page_process FD HOST PORT`, started by `page_client.Page`.

It reads what the run tells from a socket that it was given, draws the 3D part, and passes the rest on to the viewers. It ends
when the socket does.
"""

from __future__ import annotations

import contextlib
import json
import signal
import sys
import threading
from collections.abc import Mapping
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from graphengine.format.errors import UsageError
from graphengine.view.page_server import PageServer, Viewer
from graphengine.view.scene3d import Scene3D
from graphengine.view.wire import Answer, LiveMarks, LiveScene, LiveState

WHAT = ("command", "look", "drive", "playback", "gone")
"""What viewers may ask."""


class PageProcess:
    """Passes on what a run tells and what viewers ask.

    Args:
        run: the other end.
        host: address of the page.
        port: port of the page; 0 takes a free one.
    """

    def __init__(self, run: Connection, host: str, port: int) -> None:
        self._run = run
        self._sending = threading.Lock()
        self._greeting: dict[str, str] = {}
        self.server = PageServer(host, port, self._ask, lambda: self._greeting)
        self._scene = Scene3D(self.server.viser.scene)
        self._lidar = self.server.viser.gui.add_checkbox("Lidar", True, hint="what lidars hit, coloured by distance")
        self._lidar.on_update(lambda _: self._tell_shown())

    def _tell_shown(self) -> None:
        layers = ["lidar"] if self._lidar.value else []
        self._tell({"viewer": -1, "ask": "show", "viewers": len(self.server.viewers), "layers": layers})

    def _ask(self, viewer: Viewer, message: Mapping[str, Any]) -> None:
        what = message.get("ask")
        if what in ("come", "gone"):
            self._tell_shown()
        if what in WHAT:
            self._tell({**message, "viewer": viewer.number})

    def _tell(self, what: Mapping[str, Any]) -> None:
        with self._sending, contextlib.suppress(OSError):  # which the thread that reads finds too
            self._run.send_bytes(json.dumps(what).encode())

    def serve(self) -> None:
        """Serve until the run ends."""
        self._tell({"url": self.server.url})
        try:
            while True:
                self._take(self._run.recv())
        except (EOFError, OSError):
            pass
        finally:
            self.server.close()

    def _take(self, told: object) -> None:
        if isinstance(told, LiveState):
            with self.server.viser.atomic():
                self._scene.move(told.poses)
                self._scene.scan(told.scans)
            self._show("frame", {"facts": told.facts, "values": told.values, "nodes": told.nodes})
        elif isinstance(told, LiveScene):
            self._show_stage(told)
        elif isinstance(told, LiveMarks):
            self._show("marks", {"all": told.marks})
        elif isinstance(told, Answer):
            self.server.answer(told.viewer, json.dumps({"answer": told.told}))

    def _show_stage(self, stage: LiveScene) -> None:
        x, y, z = stage.focus
        camera = self.server.viser.initial_camera
        camera.position, camera.look_at = (x - 3.5, y - 3.5, z + 2.5), (x, y, z)
        self._scene.show(stage.bodies, stage.beams)
        graphs = [
            {"name": graph.name, "svg": graph.svg, "nodes": graph.nodes, "file": graph.file} for graph in stage.graphs
        ]
        self._show("stage", {"title": stage.title, "graphs": graphs, "drives": stage.drives})

    def _show(self, kind: str, content: Mapping[str, Any]) -> None:
        text = json.dumps({kind: content}, allow_nan=False, default=_plain)
        self._greeting[kind] = text
        self.server.broadcast(kind, text)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    return str(value)


def main() -> None:
    """Serve the page."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the run, whose end ends this process
    descriptor, host, port = sys.argv[1:]
    run = Connection(int(descriptor))
    try:
        process = PageProcess(run, host, int(port))
    except UsageError as error:
        run.send_bytes(json.dumps({"error": str(error)}).encode())
        return
    process.serve()


if __name__ == "__main__":
    main()
