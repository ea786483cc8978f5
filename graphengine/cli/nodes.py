"""`graphrun nodes`: list the node types and their ports."""

from __future__ import annotations

import argparse
import inspect
import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import (
    add_import_argument,
    add_message_path,
    chosen_distro,
    clean,
    make_registry,
    message_paths,
    table,
)
from graphengine.format.errors import ContextError, UsageError
from graphengine.format.files import installed_packages

if TYPE_CHECKING:
    from graphengine.compiler.registry import Registry
    from graphengine.node.node_class import Node
    from graphengine.node.port import Port

Constants = Sequence[tuple[str, str, Any]]
"""Name, ROS's type and value of each."""

LONG = 4
"""Values of a default, all the same, and types of a port of which more are counted instead of listed."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun nodes` to its parser."""
    parser.add_argument("name", metavar="NAME", nargs="?", help="describe one type, by its registered or short name")
    add_import_argument(parser)
    message = "also show the ports made from a message or service type, such as geometry_msgs/msg/Twist"
    parser.add_argument("--message", metavar="TYPE", help=message)
    add_message_path(parser)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--format", choices=("text", "json"), default="text", help="output format (default text)")
    form.add_argument("--markdown", action="store_true", help="print a reference of all types, or of NAME, as Markdown")


def execute(arguments: argparse.Namespace) -> int:
    """Print the types; return 0, or 2 for an unknown name."""
    from graphengine.compiler.registry import default_registry

    registry = make_registry(arguments.modules) if arguments.modules else default_registry()
    one = arguments.name is not None
    constants: Constants = ()
    if one:
        cls = _find(arguments.name, registry)
        if arguments.message is not None:
            cls, constants = _with_message(cls, registry, arguments)
        types = [cls]
    else:
        if arguments.message is not None:
            raise UsageError(
                "--message needs the name of a node type that makes ports from a message, such as ROS2Publisher"
            )
        for owner, problem in registry.broken.items():
            print(clean(f"warning: {owner} could not be imported: {problem}"), file=sys.stderr)
        types = [registry.types[name] for name in sorted(registry.types) if registry.types[name].type_name == name]
    if arguments.markdown:
        from graphengine.cli.node_reference import write_reference

        print(write_reference(types), end="")
    elif arguments.format == "json":
        records = [_record(cls) for cls in types]
        print(json.dumps(records[0] if one else records, indent=2))
    elif one:
        print(describe(types[0], constants))
    else:
        print(table([(cls.type_name, cls.kind(), summary(cls)) for cls in types]))
    return 0


def _find(name: str, registry: Registry) -> type[Node]:
    """Return the type with a registered or short name.

    Raises:
        UsageError: there is none.
    """
    found = registry.find(name)
    if found is None:
        from graphengine.isaac.node_replacements import replacement

        if advice := replacement(name):
            raise UsageError(f"the node type {name!r} of Isaac Sim is not available; {advice}")
        part = name.lower()
        holding = [name for name in sorted(registry.types) if part and part in name.lower()]
        hint = f"types with it in their name: {', '.join(holding)}" if holding else registry.suggest(name)
        raise UsageError(f"no node type {name!r}; {hint}")
    return found.cls


def _with_message(cls: type[Node], registry: Registry, arguments: argparse.Namespace) -> tuple[type[Node], Constants]:
    """Return the node type with the ports made from a message, and the message's constants.

    Raises:
        UsageError: the message is unknown, or the type makes no ports from messages.
    """
    from graphengine.node.node_class import grown

    parts = arguments.message.split("/")
    if len(parts) == 2 and "inputs:messageSubfolder" in cls.ports:
        parts.insert(1, cls.ports["inputs:messageSubfolder"].default)
    if len(parts) != 3:
        raise UsageError(f"--message {arguments.message}: write PACKAGE/msg/NAME, as in geometry_msgs/msg/Twist")
    literals = dict(zip(("messagePackage", "messageSubfolder", "messageName"), parts, strict=True))
    known = registry.definitions.for_distro(chosen_distro(arguments))
    definitions = known.extended(message_paths(arguments), installed_packages())
    try:
        made = grown(cls, literals, definitions)
    except ContextError as error:
        raise UsageError("\n  ".join((f"--message: {error.message}", *error.help))) from None
    if made is cls:
        raise UsageError(f"--message: {cls.type_name} makes no ports from messages")
    return made, definitions.definition("/".join(parts)).constants


def summary(cls: type[Node]) -> str:
    """Return the first line of the class's docstring."""
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def describe(cls: type[Node], constants: Constants = ()) -> str:
    """Return the description of a node type with all its ports, and with the constants of its message."""
    parts = [f"{cls.type_name}  ({cls.kind()})", "", inspect.getdoc(cls) or ""]
    for side in ("inputs", "outputs"):
        ports = [port for port in cls.fields.values() if port.side == side]
        rows = [_row(cls, port) for port in sorted(ports, key=lambda port: not port.is_exec)]
        if rows:
            parts += ["", side, table(rows, indent="  ")]
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
    """Return the names of the types that a port takes."""
    return str(port.type).split(" | ")


def default_of(port: Port) -> str:
    """Return an input's default as text, empty without one; a long list of equal values is cut to value and count."""
    return "" if port.is_exec or port.side == "outputs" or port.default is None else _shown(port.default)


def facts_of(cls: type[Node], port: Port) -> list[str]:
    """Return texts on a port: legal values, purpose, `required`, and `extension` if Isaac Sim's type does not have it."""
    facts = [port.constraint, port.doc, _required(cls, port), "extension" if port.extension else ""]
    return [fact for fact in facts if fact]


def _required(cls: type[Node], port: Port) -> str:
    """Return `required`, or `required unless …` for one of several ports; empty if the port needs no value."""
    if not isinstance(port.required, str):
        return "required" if port.required else ""
    others = [other.name for other in cls.fields.values() if other.required == port.required and other is not port]
    return f"required unless {' or '.join(others)} is given"


def _shown(value: Any) -> str:
    plain = _plain(value)
    if isinstance(plain, str):
        return repr(plain)
    if isinstance(plain, list | tuple) and plain and plain.count(plain[0]) == len(plain):
        if isinstance(plain[0], str) and len(plain) > 1:
            return f"{len(plain)} times {plain[0]!r}"
        if len(plain) > LONG:
            return f"{len(plain)} times {json.dumps(plain[0])}"
    return json.dumps(plain)


def _record(cls: type[Node]) -> dict[str, Any]:
    ports = [port for port in cls.fields.values() if port.side != "state"]
    return {
        "type": cls.type_name,
        "kind": cls.kind(),
        "doc": inspect.getdoc(cls) or "",
        "ports": [
            {
                "name": port.name,
                "side": port.side,
                "type": str(port.type),
                "unit": port.unit,
                "default": None if port.is_exec else json.loads(json.dumps(_plain(port.default))),
                "doc": port.doc,
                "legal": port.constraint,
                "required": port.required,
                "extension": port.extension,
            }
            for port in ports
        ],
    }


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value
