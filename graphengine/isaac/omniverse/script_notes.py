"""Findings on a script's actions that do not build graphs, and on values that only Omniverse knows."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from graphengine.format.diagnostics import Findings, Span
from graphengine.isaac.omniverse.frames import Frames, Stack, Where
from graphengine.isaac.omniverse.plain_data import UnknownError
from graphengine.isaac.omniverse.ros_writers import helper_node

MAX_CALLS = 20_000
"""Maximum number of calls that build nothing before the script is regarded as an endless simulation loop."""
MAX_FRAMES = 5_000
"""Maximum number of frames that a script renders before it is regarded as an endless loop."""
MAX_PASSED_OVER = 1000
"""Maximum number of reported actions that do not build graphs."""

Callback = Callable[..., Any]


class EndlessError(BaseException):
    """The script loops without end and is stopped. A BaseException, so that `except Exception` does not catch it."""


class ScriptNotes:
    """Base of the graph recorder that collects findings and queries during the run of a script.

    Args:
        where: returns the span of the script's current call.
        stack: returns the script's current call and the loops around it.
        assumed: whether objects that the script uses but did not create are assumed to exist.
    """

    def __init__(self, where: Where, stack: Stack, *, assumed: bool) -> None:
        self.where, self.assumed = where, assumed
        self.findings = Findings()
        self.frames = Frames(where, stack, self.findings)
        self.prims: set[str] = set()
        """Paths of created prims other than graphs and nodes, and all names that the user passes with `--assume`."""
        self.missed: dict[tuple[str, int], dict[str, str]] = {}
        """Names that the script queried without success, by file and line; each with the assumption in words, as in `holds`."""
        self.modules: dict[str, ModuleType] = {}
        """Stubs of the Omniverse modules that record calls, by name."""
        self.lacking: set[str] = set()
        """Names of the modules that the script imports but the importer cannot find."""
        self.starred: list[str] = []
        """Names of the stub modules from which the script imports `*`."""
        self.said: deque[str] = deque(maxlen=3)
        """The last three lines that the script printed or logged."""
        self.callbacks: list[Callback] = []
        """Functions of the script that it registers as callbacks, such as physics callbacks."""
        self.idle_calls = 0
        """Number of calls that built nothing."""
        self._told: set[str] = set()
        self._searches: list[tuple[str, Span]] = []
        """Unknown collections over which the script iterated since it last built a part of a graph, each with its span."""
        self._alike: dict[str, dict[Any, int]] = {}
        """Numbers of the distinct arguments of each stub, by name of the stub; they distinguish the results of its calls."""

    def idle(self) -> None:
        """Count a call that builds nothing; raise EndlessError if the script has made too many such calls or frames."""
        self.idle_calls += 1
        if self.idle_calls > MAX_CALLS or self.frames.number > MAX_FRAMES:
            raise EndlessError

    def draw(self) -> None:
        """Record that the script renders a frame, and count the call as one that builds nothing."""
        self.idle()
        self.frames.draw()

    def leave_out(self, message: str, hint: str = "", *help: str) -> None:
        """Warn that a part that the script builds is left out; the warning points to the string `hint` in the current call."""
        self.findings.add("W302", message, self.where(hint), *help)

    @contextmanager
    def leaving_out_unknown(self, what: str, hint: str, *help: str) -> Iterator[None]:
        """Return a context manager that catches UnknownError and warns that `what` is left out."""
        try:
            yield
        except UnknownError as error:
            self.leave_out(f"{what} is left out: {error}", hint, *help)

    def pass_over(self, what: str, *help: str) -> None:
        """Add a note that an action of the script does not build graphs; equal notes are added once."""
        if what not in self._told and len(self._told) < MAX_PASSED_OVER:
            self._told.add(what)
            self.findings.add("N302", f"{what} does not belong to a graph and is left out", self.where(""), *help)

    def lose_topic(self, writer: str, named: Mapping[str, Any]) -> None:
        """Warn that the topic of a ROS 2 writer is left out; `named` are the arguments that set its topic and namespace."""
        topic = "/".join(filter(None, (str(named.get(key, "")) for key in ("nodeNamespace", "topicName"))))
        topic = f"the topic {topic!r}" if topic else "the topic"
        advice = f"instead: {helper_node(writer)}, and its renderProductPath wired from IsaacCreateRenderProduct"
        self.leave_out(
            f"{topic} that the writer {writer} publishes is left out", str(named.get("topicName", "")), advice
        )

    def search(self, what: str) -> None:
        """Record that the script iterates over a collection that only Omniverse knows; `report_searches` may warn of it later."""
        place = self.where("")
        if place and (key := f"{place.source.path}:{place.line}") not in self._told:
            self._told.add(key)
            self._searches.append((what, place))

    def tell_apart(self, name: str, given: Any) -> str:
        """Return the name of a stub that a call or index returns, such as `f(#2)`; each distinct argument gets its own number."""
        known = self._alike.setdefault(name, {})
        number = known.setdefault(given, len(known) + 1)
        return name if number == 1 else f"{name[:-1]}#{number}{name[-1]}"

    def report_searches(self) -> None:
        """Warn of the recorded iterations, because the part that the script builds now may depend on their items."""
        for what, place in self._searches:
            lost = f"the script iterates over {what}, which is empty in an import: its work on the items is left out"
            self.findings.add("W302", lost, place)
        self._searches.clear()

    def holds(self, name: str, said: str = "it is true") -> bool:
        """Return whether `--assume` names a prim, file or condition; if not, record the query for a hint to `--assume`.

        Args:
            name: path, or name of a stub.
            said: the assumption in words, such as `the prim exists`.
        """
        if name not in self.prims and (place := self.where("")):
            self.missed.setdefault((place.source.path, place.line), {})[name] = said
        return name in self.prims
