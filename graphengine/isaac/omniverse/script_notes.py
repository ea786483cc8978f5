"""Notes on a script's actions other than building graphs, and on the unknown values that it uses."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from graphengine.format.diagnostics import Findings, Span
from graphengine.isaac.omniverse.frames import Frames, Stack, Where
from graphengine.isaac.omniverse.plain_data import UnknownError

MAX_CALLS = 20_000
"""Maximum number of calls that build nothing; with more, the script is regarded as an endless simulation loop."""
MAX_FRAMES = 5_000
"""Maximum number of frames that a script renders before it is regarded as an endless loop."""
MAX_PASSED_OVER = 1000
"""Maximum number of actions other than building graphs that are reported individually."""


class EndlessError(BaseException):
    """Ends a script that loops without end. Not an Exception, so that scripts do not catch it by mistake."""


class ScriptNotes:
    """Notes on the run of a script.

    Args:
        where: returns the current place in the script.
        stack: returns the current call of the script.
        assumed: whether to assume that objects exist which the script uses but did not create.
    """

    def __init__(self, where: Where, stack: Stack, *, assumed: bool) -> None:
        self.where, self.assumed = where, assumed
        self.findings = Findings()
        self.frames = Frames(where, stack, self.findings)
        self.prims: set[str] = set()
        """Paths of the prims other than graphs and nodes that the script created, and names that the user assumes to exist."""
        self.missed: dict[tuple[str, int], dict[str, str]] = {}
        """Names that the script queried and that do not exist, by file and line; each with the assumption that would help."""
        self.modules: dict[str, ModuleType] = {}
        """Stubs of the Omniverse modules that record calls, by name."""
        self.lacking: set[str] = set()
        """Names of the modules that the script imports and that are missing."""
        self.starred: list[str] = []
        """Names of the missing modules in `from MODULE import *`."""
        self.said: deque[str] = deque(maxlen=3)
        """The last lines that the script printed."""
        self.idle_calls = 0
        """Number of calls that built nothing."""
        self._told: set[str] = set()
        self._searches: list[tuple[str, Span]] = []
        """Items over which the script iterated since it last built a part of a graph, with the positions in the script."""
        self._alike: dict[str, dict[Any, int]] = {}
        """Numbers that distinguish calls of a stub with different arguments, by the name of the stub and by argument."""

    def idle(self) -> None:
        """Count a call that builds nothing, and end a script that repeats such calls without end."""
        self.idle_calls += 1
        if self.idle_calls > MAX_CALLS or self.frames.number > MAX_FRAMES:
            raise EndlessError

    def draw(self) -> None:
        """Render a frame, which builds nothing."""
        self.idle()
        self.frames.draw()

    def leave_out(self, message: str, hint: str = "", *help: str) -> None:
        """Warn that the graphs lack a part of what the script builds; `hint` is a text in the call, to locate the warning."""
        self.findings.add("W302", message, self.where(hint), *help)

    @contextmanager
    def leaving_out_unknown(self, what: str, hint: str, *help: str) -> Iterator[None]:
        """Return a context manager that turns an UnknownError into a warning that `what` is left out."""
        try:
            yield
        except UnknownError as error:
            self.leave_out(f"{what} is left out: {error}", hint, *help)

    def pass_over(self, what: str, *help: str) -> None:
        """Note, once per text, an action of the script that does not build graphs."""
        if what not in self._told and len(self._told) < MAX_PASSED_OVER:
            self._told.add(what)
            self.findings.add("N302", f"{what} does not belong to a graph and is left out", self.where(""), *help)

    def search(self, what: str) -> None:
        """Record that the script iterates over items that only Omniverse knows, so that graphs built next may be incomplete."""
        place = self.where("")
        if place and (key := f"{place.source.path}:{place.line}") not in self._told:
            self._told.add(key)
            self._searches.append((what, place))

    def tell_apart(self, name: str, given: Any) -> str:
        """Return a name for the result of a stub's call or index, such as `f(#2)`, that differs for different arguments."""
        known = self._alike.setdefault(name, {})
        number = known.setdefault(given, len(known) + 1)
        return name if number == 1 else f"{name[:-1]}#{number}{name[-1]}"

    def report_searches(self) -> None:
        """Warn of the recorded searches, because the part that the script builds now may depend on their results."""
        for what, place in self._searches:
            lost = f"the script iterates over {what}, which is empty in an import: its work on the items is left out"
            self.findings.add("W302", lost, place)
        self._searches.clear()

    def holds(self, name: str, said: str = "it is true") -> bool:
        """Return whether the user assumes that a prim or file exists, or that a stub is true."""
        if name not in self.prims and (place := self.where("")):
            self.missed.setdefault((place.source.path, place.line), {})[name] = said
        return name in self.prims
