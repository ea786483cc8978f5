"""What a script does besides building graphs, and the unknown values that it uses."""

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
"""Calls that do nothing to graphs after which a script is taken to go on without end, as one that steps a simulation does."""
MAX_FRAMES = 5_000
"""That a script may draw until then."""
MAX_PASSED_OVER = 1000
"""Things besides graphs that are reported one by one."""


class EndlessError(BaseException):
    """Ends a script that loops without end; scripts should not catch it."""


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
        """Paths of prims that are no graphs or nodes and that the script made, and names that the user assumes."""
        self.missed: dict[tuple[str, int], dict[str, str]] = {}
        """What the script asked for in vain at each file and line, by name: what the user may say of it."""
        self.modules: dict[str, ModuleType] = {}
        """Modules of Omniverse that are known, by name."""
        self.lacking: set[str] = set()
        """Modules that the script imports and that are not there."""
        self.starred: list[str] = []
        """Modules that are not there and of which the script imports everything."""
        self.said: deque[str] = deque(maxlen=3)
        """Lines that the script printed last."""
        self.idle_calls = 0
        """Calls that did nothing to graphs."""
        self._told: set[str] = set()
        self._searches: list[tuple[str, Span]] = []
        """What the script looked through since it last made something, and where."""
        self._alike: dict[str, dict[Any, int]] = {}
        """Numbers of the arguments with which stubs were called, by the name that the results would share."""

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
        """Report a part that the graphs will lack."""
        self.findings.add("W302", message, self.where(hint), *help)

    @contextmanager
    def leaving_out_unknown(self, what: str, hint: str, *help: str) -> Iterator[None]:
        """Return a context that reports a part which is left out because only Omniverse knows its value."""
        try:
            yield
        except UnknownError as error:
            self.leave_out(f"{what} cannot be told: {error}", hint, *help)

    def pass_over(self, what: str, *help: str) -> None:
        """Report once an action of the script that does not build graphs."""
        if what not in self._told and len(self._told) < MAX_PASSED_OVER:
            self._told.add(what)
            self.findings.add("N302", f"{what} does not belong to a graph and is left out", self.where(""), *help)

    def search(self, what: str) -> None:
        """Note that the script iterates over items that only Omniverse knows; graphs it builds next may be incomplete."""
        place = self.where("")
        if place and (key := f"{place.source.path}:{place.line}") not in self._told:
            self._told.add(key)
            self._searches.append((what, place))

    def tell_apart(self, name: str, given: Any) -> str:
        """Return the name of the stub for a call or an item, numbered by its arguments."""
        known = self._alike.setdefault(name, {})
        number = known.setdefault(given, len(known) + 1)
        return name if number == 1 else f"{name[:-1]}#{number}{name[-1]}"

    def report_searches(self) -> None:
        """Report the searches on which the part that the script builds now may depend."""
        for what, place in self._searches:
            lost = f"the script looks through {what}, which is empty here: what it finds there is left out"
            self.findings.add("W302", lost, place)
        self._searches.clear()

    def holds(self, name: str, said: str = "it to be true") -> bool:
        """Return whether the user assumes that a prim or file exists, or that a stub is true."""
        if name not in self.prims and (place := self.where("")):
            self.missed.setdefault((place.source.path, place.line), {})[name] = said
        return name in self.prims
