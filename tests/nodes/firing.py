"""Nodes whose ports a test fires, and ports that a file names."""

from __future__ import annotations

from typing import Any

from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Node
from graphengine.node.node_class import grown


def fired(node: Any, pin: str = "exec_in") -> str:
    """The outputs that a node fires when one of its pins does, by name."""
    setattr(node, pin, 1)
    ports = node.compute()
    setattr(node, pin, 0)
    outputs = [p.field for p in type(node).fields.values() if p.side == "outputs" and p.is_exec]
    return " ".join(name for name in outputs if (ports or 0) & getattr(node, name))


def of(cls: type[Node], *wired: str, **literals: Any) -> Any:
    """A node whose file names these ports and values."""
    made: Any = grown(cls, literals, DEFINITIONS, wired)
    return made(**literals)
