"""A viewer of a page without a browser, and a scene in which something goes wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

import graphengine as ge

HOSTILE = "<img src=x onerror=raise()>"
LAB = f"""graph: lab
variables: {{elapsed: {{type: double, default: 0.5}}}}
nodes:
  Tick: OnPlaybackTick
  Write: {{type: omni.graph.core.WriteVariable, inputs: {{variableName: elapsed}}}}
  Nothing: Subtract
  Ratio: {{type: Divide, inputs: {{a: 1.0}}}}
  Idle: {{type: Add, inputs: {{a: 1.0, b: 2.0}}}}
  Say: {{type: ROS2Publisher, inputs: {{topicName: /ratio, messagePackage: std_msgs, messageName: Float64}}}}
  Text:
    type: ROS2Publisher
    inputs: {{topicName: /text, messagePackage: std_msgs, messageName: String, data: "{HOSTILE}"}}
connections:
  - Tick.tick -> Write.execIn
  - Tick.time -> Write.value
  - Tick.time -> Nothing.a
  - Tick.time -> Nothing.b
  - Nothing.difference -> Ratio.b
  - Ratio.result -> Say.data
  - Tick.tick -> Say.execIn
  - Tick.tick -> Text.execIn
"""
"""Divides by zero in each tick."""
SCENE = """scene: lab
world: worlds/flat_grid.xml
robots:
  dd100: {use: robots/dd100.yaml, position: [0.0, 0.0, 0.02]}
graphs:
  lab: {use: lab.yaml, at: /World/lab}
"""


def write_lab(folder: Path) -> Path:
    """The scene's file."""
    (folder / "lab.yaml").write_text(LAB, encoding="utf-8")
    path = folder / "scene.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def socket_of(url: str, path: str, tab: str = "tab") -> str:
    """The address of a WebSocket of the page with this URL, for the page in a tab."""
    base, _, token = url.partition("/#token=")
    return f"{base.replace('http', 'ws')}{path}?token={token}&tab={tab}"


class Viewer:
    """A browser of which only the feed is played."""

    def __init__(self, url: str) -> None:
        self.socket: ClientConnection = connect(
            socket_of(url, "/feed"),
            max_size=None,
            close_timeout=0.5,  # s; what was not read holds the closing up
        )
        self.url = url
        self.stage: Any = None
        self.frame: Any = None
        self.marks: Any = None
        self.told: dict[str, Any] = {}
        """The newest of each kind."""
        self._asked = 0

    def ask(self, **what: Any) -> None:
        """Send something."""
        self.socket.send(json.dumps(what))

    def until(self, condition: Callable[[Any], object]) -> Any:
        """Read until a frame fulfils a condition."""
        while self.frame is None or not condition(self.frame):
            self._read()
        return self.frame

    def wait(self, kind: str, condition: Callable[[Any], object] = lambda content: True) -> Any:
        """Read until something of a kind fulfils a condition."""
        while kind not in self.told or not condition(self.told[kind]):
            self._read()
        return self.told[kind]

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Ask for a command and wait for its answer."""
        self._asked += 1
        self.ask(ask="command", id=self._asked, command=name, arguments=arguments)
        return self.answer(self._asked)

    def answer(self, number: int) -> Any:
        """Wait for the answer to something that was asked with a number."""
        while True:
            told = self._read()
            if told.get("answer", {}).get("id") == number:
                return told["answer"]

    def next_frame(self) -> Any:
        """Wait for another frame."""
        self.frame = None
        return self.until(lambda frame: True)

    def _read(self) -> Any:
        told: dict[str, Any] = json.loads(self.socket.recv(timeout=60))
        self.told |= told
        self.marks = told.get("marks", {}).get("all", self.marks)
        self.stage, self.frame = told.get("stage", self.stage), told.get("frame", self.frame)
        self.marks = told.get("marks", {}).get("all", self.marks)
        return told


def viewed(sim: ge.Session, play: Callable[[Viewer], Any], **options: Any) -> Any:
    """Run a session in real time while a viewer plays; the result of the play."""
    url = sim.view(**options)
    with ThreadPoolExecutor(1) as pool:

        def play_and_leave() -> Any:
            viewer = Viewer(url)
            with viewer.socket:
                return play(viewer)

        played = pool.submit(play_and_leave)
        # One run: a pause that comes between two runs is undone by the second.
        sim.run(math.inf, rate=1.0, until=lambda _: played.done())
        return played.result()
