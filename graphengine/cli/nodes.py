"""`graphrun nodes`: the node types, from their classes."""

from __future__ import annotations

import argparse
import inspect
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graphengine.node import Node, Port


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    parser.add_argument("name", metavar="NAME", nargs="?", help="one type, in full; its registered or short name")
    parser.add_argument(
        "--import", metavar="MODULE", dest="modules", action="append", default=[], help="Python module with node types"
    )
    parser.add_argument("--format", choices=("text", "json"), default="text")


def execute(arguments: argparse.Namespace) -> int:
    """0, or 2 for a name that is no type."""
    from graphengine.cli.common import make_registry, table
    from graphengine.diagnostics import UsageError
    from graphengine.registry import default_registry

    registry = make_registry(arguments.modules) if arguments.modules else default_registry()
    if arguments.name is not None:
        found = registry.find(arguments.name)
        if found is None:
            part = arguments.name.lower()
            holding = [name for name in sorted(registry.types) if part and part in name.lower()]
            hint = f"types with it in their name: {', '.join(holding)}" if holding else registry.suggest(arguments.name)
            raise UsageError(f"no node type {arguments.name!r}; {hint}")
        print(json.dumps(_record(found.cls), indent=2) if arguments.format == "json" else describe(found.cls))
        return 0
    types = [registry.types[name] for name in sorted(registry.types) if registry.types[name].type_name == name]
    if arguments.format == "json":
        print(json.dumps([_record(cls) for cls in types], indent=2))
        return 0
    print(table([(cls.type_name, cls.kind(), summary(cls)) for cls in types]))
    for owner, problem in registry.broken.items():
        print(f"plugin {owner} could not be loaded: {problem}")
    return 0


def summary(cls: type[Node]) -> str:
    """First line of the class's docstring."""
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def describe(cls: type[Node]) -> str:
    """A node type with all its ports."""
    from graphengine.cli.common import table

    parts = [f"{cls.type_name}  ({cls.kind()})", "", inspect.getdoc(cls) or ""]
    for side in ("inputs", "outputs"):
        rows = [_row(port) for port in cls.fields.values() if port.side == side]
        if rows:
            parts += ["", side, table(rows, indent="  ")]
    if cls.aliases:
        parts += ["", f"also called: {', '.join(cls.aliases)}"]
    return "\n".join(parts)


def _row(port: Port) -> tuple[str, ...]:
    default = "" if port.is_exec or port.side == "outputs" else _shown(port.default)
    facts = [port.constraint, port.doc, "required" if port.required else "", "extension" if port.extension else ""]
    return port.name, str(port.type), port.unit, default, "; ".join(fact for fact in facts if fact)


def _shown(value: Any) -> str:
    plain = value.tolist() if hasattr(value, "tolist") else value
    return json.dumps(plain) if not isinstance(plain, str) else repr(plain)


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
