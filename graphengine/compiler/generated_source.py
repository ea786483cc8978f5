"""Source code that the compiler generates, with the node of each line."""

from __future__ import annotations

import linecache
import re
import traceback
import weakref
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from types import CodeType

VARIABLE = re.compile(r"(?<![.\w])[a-z]\d+\w*")
"""Pattern of the name of a flag or of another generated variable."""


@dataclass(eq=False)
class GeneratedSource:
    """Generated source code, with the index of the node that each line runs."""

    name: str
    lines: list[str] = field(default_factory=list)
    nodes: list[int | None] = field(default_factory=list)

    def add(self, lines: Iterable[str], node: int | None = None, indent: int = 0) -> None:
        """Append lines of source code, and record that they run `node`; None if they run no node."""
        for line in lines:
            self.lines.append("    " * indent + line)
            self.nodes.append(node)

    def extend(self, other: GeneratedSource, indent: int = 0) -> None:
        """Append the lines of other source code, with their nodes."""
        self.lines += ["    " * indent + line for line in other.lines]
        self.nodes += other.nodes

    def variables(self) -> set[str]:
        """Return the names of the generated variables in the lines, such as `n3` and `f3_exec_out`."""
        return {name for line in self.lines for name in VARIABLE.findall(line)}

    @property
    def text(self) -> str:
        """The source code as one string."""
        return "\n".join(self.lines) + "\n"

    @cached_property
    def code(self) -> CodeType:
        """The compiled source; tracebacks show its lines as long as this object exists."""
        linecache.cache[self.name] = (len(self.text), None, self.text.splitlines(keepends=True), self.name)
        weakref.finalize(self, linecache.cache.pop, self.name, None)
        return compile(self.text, self.name, "exec")

    def node_of(self, error: BaseException) -> int | None:
        """Return the index of the node that the code ran when the exception was raised; None if it is unknown."""
        frames = traceback.walk_tb(error.__traceback__)
        lines = [line for frame, line in frames if frame.f_code.co_filename == self.name]
        return self.nodes[lines[-1] - 1] if lines and 1 <= lines[-1] <= len(self.nodes) else None
