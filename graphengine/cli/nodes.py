"""`graphrun nodes`: list all node types, or print the ports of one."""

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
    fitted_table,
    make_registry,
    message_paths,
)
from graphengine.cli.node_description import Constants, describe, summary
from graphengine.cli.options import add_flag, add_value
from graphengine.format.errors import ContextError, UsageError
from graphengine.format.files import installed_packages
from graphengine.format.wording import quoted

if TYPE_CHECKING:
    from graphengine.compiler.registry import Registry
    from graphengine.node.node_class import Node

MANY = 20
"""Maximum number of node types that the error message for an ambiguous name lists."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun nodes` to its parser."""
    name = "node type to describe: its full or short name, or a part that only one name has, such as Diff"
    add_value(parser, "name", "NAME", name, nargs="?")
    add_value(parser, "--search", "WORD", "list the node types whose name, documentation or ports contain this text")
    add_import_argument(parser)
    message = "also print the ports that the node type gets from this type, such as geometry_msgs/msg/Twist"
    add_value(parser, "--message", "TYPE", message)
    add_message_path(parser)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--format", choices=("text", "json"), default="text", help="output format (default text)")
    add_flag(form, "--markdown", "print a reference of all node types, or of NAME, as Markdown")


def execute(arguments: argparse.Namespace) -> int:
    """Print the node types or the given one; return 0.

    Raises:
        UsageError: the name of the node type or message is unknown, no type is found, or two options do not fit together.
    """
    from graphengine.compiler.registry import default_registry

    registry = make_registry(arguments.modules) if arguments.modules else default_registry()
    one = arguments.name is not None
    constants: Constants = ()
    if one and arguments.search is not None:
        raise UsageError("NAME describes one node type, and --search lists several; give one of them")
    if one:
        cls = _find(arguments.name, registry)
        if arguments.message is not None:
            cls, constants = _with_message(cls, registry, arguments)
        types = [cls]
    else:
        if arguments.message is not None:
            raise UsageError("--message needs NAME, a node type with ports for a message type, such as ROS2Publisher")
        for owner, problem in registry.broken.items():
            print(clean(f"warning: {owner} could not be imported: {problem}"), file=sys.stderr)
        types = [registry.types[name] for name in sorted(registry.types) if registry.types[name].type_name == name]
    if arguments.search is not None:
        types = _search(arguments.search, types, registry)
    if arguments.markdown:
        from graphengine.cli.node_reference import write_reference

        print(write_reference(types), end="")
    elif arguments.format == "json":
        records = [_record(cls) for cls in types]
        print(json.dumps(records[0] if one else records, indent=2))
    elif one:
        print(describe(types[0], constants))
    else:
        rows = [(cls.type_name, cls.kind(), summary(cls), _found(arguments.search, cls)) for cls in types]
        print(fitted_table(rows, 2))
    return 0


def _search(word: str, types: Sequence[type[Node]], registry: Registry) -> list[type[Node]]:
    """Return the node types that contain a text: first in the name, then in the documentation, then in ports.

    Raises:
        UsageError: no node type contains the text.
    """
    part = word.lower()
    by_name = [cls for cls in types if any(part in name.lower() for name in (cls.type_name, *cls.aliases))]
    by_doc = [cls for cls in types if part in (inspect.getdoc(cls) or "").lower()]
    found = list(dict.fromkeys((*by_name, *by_doc, *(cls for cls in types if _found(word, cls)))))
    if not found:
        raise UsageError(f"--search {word}: no name, documentation or port contains it; {registry.suggest(word)}")
    return found


def _found(word: str | None, cls: type[Node]) -> str:
    """Return the names of the ports whose name or documentation contains a word, as text such as `ports: speed, angle`.

    The text is empty if no port contains the word, or if `word` is None or empty.
    """
    part = (word or "").lower()
    ports = [port.name for port in cls.fields.values() if part and part in f"{port.name} {port.doc}".lower()]
    return f"ports: {', '.join(ports)}" if ports else ""


def _find(name: str, registry: Registry) -> type[Node]:
    """Return the node type with this registered or short name, or the only node type whose name contains the text.

    Raises:
        UsageError: no node type has this name, or several contain the text.
    """
    found = registry.find(name)
    if found is None:
        from graphengine.isaac.node_replacements import replacement

        if advice := replacement(name):
            raise UsageError(f"the node type {name!r} of Isaac Sim is not available; {advice}")
        part = name.lower()
        named = sorted({cls.type_name for n, cls in registry.types.items() if part and part in n.lower()})
        if len(named) == 1:
            return registry.types[named[0]]
        more = [f"… ({len(named) - MANY} more): graphrun nodes --search {quoted(name)}"] if len(named) > MANY else []
        several = [f"{len(named)} names contain it:", *named[:MANY], *more]
        raise UsageError(f"no node type {name!r}; " + ("\n  ".join(several) if named else registry.suggest(name)))
    return found.cls


def _with_message(cls: type[Node], registry: Registry, arguments: argparse.Namespace) -> tuple[type[Node], Constants]:
    """Return the node type with the ports that it gets from the `--message` type, and the constants of the message type.

    Raises:
        UsageError: the message type is unknown, or the node type gets no ports from messages.
    """
    from graphengine.node.node_class import grown

    parts = arguments.message.split("/")
    if len(parts) == 2 and "inputs:messageSubfolder" in cls.ports:
        parts.insert(1, cls.ports["inputs:messageSubfolder"].default)
    if len(parts) != 3:
        raise UsageError(f"--message {arguments.message}: write PACKAGE/msg/NAME, such as geometry_msgs/msg/Twist")
    literals = dict(zip(("messagePackage", "messageSubfolder", "messageName"), parts, strict=True))
    known = registry.definitions.for_distro(chosen_distro(arguments))
    definitions = known.extended(message_paths(arguments), installed_packages())
    try:
        made = grown(cls, literals, definitions)
    except ContextError as error:
        raise UsageError("\n  ".join((f"--message: {error.message}", *error.help))) from None
    if made is cls:
        raise UsageError(f"--message: {cls.type_name} gets no ports from message types")
    return made, definitions.definition("/".join(parts)).constants


def _record(cls: type[Node]) -> dict[str, Any]:
    from graphengine.compiler.port_texts import listed

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
                "default": None if port.is_exec else json.loads(json.dumps(listed(port.default))),
                "doc": port.doc,
                "legal": port.constraint,
                "required": port.required,
                "extension": port.extension,
            }
            for port in ports
        ],
    }
