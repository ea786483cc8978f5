"""Values of inputs: those of the file, those of the command line, those that are missing."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from graphengine import types
from graphengine.diagnostics import Findings, Span, did_you_mean, listing, shown
from graphengine.graph import Graph, Instance, declared_inputs, find_port, wired_ports, with_article
from graphengine.node import Port
from graphengine.parameters import UNKNOWN
from graphengine.types import PortType, UnionType, brief


@dataclass(slots=True)
class Override:
    """A value given on the command line: `[robot/][graph/]Node.port=value`, globs allowed."""

    text: str
    target: str
    port: str
    value: Any
    used: bool = False

    @staticmethod
    def parse(text: str, value: Any) -> Override:
        """Of `Node.port`, with as many outer names in front as wanted."""
        target, _, port = text.rpartition(".")
        return Override(text, target, port.removeprefix("inputs:"), value)

    @staticmethod
    def parse_all(values: Mapping[str, Any]) -> list[Override]:
        """Of values by what they are for."""
        return [Override.parse(text, value) for text, value in values.items()]

    def matches(self, path: str) -> bool:
        """Whether it means the node at `robot/graph/Node`."""
        wanted, parts = self.target.split("/"), path.split("/")
        tail = parts[-len(wanted) :]
        return len(tail) == len(wanted) and all(fnmatch.fnmatchcase(p, w) for p, w in zip(tail, wanted, strict=True))


def set_literals(graph: Graph, known: dict[str, Instance | None], findings: Findings) -> None:
    """Put the file's values into inputs."""
    for instance in graph.instances:
        entry, cls = instance.entry, instance.cls
        for name, value in entry.spec.inputs.items():
            port = find_port(cls, name.removeprefix("inputs:"), ["inputs"])
            if port is None:
                outputs = find_port(cls, name.removeprefix("outputs:"), ["outputs"])
                inputs = [p.name for p in cls.fields.values() if p.side == "inputs" and not p.is_exec]
                findings.add(
                    "G205" if outputs else "G204",
                    f"{name!r} is an output of {cls.__name__}" if outputs else f"{cls.__name__} has no input {name!r}",
                    entry.key_span("inputs", name),
                    did_you_mean(name, inputs) or listing(inputs, "inputs"),
                    related=entry.via,
                )
                meant = [p for p in cls.fields.values() if p.name in inputs and did_you_mean(name, [p.name])]
                instance.refused.update(p.field for p in meant)
            elif port.is_exec:
                findings.add(
                    "G211",
                    f"{name!r} carries execution and has no value",
                    entry.key_span("inputs", name),
                    "wire it",
                    related=entry.via,
                )
            else:
                _set_literal(instance, port, value, entry.span("inputs", name), findings)


def _set_literal(instance: Instance, port: Port, value: Any, span: Span, findings: Findings) -> None:
    """Put a value from the file, or from the command line, into an input."""
    if value is UNKNOWN:
        instance.refused.add(port.field)
        return
    try:
        if isinstance(port.type, UnionType) or port.type == types.ANY:
            port_type, value = _explicit(value, port.type)
            instance.settled[port.field] = port_type
        setattr(instance.node, port.field, port.check(value))
    except TypeError as error:
        instance.refused.add(port.field)
        wrong, _, remedy = str(error).partition("; ")
        if isinstance(port.type, PortType) and port.type.array and isinstance(value, str | int | float):
            remedy = f"write [{value}]"
        findings.add(
            "G211",
            f"{instance.id}.{port.name} is {with_article(port.type)}: {wrong}, got {shown(value)}",
            span,
            remedy,
            related=instance.entry.via,
        )
    except ValueError as error:
        instance.refused.add(port.field)
        unit = f" (unit: {port.unit})" if port.unit else ""
        given = "" if ", got " in str(error) else f", got {shown(value)}"
        findings.add(
            "G212",
            f"{instance.id}.{port.name}: {error}{given}{unit}",
            span,
            did_you_mean(str(value), port.tokens) if port.tokens else "",
            related=instance.entry.via,
        )
    else:
        instance.literals.add(port.field)
        instance.refused.discard(port.field)


_TUPLES = tuple(PortType(base, count) for base in ("int", "double") for count in (2, 3, 4))
_PLAIN_TYPES = tuple(PortType(name) for name in ("bool", "int", "int64", "double", "token"))
_PLAIN_TYPES += (*_TUPLES, *(PortType(name, array=True) for name in ("int", "int64", "double", "token", "bool")))
"""What a value is on a port that takes everything, where the file does not say it."""


def _explicit(value: Any, port_type: PortType | UnionType) -> tuple[PortType, Any]:
    """The type and value of a literal for a port of several types: `{type: double, value: 1}`, or the first that takes it."""
    alternatives = port_type.alternatives if isinstance(port_type, UnionType) else ()
    if isinstance(value, dict) and set(value) == {"type", "value"}:
        named = _alternative(types.parse(str(value["type"])), port_type)
        return named, types.coerce(value["value"], named)
    for alternative in alternatives or _PLAIN_TYPES:
        try:
            return alternative, types.coerce(value, alternative)
        except (TypeError, ValueError):
            continue
    raise TypeError(_refusal(value, alternatives))


def _refusal(value: Any, alternatives: Sequence[PortType]) -> str:
    """Why none of several types takes a value, and what to write."""
    how = "write {type: …, value: …}"
    if not alternatives:
        return f"its type is not clear; {how}"
    if isinstance(value, list | dict) or value is None:
        return f"none of these takes it; {how}"
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
    """What a port takes for a type that the file names; roles do not matter.

    Raises:
        ValueError: the port takes nothing of the kind.
    """
    if not isinstance(named, PortType) or named.base in ("any", "bundle", "execution"):
        raise ValueError(f"a value is of one type, such as double or token, and not {with_article(named)}")
    if isinstance(port_type, PortType) or named in port_type.alternatives:
        return named
    for alternative in port_type.alternatives:
        if replace(alternative, role=named.role) == named:
            return alternative
    raise ValueError(f"expected one of {brief(port_type)}")


def set_overrides(name: str, instances: Sequence[Instance], overrides: Sequence[Override], findings: Findings) -> None:
    """Put the command line's values into inputs of a graph's instances; those that match are marked as used."""
    for override in overrides:
        for instance in instances:
            if not override.matches(f"{name}/{instance.id}"):
                continue
            port = find_port(instance.cls, override.port, ["inputs"])
            if port is not None and not port.is_exec:
                override.used = True
                _set_literal(instance, port, override.value, instance.span, findings)


def check_required(graph: Graph, findings: Findings) -> None:
    """Tell of inputs that must have a value or a wire and have neither."""
    wired, declared = wired_ports(graph), declared_inputs(graph)
    for instance in graph.instances:
        groups: dict[str, list[Port]] = {}
        for port in instance.cls.fields.values():
            if port.side == "inputs" and port.required:
                groups.setdefault(port.field if port.required is True else str(port.required), []).append(port)
        for ports in groups.values():
            empty = [types.equal(getattr(instance.node, port.field), port.default) for port in ports]
            told = any(port.field in instance.refused for port in ports)
            if told or not all(empty) or any((instance.id, port.name) in wired for port in ports):
                continue
            if any((instance.id, port.name) in declared for port in ports):
                graph.left_open |= dict.fromkeys(f"{instance.id}.{port.name}" for port in ports)
                continue
            names = " or ".join(repr(port.name) for port in ports)
            docs = "; ".join(f"{port.name}: {port.doc}" for port in ports if port.doc)
            findings.add(
                "G208",
                f"{instance.id} needs its input {names}",
                instance.span,
                "set it below `inputs:`, or wire it",
                docs,
                related=instance.entry.via,
            )


def set_variables(graph: Graph, findings: Findings) -> None:
    """Give the graph's variables their defaults."""
    for name, entry in graph.flat.variables.items():
        spec, document = entry.spec, entry.document
        try:
            port_type = types.parse(spec.type)
            if isinstance(port_type, UnionType):
                raise ValueError(f"{spec.type!r} is not the type of a variable")
            graph.variable_types[name] = port_type
            graph.variables[name] = port_type.zero if spec.default is None else types.coerce(spec.default, port_type)
        except ValueError as error:
            span = document.span("variables", entry.name, "type")
            findings.add("G211", f"variable {name!r}: {error}", span, "types are double, int, string, vectord[3], …")
        except TypeError as error:
            span = document.span("variables", entry.name, "default")
            findings.add(
                "G211", f"variable {name!r} is {with_article(port_type)}: {error}, got {shown(spec.default)}", span
            )
