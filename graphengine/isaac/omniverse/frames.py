"""Detects the frames that a script renders in loops; values that the script sets between frames are left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from graphengine.format.diagnostics import Findings, Span
from graphengine.isaac.recorded_graph import IMPULSE, RecordedValue

TURNS = 120
"""Number of turns after which a loop that runs while the application runs is ended."""

Loop = tuple[str, int]
"""A loop statement: its file and line."""
Part = tuple[str, str]
"""A node or variable, or a graph with an empty name: the prim path of the graph, and the name."""
Values = dict[str, RecordedValue]
"""Values of a node's attributes or of variables, by name."""
Call = tuple[str, int, int]
"""A call in the script: file, first line of the calling function, and offset of the bytecode instruction."""
Where = Callable[[str], Span | None]
"""Returns the position in the script of the current call, or of a given text within the call."""
Stack = Callable[[], tuple[Call, Sequence[Loop]]]
"""Returns the current call of the script, and the loops around it, innermost first."""


class Frames:
    """Tracks the frames that a script renders, and the values that the script sets on existing nodes between frames.

    Args:
        where: returns the current position in the script.
        stack: returns the current call and loops of the script.
        findings: receives a warning for each value that is set between frames.
    """

    def __init__(self, where: Where, stack: Stack, findings: Findings) -> None:
        self.where, self.stack, self.findings = where, stack, findings
        self.number = 0
        """Number of the current frame; a new frame begins when a rendering call is repeated."""
        self.over = False
        """Whether the application has ended from the script's point of view."""
        self.impulses: dict[Part, Span | None] = {}
        """Nodes to which the script sends impulses between frames, with the positions in the script."""
        self._drawing: set[Loop] = set()
        self._seen: set[Call] = set()
        """Rendering calls in the current frame."""
        self._asked: Counter[Call] = Counter()
        self._built: dict[Part, tuple[int, Sequence[Loop]]] = {}
        self._changes: dict[Loop, dict[tuple[Part, str], tuple[Values, RecordedValue | None, Span | None]]] = {}
        """Values first set in each loop, with the previous value and the position in the script."""

    def go_on(self) -> bool:
        """Return the answer to `is_running()`: True for the first `TURNS` calls, each of which renders a frame."""
        call, _ = self.stack()
        self._asked[call] += 1
        if self._asked[call] <= TURNS:
            self.draw()
        elif not self.over:
            self.over, self.number = True, self.number + 1
        return self._asked[call] <= TURNS

    def tire(self) -> bool:
        """Return whether a loop has repeated a query more than `TURNS` times, so that it evidently waits for another answer."""
        call, loops = self.stack()
        self._asked[call] += bool(loops)
        return self._asked[call] > TURNS

    def draw(self) -> None:
        """Record that the script renders a frame. At a loop's first frame, undo and report the values that the loop has set."""
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
        """Whether the script has rendered frames in a loop."""
        return bool(self._drawing)

    def build(self, part: Part) -> None:
        """Record that a graph, node or variable is created in the current frame."""
        self._built[part] = self.number, self.loops

    def pass_by(self, part: Part) -> bool:
        """Return whether frames were rendered since a part was created, so that the script simulates with this part."""
        number, around = self._built.get(part, (0, ()))
        if self.over:
            return number < self.number
        drawing = (loop for loop in self.loops if loop in self._drawing)
        return any(loop not in around or number < self.number for loop in drawing)

    def drive(self, part: Part, values: Values, name: str, hint: str) -> bool:
        """Return whether a value is set between frames. If so, it is reported, and the caller must not record the value."""
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
        what += "; the graph file keeps the previous value"
        self.findings.add("W302", what, place, "publish the value over ROS 2 at run time, or compute it in the graph")
