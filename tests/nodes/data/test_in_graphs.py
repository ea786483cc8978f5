"""Every data node: a graph gives what the node gives alone, and again after a stop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

from graphengine.compiler.registry import default_registry
from graphengine.node import Node, PortType, UnionType
from graphengine.nodes.data.broadcast import type_of
from graphengine.nodes.data.conversion import text_of
from tests.nodes.data.harness import computed
from tests.nodes.harness import Player
from tests.nodes.test_ports import NEEDED

OF_THE_SURROUNDINGS = {"GetGraphTargetPrim", "GraphTarget", "ReadTime"}
"""Their values are of the graph or the time, and no other node's business."""
COMPUTING = {
    cls.__name__: cls
    for name, cls in default_registry().types.items()
    if name == cls.type_name and cls.__module__.startswith("graphengine.nodes.data.") and cls.kind() == "data"
    if cls.__name__ not in OF_THE_SURROUNDINGS and any(port.side == "outputs" for port in cls.fields.values())
}


def literal(cls: type[Node], field: str, value: Any) -> Any:
    """A value as a file writes it, with its type where the port takes that among others."""
    union = cls.fields[field].type
    if isinstance(value, list):
        value = tuple(value) if isinstance(value[0], str) else np.array(value)
    taken = type_of(value)
    written = list(value) if isinstance(value, tuple) else np.asarray(value).tolist()
    if not isinstance(union, UnionType):
        return written
    matrix = PortType("double", taken.count, taken.array, "matrixd")
    named = next((one for one in (taken, matrix) if one in union.alternatives), None)
    return {"type": str(named), "value": written} if named else written


def outputs(node: Any) -> dict[str, Any]:
    """What a node gives, by Python name."""
    return {port.field: getattr(node, port.field) for port in type(node).fields.values() if port.side == "outputs"}


def graph_of(cls: type[Node], inputs: dict[str, Any]) -> str:
    """A graph in which all outputs of a node become texts."""
    given = {cls.fields[field].name: literal(cls, field, value) for field, value in inputs.items()}
    nodes: dict[str, Any] = {"Tick": "OnPlaybackTick", "Node": {"type": cls.type_name, "inputs": given}}
    wires = []
    for port in cls.fields.values():
        if port.side == "outputs":
            nodes |= {f"text_{port.field}": "ToString", f"tell_{port.field}": "PrintText"}
            wires += [f"Tick.tick -> tell_{port.field}.execIn", f"Node.{port.name} -> text_{port.field}.value"]
            wires.append(f"text_{port.field}.converted -> tell_{port.field}.text")
    return yaml.safe_dump({"nodes": nodes, "connections": wires}, sort_keys=False)


@pytest.mark.parametrize("name", sorted(COMPUTING))
def test_a_graph_gives_the_same_outputs_as_the_node_outside_a_graph_and_again_after_a_stop(
    play: Player, name: str
) -> None:
    cls, inputs = COMPUTING[name], NEEDED.get(name, {})
    alone = {field: text_of(value) for field, value in outputs(computed(cls, **inputs)).items()}
    playing = play.graph(graph_of(cls, inputs))
    for _ in range(2):
        playing.tick()
        assert {field: playing.node(f"tell_{field}").text for field in alone} == alone
        playing.session.stop()
