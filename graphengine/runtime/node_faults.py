"""Handles the exceptions of nodes: drops a bad value, or explains and reports the exception."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import InitVar, dataclass
from typing import Any

from graphengine.compiler.graph import Graph
from graphengine.format.errors import BadValueError, NodeError
from graphengine.node.node_class import Node

FaultHandler = Callable[[NodeError], None]
"""Callback for an exception of a node, after which the run continues."""


@dataclass(eq=False)
class NodeFaults:
    """Handles the exceptions of the nodes of a graph.

    Args:
        graph: the graph.
        nodes: nodes of the graph, by index.
        now: function that returns the number and time (s) of the current tick, for error messages.
        fault: receives each exception of a node; None: an exception ends the run.
        dropped: called for a bad value from a wire, or set while the session ran, with the node's index, the error, and whether
            the value came from a wire; returns whether the value is dropped. None: `fault` receives these errors too.
        started: whether the session already runs; the values in the graph's files then count as set while the session ran.
    """

    graph: Graph
    nodes: Sequence[Node]
    now: Callable[[], tuple[int, float]]
    fault: FaultHandler | None = None
    dropped: Callable[[int, BadValueError, bool], bool] | None = None
    started: InitVar[bool] = False

    def __post_init__(self, started: bool) -> None:
        self.caught = (Exception,) if self.fault else (BadValueError,) if self.dropped else ()
        """Exceptions of nodes after which the pass continues."""
        self.wired = {(wire.target, wire.target_field) for wire in self.graph.data_wires}
        """Node index and field of each wired input."""
        self.set_later: set[int] = set(range(len(self.nodes))) if started else set()
        """Indices of the nodes with an input that was set in any way after the session started."""

    def end_branch(self, index: int, error: Exception) -> None:
        """Handle an exception after which the pass continues: drop a bad value, or report the exception to `fault`."""
        if not self.drop(index, error):
            self.report(index, error)

    def drop(self, index: int, error: Exception) -> bool:
        """Report a bad value to `dropped`, unless it comes from the files at the start; return whether the value is dropped.

        The result is False without `dropped`, for an exception that is not a BadValueError, and if all inputs in the error are
        unwired and no input of the node was set while the session ran.
        """
        if self.dropped is None or not isinstance(error, BadValueError):
            return False
        ports = [type(self.nodes[index]).ports.get(f"inputs:{name}") for name in error.port.split(", ")]
        wired = any(port is None or (index, port.field) in self.wired for port in ports)
        return (wired or index in self.set_later) and self.dropped(index, error, wired)

    def report(self, index: int, error: Exception) -> None:
        """Pass the explained exception to `fault`, or raise it if there is no `fault`."""
        explained = self.explain(index, error)
        explained.__cause__ = error
        if self.fault is None:
            raise explained
        self.fault(explained)

    def explain(self, index: int | None, error: Exception) -> NodeError:
        """Return a NodeError for an exception of a node, with the node's file position and inputs, and the tick.

        If `index` is None, the node is unknown.
        """
        tick, time = self.now()
        when = f"at tick {tick}, {time:.6g} s"
        if index is None:
            return NodeError(f"graph {self.graph.name}, {when}: {type(error).__name__}: {error}")
        instance = self.graph.instances[index]
        node = self.nodes[index]
        inputs = [p for p in type(node).fields.values() if p.side == "inputs" and not p.is_exec]
        shown = ", ".join(f"{p.name}={_short(getattr(node, p.field, None))}" for p in inputs)
        return NodeError(
            f"{instance.span}: node {instance.id} ({type(node).type_name}) raised {type(error).__name__}: {error}\n"
            f"  {when}, in graph {self.graph.name}\n"
            f"  inputs: {shown or 'none'}",
            f"{self.graph.prim_path}/{instance.id}",
        )


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
