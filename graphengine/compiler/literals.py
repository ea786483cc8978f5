"""Sets inputs to the values in the graph file and on the command line, and reports wrong and missing values."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from graphengine.compiler.graph import Graph, Instance, find_port
from graphengine.compiler.port_texts import brief, with_article
from graphengine.compiler.substitution import UNKNOWN
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import did_you_mean, got_value, listing, shown, unknown
from graphengine.node import types
from graphengine.node.node_class import Node
from graphengine.node.port import Port, Side
from graphengine.node.types import PortType, UnionType


@dataclass(slots=True)
class Override:
    """A value that the command line sets for inputs, as `[robot/][graph/]Node.port=value`; the left side can have globs."""

    text: str
    target: str
    port: str
    value: Any
    used: bool = False
    wired: str = ""
    """Address of a matching input that cannot be set because of its wire; empty without such an input."""

    @staticmethod
    def parse(text: str, value: Any) -> Override:
        """Return the override for a port, given as `Node.port`, `graph/Node.port` or `robot/graph/Node.port`."""
        target, _, port = text.rpartition(".")
        return Override(text, target, port.removeprefix("inputs:"), value)

    @staticmethod
    def parse_all(values: Mapping[str, Any]) -> list[Override]:
        """Return the overrides for a mapping from ports, in the forms that `parse` accepts, to values."""
        return [Override.parse(text, value) for text, value in values.items()]


def ends_with(path: str, pattern: str) -> bool:
    """Return whether a path such as `robot/graph/Node` ends with a pattern such as `graph/Node`, whose parts can be globs."""
    wanted = pattern.split("/")
    tail = path.split("/")[-len(wanted) :]
    return len(tail) == len(wanted) and all(map(fnmatch.fnmatchcase, tail, wanted))


def no_node(pattern: str, paths: Iterable[str]) -> str:
    """Return the message that a pattern matches no node, with a suggestion or a list from the paths of all nodes."""
    return unknown("node", pattern, (path if "/" in pattern else path.rpartition("/")[2] for path in paths))


def no_port(classes: Iterable[type[Node]], name: str, sides: Sequence[Side] = ("inputs",)) -> str:
    """Return the message that none of the node types has a port `name` on the given sides, with a suggestion or a list."""
    types_ = list(dict.fromkeys(classes))
    ports = [port for cls in types_ for port in cls.fields.values() if port.side in sides and not port.is_exec]
    who = f"{types_[0].__name__} has" if len(types_) == 1 else "the nodes that it matches have"
    what, many = ("input", "inputs") if list(sides) == ["inputs"] else ("port with a value", "ports")
    names = dict.fromkeys(port.name for port in ports)
    return f"{who} no {what} {name!r}\n  {did_you_mean(name.rpartition(':')[2], names) or listing(names, many)}"


def set_literals(graph: Graph, findings: Findings, *, recorded: bool = False) -> None:
    """Set the inputs of all instances to the values in the graph file; wrong names and values are added to `findings`.

    With `recorded`, i.e. for files of a recording, values out of range are also set, with a warning.
    """
    for instance in graph.instances:
        entry, cls = instance.entry, instance.cls
        for name, value in entry.spec.inputs.items():
            port = find_port(cls, name.removeprefix("inputs:"), ["inputs"])
            if port is None:
                outputs = find_port(cls, name.removeprefix("outputs:"), ["outputs"])
                inputs = [p.name for p in cls.fields.values() if p.side == "inputs" and not p.is_exec]
                code, message = "G204", f"{cls.__name__} has no input {name!r}"
                if outputs:
                    code, message = "G205", f"{name!r} is an output of {cls.__name__}"
                hint = findings.guess(name, inputs) or listing(inputs, "inputs")
                findings.add(code, message, entry.key_span("inputs", name), hint, related=entry.via)
                instance.note_misnamed(name, entry.key_span("inputs", name))
            elif port.is_exec:
                message = f"{name!r} is an execution input and cannot have a value"
                remedy = "remove the value, and connect a wire"
                findings.add("G211", message, entry.key_span("inputs", name), remedy, related=entry.via)
            else:
                _set_literal(instance, port, value, partial(entry.span, "inputs", name), findings, recorded=recorded)


def _set_literal(
    instance: Instance,
    port: Port,
    value: Any,
    at: Callable[..., Span],
    findings: Findings,
    given_by: str = "",
    *,
    recorded: bool = False,
) -> None:
    """Set an input to a value from the graph file or from the command line; errors are added to `findings`.

    Args:
        instance: node that has the input.
        port: the input.
        value: value as in a graph file; for a union or `any` port, also a mapping with the keys `type` and `value`.
        at: function that returns the position of the value, or of the element at the keys or indices in its arguments.
        findings: receives the errors.
        given_by: help line that says where the value comes from; empty if it comes from the file.
        recorded: whether the value comes from a recording; then a value out of range is set too, with a warning.
    """
    instance.refused.add(port.field)
    if value is UNKNOWN:
        return
    wanted = port.type
    if _is_open(port.type) and isinstance(value, dict) and set(value) == {"type", "value"}:
        try:
            wanted = _alternative(types.parse(str(value["type"])), port.type)
        except ValueError as error:
            near = findings.guess(str(value["type"]), map(str, _alternatives(port.type) or _PLAIN_TYPES))
            message = f"{instance.id}.{port.name}: {error}"
            findings.add("G212", message, at("type"), near, given_by, related=instance.entry.via)
            return
        value, at = value["value"], partial(at, "value")
    try:
        if _is_open(port.type):
            instance.settled[port.field], value = _typed(value, wanted)
        checked = port.check(value, recorded=recorded)
        if recorded and (illegal := port.refusal(checked)):
            message = f"{instance.id}.{port.name}: {illegal}{got_value(illegal, value)}{_unit(port)}"
            remedy = "the replay uses the value, as the run did; change it in your own files"
            findings.add("W109", message, at(), remedy, given_by, related=instance.entry.via)
    except TypeError as error:
        wrong, _, remedy = str(error).partition("; ")
        if isinstance(wanted, PortType) and wanted.array and isinstance(value, str | int | float):
            remedy = f"write [{value}]"
        which, got, place = " is", value, at()
        if (number := _wrong_element(wanted, value)) is not None:
            which, got, place = f"[{number}] of", value[number], at(number)
        message = f"{instance.id}.{port.name}{which} {with_article(wanted)}: {wrong}, got {shown(got)}"
        findings.add("G211", message, place, remedy, given_by, related=instance.entry.via)
    except ValueError as error:
        message = f"{instance.id}.{port.name}: {error}{got_value(error, value)}{_unit(port)}"
        near = findings.guess(str(value), port.tokens) if port.tokens else ""
        findings.add("G212", message, at(), near, given_by, related=instance.entry.via)
    else:
        instance.literals[port.field] = checked
        instance.refused.discard(port.field)


def _unit(port: Port) -> str:
    return f" (unit: {port.unit})" if port.unit else ""


def _wrong_element(port_type: PortType | UnionType, value: Any) -> int | None:
    """Return the index of the first list element that an array type refuses; None if all fit, or if the type is no array."""
    if not (isinstance(port_type, PortType) and port_type.array and isinstance(value, list)):
        return None
    return next((number for number, element in enumerate(value) if not _takes(port_type, [element])), None)


def _is_open(port_type: PortType | UnionType) -> bool:
    return isinstance(port_type, UnionType) or port_type == types.ANY


def _alternatives(port_type: PortType | UnionType) -> Sequence[PortType]:
    return port_type.alternatives if isinstance(port_type, UnionType) else ()


_TUPLES = tuple(PortType(base, count) for base in ("int", "double") for count in (2, 3, 4))
_PLAIN_TYPES = tuple(PortType(name) for name in ("bool", "int", "int64", "double", "token"))
_PLAIN_TYPES += (*_TUPLES, *(PortType(name, array=True) for name in ("int", "int64", "double", "token", "bool")))
"""Types that are tried in this order for a value without a type at an `any` port."""


def _typed(value: Any, wanted: PortType | UnionType) -> tuple[PortType, Any]:
    """Return the type of a literal, and its value converted to this type.

    The type is `wanted` if that is a single type; for a union or `any`, it is the first alternative that accepts the value.

    Raises:
        TypeError: `wanted`, or each of its alternatives, does not accept the value.
        ValueError: `wanted` is a single type, and the value is out of its range.
    """
    if isinstance(wanted, PortType) and wanted != types.ANY:
        return wanted, types.coerce(value, wanted)
    alternatives = _alternatives(wanted)
    try:
        return types.first_that_takes(value, alternatives or _PLAIN_TYPES)
    except TypeError:
        raise TypeError(_refusal(value, alternatives)) from None


def _refusal(value: Any, alternatives: Sequence[PortType]) -> str:
    """Return a message with the reason why no alternative of a union accepts a value, and the legal form."""
    how = "write {type: …, value: …}"
    if not alternatives:
        return f"its type is not clear; {how}"
    if isinstance(value, list | dict) or value is None:
        return f"none of these types fits; {how}"
    if any(_takes(alternative, [value]) for alternative in alternatives):
        return f"expected a list; write [{value}]"
    single = [alternative for alternative in alternatives if not alternative.array and alternative.count == 1]
    try:
        types.coerce(value, (single or alternatives)[-1])  # groups go from whole numbers to real ones to texts
    except (TypeError, ValueError) as error:
        return str(error)
    return how


def _takes(port_type: PortType, value: Any) -> bool:
    try:
        types.coerce(value, port_type)
    except (TypeError, ValueError):
        return False
    return True


def _alternative(named: PortType | UnionType, port_type: PortType | UnionType) -> PortType:
    """Return the alternative of a union that equals a type in the file; if none is equal, one that differs only in the role.

    An `any` port accepts the type itself.

    Raises:
        ValueError: the port does not accept the type.
    """
    named = _one_type(named, "value")
    if isinstance(port_type, PortType) or named in port_type.alternatives:
        return named
    for alternative in port_type.alternatives:
        if replace(alternative, role=named.role) == named:
            return alternative
    raise ValueError(f"expected one of {brief(port_type)}")


def _one_type(named: PortType | UnionType, what: str) -> PortType:
    """Return `named` if it is a single type whose values a file can contain, such as double or token.

    Args:
        named: type that the file names.
        what: noun for the error message: `value` or `variable`.

    Raises:
        ValueError: the type is a union or `any`, or has no values in files (execution, bundle).
    """
    if not isinstance(named, PortType) or named.base in ("any", "bundle", "execution"):
        raise ValueError(f"a {what} has a single type, such as double or token, got {brief(named)}")
    return named


def set_overrides(
    graph: Graph,
    instances: Sequence[Instance],
    overrides: Sequence[Override],
    findings: Findings,
    *,
    recorded: bool = False,
) -> None:
    """Set inputs of a graph's instances to values from the command line; set `used` of each override that matches an input.

    Args:
        graph: graph of the instances.
        instances: instances whose inputs may be set; an input with a wire is not set.
        overrides: values from the command line.
        findings: receives errors in the values.
        recorded: whether the values come from a recording; then values out of range are set too, with a warning.
    """
    wired = graph.wired_ports if overrides else ()
    for override in overrides:
        for instance in instances:
            path = f"{graph.name}/{instance.id}"
            if not ends_with(path, override.target):
                continue
            port = find_port(instance.cls, override.port, ["inputs"])
            if port is not None and not port.is_exec:
                override.used = True
                if (instance.id, port.name) in wired:
                    override.wired = f"{path}.{port.name}"
                    continue
                given_by = f"given by --set {override.text}"
                at = partial(_only, instance.span)
                _set_literal(instance, port, override.value, at, findings, given_by, recorded=recorded)


def _only(span: Span, *_: str) -> Span:
    """Return `span` for any element of a value: a value from the command line has the position of its node."""
    return span


def check_required(graph: Graph, findings: Findings) -> None:
    """Report required inputs that have neither a value nor a wire; add inputs that a subgraph exposes to `graph.left_open`."""
    wired, declared = graph.wired_ports, graph.declared_inputs
    for instance in graph.instances:
        groups: dict[str, list[Port]] = {}
        for port in instance.cls.fields.values():
            if port.side == "inputs" and port.required:
                groups.setdefault(port.field if port.required is True else str(port.required), []).append(port)
        for ports in groups.values():
            empty = [
                types.equal(instance.value(port.field), port.default)
                and not (port.default_counts and port.field in instance.literals)
                for port in ports
            ]
            told = any(port.field in instance.refused for port in ports)
            if told or not all(empty) or any((instance.id, port.name) in wired for port in ports):
                continue
            if any((instance.id, port.name) in declared for port in ports):
                graph.left_open |= dict.fromkeys(f"{instance.id}.{port.name}" for port in ports)
                continue
            names = " or ".join(repr(port.name) for port in ports)
            docs = "; ".join(f"{port.name}: {port.doc}" for port in ports if port.doc)
            message = f"{instance.id} needs its input {names}"
            remedy = "set it below `inputs:`, or wire it"
            cause = instance.misnamed
            findings.add("G208", message, instance.span, remedy, docs, related=instance.entry.via, cause=cause)


def set_variables(graph: Graph, findings: Findings) -> None:
    """Set the types and default values of the graph's variables; wrong types and defaults are added to `findings`."""
    for name, entry in graph.flat.variables.items():
        spec, at = entry.spec, partial(entry.document.span, "variables", entry.name)
        graph.variable_types[name], graph.variables[name] = types.ANY, None
        try:
            port_type = _one_type(types.parse(spec.type), "variable")
        except ValueError as error:
            hint = "types are double, int, string, vectord[3], …"
            findings.add("G211", f"variable {name!r}: {error}", at("type"), hint)
            continue
        graph.variable_types[name], graph.variables[name] = port_type, port_type.zero
        if spec.default is None:
            continue
        try:
            graph.variables[name] = types.coerce(spec.default, port_type)
        except (TypeError, ValueError) as error:
            wrong, _, remedy = str(error).partition("; ")
            message = f"variable {name!r} is {with_article(port_type)}: {wrong}{got_value(error, spec.default)}"
            findings.add("G211" if isinstance(error, TypeError) else "G212", message, at("default"), remedy)
