"""The web page that shows and controls a session."""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Mapping
from typing import TYPE_CHECKING

from graphengine.api.topics import Publication
from graphengine.format.errors import UsageError
from graphengine.messages.names import join_namespaces

if TYPE_CHECKING:
    from graphengine.api.runner import Runner

EVERY = 0.1
"""Period of the commands of a viewer who drives, s of simulation."""
TWISTS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


class TwistPublisher:
    """Publishes the velocities that viewers command; a recording stores them like the messages of another program."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._driven: dict[str, Publication] = {}

    def topics(self) -> Mapping[str, str]:
        """Velocity topic of each robot, by the robot's name; robots without one are left out."""
        found: dict[str, str] = {}
        stage = self._runner.session.services.stage
        for prim in stage.prims("robot"):
            namespace = join_namespaces(stage.namespaces(prim.facts["base_link"]))
            own = [topic for topic in self._twists() if topic.startswith(f"/{namespace}/" if namespace else "/")]
            if own:
                found[prim.entity_name] = own[0]
        return found

    def _twists(self) -> dict[str, str]:
        """Message type of each topic on which a graph takes velocities."""
        found: dict[str, str] = {}
        for end in self._runner.network.subscriptions:
            if end.claim.message_type in TWISTS:
                found.setdefault(end.topic, end.claim.message_type)
        return found

    def drive(self, topic: str, twist: tuple[float, float, float] | None) -> None:
        """Publish a twist until the next call: forward and sideways, m/s, and turn, rad/s; None stops the robot."""
        if topic in self._driven:
            self._driven.pop(topic).close()
        x, y, turn = twist or (0.0, 0.0, 0.0)
        plain = {"linear": {"x": x, "y": y}, "angular": {"z": turn}}
        kind = self._twists().get(topic, TWISTS[0])
        message = {"twist": plain} if kind == TWISTS[1] else plain
        made = Publication(self._runner, topic, message, EVERY if twist is not None else None, kind)
        if twist is not None:
            self._driven[topic] = made


def missing_packages() -> list[str]:
    """Packages of the extra `view` that are not installed."""
    return [name for name in ("viser", "graphlay") if importlib.util.find_spec(name) is None]


def check_packages() -> None:
    """Raise UsageError if the extra `view` is not installed."""
    missing = missing_packages()
    if missing:
        raise UsageError(f"the page needs {' and '.join(missing)}\n  pip install 'graphengine[view]'")


def open_page(runner: Runner, host: str, port: int, *, read_only: bool) -> str:
    """Start the page of a session, or another one after its process was lost; return the address.

    Raises:
        UsageError: the extra `view` is not installed, or the address cannot be used.
    """
    if runner.feed is not None and not runner.feed.page.lost:
        return runner.feed.url
    check_packages()
    from graphengine.view.feed import Feed

    def lost(text: str) -> None:
        runner.options.log("warning", "", text)

    title = runner.scene.path.stem
    feed = Feed(runner.session, runner.desk, title, host, port, TwistPublisher(runner), lost, read_only=read_only)
    runner.show(feed)
    runner.session.open_page = functools.partial(open_page, runner, host, port, read_only=read_only)
    return feed.url
