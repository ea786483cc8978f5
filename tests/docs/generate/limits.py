"""The page of limits: each named limit on what comes from files, users or the network, with its value and meaning."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from itertools import groupby
from typing import Any

from graphengine.cli.node_reference import code, prose, table
from tests.limits import exempt, foundations, isaac, network, physics, robot_files, sessions, surfaces
from tests.limits.table import LIMITS, _modules, limit_value

ENTRIES = (foundations, isaac, network, physics, robot_files, sessions, surfaces)
"""Modules that enter limits into the table of `tests.limits` when they are imported."""

_INTRODUCTION = """# Limits

graphengine limits its input from files, users and the network. A value beyond a limit is refused or truncated, and a
message names the limit. If the limit is a time, graphengine stops waiting after this time. For each limit, a test gives an
input at the limit and an input beyond it. The last column names the constant in the code, without the prefix `graphengine.`."""

ROOMS = {
    "format": "Files", "messages": "Messages", "sandbox": "Sandbox", "devices": "Devices",
    "descriptions": "Descriptions of robots and worlds", "node": "Nodes", "compiler": "Graphs",
    "runtime": "Runs", "physics": "Worlds, robots and sensors", "ros": "ROS 2 network", "nodes": "Node types", "scene": "Scenes",
    "recording": "Recordings", "control": "Control of runs", "drawing": "Drawings", "isaac": "Import from Isaac Sim",
    "view": "The page", "api": "Python", "bringup": "Robots, maps and Nav2", "experiments": "Scenarios",
    "cli": "Commands", "testing": "Tests",
}  # fmt: skip


def pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the page."""
    rooms = [*ROOMS]
    named = {*(one.name for one in LIMITS), *exempt.TESTED}
    names = sorted(named, key=lambda name: (rooms.index(name.partition(".")[0]), name))
    lines = [_INTRODUCTION]
    for room, inside in groupby(names, lambda name: name.partition(".")[0]):
        rows = [(prose(meaning_of(name)), _shown(limit_value(name)), code(name)) for name in inside]
        lines += ["", f"## {ROOMS[room]}", "", *table(("limit", "value", "constant"), rows)]
    yield "limits.md", "\n".join([*lines, ""])


def _shown(value: Any) -> str:
    return f"{value:,}".replace(",", " ") if isinstance(value, int) else f"{value:g}"


def meaning_of(name: str) -> str:
    """Return the docstring of a constant, or the comment behind it, else an empty text."""
    module, _, constant = name.rpartition(".")
    owner, _, cls = module.rpartition(".")
    return _meanings(owner, cls).get(constant, "") if cls[0].isupper() else _meanings(module, "").get(constant, "")


@cache
def _meanings(module: str, cls: str) -> dict[str, str]:
    """Return the meanings of the constants of a module, or of a class in it."""
    text = _modules()[module]
    body = ast.parse(text).body
    if cls:
        body = next(one.body for one in body if isinstance(one, ast.ClassDef) and one.name == cls)
    found: dict[str, str] = {}
    for one, below in zip(body, [*body[1:], None], strict=True):
        targets = one.targets if isinstance(one, ast.Assign) else [one.target] if isinstance(one, ast.AnnAssign) else []
        document = below.value.value if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) else None
        line = text.splitlines()[one.lineno - 1] if targets else ""
        meaning = " ".join(document.split()) if isinstance(document, str) else line.partition("# ")[2]
        found |= {target.id: meaning for target in targets if isinstance(target, ast.Name)}
    return found
