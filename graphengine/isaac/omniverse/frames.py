"""Frames that a script's loops render. Values that a script sets between frames are not part of its graphs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from graphengine.format.diagnostics import Findings, Span
from graphengine.isaac.recorded_graph import IMPULSE, RecordedValue

TURNS = 120
"""Of a loop that goes on while the application runs."""

Loop = tuple[str, int]
"""A loop statement: its file and line."""
Part = tuple[str, str]
"""A node or a variable: the path of its graph, and its name."""
Values = dict[str, RecordedValue]
"""Values of a part, by name; of a variable its own."""
Call = tuple[str, int, int]
"""A call: its file, the line at which its function begins, and the instruction."""
Where = Callable[[str], Span | None]
"""Returns the place in the script of the current call, or of a text in it."""
Stack = Callable[[], tuple[Call, Sequence[Loop]]]
"""Returns the current call of the script, and the loops that it is in, innermost first."""


class Frames:
    """Tracks the frames that a script renders, and values that it sets between them on parts it built before.

    Args:
        where: returns the current place in the script.
        stack: returns the current call and loops of the script.
        findings: receives the values that are set between frames.
    """

    def __init__(self, where: Where, stack: Stack, findings: Findings) -> None:
        self.where, self.stack, self.findings = where, stack, findings
        self.number = 0
        """Of the frame; a new one begins where a call that draws comes again."""
        self.over = False
        """Whether the application no longer runs."""
        self.impulses: dict[Part, Span | None] = {}
        """Nodes that get impulses while frames go by, and where."""
        self._drawing: set[Loop] = set()
        self._seen: set[Call] = set()
        """Calls that drew the current frame."""
        self._asked: Counter[Call] = Counter()
        self._built: dict[Part, tuple[int, Sequence[Loop]]] = {}
        self._changes: dict[Loop, dict[tuple[Part, str], tuple[Values, RecordedValue | None, Span | None]]] = {}
        """Values that were first set in a loop, what they were before, and where they were set."""

    def go_on(self) -> bool:
        """Return whether the application runs for another frame, and render it."""
        call, _ = self.stack()
        self._asked[call] += 1
        if self._asked[call] <= TURNS:
            self.draw()
        elif not self.over:
            self.over, self.number = True, self.number + 1
        return self._asked[call] <= TURNS

    def tire(self) -> bool:
        """Return whether a loop has repeated a query so often that it evidently waits for another result."""
        call, loops = self.stack()
        self._asked[call] += bool(loops)
        return self._asked[call] > TURNS

    def draw(self) -> None:
        """Render a frame. The first frame of a loop shows that the loop's earlier changes belong to frames; they are undone."""
        call, loops = self.stack()
        if not loops:
            return
        loop = loops[0]
        if loop not in self._drawing:
            self._drawing.add(loop)
            self._seen.clear()
        elif call in self._seen:
            self._seen.clear()
            self.number += 1
        self._seen.add(call)
        for (part, name), (values, before, place) in self._changes.pop(loop, {}).items():
            values.pop(name, None)
            if before is not None:
                values[name] = before
            self._tell(part, name, place)

    @property
    def loops(self) -> Sequence[Loop]:
        """The loops that the script is in, innermost first."""
        return self.stack()[1]

    @property
    def drawn(self) -> bool:
        """Whether a loop renders frames."""
        return bool(self._drawing)

    def build(self, part: Part) -> None:
        """Note that a part is built in the current frame."""
        self._built[part] = self.number, self.loops

    def pass_by(self, part: Part) -> bool:
        """Return whether frames were rendered since a part was built: the script simulates with it."""
        number, around = self._built.get(part, (0, ()))
        if self.over:
            return number < self.number
        drawing = (loop for loop in self.loops if loop in self._drawing)
        return any(loop not in around or number < self.number for loop in drawing)

    def drive(self, part: Part, values: Values, name: str, hint: str) -> bool:
        """Return whether a value is set between frames; it is reported, and the caller must leave it out."""
        if self.pass_by(part):
            self._tell(part, name, self.where(hint))
            return True
        _, around = self._built.get(part, (0, ()))
        for loop in self.loops:
            if loop not in around and (part, name) not in self._changes.setdefault(loop, {}):
                self._changes[loop][part, name] = values, values.get(name), self.where(hint)
        return False

    def _tell(self, part: Part, name: str, place: Span | None) -> None:
        if name == IMPULSE:
            self.impulses.setdefault(part, place)
            return
        what = f"the script sets {'/'.join(part)}{'' if part[1] == name else '.' + name} while it runs the simulation"
        what += "; the file keeps the value from before"
        self.findings.add("W302", what, place, "publish it over ROS 2 while the graph runs, or compute it in the graph")
