"""What is told of values and wires that a port does not take."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.format.diagnostics import Finding
from tests.nodes.harness import checked


def the_mistake(folder: Path, nodes: str, wires: str = "") -> Finding:
    (found,) = checked(folder, f"nodes: {{{nodes}}}\nconnections: [{wires}]").errors
    return found


@pytest.mark.parametrize(
    ("node", "wrong", "remedy"),
    [
        ("{type: omni.graph.nodes.Add, inputs: {a: hello, b: 1}}", "expected a number, got 'hello'", ""),
        ("{type: omni.graph.nodes.BooleanNot, inputs: {valueIn: 1}}", "expected true or false, got 1", ""),
        ("{type: omni.graph.nodes.ArrayGetSize, inputs: {array: 3}}", "expected a list, got 3", "write [3]"),
        ("{type: omni.graph.nodes.BuildString, inputs: {a: 3, b: x}}", "expected text, got 3", 'write "3"'),
        (
            "{type: omni.graph.nodes.AppendArray, inputs: {input0: [1], input1: [2], input2: null}}",
            "got nothing",
            "type",
        ),
        ("{type: omni.graph.action.ForEach, inputs: {arrayIn: 3}}", "expected a list, got 3", "write [3]"),
        (
            "{type: omni.graph.nodes.Modulo, inputs: {a: [1], b: 1}}",
            "none of these types fits, got a list",
            "write {type",
        ),
    ],
)
def test_the_error_of_a_value_without_matching_type_lists_the_types_of_the_port(
    tmp_path: Path, node: str, wrong: str, remedy: str
) -> None:
    found = the_mistake(tmp_path, f"N: {node}")
    assert found.code == "G211"
    assert found.message.endswith(wrong)
    assert remedy in "".join(found.help)


@pytest.mark.parametrize(
    ("node", "needed"),
    [
        ("{type: omni.graph.nodes.Add, inputs: {a: 1}}", "'b'"),
        ("BreakVector3", "'tuple'"),
        ("CreateRenderProduct", "'cameraPrim'"),
        ("ArticulationController", "'targetPrim' or 'robotPath'"),
        ("PublishJointState", "'targetPrim' or 'jointNames'"),
        ("{type: DifferentialController, inputs: {wheelRadius: 0.1}}", "'wheelDistance'"),
        ("{type: DifferentialController, inputs: {wheelDistance: 0.1}}", "'wheelRadius'"),
    ],
)
def test_a_missing_required_input_is_reported(tmp_path: Path, node: str, needed: str) -> None:
    found = the_mistake(tmp_path, f"N: {node}")
    assert (found.code, found.message) == ("G208", f"N needs its input {needed}")


@pytest.mark.parametrize(
    ("source", "target", "between"),
    [
        ("omni.graph.nodes.ConstantToken", "omni.graph.nodes.StartsWith", "ToString"),
        ("omni.graph.nodes.ConstantString", "omni.graph.nodes.GraphTarget", "ToToken"),
    ],
)
def test_the_error_of_a_wire_between_text_types_names_the_converter_node(
    tmp_path: Path, source: str, target: str, between: str
) -> None:
    port = {"ToString": "value", "ToToken": "targetPath"}[between]
    found = the_mistake(tmp_path, f"A: {source}, B: {target}", f"A.value -> B.{port}")
    assert (found.code, found.help) == ("G206", (f"put {between} between them",))


def test_a_wire_from_a_value_into_execution_names_the_first_few_of_many_types(tmp_path: Path) -> None:
    add = "A: {type: omni.graph.nodes.Add, inputs: {a: 1, b: 2}}"
    found = the_mistake(tmp_path, f"{add}, D: Branch", "A.sum -> D.execIn")
    assert found.message.endswith("more: `graphrun nodes --format json`)), D.execIn takes execution")


def test_a_gap_in_the_numbers_of_element_inputs_is_reported(tmp_path: Path) -> None:
    found = the_mistake(tmp_path, "Make: {type: ConstructArray, inputs: {arraySize: 3, input0: 1.0, input2: 3.0}}")
    assert (found.code, found.message) == ("G206", "Make: input2 is given, but input1 is missing")


def test_a_cycle_without_resolvable_types_gives_only_the_cycle_error(tmp_path: Path) -> None:
    nodes = "Sum: omni.graph.nodes.Add, Product: omni.graph.nodes.Multiply, Text: omni.graph.nodes.ToString"
    wires = "Sum.sum -> Product.a, Sum.sum -> Product.b, Product.product -> Sum.a, Product.product -> Sum.b"
    found = the_mistake(tmp_path, nodes, f"{wires}, Sum.sum -> Text.value")
    assert (found.code, found.message) == ("G209", "data nodes form a cycle: Sum -> Product -> Sum")
