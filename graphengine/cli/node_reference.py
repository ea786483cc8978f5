"""Writes the node reference as Markdown: all node types with their ports. The anchor of a type is its registered name."""

from __future__ import annotations

import html
import inspect
import re
from collections.abc import Iterable, Sequence
from itertools import groupby

from graphengine.cli.node_description import default_of, facts_of, summary
from graphengine.compiler.port_texts import brief
from graphengine.node.node_class import Node
from graphengine.node.port import Port


def write_reference(types: Sequence[type[Node]]) -> str:
    """Return the reference of the given node types as Markdown, sorted by family and then by name."""
    ordered = sorted(types, key=lambda cls: (family_of(cls), cls.type_name))
    families = [(family, list(members)) for family, members in groupby(ordered, family_of)]
    parts = ["# Nodes", "", f"{len(ordered)} node types. Units are SI unless a port says otherwise.", ""]
    parts += [f"- [{code(family)}](#{family}): {len(members)}" for family, members in families]
    for family, members in families:
        parts += ["", f'<a id="{family}"></a>', "", f"## {code(family)}", ""]
        rows = [(f"[{code(last_part(cls))}](#{cls.type_name})", cls.kind(), prose(summary(cls))) for cls in members]
        parts += table(("type", "kind", "what it does"), rows)
        for cls in members:
            parts += ["", f'<a id="{html.escape(cls.type_name)}"></a>', "", f"### {code(last_part(cls))}", ""]
            parts += description(cls)
    return "\n".join([*parts, ""])


def family_of(cls: type[Node]) -> str:
    """Return the family of a node type: its registered name without the last part, or `nodes` if the name has one part."""
    return cls.type_name.rpartition(".")[0] or "nodes"


def last_part(cls: type[Node]) -> str:
    """Return the last part of the registered name of a node type."""
    return cls.type_name.rpartition(".")[2]


def description(cls: type[Node]) -> Iterable[str]:
    """Yield the lines below the heading of a node type: its names, documentation and ports."""
    also = f"; also called {', '.join(map(code, cls.aliases))}" if cls.aliases else ""
    yield f"{code(cls.type_name)}, {cls.kind()}{also}"
    yield from ("", prose(inspect.getdoc(cls) or ""))
    for side in ("inputs", "outputs"):
        ports = sorted((port for port in cls.fields.values() if port.side == side), key=lambda port: not port.is_exec)
        if ports:
            heads = (side[:-1], "type", "unit", "default", "") if side == "inputs" else (side[:-1], "type", "unit", "")
            yield ""
            yield from table(heads, [_row(cls, port) for port in ports])
    for stem in cls.numbered:
        yield ""
        yield f"The node has a port for each of the names {code(f'{stem}0')}, {code(f'{stem}1')}, … that the graph file uses."


def _row(cls: type[Node], port: Port) -> tuple[str, ...]:
    default = default_of(port)
    facts = prose("; ".join(facts_of(cls, port)))
    cells = (code(port.name), code(brief(port.type)), prose(port.unit))
    return (*cells, code(default) if default else "", facts) if port.side == "inputs" else (*cells, facts)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterable[str]:
    """Yield the lines of a Markdown table with the given column heads."""
    yield f"| {' | '.join(heads)} |"
    yield f"|{'---|' * len(heads)}"
    for row in rows:
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|').replace(chr(10), ' ') for cell in row)} |"


def prose(text: str) -> str:
    """Return the text with all Markdown syntax except backticks escaped."""
    parts = re.split(r"(`[^`\n]+`)", text)
    return "".join(part if number % 2 else _inert(part) for number, part in enumerate(parts))


def _inert(text: str) -> str:
    return re.sub(r"([\\`*\[\]#~]|\b_(?!\w)|(?<!\w)_)", r"\\\1", html.escape(text, quote=False))


def code(text: str) -> str:
    """Return the text as Markdown code, with enough backticks around it."""
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", text)), default=0))
    room = " " if "`" in text else ""
    return f"{fence}{room}{text}{room}{fence}"
