"""Data nodes alone, with types as a graph settles them, and in graphs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np

from graphengine.node import Node
from graphengine.node.types import PortType, parse
from graphengine.testing import RecordingContext
from tests.nodes import harness
from tests.nodes.harness import Player

N = TypeVar("N", bound=Node)


def concrete(name: str) -> PortType:
    """A type by its name."""
    found = parse(name)
    assert isinstance(found, PortType)
    return found


def computed(cls: type[N], /, **inputs: Any) -> N:
    """A node with those inputs, set up and computed."""
    return harness.computed(cls, RecordingContext(), **inputs)


def output_of(node: Any, output: str) -> Any:
    """An output after a compute; arrays as lists."""
    node.compute()
    value = getattr(node, output)
    return value.tolist() if isinstance(value, np.ndarray) else value


def typed(cls: type[N], types: Mapping[str, str], /, **inputs: Any) -> N:
    """The same, where a graph has settled the types of its inputs to those names."""
    node = cls(**inputs)
    known = {field: concrete(name) for field, name in types.items()}
    fixed = {p.field: p.type for p in cls.fields.values() if isinstance(p.type, PortType)}
    node.settled = {**known, **node.resolve_types({**fixed, **known}, {})}
    node.setup(RecordingContext())
    node.compute()
    return node


def shown(play: Player, wanted: str, nodes: Mapping[str, str], wires: Iterable[str] = ()) -> Any:
    """What comes out of `Node.port`, which a variable of its type takes, in a graph of nodes by name.

    Args:
        play: makes the session.
        wanted: type and source, as in `double Sum.sum`.
        nodes: each as YAML.
        wires: as in `connections:`.
    """
    port_type, source = wanted.split()
    lines = ["variables: {shown: {type: " + repr(port_type) + "}}", "nodes:", "  Tick: OnPlaybackTick"]
    lines += ["  Show: {type: WriteVariable, inputs: {variableName: shown}}"]
    lines += [f"  {name}: {text}" for name, text in nodes.items()]
    lines += ["connections:", "  - Tick.tick -> Show.execIn", f"  - {source} -> Show.value"]
    lines += [f"  - {wire}" for wire in wires]
    playing = play.graph("\n".join(lines))
    playing.tick()
    return playing.node("Show").value_out
