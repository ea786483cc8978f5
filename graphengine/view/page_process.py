"""The process of the page: `python -m graphengine.view.page_process FD HOST PORT TOKEN`, started by `page_client.Page`.

It reads the run's data from a socket that it inherits, draws the 3D part, and sends all other data to the viewers. It ends when
the socket closes.
"""

from __future__ import annotations

import contextlib
import json
import math
import secrets
import signal
import sys
import threading
import warnings
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from graphengine.drawing import svg
from graphengine.format.errors import UsageError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.runtime.log_lines import MOST_LINES
from graphengine.view.image_encoding import encoded_image
from graphengine.view.message_rows import message_rows
from graphengine.view.page_server import PageServer, Viewer, number_of
from graphengine.view.scene.scene3d import Scene3D
from graphengine.view.wire import (
    Answer,
    CameraImage,
    Ended,
    GraphDetails,
    LiveScene,
    LiveState,
    LogMessages,
    PaneContent,
    PlotSamples,
    TopicMessage,
)

WHAT = ("command", "look", "select", "topics", "drive", "image", "keys", "playback", "plots", "gone")
"""Kinds of viewers' requests that the process passes to the run."""
CAMERA = np.array([-2.5, -2.5, 1.8])
"""Initial position of a viewer's camera relative to the first robot, world axes, m."""
OF_SCENE = -1
"""Number in place of a viewer's number in requests from the 3D part."""


class PageProcess:
    """Passes data of a run to viewers, and requests of viewers to the run.

    Args:
        run: connection to the run.
        host: IP address on which to serve the page.
        port: TCP port of the page; 0 selects a free port.
        keep_token: whether runs on this port have the same token.
    """

    def __init__(self, run: Connection, host: str, port: int, keep_token: bool) -> None:
        self._run = run
        self._sending = threading.Lock()
        self._greeting: dict[str, str] = {}
        self._lines: dict[tuple[str, str, str], Mapping[str, Any]] = {}
        """The newest log messages, by severity, node and text."""
        self._definitions = DEFINITIONS
        self.server = PageServer(host, port, self._ask, self._greet, keep_token)
        self._scene = Scene3D(self.server.viser, self.server.tab_of, self._command, self._pick)
        self._greeting["run"] = _text({"run": secrets.token_hex(8)})
        self._greeting["layers"] = _text({"layers": self._scene.layers})

    def _greet(self) -> Mapping[str, str]:
        """Return the first messages for a new viewer."""
        return {**self._greeting, "log": _text({"log": [*self._lines.values()]})}

    def _keep(self, lines: Sequence[Mapping[str, Any]]) -> None:
        for line in lines:
            key = line["severity"], line["node"], line["text"]
            self._lines.pop(key, None)
            self._lines[key] = line
        for key in [*self._lines][: max(len(self._lines) - MOST_LINES, 0)]:
            del self._lines[key]

    def _tell_shown(self) -> None:
        layers = list(self._scene.shown)
        self._tell({"viewer": OF_SCENE, "ask": "show", "viewers": len(self.server.viewers), "layers": layers})

    def _command(self, tab: str, name: str, arguments: Mapping[str, Any]) -> None:
        """Send a command from the 3D part to the run."""
        for number in self.server.viewers_in(tab):
            self._tell({"viewer": number, "ask": "command", "command": name, "arguments": arguments})

    def _pick(self, tab: str, name: str) -> None:
        """Tell a viewer what was selected in its 3D part."""
        for number in self.server.viewers_in(tab):
            self.server.answer(number, _text({"picked": name}))

    def _ask(self, viewer: Viewer, message: Mapping[str, Any]) -> None:
        what = message.get("ask")
        if what == "gone" and not self.server.viewers_in(viewer.tab):
            self._scene.leave(viewer.tab)
        if what == "picture":
            self._scene.choices(viewer.tab).choose(message)
            self._scene.apply()
        if what in ("come", "gone", "picture"):
            self._tell_shown()
        if what == "select" and isinstance(name := message.get("robot"), str):
            self._scene.choices(viewer.tab).selected = name
        if what in WHAT:
            self._tell({**message, "viewer": viewer.number, "id": number_of(message)})

    def _tell(self, what: Mapping[str, Any]) -> None:
        # An OSError is found by the thread that reads too; the nesting of a request may be as deep as Python allows.
        with self._sending, contextlib.suppress(OSError, RecursionError):
            self._run.send_bytes(json.dumps(what).encode())

    def serve(self) -> None:
        """Serve the page until the run ends."""
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
                self._scene.update(told)
            notes = told.layers.notes
            frame = {
                "notes": notes,
                "facts": told.facts,
                "values": told.values,
                "nodes": told.nodes,
                "robots": told.robots,
            }
            self._show("frame", frame)
        elif isinstance(told, LiveScene):
            self._show_stage(told)
        elif isinstance(told, PaneContent):
            self._show(told.kind, told.content)
        elif isinstance(told, CameraImage):
            image = {"camera": told.camera, "error": told.error}
            if told.pixels is not None:
                image |= encoded_image(told.pixels)
            for viewer in told.viewers:
                self.server.tell(viewer, "image", _text({"image": image}))
        elif isinstance(told, LogMessages):
            self._keep(told.lines)
            self.server.answer_all(_text({"log": told.lines}))
        elif isinstance(told, PlotSamples):
            self.server.answer_all(_text({"samples": {"times": told.times, "values": told.values}}))
        elif isinstance(told, TopicMessage):
            self._show_message(told)
        elif isinstance(told, GraphDetails):
            graph = {"name": told.name, "svg": _draw(told), "nodes": told.nodes}
            self.server.answer(told.viewer, _text({"graph": graph}))
        elif isinstance(told, Answer):
            self.server.answer(told.viewer, _text({"answer": told.told}))
        elif isinstance(told, Ended):
            self.server.end(_text({"ended": {"error": told.error}}))

    def _show_stage(self, stage: LiveScene) -> None:
        camera, focus = self.server.viser.initial_camera, np.array(stage.focus)
        camera.position, camera.look_at = focus + CAMERA, focus
        self._scene.show(stage)
        self._definitions = stage.definitions
        shown = {"title": stage.title, "graphs": stage.graphs, "robots": stage.robots, "drives": stage.drives}
        self._show("stage", shown | {"topics": stage.topics, "objects": stage.objects, "keys": stage.keys})

    def _show(self, kind: str, content: Any) -> None:
        text = _text({kind: content})
        self._greeting[kind] = text
        self.server.broadcast(kind, text)

    def _show_message(self, told: TopicMessage) -> None:
        rows = message_rows(told.data, told.type, self._definitions) if told.data is not None else []
        message = {"topic": told.topic, "type": told.type, "size": told.size, "rows": rows}
        self.server.broadcast(f"message of {told.topic}", _text({"message": message}))


def _draw(graph: GraphDetails) -> str:
    """Return the drawing of a graph as SVG, like `graphrun show`; if drawing fails, an HTML paragraph with the reason."""
    try:
        if isinstance(graph.view, str):
            raise UsageError(graph.view)
        return svg.draw([graph.view], named=True)
    except UsageError as error:  # the graph is too large, or the layout library is missing
        return f"<p>{svg.escape(str(error))}</p>"


def _text(told: Mapping[str, Any]) -> str:
    try:
        return json.dumps(told, allow_nan=False, default=_plain)
    except ValueError:  # a command's result may hold numbers that JSON does not have
        return json.dumps(_finite(told), allow_nan=False)


def _finite(value: Any) -> Any:
    """Return the value with strings such as `nan` instead of numbers that are not finite, which JSON does not have."""
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {str(key): _finite(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    return value if value is None or isinstance(value, bool | int | str) else _finite(_plain(value))


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    return str(value)


def main() -> None:
    """Serve the page until the run ends; the arguments are the socket's file descriptor, host, port, and `keep` or `new`."""
    # A viewer may disconnect while the camera is set.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the run, whose end ends this process
    descriptor, host, port, token = sys.argv[1:]
    run = Connection(int(descriptor))
    try:
        process = PageProcess(run, host, int(port), token == "keep")
    except UsageError as error:
        run.send_bytes(json.dumps({"error": str(error)}).encode())
        return
    process.serve()


if __name__ == "__main__":
    main()
