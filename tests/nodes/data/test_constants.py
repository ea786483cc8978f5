"""Constants: a wire begins at the input that the file sets."""

from __future__ import annotations

import math
from typing import Any

import pytest

from graphengine.compiler.registry import default_registry
from graphengine.nodes.data.constants import ConstantE, ConstantPi
from tests.nodes.data.harness import computed, shown
from tests.nodes.harness import Player, facts

TYPES = {
    name.rpartition(".")[2]: table["inputs"]["value"]["type"]
    for name, table in facts("kit_ports.json")["types"].items()
    if name.startswith("omni.graph.nodes.Constant") and "value" in table["inputs"]
}
DOUBLE3 = default_registry().types["omni.graph.nodes.ConstantDouble3"]


def value_of(port_type: str) -> tuple[str, Any]:
    """A value as YAML, and as a port carries it."""
    texts: dict[str, tuple[str, Any]] = {"bool": ("true", True), "target": ("[/a, /b]", ("/a", "/b"))}
    texts |= dict.fromkeys(("string", "token", "path"), ("/somewhere", "/somewhere"))
    if port_type in texts:
        return texts[port_type]
    base, _, size = port_type.removesuffix("]").partition("[")
    if base in ("matrixd", "frame"):
        rows = [[float(row * 10 + column) for column in range(int(size))] for row in range(int(size))]
        return str(rows), tuple(number for row in rows for number in row)
    number = int if "int" in base or base == "uchar" else float
    numbers = tuple(number(n + 1) for n in range(int(size or 1)))
    return (str(list(numbers)), numbers) if size else (str(numbers[0]), numbers[0])


def test_every_constant_type_of_isaac_sim_exists() -> None:
    assert len(TYPES) == 54
    assert {"ConstantDouble", "ConstantInt3", "ConstantColor4h", "ConstantTexCoord2f", "ConstantTarget"} <= set(TYPES)


@pytest.mark.parametrize("name", sorted(TYPES))
def test_in_a_graph_wires_start_at_the_input_of_a_constant(play: Player, name: str) -> None:
    text, expected = value_of(TYPES[name])
    found = shown(play, f"{TYPES[name]} Here.inputs:value", {"Here": f"{{type: {name}, inputs: {{value: {text}}}}}"})
    assert found == expected
    assert type(found) is type(expected)


@pytest.mark.parametrize("name", sorted(TYPES))
def test_a_constant_is_a_data_node_with_one_port(name: str) -> None:
    cls = default_registry().types[f"omni.graph.nodes.{name}"]
    assert (cls.kind(), list(cls.ports)) == ("data", ["inputs:value"])


def test_outside_a_graph_a_constant_holds_its_value() -> None:
    node: Any = DOUBLE3(value=(1.0, 2.0, 3.0))
    node.compute()
    assert node.value == (1.0, 2.0, 3.0)


def test_a_value_of_another_type_is_refused() -> None:
    with pytest.raises(ValueError, match=r"ConstantDouble3\.value: expected 3 values, got 2"):
        DOUBLE3(value=(1.0, 2.0))


def test_pi_is_multiplied_and_e_is_raised(play: Player) -> None:
    assert computed(ConstantPi).value == math.pi
    assert computed(ConstantPi, factor=0.5).value == math.pi / 2
    assert computed(ConstantE).value == math.e
    assert computed(ConstantE, exponent=0.0).value == 1.0
    assert computed(ConstantE, exponent=1000.0).value == math.inf
    assert shown(play, "double Turn.value", {"Turn": "{type: ConstantPi, inputs: {factor: 2}}"}) == 2 * math.pi
