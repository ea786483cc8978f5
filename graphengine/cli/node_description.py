"""Describes a node type as text: its documentation, ports, defaults and legal values."""

from __future__ import annotations

import inspect
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import fitted_table, fitted_text, table

if TYPE_CHECKING:
    from graphengine.node.node_class import Node
    from graphengine.node.port import Port

Constants = Sequence[tuple[str, str, Any]]
"""Name, ROS type and value of each constant of a message type."""

LONG = 4
"""Maximum length of a list of port types, or of a default with equal values, that is printed in full."""


def summary(cls: type[Node]) -> str:
    """Return the first line of a node class's docstring."""
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def describe(cls: type[Node], constants: Constants = ()) -> str:
    """Return the description of a node type as text, with all ports, constants and other names."""
    parts = [f"{cls.type_name}  ({cls.kind()})", "", fitted_text(inspect.getdoc(cls) or "")]
    for side in ("inputs", "outputs"):
        ports = [port for port in cls.fields.values() if port.side == side]
        rows = [_row(cls, port) for port in sorted(ports, key=lambda port: not port.is_exec)]
        if rows:
            parts += ["", side, fitted_table(rows, 4, indent="  ")]
    if constants:
        rows = [(name, kind, json.dumps(value)) for name, kind, value in constants]
        parts += ["", "constants", table(rows, indent="  ")]
    if any(len(_kinds(port)) > LONG for port in cls.fields.values()):
        parts += ["", f"all types of a port: graphrun nodes {cls.type_name} --format json"]
    if cls.aliases:
        parts += ["", f"also called: {', '.join(cls.aliases)}"]
    return "\n".join(parts)


def _row(cls: type[Node], port: Port) -> tuple[str, ...]:
    kinds = _kinds(port)
    named = kinds if len(kinds) <= LONG else [*kinds[: LONG - 1], f"… ({len(kinds)} types)"]
    return port.name, " | ".join(named), port.unit, default_of(port), "; ".join(facts_of(cls, port))


def _kinds(port: Port) -> list[str]:
    """Return the names of all types that a port accepts."""
    return str(port.type).split(" | ")


def default_of(port: Port) -> str:
    """Return the default of an input as text, such as `9 times 0.0` for a long list of equal values.

    Return an empty text if the port has no default.
    """
    return "" if port.is_exec or port.side == "outputs" or port.default is None else _shown(port.default)


def facts_of(cls: type[Node], port: Port) -> list[str]:
    """Return legal values and purpose of a port, `required` if it is, and `extension` if Isaac Sim's node type lacks it."""
    facts = [port.constraint, port.doc, _required(cls, port), "extension" if port.extension else ""]
    return [fact for fact in facts if fact]


def _required(cls: type[Node], port: Port) -> str:
    """Return `required`; `required unless X is given` if one of several ports needs a value; empty if the port is optional."""
    if not isinstance(port.required, str):
        return "required" if port.required else ""
    others = [other.name for other in cls.fields.values() if other.required == port.required and other is not port]
    return f"required unless {' or '.join(others)} is given"


def _shown(value: Any) -> str:
    from graphengine.compiler.port_texts import listed

    plain = listed(value)
    if isinstance(plain, str):
        return repr(plain)
    if isinstance(plain, list | tuple) and plain and plain.count(plain[0]) == len(plain):
        if isinstance(plain[0], str) and len(plain) > 1:
            return f"{len(plain)} times {plain[0]!r}"
        if len(plain) > LONG:
            return f"{len(plain)} times {json.dumps(plain[0])}"
    return json.dumps(plain)
