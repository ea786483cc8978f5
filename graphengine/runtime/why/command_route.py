"""The way of a robot's commands through the graphs: from subscriptions and other sources to the nodes that command its joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graphengine.compiler.graph import Graph, Instance, Wire
from graphengine.devices.motion import CommandKind
from graphengine.devices.stage import Prim
from graphengine.format.prim_paths import at_or_below
from graphengine.messages.endpoints import EndpointClaim
from graphengine.node import types
from graphengine.node.port import Port
from graphengine.runtime.graph_run import GraphRun

COMMANDS: Mapping[CommandKind, str] = {
    "position": "positionCommand",
    "velocity": "velocityCommand",
    "effort": "effortCommand",
}
"""Name of the input with the commands of each kind, in the nodes that command joints."""


@dataclass(frozen=True, slots=True)
class CommandRoute:
    """One node that commands joints of a robot, with the nodes from which its commands come, in the order of execution."""

    run: GraphRun
    target: Instance
    wires: Sequence[Wire]
    """Data wires on the way to the commands of `target`."""

    @property
    def nodes(self) -> list[Instance]:
        """Nodes on the way in the order of execution; the last one is `target`."""
        graph = self.run.executor.graph
        indices = {self.target.index, *(wire.source for wire in self.wires)}
        return [graph.instances[index] for index in graph.plan.order if index in indices]

    def name(self, instance: Instance) -> str:
        """Return the name of a node with its graph, such as `dd100/cmd_vel/DiffController`."""
        return f"{self.run.name}/{instance.id}"

    def path(self, instance: Instance) -> str:
        """Return the prim path of a node."""
        return f"{self.run.executor.graph.prim_path}/{instance.id}"

    def endpoints(self, claims: Sequence[EndpointClaim]) -> list[EndpointClaim]:
        """Return those of the session's claims through which nodes of the route receive messages or requests."""
        paths = {self.path(instance) for instance in self.nodes}
        return [claim for claim in claims if claim.node in paths and claim.direction in ("subscribe", "serve")]

    def value(self, instance: Instance, field: str) -> Any:
        """Return the present value of a node's port."""
        return getattr(self.run.executor.nodes[instance.index], field, None)

    def port_text(self, instance: Instance, port: Port) -> str:
        """Return a node's port with its value and unit, such as `dd100/cmd_vel/DiffController.linearVelocity = 0.5 m/s`."""
        unit = f" {port.unit}" if port.unit else ""
        return f"{self.name(instance)}.{port.name} = {value_text(self.value(instance, port.field))}{unit}"

    def values(self) -> Iterator[str]:
        """Yield a text for each value on the way, in the order of execution."""
        for instance in self.nodes:
            fields = {wire.source_field: None for wire in self.wires if wire.source == instance.index}
            ports = [instance.cls.fields[field] for field in fields] or self.commands()
            yield from (self.port_text(instance, port) for port in ports)

    def commands(self) -> list[Port]:
        """Return the command inputs of `target` that have a value."""
        ports = [
            port for port in self.target.cls.fields.values() if port.name in COMMANDS.values() and port.side == "inputs"
        ]
        return [port for port in ports if np.size(self.value(self.target, port.field))]

    def commands_motion(self) -> bool:
        """Return whether a command of `target` is a velocity or effort other than 0, or a position."""
        ports = self.commands()
        return any(
            port.field == "position_command" or is_nonzero(self.value(self.target, port.field)) for port in ports
        )

    def first_stale(self) -> tuple[Wire, Instance] | None:
        """Return the first wire whose value has not reached its target, and the node that has not run since."""
        graph, nodes = self.run.executor.graph, self.run.executor.nodes
        ranks = {index: rank for rank, index in enumerate(graph.plan.order)}
        for wire in sorted(self.wires, key=lambda wire: ranks.get(wire.target, -1)):
            value = getattr(nodes[wire.source], wire.source_field)
            sent = types.CONVERTERS[wire.converter](value) if wire.converter else value
            if not types.equal(sent, getattr(nodes[wire.target], wire.target_field)):
                return wire, self._reader(graph.instances[wire.target])
        return None

    def _reader(self, instance: Instance) -> Instance:
        """Return the first node downstream that execution reaches, because a data node is computed only for its reader."""
        while instance.cls.kind() == "data":
            wire = next(wire for wire in self.wires if wire.source == instance.index)
            instance = self.run.executor.graph.instances[wire.target]
        return instance

    def first_zero(self) -> Instance | None:
        """Return the first node that gets a value other than 0 on the way and outputs only zeros; None without one."""
        for instance in self.nodes:
            into = [wire.target_field for wire in self.wires if wire.target == instance.index]
            out = [wire.source_field for wire in self.wires if wire.source == instance.index]
            gets, gives = (any(is_nonzero(self.value(instance, field)) for field in fields) for fields in (into, out))
            if out and gets and not gives:
                return instance
        return None

    def limits(self) -> Iterator[tuple[Instance, Port, Port]]:
        """Yield each node on the way with a limit and the input that exceeds it; both have the same unit."""
        for instance in self.nodes:
            into = {wire.target_field for wire in self.wires if wire.target == instance.index}
            ports = instance.cls.fields
            for limit in (port for name, port in ports.items() if name.startswith("max_") and port.unit):
                most = self.value(instance, limit.field)
                for port in (ports[field] for field in into if ports[field].unit == limit.unit):
                    if most and np.max(np.abs(self.value(instance, port.field)), initial=0.0) > most:
                        yield instance, limit, port


def routes_to(runs: Sequence[GraphRun], robot: Prim) -> list[CommandRoute]:
    """Return the routes to all nodes that command joints of a robot."""
    found = []
    for run in runs:
        graph = run.executor.graph
        for instance in graph.instances:
            context = run.contexts.of(instance.index)
            if context is None or not any(f"inputs:{name}" in instance.cls.ports for name in COMMANDS.values()):
                continue
            if any(at_or_below(prim.path, robot.path) for prim in context.asked.values()):
                found.append(CommandRoute(run, instance, _upstream(graph, instance.index)))
    return found


def _upstream(graph: Graph, target: int) -> list[Wire]:
    """Return the data wires through which values reach the command inputs of a node, without handles and times of events."""
    wires = [wire for wire in graph.data_wires if _carries_commands(*graph.source(wire))]
    found = [wire for wire in wires if wire.target == target and graph.target(wire)[1].name in COMMANDS.values()]
    seen = {target}
    for wire in found:  # grows while it is read
        if wire.source not in seen:
            seen.add(wire.source)
            found += [other for other in wires if other.target == wire.source]
    return found


def _carries_commands(source: Instance, port: Port) -> bool:
    return source.cls.kind() != "event" and str(port.type) != "uint64"


def is_nonzero(value: Any) -> bool:
    """Return whether a value has a number other than 0; NaN does not count."""
    try:
        numbers = np.asarray(value, float)
    except (TypeError, ValueError):
        return False
    return bool(np.any(np.nan_to_num(numbers)))


def number_text(value: float) -> str:
    """Return a number with four digits, and 0 for one that differs from 0 by rounding only."""
    return f"{value:.4g}" if not abs(value) < 1e-9 else "0"


def value_text(value: Any) -> str:
    """Return a value as short text, with numbers of four digits."""
    if isinstance(value, float | np.floating):
        return number_text(float(value))
    if isinstance(value, tuple | list | np.ndarray):
        parts = [value_text(part) for part in value[:8]]
        return f"({', '.join(parts)}{', ...' if len(value) > 8 else ''})"
    return str(value)[:100]
