"""Finds ports and variables of running graphs.

A port has an address: `[robot/][graph/][subgraph/…]Node.[inputs:|outputs:|state:]port`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from graphengine.compiler.graph import settled_type
from graphengine.compiler.literals import ends_with, no_node, no_port
from graphengine.compiler.port_texts import with_article
from graphengine.format.errors import UsageError
from graphengine.format.wording import got_value, listing, shown, unknown
from graphengine.node import types
from graphengine.node.node_class import Node
from graphengine.node.port import Port, Side
from graphengine.runtime.executor import Executor
from graphengine.runtime.graph_run import GraphRun

SIDES: tuple[Side, ...] = ("outputs", "inputs", "state")
"""Order in which the sides of a node are searched for a port name without a side."""


@dataclass(frozen=True, slots=True)
class NodePort:
    """A port of a node in a running graph, whose value can be read and set."""

    address: str
    """Full address, such as `robot/graph/Node.port`; with the side if the search pattern had a side."""
    executor: Executor
    index: int
    port: Port

    @property
    def value(self) -> Any:
        """Current value of the port."""
        return getattr(self.executor.nodes[self.index], self.port.field)

    def put(self, value: Any) -> None:
        """Set the port, an unwired input, to a value that `convert` returned.

        Raises:
            GraphError: a node cannot be set up with the value. The port keeps its old value.
        """
        self.executor.set_input(self.index, self.port.field, value)

    def convert(self, value: Any, *, recorded: bool = False) -> Any:
        """Return a value converted to the type of the port, which must be an unwired input.

        All ways to set an input of a running graph call this method. The input's current value is legal.

        Args:
            value: value as in a graph file.
            recorded: whether the value comes from a recording; such a value may exceed the port's bounds.

        Raises:
            UsageError: the input is wired, or the value is not legal for the port.
        """
        graph = self.executor.graph
        for wire in graph.data_wires:
            if (wire.target, wire.target_field) == (self.index, self.port.field):
                raise UsageError(f"{self.address} is wired: {wire}\n  only unwired inputs can be set")
        converted = _converted(value, settled_type(graph.instances[self.index], self.port), self.address)
        tolerated = (recorded and self.port.is_bounded) or types.equal(converted, self.value)
        missing = "the input is required, expected a value" if self.port.is_missing(converted) else ""
        wrong = "" if tolerated else missing or self.port.refusal(converted)
        if wrong:
            unit = f" (unit: {self.port.unit})" if self.port.unit else ""
            raise UsageError(f"{self.address}: {wrong}{got_value(wrong, value)}{unit}")
        return converted


@dataclass(frozen=True, slots=True)
class GraphVariable:
    """A variable of a running graph."""

    run: GraphRun
    name: str

    @property
    def type(self) -> types.PortType:
        """Type of the variable."""
        return self.run.executor.graph.variable_types[self.name]

    @property
    def value(self) -> Any:
        """Current value of the variable."""
        return self.run.variables[self.name].value

    def convert(self, value: Any) -> Any:
        """Return a value converted to the type of the variable.

        Raises:
            UsageError: the value is not legal for the variable.
        """
        return _converted(value, self.type, f"variable {self.name} of {self.run.name}")

    def put(self, value: Any) -> None:
        """Set the variable to a value, which is converted to its type; call this only between two ticks.

        Raises:
            UsageError: the value is not legal for the variable.
        """
        self.run.variables[self.name].value = self.convert(value)
        self.run.executor.mark_stale()


def _converted(value: Any, wanted: types.PortType | types.UnionType, owner: str) -> Any:
    """Return a value converted to a type; raise UsageError, with the name `owner`, if the value is not legal for the type."""
    try:
        if isinstance(wanted, types.UnionType):
            return types.first_that_takes(value, wanted.alternatives)[1]
        return types.coerce(value, wanted)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{owner} is {with_article(wanted)}: {error}, got {shown(value)}") from None


def find_variable_at(runs: Iterable[GraphRun], graph: str, name: str) -> GraphVariable:
    """Return the variable `name` of the graph with the full name `graph`, such as `robot/graph`.

    Raises:
        UsageError: there is no such graph or variable.
    """
    named = {run.name: run for run in runs}
    if graph not in named:
        raise UsageError(unknown("graph", graph, named))
    variables = named[graph].variables
    if name not in variables:
        raise UsageError(f"{graph}: {unknown('variable', name, variables)}")
    return GraphVariable(named[graph], name)


def find_ports(runs: Iterable[GraphRun], pattern: str, sides: Sequence[Side] = SIDES) -> list[NodePort]:
    """Return the ports that match a pattern: the address of a port, or the last parts of an address, as globs.

    A pattern with the full path of a node matches only ports of this node. The pattern `*` matches all ports.

    Args:
        runs: running graphs to search.
        pattern: the pattern, such as `Node.port` or `robot/*/Node.outputs:port`.
        sides: sides on which ports are searched.

    Returns:
        At least one port.

    Raises:
        UsageError: no port matches.
    """
    path, _, name = ("*.*" if pattern == "*" else pattern).rpartition(".")
    nodes = list(_nodes(runs))
    whole = [node for node in nodes if node[0] == path]
    matching = whole or [node for node in nodes if ends_with(node[0], path)]
    found = [port for node in matching for port in _ports(*node, name, sides)]
    if found:
        return found
    if not matching:
        if not path:
            raise UsageError(f"{pattern!r} is no address; write NODE.PORT")
        raise UsageError(f"{pattern}: {no_node(path, [known for known, _, _ in nodes])}")
    classes = (type(executor.nodes[index]) for _, executor, index in matching)
    raise UsageError(f"{pattern}: {no_port(classes, name, sides)}")


def find_port_at(runs: Iterable[GraphRun], address: str) -> NodePort:
    """Return the only port that matches an address; leading parts of the address may be omitted.

    Raises:
        UsageError: no port or several ports match.
    """
    found = find_ports(runs, address)
    found = [port for port in found if port.address == address] or found
    if len(found) > 1:
        ports = listing([port.address for port in found], "write one of")
        raise UsageError(f"{address} could mean {len(found)} ports\n  {ports}")
    return found[0]


def _nodes(runs: Iterable[GraphRun]) -> Iterator[tuple[str, Executor, int]]:
    """Yield path, executor and index of each node of the graphs, except for gates that the compiler inserts for `every`."""
    for run in runs:
        for instance in run.executor.graph.instances:
            if not instance.part_of:
                yield f"{run.name}/{instance.id}", run.executor, instance.index


def _ports(path: str, executor: Executor, index: int, pattern: str, sides: Sequence[Side]) -> Iterator[NodePort]:
    """Yield the ports with values whose names match a pattern; of equal names, only the port on the first side."""
    cls: type[Node] = type(executor.nodes[index])
    side, colon, name = pattern.partition(":")
    given = bool(colon) and side in SIDES
    seen: set[str] = set()
    for wanted in sides:
        for port in cls.fields.values():
            if port.side != wanted or port.is_exec or port.bound_in_setup or (given and wanted != side):
                continue
            if fnmatchcase(port.name, name if given else pattern) and port.name not in seen:
                seen.add(port.name)
                yield NodePort(f"{path}.{f'{side}:' if given else ''}{port.name}", executor, index, port)
