"""Typed instances and wires of one graph: the output of `resolve`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np

from graphengine.compiler.plan import Plan
from graphengine.compiler.subgraph_expansion import FlatGraph, NodeEntry, WireEntry
from graphengine.format.diagnostics import Finding, Span
from graphengine.format.errors import ContextError
from graphengine.node.node_class import Node
from graphengine.node.port import Port
from graphengine.node.types import PortType, UnionType, brief

T = TypeVar("T")


@dataclass(slots=True, eq=False)
class Instance:
    """A node of a resolved graph."""

    index: int
    id: str
    cls: type[Node]
    entry: NodeEntry
    literals: dict[str, Any] = field(default_factory=dict)
    """Values of inputs that the file or an override sets, by field."""
    refused: set[str] = field(default_factory=set)
    """Fields of inputs whose value was reported as wrong, so that they are not reported as missing too."""
    settled: dict[str, PortType] = field(default_factory=dict)
    """Types that ports of several types were resolved to, by field."""
    reads: tuple[str, ...] = ()
    """Keys of resources that the node reads besides its inputs; a variable has its name in the flat graph."""
    writes: tuple[str, ...] = ()
    """Keys of resources that the node changes besides its outputs."""
    part_of: str = ""
    """For a gate of `every:`, the id of the node that it belongs to."""

    def value(self, field: str) -> Any:
        """Return the value of an input before the first tick: the literal, or else the default."""
        return self.literals.get(field, self.cls.fields[field].default)

    def make_node(self) -> Node:
        """Make a node whose inputs have the values of the literals."""
        node = self.cls()
        for name, value in self.literals.items():
            setattr(node, name, value)
        node.settled = self.settled
        node.clear()
        return node

    @property
    def span(self) -> Span:
        """Place of the node's name in the file."""
        return self.entry.key_span()

    def refusal(self, error: ContextError) -> Finding:
        """Return a finding for an error in the node's setup, located at the input that caused the error."""
        _, place = self.asking(error.value)
        return Finding(error.code, f"{self.id}: {error.message}", place, error.help, self.entry.via)

    def literal_key(self, port: Port) -> str:
        """Return the key of an input in the file: its name, with the prefix `inputs:` if the file writes it so."""
        sided = f"inputs:{port.name}"
        return sided if sided in self.entry.spec.inputs else port.name

    def asking(self, value: object) -> tuple[str, Span]:
        """Return the field of the input whose literal is or contains `value`, and the position of that literal in the file.

        If no input matches, return an empty string and the position of the node.
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
    """A wire between two instances; `converter` is the function that converts its values, as in `types.CONVERTERS`."""

    source: int
    source_field: str
    target: int
    target_field: str
    converter: str
    entry: WireEntry
    order: int

    @property
    def ends(self) -> tuple[int, str, int, str]:
        """Source index, source field, target index and target field."""
        return self.source, self.source_field, self.target, self.target_field

    @property
    def span(self) -> Span:
        """Place of the wire in the file."""
        return self.entry.span

    def __str__(self) -> str:
        return f"{self.entry.source} -> {self.entry.target}"


@dataclass(slots=True, eq=False)
class Graph:
    """Typed instances and wires of one graph at a prim."""

    name: str
    prim_path: str
    flat: FlatGraph
    instances: list[Instance] = field(default_factory=list)
    data_wires: list[Wire] = field(default_factory=list)
    exec_wires: list[Wire] = field(default_factory=list)
    variables: dict[str, Any] = field(default_factory=dict)
    """Defaults of the graph's variables."""
    variable_types: dict[str, PortType] = field(default_factory=dict)
    left_open: dict[str, None] = field(default_factory=dict)
    """Ports, in order, that need a value and get none unless a graph uses this one as a subgraph."""
    plan: Plan = field(init=False)
    """Plan of the execution; missing for a graph with a cycle."""

    @property
    def runs(self) -> Literal["tick", "physics_step"]:
        """How often the graph runs: once per `tick` or once per `physics_step`."""
        return self.flat.spec.runs

    @property
    def declared_inputs(self) -> set[tuple[str, str]]:
        """Inner inputs behind the ports that this graph declares for its use as a subgraph, as node id and port name."""
        return {(end.node, end.port) for side, end in self.flat.declared if side == "inputs"}

    @property
    def wired_ports(self) -> set[tuple[str, str]]:
        """Target ports of all wires in the file, including wires with errors, as node id and port name."""
        return {(wire.target.node, wire.target.port) for wire in self.flat.wires}

    def note_accesses(self) -> None:
        """Set `reads` and `writes` of all instances; called after literals are set."""
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
        """Return the instance with this id."""
        return next(instance for instance in self.instances if instance.id == node_id)


def _key(key: str, variables: Mapping[str, str]) -> str:
    """Return a node's resource key; the key of a variable gets the variable's name in the flat graph."""
    kind, _, name = key.partition(":")
    return f"variable:{variables.get(name, name)}" if kind == "variable" else key


def visible(node_id: str, variables: Mapping[str, T]) -> Mapping[str, T]:
    """Return the variables that a node can use, by name; variables of its subgraph hide those of the graph around it."""
    parts = node_id.split("/")
    scopes = ["/".join(parts[:depth]) for depth in range(len(parts))]
    split = [(*name.rpartition("/")[::2], it) for name, it in variables.items()]
    return {name: it for scope in scopes for place, name, it in split if place == scope}


def find_port(cls: type[Node], name: str, sides: Iterable[str]) -> Port | None:
    """Return the port with an OmniGraph name, or None; `sides` are searched in their order."""
    return next((cls.ports[f"{side}:{name}"] for side in sides if f"{side}:{name}" in cls.ports), None)


def port_names(cls: type[Node], side: str) -> list[str]:
    """Return the OmniGraph names of a node type's ports on one side."""
    return [port.name for port in cls.fields.values() if port.side == side]


def known_type(instance: Instance, port: Port) -> PortType | None:
    """Return the type of a port, or None for a union that is not resolved yet."""
    settled = instance.settled.get(port.field)
    if settled is not None:
        return settled
    return port.type if isinstance(port.type, PortType) else None


def settled_type(instance: Instance, port: Port) -> PortType | UnionType:
    """Return the type of a port after resolution; a union if it could not be resolved."""
    return known_type(instance, port) or port.type


def with_article(port_type: PortType | UnionType) -> str:
    """Return the name of a type with its article, such as `a double` or `an int`."""
    name = brief(port_type)
    return f"{'an' if name[0] in 'aeio' else 'a'} {name}"
