"""Opens the web page that shows and controls a session."""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graphengine.api.topics import Publication, Subscription
from graphengine.format.diagnostics import Finding
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError
from graphengine.messages.names import join_namespaces
from graphengine.scene.hot_reload import scene_of

if TYPE_CHECKING:
    from graphengine.api.runner import Runner
    from graphengine.runtime.session_core import SessionCore
    from graphengine.view.feed import Feed
    from graphengine.view.layer_data import FloorMap

EVERY = 0.1
"""Period of the velocity messages while a viewer drives a robot, s of simulation time."""
MAP_HEIGHTS, MAP_CELL = (0.2, 0.62), 0.05
"""Height range of obstacles and side of a cell for the page's occupancy map, m; `graphrun map` has the same defaults."""
TWISTS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


class TwistPublisher:
    """Publishes the velocities that viewers command. Recordings store these messages like messages of other programs."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._driven: dict[str, Publication] = {}

    def topics(self) -> Mapping[str, str]:
        """Return the velocity topic of each robot by robot name; robots without a velocity topic are left out."""
        found: dict[str, str] = {}
        stage = self._runner.session.services.stage
        for prim in stage.prims("robot"):
            namespace = join_namespaces(stage.namespaces(prim.facts["base_link"]))
            own = [topic for topic in self._twists() if topic.startswith(f"/{namespace}/" if namespace else "/")]
            if own:
                found[prim.entity_name] = own[0]
        return found

    def _twists(self) -> dict[str, str]:
        """Return the message type, Twist or TwistStamped, of each velocity topic that a graph subscribes to."""
        found: dict[str, str] = {}
        for end in self._runner.network.subscriptions:
            if end.claim.message_type in TWISTS:
                found.setdefault(end.topic, end.claim.message_type)
        return found

    def drive(self, topic: str, twist: tuple[float, float, float] | None) -> None:
        """Publish a twist periodically until the next call for the topic.

        Args:
            topic: velocity topic.
            twist: velocity forward and to the left, m/s, and turn rate, rad/s; None publishes a zero velocity once.
        """
        if topic in self._driven:
            self._driven.pop(topic).close()
        x, y, turn = twist or (0.0, 0.0, 0.0)
        plain = {"linear": {"x": x, "y": y}, "angular": {"z": turn}}
        kind = self._twists().get(topic, TWISTS[0])
        message = {"twist": plain} if kind == TWISTS[1] else plain
        made = Publication(self._runner, topic, message, EVERY if twist is not None else None, kind)
        if twist is not None:
            self._driven[topic] = made


def findings_of(session: SessionCore) -> Sequence[Finding | str]:
    """Return the findings of the session's files, and those of changed files that a reload rejected because of errors."""
    return [*session.findings, *scene_of(session).findings.sorted()]


def missing_packages() -> list[str]:
    """Return the names of packages that the web page needs (extra `view`) and that are not installed."""
    return [name for name in ("viser", "graphlay") if importlib.util.find_spec(name) is None]


def check_packages() -> None:
    """Raise UsageError if the extra `view` is not installed."""
    missing = missing_packages()
    if missing:
        raise UsageError(f"the web page needs {' and '.join(missing)}\n  {install_command('view')}")


def open_page(
    runner: Runner, host: str, port: int, *, read_only: bool, served: Callable[[str], None] | None = None
) -> Feed:
    """Return the feed of a session's web page; start the page first if no process serves it. Does not wait for the process.

    Args:
        runner: runner of the session.
        host: IP address on which to serve the page.
        port: TCP port of the page; 0 selects a free port.
        read_only: whether viewers can watch but not send commands.
        served: called with the address of a new page after the first tick at which the page can be opened.

    Raises:
        UsageError: the extra `view` is not installed.
    """
    if runner.feed is not None and not runner.feed.page.lost:
        return runner.feed
    check_packages()
    from graphengine.api.plot_values import PlotValues
    from graphengine.view.feed import Feed

    def listen(topic: str) -> Subscription[Any]:
        return Subscription(runner, topic, None, keep=1)

    feed = Feed(
        runner.session,
        runner.queue,
        runner.scene.path.stem,
        host,
        port,
        TwistPublisher(runner),
        functools.partial(runner.options.log, "warning", ""),
        make_floor=functools.partial(make_floor, runner.session),
        plots=PlotValues(runner.session, runner.scene.definitions, listen),
        listen=listen,
        findings=functools.partial(findings_of, runner.session),
        definitions=runner.scene.definitions,
        read_only=read_only,
        problems=runner.problems,
        served=served,
    )
    runner.show(feed)

    def again(waiting: bool) -> str:
        if waiting and feed.page.lost:
            raise UsageError(feed.page.failure)
        return open_page(runner, host, port, read_only=read_only, served=served).page.url

    runner.session.open_page = again
    return feed


def make_floor(session: SessionCore) -> FloorMap:
    """Return the occupancy map of a session's scene, made with the default arguments of `graphrun map`.

    Raises:
        UsageError: the session runs a graph without a scene, or no map can be made.
    """
    from graphengine.physics.occupancy.occupancy_map import MapRequest, make_map
    from graphengine.view.layer_data import FloorMap

    world = scene_of(session).world
    if world is None:
        raise UsageError("a graph without a scene has no map")
    made = make_map(world, MapRequest(MAP_HEIGHTS, MAP_CELL))
    return FloorMap(made.cells, (made.grid.west, made.grid.south), made.grid.cell)
