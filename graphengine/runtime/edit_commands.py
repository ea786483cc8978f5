"""The commands that change the files of a session: they write values of inputs and positions of nodes, and undo this."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any

from pydantic import Field

from graphengine.compiler.port_texts import listed
from graphengine.format.errors import StateError, UsageError
from graphengine.format.wording import unknown
from graphengine.runtime.addresses import find_ports
from graphengine.runtime.command import Command, EntityName
from graphengine.runtime.session_core import SessionCore


class _Edit(Command):
    """Base class of the commands that change files of the session; they need a run with `--edit`."""

    @abstractmethod
    def _change(self, session: SessionCore) -> Any:
        """Change a file, and return the change."""

    def _apply(self, session: SessionCore) -> dict[str, str]:
        if not session.edits:
            raise StateError("the run may not change its files; start it with --edit")
        session.admit()
        return {"text": self._change(session).text}


class Save(_Edit):
    """Write the value of an unwired input into the file that sets it, and reload; return the change as one line, `text`."""

    address: EntityName
    """Address of the input, `[robot/][graph/]Node.port`."""
    value: Any = None
    """The value, written as in a graph file; None: the present value of the input."""
    preview: bool = False
    """Whether to return the change without writing it; this needs no permission."""

    def _apply(self, session: SessionCore) -> dict[str, str]:
        return {"text": self._proposed(session).text} if self.preview else super()._apply(session)

    def _change(self, session: SessionCore) -> Any:
        change = self._proposed(session)
        session.reloader.write(change)
        return change

    def _proposed(self, session: SessionCore) -> Any:
        (port, *others) = find_ports(session.graphs, self.address, ("inputs",))
        if others:
            raise UsageError(f"{self.address} could mean {1 + len(others)} inputs; write the whole address")
        return session.reloader.propose_value(port, listed(port.value) if self.value is None else self.value)


class Place(_Edit):
    """Write the position of a node in drawings into its graph file, and reload; return the change as one line, `text`."""

    graph: EntityName
    """Name of the graph; `robot/graph` for a graph of a robot."""
    node: EntityName
    """Name of the node in the file."""
    position: Annotated[tuple[float, float], Field(strict=False)]
    """Position of the node in the drawing, as in the key `layout`."""

    def _change(self, session: SessionCore) -> Any:
        found = next((run for run in session.graphs if run.name == self.graph), None)
        if found is None:
            raise UsageError(unknown("graph", self.graph, [run.name for run in session.graphs]))
        change = session.reloader.propose_position(found.executor.graph, self.node, self.position)
        session.reloader.write(change)
        return change


class Undo(_Edit):
    """Take back the newest change of `save` or `place`, and reload; return this change as one line, `text`."""

    def _change(self, session: SessionCore) -> Any:
        return session.reloader.undo()


class Redo(_Edit):
    """Write the change that `undo` took back last, and reload; return this change as one line, `text`."""

    def _change(self, session: SessionCore) -> Any:
        return session.reloader.redo()
