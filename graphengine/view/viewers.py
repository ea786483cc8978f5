"""Executes the requests that viewers of a page send to a session."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import Any, Protocol

from graphengine.format.errors import GraphError, UsageError
from graphengine.runtime.command import Command
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.commands import parse
from graphengine.view.page_client import Page
from graphengine.view.wire import Answer

MAX_ASKED = 1000
"""Maximum number of waiting requests of viewers; if there are more, the oldest requests are discarded."""
DEAD_MAN = 0.5
"""Wall time without a request after which a driven robot is stopped and held keys are released, s."""


class Driver(Protocol):
    """Publishes the drive commands of viewers."""

    def topics(self) -> Mapping[str, str]:
        """Return the drive topics by robot name; robots without a drive topic are left out."""

    def drive(self, topic: str, twist: tuple[float, float, float] | None) -> None:
        """Publish a twist until the next call: forward and sideways speed (m/s) and turn rate (rad/s); None stops the robot."""


class RecordingControls(Protocol):
    """Controls of a recording that the page shows instead of a run.

    Attributes:
        folder: prefix to remove from the paths of files that were extracted from the recording.
    """

    folder: str

    def obey(self, asked: Mapping[str, Any]) -> None:
        """Execute a request of a viewer.

        Raises:
            UsageError: the request is invalid.
        """

    def facts(self) -> Mapping[str, Any]:
        """Return JSON values for the page's status: `recording`, and fields that replace fields of `RunStatus`."""

    def marks(self) -> Sequence[Mapping[str, Any]]:
        """Return the events of the recording that were found so far; the list only grows."""


class Viewers:
    """The viewers of a session's page, and their requests.

    Args:
        queue: queue for the commands of viewers.
        driver: publishes the drive commands of viewers.
        read_only: whether viewers can watch but not send commands.
        playback: controls of the recording that the page shows; None for a live run.

    Attributes:
        number: number of viewers.
        layers: shown layers of the 3D part.
        graphs: selected graph, by number of the viewer.
        newcomers: numbers of viewers to which their selected graph has not been sent yet.
        robots: selected robot, by number of the viewer.
        plots: plotted expressions, by number of the viewer.
        images: camera whose image is shown, and whether as depth, by number of the viewer.
        topics: selected topic, by number of the viewer; only viewers with an open topics pane, empty if none is selected.
    """

    def __init__(
        self, queue: CommandQueue, driver: Driver, *, read_only: bool, playback: RecordingControls | None = None
    ) -> None:
        self.number = 0
        self.layers: frozenset[str] = frozenset()
        self.graphs: dict[int, str] = {}
        self.newcomers: set[int] = set()
        self.robots: dict[int, str] = {}
        self.plots: dict[int, Sequence[str]] = {}
        self.images: dict[int, tuple[str, bool]] = {}
        self.topics: dict[int, str] = {}
        self._queue = queue
        self._driver = driver
        self._read_only = read_only
        self._playback = playback
        self._driven: dict[str, float] = {}
        """Wall time of the last drive command on each drive topic, s."""
        self._keys: dict[int, tuple[set[str], float]] = {}
        """Keys that each viewer holds, and the wall time of its last request for keys, s."""
        self._asked: deque[tuple[Mapping[str, Any], Command | UsageError | None]] = deque(maxlen=MAX_ASKED)
        """Waiting requests; each command together with its parsed form, or the error in it."""

    def ask(self, asked: Mapping[str, Any]) -> None:
        """Queue the request of a viewer; thread-safe. Parses a command here, because that may take longer than a tick."""
        parsed: Command | UsageError | None = None
        if asked.get("ask") == "command" and self._playback is None and not self._read_only:
            parsed = _parse(asked)
        self._asked.append((asked, parsed))

    @property
    def asked(self) -> bool:
        """Whether there are pending requests."""
        return bool(self._asked)

    @property
    def plotted(self) -> list[str]:
        """The expressions that viewers plot, each once."""
        return [*dict.fromkeys(text for texts in self.plots.values() for text in texts)] if self.plots else []

    def obey(self, page: Page, now: float) -> None:
        """Execute the waiting requests; stop driven robots that have received no drive command for `DEAD_MAN` s."""
        while self._asked:
            self._obey(page, *self._asked.popleft(), now)
        for topic, driven in list(self._driven.items()):
            if now - driven > DEAD_MAN:
                self._stop(topic)
        for viewer, (keys, held) in list(self._keys.items()):
            if keys and now - held > DEAD_MAN:
                self._drop_keys(viewer)

    def leave(self) -> None:
        """Stop all robots that viewers drive; called when the viewers are gone."""
        for topic in list(self._driven):
            self._stop(topic)
        for viewer in list(self._keys):
            self._drop_keys(viewer)

    def _obey(self, page: Page, asked: Mapping[str, Any], parsed: Command | UsageError | None, now: float) -> None:
        viewer, what = asked["viewer"], asked.get("ask")
        if what == "show":
            self.number, self.layers = asked["viewers"], frozenset(asked["layers"])
        elif what == "gone":
            for choices in (self.graphs, self.robots, self.topics, self.plots, self.images):
                choices.pop(viewer, None)
            self.newcomers.discard(viewer)
            self._drop_keys(viewer)
        elif what == "look":
            self.graphs[viewer] = _name(asked, "graph")
            self.newcomers.add(viewer)
        elif what == "select":
            self.robots[viewer] = _name(asked, "robot")
        elif what == "image":
            self.images.pop(viewer, None)
            if camera := _name(asked, "camera"):
                self.images[viewer] = camera, asked.get("depth") is True
        elif what == "plots":
            texts = asked.get("series")
            self.plots[viewer] = [text for text in texts if isinstance(text, str)] if isinstance(texts, list) else []
        elif what == "topics":
            self.topics.pop(viewer, None)
            if asked.get("open") is True:
                self.topics[viewer] = _name(asked, "topic")
        elif self._playback is not None:
            self._play(page, self._playback, asked)
        elif self._read_only:
            page.tell(
                Answer(viewer, {"id": asked.get("id"), "error": "this page is read-only: it cannot send commands"})
            )
        elif what == "drive":
            self._drive(page, asked, now)
        elif what == "keys":
            self._hold_keys(page, asked, now)
        elif parsed is not None:
            self._command(page, viewer, asked.get("id"), parsed)

    def _play(self, page: Page, playback: RecordingControls, asked: Mapping[str, Any]) -> None:
        try:
            if asked.get("ask") != "playback":
                raise UsageError("this page shows a recording, which cannot be changed")
            playback.obey(asked)
        except UsageError as error:
            page.tell(Answer(asked["viewer"], {"id": asked.get("id"), "error": str(error)}))

    def _command(self, page: Page, viewer: int, number: object, parsed: Command | UsageError) -> None:
        if isinstance(parsed, UsageError):
            page.tell(Answer(viewer, {"id": number, "error": str(parsed)}))
            return

        def answer(done: Future[Any]) -> None:
            error = done.exception() if not done.cancelled() else UsageError("the run has ended")
            told = {"error": str(error)} if error is not None else {"result": done.result()}
            page.tell(Answer(viewer, {"id": number, **told}))

        self._queue.ask(parsed.apply).add_done_callback(answer)

    def _drive(self, page: Page, asked: Mapping[str, Any], now: float) -> None:
        topic, twist = asked.get("topic"), asked.get("twist")
        if not isinstance(topic, str) or topic not in self._driver.topics().values():
            return
        if isinstance(twist, list) and len(twist) == 3 and all(type(x) in (int, float) and abs(x) < 1e3 for x in twist):
            try:
                self._driver.drive(topic, (float(twist[0]), float(twist[1]), float(twist[2])))
            except GraphError as error:
                page.tell(Answer(asked["viewer"], {"error": str(error)}))
            else:
                self._driven[topic] = now
        elif topic in self._driven:
            self._stop(topic)

    def _hold_keys(self, page: Page, asked: Mapping[str, Any], now: float) -> None:
        """Hold the keys that a viewer holds; a key that several viewers hold is released with the last of them."""
        viewer, down = asked["viewer"], asked.get("down")
        keys = {key for key in down if isinstance(key, str)} if isinstance(down, list) else set[str]()
        before = self._all_keys()
        self._keys[viewer] = keys, now
        try:
            self._change_keys(before)
        except UsageError as error:
            del self._keys[viewer]
            page.tell(Answer(viewer, {"error": str(error)}))

    def _all_keys(self) -> set[str]:
        return set[str]().union(*(keys for keys, _ in self._keys.values()))

    def _change_keys(self, before: set[str]) -> None:
        """Press and release the keys by which the held keys differ from those before."""
        now = self._all_keys()
        for name, keys in (("press", now - before), ("release", before - now)):
            if keys:
                self._queue.ask(parse(name, {"keys": sorted(keys)}).apply)

    def _drop_keys(self, viewer: int) -> None:
        before = self._all_keys()
        self._keys.pop(viewer, None)
        self._change_keys(before)

    def _stop(self, topic: str) -> None:
        del self._driven[topic]
        with contextlib.suppress(GraphError):  # the topic may have gone with its robot
            self._driver.drive(topic, None)


def _parse(asked: Mapping[str, Any]) -> Command | UsageError:
    """Return the command in a request, or the error in it."""
    name, arguments = asked.get("command"), asked.get("arguments", {})
    if not isinstance(name, str) or not isinstance(arguments, dict):
        return UsageError("a command request needs a `command` string and an `arguments` object")
    try:
        return parse(name, arguments)
    except UsageError as error:
        return error
    except RecursionError:
        return UsageError(f"{name[:40]}: the arguments are nested too deeply")


def _name(asked: Mapping[str, Any], what: str) -> str:
    name = asked.get(what)
    return name if isinstance(name, str) else ""
