"""Tells a page what happens in a session, and does in the session what viewers ask for."""

from __future__ import annotations

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.compiler.graph import Graph
from graphengine.devices.lidar import Lidar
from graphengine.devices.rotation import Pose
from graphengine.drawing import svg
from graphengine.drawing.view_model import make_graph_view
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.files import near
from graphengine.runtime.command_queue import Desk
from graphengine.runtime.profile import Profile
from graphengine.view.page_client import Page
from graphengine.view.wire import Answer, GraphDrawing, LiveScene, LiveState

if TYPE_CHECKING:
    from graphengine.runtime.graph_run import GraphRun
    from graphengine.runtime.session_core import SessionCore

PERIOD = 0.05
"""Seconds of wall time between two frames."""
MAX_ASKED = 1000
"""Messages of viewers that wait for the end of a tick; older ones are lost."""
MOST_ELEMENTS, LONGEST_TEXT = 8, 200
"""Of an array and of a text that are written out."""
DEAD_MAN = 0.5
"""Seconds of wall time after which a robot stops that no viewer drives any more."""


class Driver(Protocol):
    """Publishes the twists of viewers."""

    def topics(self) -> Mapping[str, str]:
        """The topic by which each robot is driven, by the robot's name; robots without one are left out."""

    def drive(self, topic: str, twist: tuple[float, float, float] | None) -> None:
        """Publish a twist until the next call: forward and sideways, m/s, and turn, rad/s; None stops the robot."""


class Feed:
    """Feeds a page from a session, in the thread of its ticks.

    Args:
        session: what is seen.
        desk: where commands of viewers are queued.
        title: name of the scene.
        host: address of the page.
        port: port of the page; 0 takes a free one.
        driver: publishes what viewers drive.
        lost: called once, if the page's process ends before `close`.
        read_only: whether viewers may only look.
    """

    def __init__(
        self,
        session: SessionCore,
        desk: Desk,
        title: str,
        host: str,
        port: int,
        driver: Driver,
        lost: Callable[[str], None],
        *,
        read_only: bool = False,
    ) -> None:
        self._session = session
        self._desk = desk
        self._title = title
        self._driver = driver
        self._lost: Callable[[str], None] | None = lost
        self._read_only = read_only
        self._driven: dict[str, float] = {}
        """When a viewer last drove on a topic, s of wall time."""
        self._asked: deque[Mapping[str, Any]] = deque(maxlen=MAX_ASKED)
        self._looked_at: dict[int, str] = {}
        """The graph that each viewer looks at."""
        self._viewers = 0
        self._layers: frozenset[str] = frozenset()
        self._lidars: dict[str, Lidar] = {}
        self._profile = Profile(every=1)
        self._observed: list[GraphRun] = []
        """Graphs whose nodes are timed."""
        self._counted: dict[str, tuple[int, int, float]] = {}
        self._next = 0.0
        self._shown: tuple[object, ...] = ()
        self._rate = _Rate()
        self.page = Page(host, port, self._asked.append)
        self.url = self.page.url

    def after_tick(self) -> None:
        """Do what viewers asked for, and tell the page if it is time to; call it after each tick, and while there are none."""
        now = time.monotonic()
        if self.page.lost:
            self._tell_loss()
            return
        while self._asked:
            self._obey(self._asked.popleft(), now)
        for topic, driven in list(self._driven.items()):
            if now - driven > DEAD_MAN:
                self._stop(topic)
        if self._viewers and now >= self._next and not self.page.busy:
            self._next = now + PERIOD
            poses = self._session.services.world.poses()
            self._tell_scene(len(poses))
            self.page.show(self._state(now, poses))

    def _tell_loss(self) -> None:
        """Tell once that the page's process has ended, and stop what viewers drove."""
        for topic in list(self._driven):
            self._stop(topic)
        if self._lost is not None:
            self._lost("the process of the page has ended; the run goes on\n  `graphrun ctl view` opens a new page")
            self._lost = None

    def close(self) -> None:
        """End the page."""
        self.page.close()

    # What viewers ask

    def _obey(self, asked: Mapping[str, Any], now: float) -> None:
        viewer, what = asked["viewer"], asked.get("ask")
        if what == "show":
            self._viewers, self._layers = asked["viewers"], frozenset(asked["layers"])
            if not self._viewers:
                self._profile.end()
        elif what == "gone":
            self._looked_at.pop(viewer, None)
        elif what == "look":
            self._looked_at[viewer] = str(asked.get("graph", ""))
        elif self._read_only:
            self.page.tell(Answer(viewer, {"id": asked.get("id"), "error": "this page is for looking only"}))
        elif what == "drive":
            self._obey_drive(asked, now)
        elif what == "command":
            self._command(viewer, asked)

    def _command(self, viewer: int, asked: Mapping[str, Any]) -> None:
        name, arguments = asked.get("command"), asked.get("arguments", {})
        try:
            if not isinstance(name, str) or not isinstance(arguments, dict):
                raise UsageError("write a command and its arguments")
            done = self._desk.submit(name, arguments)
        except UsageError as error:
            self.page.tell(Answer(viewer, {"id": asked.get("id"), "error": str(error)}))
            return

        def answer(done: Future[Any]) -> None:
            error = done.exception() if not done.cancelled() else UsageError("the run has ended")
            told = {"error": str(error)} if error is not None else {"result": done.result()}
            self.page.tell(Answer(viewer, {"id": asked.get("id"), **told}))

        done.add_done_callback(answer)

    def _obey_drive(self, asked: Mapping[str, Any], now: float) -> None:
        topic, twist = asked.get("topic"), asked.get("twist")
        if not isinstance(topic, str) or topic not in self._driver.topics().values():
            return
        if isinstance(twist, list) and len(twist) == 3 and all(type(x) in (int, float) and abs(x) < 1e3 for x in twist):
            try:
                self._driver.drive(topic, (float(twist[0]), float(twist[1]), float(twist[2])))
            except GraphError as error:
                self.page.tell(Answer(asked["viewer"], {"error": str(error)}))
            else:
                self._driven[topic] = now
        elif topic in self._driven:
            self._stop(topic)

    def _stop(self, topic: str) -> None:
        del self._driven[topic]
        with contextlib.suppress(GraphError):  # the topic may have gone with its robot
            self._driver.drive(topic, None)

    # What the page shows

    def _tell_scene(self, bodies: int) -> None:
        """Send the scene if it is another one than before: other graphs, or another number of bodies."""
        graphs, world = self._session.graphs, self._session.services.world
        present = (*map(id, graphs), bodies)
        if present == self._shown:
            return
        self._shown = present
        robots = list(self._session.services.stage.prims("robot"))
        prims = self._session.services.stage.prims("lidar")
        self._lidars = {prim.path: world.device(Lidar, prim) for prim in prims}
        beams = {path: lidar.directions.astype(np.float32) for path, lidar in self._lidars.items()}
        focus = world.entities.state(robots[0].entity_name).position if robots else (0.0, 0.0, 0.0)
        self.page.tell(
            LiveScene(
                self._title, world.bodies(), [_drawing(run) for run in graphs], self._driver.topics(), beams, focus
            )
        )

    def _state(self, now: float, poses: NDArray[np.float64]) -> LiveState:
        session = self._session
        clock = session.clock
        facts = {
            "time": clock.time,
            "tick": clock.frame,
            "state": session.state,
            "pace": session.pace,
            "rate": self._rate.of(now, session.ticks * clock.delta),
            "messages": getattr(session.services.network, "sent", 0),
            "dropped": len(session.services.dropped.ticks) if session.services.dropped else 0,
        }
        wanted = set(self._looked_at.values())
        runs = [run for run in session.graphs if run.name in wanted]
        values = {run.name: _values(run) for run in runs}
        return LiveState(facts, poses, self._scans(), values, self._nodes(runs))

    def _scans(self) -> Mapping[str, tuple[Pose, NDArray[np.float32]]]:
        if "lidar" not in self._layers:
            return {}
        world, stage = self._session.services.world, self._session.services.stage
        return {
            path: (world.frame(stage.find(path)).pose(), lidar.scan().ranges) for path, lidar in self._lidars.items()
        }

    def _nodes(self, runs: list[GraphRun]) -> Mapping[str, Mapping[str, tuple[int, int, float]]]:
        """How often nodes ran and fired since the last frame, and microseconds of a run."""
        if runs != self._observed:
            self._profile.end()
            self._observed = runs
        self._profile.begin_tick(self._session.ticks, runs)
        found: dict[str, dict[str, tuple[int, int, float]]] = {run.name: {} for run in runs}
        for node in self._profile.nodes():
            graph = next((name for name in found if node.path.startswith(f"{name}/")), None)
            if graph is None:
                continue
            runs_before, fired_before, seconds = self._counted.get(node.path, (0, 0, 0.0))
            self._counted[node.path] = node.runs, node.fired, node.seconds
            ran = node.runs - runs_before
            each = (node.seconds - seconds) / ran * 1e6 if ran else 0.0
            found[graph][node.path.removeprefix(f"{graph}/")] = ran, node.fired - fired_before, each
        return found


class _Rate:
    """Seconds of simulation in a second of wall time, over the last second."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, float]] = deque(maxlen=round(1.0 / PERIOD))

    def of(self, now: float, simulated: float) -> float:
        self._seen.append((now, simulated))
        (begun, first), elapsed = self._seen[0], now - self._seen[0][0]
        return (simulated - first) / elapsed if elapsed > 0.0 and begun < now else 0.0


def _drawing(run: GraphRun) -> GraphDrawing:
    graph = run.executor.graph
    try:
        drawing = svg.draw([make_graph_view(graph, Findings())], named=True)
    except UsageError as error:  # it is too large, or the layout library is missing
        drawing = f"<p>{svg.escape(str(error))}</p>"
    return GraphDrawing(run.name, drawing, _nodes_of(graph), str(graph.flat.loaded.document.path))


def _nodes_of(graph: Graph) -> dict[str, dict[str, Any]]:
    wired = {(wire.target, wire.target_field) for wire in (*graph.data_wires, *graph.exec_wires)}
    return {
        instance.id: {
            "type": instance.cls.type_name,
            "place": near(str(instance.span)),
            "ports": [
                {
                    "name": port.name,
                    "side": port.side,
                    "unit": port.unit,
                    "doc": port.doc,
                    "type": str(port.type),
                    "wired": (instance.index, port.field) in wired,
                }
                for port in instance.cls.fields.values()
                if not port.is_exec
            ],
        }
        for instance in graph.instances
        if not instance.part_of
    }


def _values(run: GraphRun) -> dict[str, Any]:
    """The values of all ports of a graph by `Node.side:port`."""
    found = {}
    for instance, node in zip(run.executor.graph.instances, run.executor.nodes, strict=True):
        if instance.part_of:
            continue
        for port in instance.cls.fields.values():
            if not port.is_exec:
                found[f"{instance.id}.{port.side}:{port.name}"] = _shown(getattr(node, port.field, None))
    return found


def _shown(value: Any) -> Any:
    """A number as it is, anything else as a short text: of a large array shape and range, of an object its class."""
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, int):
        return value
    if isinstance(value, str):
        return value[:LONGEST_TEXT]
    if isinstance(value, np.ndarray) and value.size > MOST_ELEMENTS and np.issubdtype(value.dtype, np.number):
        finite = value[np.isfinite(value)]
        return f"{value.shape} " + (f"{finite.min():.4g} to {finite.max():.4g}" if finite.size else "not finite")
    if isinstance(value, tuple | list | np.ndarray):
        parts = [f"{part:.4g}" if isinstance(part, float) else str(_shown(part)) for part in value[:MOST_ELEMENTS]]
        return "(" + ", ".join(parts) + (", …)" if len(value) > MOST_ELEMENTS else ")")
    return type(value).__name__
