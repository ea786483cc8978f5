"""Lists the values of a session that ROS 2 clients can read and set as parameters, with names, types and limits.

Parameters are the variables of graphs, and the inputs of nodes that are neither wired nor read in setup. Parameter names have
dots: `cmd_vel.DiffController.maxLinearSpeed` is an input of a node in the graph `cmd_vel`, and `cmd_vel.variables.speed` is a
variable of this graph. The name of a node in a subgraph follows the name of the subgraph: `arm.Left.Gain.value`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from graphengine.compiler.graph import Instance, known_type
from graphengine.compiler.port_texts import listed
from graphengine.format.errors import UsageError
from graphengine.format.wording import shown
from graphengine.messages.parameters import ARRAY_OF, ParameterType, parameter_message
from graphengine.node.port import Port
from graphengine.node.types import INTEGERS, POINTER, PortType, coerce, equal
from graphengine.runtime.addresses import SIDES, GraphVariable, NodePort
from graphengine.runtime.command import Command
from graphengine.runtime.commands import Assign, Rate, Set
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.session_core import SessionCore

FASTEST = 1e6
"""Largest legal value of the parameter `real_time_factor`; 0 means as fast as possible."""

_WITHOUT_PARAMETERS = ("target", "any", "bundle", "execution")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A value of a session, which can be read and, unless it is read-only, set between two ticks.

    Attributes:
        name: name with dots, unique on its ROS node.
        kind: port type of the value.
        read: function that returns the current value; thread-safe.
        command: function that checks a value and returns the command that sets it; raises UsageError if the value is not legal.
            None: the value is read-only.
        doc: description of the value.
        unit: unit of the value; empty if the value has no unit.
        limits: smallest and largest legal number; None if one of the two does not exist.
        constraint: description of the legal values; empty if every value of the type or within `limits` is legal.
    """

    name: str
    kind: PortType
    read: Callable[[], Any]
    command: Callable[[Any], Command] | None
    doc: str = ""
    unit: str = ""
    limits: tuple[float, float] | None = None
    constraint: str = ""

    @property
    def type(self) -> ParameterType:
        """ROS 2 parameter type of the value; a tuple such as double[3] has an array type."""
        scalar = ParameterType.STRING
        if self.kind.base == "bool":
            scalar = ParameterType.BOOL
        elif self.kind.is_number:
            scalar = ParameterType.INTEGER if self.kind.base in INTEGERS else ParameterType.DOUBLE
        return ParameterType(scalar + ARRAY_OF) if self.kind.array or self.kind.count > 1 else scalar

    def has(self, value: Any) -> bool:
        """Return whether the current value equals `value`."""
        return equal(self.read(), value)

    def message(self, value: Any) -> Any:
        """Return an rcl_interfaces/Parameter with the name and type of this parameter, and the given value."""
        return parameter_message(self.name, self.type, listed(value))

    def undo(self) -> Command:
        """Return the command that sets the parameter to its present value; the parameter must not be read-only."""
        assert self.command is not None
        return self.command(listed(self.read()))


USE_SIM_TIME = Parameter("use_sim_time", PortType("bool"), lambda: True, None, "message stamps are simulation time")
"""The parameter `use_sim_time`, always true and read-only; ROS 2 tools expect it on every node."""


def graph_parameters(runs: Iterable[GraphRun], robot: str = "") -> dict[str, Parameter]:
    """Return the parameters of a robot's graphs, by name; without a robot, of all graphs that belong to no robot."""
    above = f"{robot}/" if robot else ""
    found: dict[str, Parameter] = {}
    for run in runs:
        if run.name.startswith(above) and "/" not in run.name.removeprefix(above):
            graph = run.name.removeprefix(above)
            for parameter in (*_inputs(run, graph), *_variables(run, graph)):
                found.setdefault(parameter.name, parameter)
    return found


def session_parameters(session: SessionCore) -> dict[str, Parameter]:
    """Return the session's own parameter, the real-time factor, by name."""
    factor = Parameter(
        "real_time_factor",
        PortType("double"),
        lambda: session.pace or 0.0,
        _rate,
        "seconds of simulation per second of wall time; 0 for as fast as possible",
        constraint=f"0, or {SLOWEST:g} to {FASTEST:g}",
    )
    return {factor.name: factor}


def _rate(value: Any) -> Command:
    try:
        factor = coerce(value, PortType("double"))
    except (TypeError, ValueError) as error:
        raise UsageError(f"real_time_factor: {error}, got {shown(value)}") from None
    if factor != 0.0 and not SLOWEST <= factor <= FASTEST:
        raise UsageError(f"real_time_factor: expected 0, or {SLOWEST:g} to {FASTEST:g}, got {factor:g}")
    return Rate(factor=factor or None)


def _inputs(run: GraphRun, graph: str) -> Iterator[Parameter]:
    """Yield the parameters for inputs of a graph's nodes; `graph` is the first part of the parameters' names."""
    resolved = run.executor.graph
    wired = {(wire.target, wire.target_field) for wire in resolved.data_wires}
    for instance in resolved.instances:
        if instance.part_of:
            continue
        for port in instance.cls.fields.values():
            kind = _settable(instance, port)
            if kind is None or (instance.index, port.field) in wired:
                continue
            name = f"{graph}.{instance.id.replace('/', '.')}.{port.name}"
            at = NodePort(f"{run.name}/{instance.id}.{_addressed(port)}", run.executor, instance.index, port)
            limits = _limits(kind, port)
            unlimited = limits is None or port.tokens
            constraint = ", ".join(filter(None, (port.constraint, _length(kind)))) if unlimited else ""
            read = partial(getattr, run.executor.nodes[instance.index], port.field)
            yield Parameter(name, kind, read, partial(_set, at), port.doc, port.unit, limits, constraint)


def _addressed(port: Port) -> str:
    """Return the name of an input in an address, with the prefix `inputs:` if the name itself begins like a side."""
    return f"inputs:{port.name}" if port.name.partition(":")[0] in SIDES else port.name


def _settable(instance: Instance, port: Port) -> PortType | None:
    """Return the type of a port that can be a parameter while it is unwired; None for any other port."""
    if port.side != "inputs" or port.setup:
        return None
    kind = known_type(instance, port)
    return kind if kind is not None and is_representable(kind) else None


def is_representable(kind: PortType) -> bool:
    """Return whether a parameter can have values of a port type: scalars, tuples of scalars, or arrays of scalars."""
    return kind.base not in _WITHOUT_PARAMETERS and kind != POINTER and not (kind.array and kind.count > 1)


def _variables(run: GraphRun, graph: str) -> Iterator[Parameter]:
    """Yield the parameters for variables of a graph; `graph` is the first part of the parameters' names."""
    for path, kind in run.executor.graph.variable_types.items():
        if is_representable(kind):
            subgraph, _, variable = path.rpartition("/")
            name = ".".join((graph, *filter(None, subgraph.split("/")), "variables", variable))
            read, command = partial(getattr, run.variables[path], "value"), partial(_assign, GraphVariable(run, path))
            yield Parameter(name, kind, read, command, "variable of the graph", "", _limits(kind), _length(kind))


def _set(at: NodePort, value: Any) -> Command:
    at.convert(value)
    return Set(address=at.address, value=value)


def _assign(at: GraphVariable, value: Any) -> Command:
    at.convert(value)
    return Assign(graph=at.run.name, variable=at.name, value=value)


def _limits(kind: PortType, port: Port | None = None) -> tuple[float, float] | None:
    """Return the smallest and the largest legal value of a single number; None if the value has no such limits.

    An integer has the limits of its type and of int64, or narrower bounds of the port. The full range of int64 is no limit.
    A real number has limits only if the port has inclusive lower and upper bounds. Arrays and tuples have none.

    Args:
        kind: type of the value.
        port: input whose bounds apply; None for a variable.
    """
    if kind.array or kind.count > 1:
        return None
    low, high = (port.ge, port.le) if port is not None else (None, None)
    if kind.base in INTEGERS:
        first, last = INTEGERS[kind.base][0], min(INTEGERS[kind.base][1], 2**63 - 1)
        if port is not None:
            low = port.gt + 1 if port.gt is not None else low
            high = port.lt - 1 if port.lt is not None else high
        bounds = max(first, int(low) if low is not None else first), min(last, int(high) if high is not None else last)
        return None if bounds == (-(2**63), 2**63 - 1) else bounds
    if port is None or low is None or high is None or port.gt is not None or port.lt is not None:
        return None
    return low, high


def _length(kind: PortType) -> str:
    """Return the number of values of a tuple type as text, such as `3 values`; empty for other types."""
    if kind.count == 1:
        return ""
    return f"{kind.count} values: x, y, z, w" if kind.role == "quat" else f"{kind.count} values"
