"""Detects simulation loops: counts the frames that a script renders in loops, and reports values that it sets between frames.

Such values belong to the running simulation, so the imported graph keeps the values from before the loop.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from graphengine.format.diagnostics import Findings, Span
from graphengine.isaac.recorded_graph import IMPULSE, RecordedValue

TURNS = 120
"""Number of times that a query such as `is_running()` is true at one position of the script; then it is false, to end loops."""

Loop = tuple[str, int]
"""A loop statement: its file and line."""
Part = tuple[str, str]
"""A node or variable as (prim path of its graph, name); a graph has an empty name."""
Values = dict[str, RecordedValue]
"""Values of the attributes of a node, or of the variables of a graph, by name."""
Call = tuple[str, int, int]
"""A call in the script: file, first line of the calling function, and offset of the call's bytecode instruction."""
Where = Callable[[str], Span | None]
"""Returns the span of the script's current call, or of the given string literal if the call contains it."""
Stack = Callable[[], tuple[Call, Sequence[Loop]]]
"""Returns the script's current call and the loops around this call, innermost first."""


class Frames:
    """Tracks the frames that a script renders in loops, and the values that the script sets between these frames.

    Args:
        where: returns the current position in the script.
        stack: returns the current call and loops of the script.
        findings: receives a warning for each value that is set between frames.
    """

    def __init__(self, where: Where, stack: Stack, findings: Findings) -> None:
        self.where, self.stack, self.findings = where, stack, findings
        self.number = 0
        """Number of the current frame; a new frame begins when a loop repeats a rendering call."""
        self.over = False
        """Whether `is_running()` has returned False, so that the application has ended for the script."""
        self.impulses: dict[Part, Span | None] = {}
        """Nodes whose impulse attribute the script sets between frames, each with the span of the first such call."""
        self._drawing: set[Loop] = set()
        self._seen: set[Call] = set()
        """Rendering calls that the script has made in the current frame."""
        self._asked: Counter[Call] = Counter()
        self._built: dict[Part, tuple[int, Sequence[Loop]]] = {}
        self._changes: dict[Loop, dict[tuple[Part, str], tuple[Values, RecordedValue | None, Span | None]]] = {}
        """Values that each loop has set without rendering a frame so far, each with the previous value and the span of the call.

        If the loop renders a frame later, `draw` restores the previous values.
        """

    def go_on(self) -> bool:
        """Return whether the application is to run on: True for the first `TURNS` executions of the current call, then False.

        Each execution that returns True also counts as rendering a frame.
        """
        call, _ = self.stack()
        self._asked[call] += 1
        if self._asked[call] <= TURNS:
            self.draw()
        elif not self.over:
            self.over, self.number = True, self.number + 1
        return self._asked[call] <= TURNS

    def tire(self) -> bool:
        """Count a call of the script that a loop uses as its condition.

        Returns:
            Whether the loop has made this call more than `TURNS` times. The call must then return False, so that the loop ends.
        """
        call, loops = self.stack()
        self._asked[call] += bool(loops)
        return self._asked[call] > TURNS

    def draw(self) -> None:
        """Record that the script renders a frame; at a loop's first frame, undo and report the values that the loop has set."""
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
        """The loops around the script's current call, innermost first."""
        return self.stack()[1]

    @property
    def drawn(self) -> bool:
        """Whether the script has rendered frames in a loop."""
        return bool(self._drawing)

    def build(self, part: Part) -> None:
        """Record the current frame and loops as those in which a graph, node or variable is created."""
        self._built[part] = self.number, self.loops

    def pass_by(self, part: Part) -> bool:
        """Return whether the script has rendered a frame since it created a part of the stage; the part is then simulated."""
        number, around = self._built.get(part, (0, ()))
        if self.over:
            return number < self.number
        drawing = (loop for loop in self.loops if loop in self._drawing)
        return any(loop not in around or number < self.number for loop in drawing)

    def drive(self, part: Part, values: Values, name: str, hint: str) -> bool:
        """Return whether the script sets a value between frames; if so, report it, and the caller must not record the value.

        Otherwise, note the change, so that `draw` can undo it if the loop renders a frame later.
        """
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
