"""Classes for a resolved graph, the output of `resolve`: node instances with types and values, and wires between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np

from graphengine.compiler.plan import Plan
from graphengine.compiler.subgraph_expansion import FlatGraph, NodeEntry, WireEntry
from graphengine.format.diagnostics import Finding, Span
from graphengine.format.errors import ContextError
from graphengine.format.wording import similar
from graphengine.node.node_class import Node
from graphengine.node.port import Port
from graphengine.node.types import PortType, UnionType

T = TypeVar("T")


@dataclass(slots=True, eq=False)
class Instance:
    """A node of a resolved graph, with its type, the values of its inputs and its position in the file."""

    index: int
    id: str
    cls: type[Node]
    entry: NodeEntry
    literals: dict[str, Any] = field(default_factory=dict)
    """Values of inputs that the file or the command line sets, by field."""
    refused: set[str] = field(default_factory=set)
    """Fields of inputs with a reported error; a missing value of these inputs is not reported."""
    misnamed: Span | None = None
    """Position in the file of an unknown input name that resembles no input of the node type; None without such a name."""
    settled: dict[str, PortType] = field(default_factory=dict)
    """Resolved types of the union and `any` ports, by field."""
    reads: tuple[str, ...] = ()
    """Keys of the resources that the node reads besides its inputs, such as `variable:Instance/speed`."""
    writes: tuple[str, ...] = ()
    """Keys of the resources that the node changes besides its outputs, in the form of `reads`."""
    part_of: str = ""
    """For a gate of `every`: the id of the node for which the compiler inserted the gate; empty for other nodes."""

    def value(self, field: str) -> Any:
        """Return the value of an input before the first tick: its literal; without a literal, the default of the port."""
        return self.literals.get(field, self.cls.fields[field].default)

    def note_misnamed(self, name: str, at: Span) -> None:
        """Record that the file has a value or wire for an input `name` that does not exist.

        Inputs with similar names are then not reported as missing.
        """
        inputs = {port.name: port.field for port in self.cls.fields.values() if port.side == "inputs"}
        meant = [inputs[near] for near in similar(name, inputs)]
        self.refused.update(meant)
        self.misnamed = self.misnamed or (None if meant else at)

    def make_node(self) -> Node:
        """Return a new node whose inputs have the values of the literals."""
        node = self.cls()
        for name, value in self.literals.items():
            setattr(node, name, value)
        node.settled = self.settled
        node.clear()
        return node

    @property
    def span(self) -> Span:
        """Position of the node's name in the file."""
        return self.entry.key_span()

    def refusal(self, error: ContextError) -> Finding:
        """Return a finding for an error in the node's setup, at the position of the input that caused the error."""
        _, place = self.asking(error.value)
        return Finding(error.code, f"{self.id}: {error.message}", place, error.help, self.entry.via)

    def literal_key(self, port: Port) -> str:
        """Return the key of an input as the file writes it: the name of the port, with or without the prefix `inputs:`."""
        sided = f"inputs:{port.name}"
        return sided if sided in self.entry.spec.inputs else port.name

    def asking(self, value: object) -> tuple[str, Span]:
        """Return the field and position of the input whose value in the file is `value`, or is a list that contains `value`.

        If no input matches, return an empty string and the position of the node's name.
        """
        given = self.entry.spec.inputs
        for port in self.cls.fields.values():
            key = self.literal_key(port)
            if port.side != "inputs" or key not in given:
                continue
            held, literal = self.value(port.field), given[key]
            alike = not isinstance(value, np.ndarray) and (
                literal == value or (isinstance(held, str | tuple) and held == value)
            )
            if held is value or alike:
                return port.field, self.entry.span("inputs", key)
            if isinstance(literal, list) and isinstance(value, str | int) and value in literal:
                return port.field, self.entry.span("inputs", key, literal.index(value))
        return "", self.span


@dataclass(frozen=True, slots=True)
class Wire:
    """A wire between two instances; `converter` is the name of a function in `types.CONVERTERS` that converts the values.

    `order` is the position of the wire in the flat graph. An empty `converter` passes values on unchanged.
    """

    source: int
    source_field: str
    target: int
    target_field: str
    converter: str
    entry: WireEntry
    order: int

    @property
    def ends(self) -> tuple[int, str, int, str]:
        """Index of the source instance, field of its port, index of the target instance, field of its port."""
        return self.source, self.source_field, self.target, self.target_field

    @property
    def span(self) -> Span:
        """Position of the wire in the file."""
        return self.entry.span

    def __str__(self) -> str:
        return f"{self.entry.source} -> {self.entry.target}"


@dataclass(slots=True, eq=False)
class Graph:
    """A resolved graph: instances, wires and variables, and the prim path of the graph."""

    name: str
    prim_path: str
    flat: FlatGraph
    instances: list[Instance] = field(default_factory=list)
    data_wires: list[Wire] = field(default_factory=list)
    exec_wires: list[Wire] = field(default_factory=list)
    variables: dict[str, Any] = field(default_factory=dict)
    """Default values of the graph's variables, by name in the flat graph."""
    variable_types: dict[str, PortType] = field(default_factory=dict)
    left_open: dict[str, None] = field(default_factory=dict)
    """Inputs that need a value or type from the graph that uses this graph as a subgraph, each as `Node.port`."""
    plan: Plan = field(init=False)
    """Plan of the execution; the planner sets it, except for a graph with a cycle."""

    @property
    def runs(self) -> Literal["tick", "physics_step"]:
        """Whether the graph runs once per `tick` or once per `physics_step`."""
        return self.flat.spec.runs

    @property
    def declared_inputs(self) -> set[tuple[str, str]]:
        """Inputs of nodes that the graph file exposes as inputs of a subgraph, each as node id and port name."""
        return {(end.node, end.port) for side, end in self.flat.declared if side == "inputs"}

    @property
    def wired_ports(self) -> set[tuple[str, str]]:
        """Target ports of the wires in the file, each as node id and port name; wires with errors count too."""
        return {(wire.target.node, wire.target.port) for wire in self.flat.wires}

    def note_accesses(self) -> None:
        """Set `reads` and `writes` of all instances; the literals must be set before."""
        names = {name: name for name in self.variables}
        for instance in self.instances:
            if instance.cls.reads is Node.reads and instance.cls.writes is Node.writes:
                continue
            node, variables = instance.make_node(), visible(instance.id, names)
            instance.reads = tuple(_key(key, variables) for key in node.reads())
            instance.writes = tuple(_key(key, variables) for key in node.writes())

    def source(self, wire: Wire) -> tuple[Instance, Port]:
        """Return the instance and the port at which a wire begins."""
        instance = self.instances[wire.source]
        return instance, instance.cls.fields[wire.source_field]

    def target(self, wire: Wire) -> tuple[Instance, Port]:
        """Return the instance and the port at which a wire ends."""
        instance = self.instances[wire.target]
        return instance, instance.cls.fields[wire.target_field]

    def by_id(self, node_id: str) -> Instance:
        """Return the instance with an id, which must exist."""
        return next(instance for instance in self.instances if instance.id == node_id)


def _key(key: str, variables: Mapping[str, str]) -> str:
    """Return a resource key of a node in its final form: in `variable:NAME`, NAME is replaced by the name in the flat graph."""
    kind, _, name = key.partition(":")
    return f"variable:{variables.get(name, name)}" if kind == "variable" else key


def visible(node_id: str, variables: Mapping[str, T]) -> Mapping[str, T]:
    """Return a dict from names, as a node uses them, to the variables that the node can use.

    A variable of the node's own subgraph hides a variable of the same name in the graph around the subgraph.

    Args:
        node_id: id of the node in the flat graph.
        variables: all variables, by name in the flat graph.
    """
    parts = node_id.split("/")
    scopes = ["/".join(parts[:depth]) for depth in range(len(parts))]
    split = [(*name.rpartition("/")[::2], it) for name, it in variables.items()]
    return {name: it for scope in scopes for place, name, it in split if place == scope}


def find_port(cls: type[Node], name: str, sides: Iterable[str]) -> Port | None:
    """Return the port with an OmniGraph name; None if no side has it. `sides` are searched in the given order."""
    return next((cls.ports[f"{side}:{name}"] for side in sides if f"{side}:{name}" in cls.ports), None)


def port_names(cls: type[Node], side: str) -> list[str]:
    """Return the OmniGraph names of a node type's ports on one side, such as `inputs`."""
    return [port.name for port in cls.fields.values() if port.side == side]


def known_type(instance: Instance, port: Port) -> PortType | None:
    """Return the type of a port; None for a union port whose type is not resolved yet."""
    settled = instance.settled.get(port.field)
    if settled is not None:
        return settled
    return port.type if isinstance(port.type, PortType) else None


def settled_type(instance: Instance, port: Port) -> PortType | UnionType:
    """Return the type of a port after resolution; for a port whose type could not be resolved, the union."""
    return known_type(instance, port) or port.type
