"""From a flat graph to instances and wires: ports of several types, dynamic ports, literals, overrides, mistakes."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.compiler.graph import Graph, settled_type
from graphengine.compiler.literals import Override
from graphengine.compiler.port_texts import with_article
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UsageError
from graphengine.messages.endpoints import Network
from graphengine.node import In, Node, Out
from graphengine.node.types import UnionType, parse
from graphengine.scene import build
from tests.compiler import harness
from tests.compiler.conftest import MakeBench, MakeFile

NUMBERS = "double|float|half|int"
TRIPLES = "double[3]|float[3]|int[3]|vectord[3]"


class Break(Node, type="test.Break"):
    """Components of a vector of any type."""

    vector: Any = In(type=TRIPLES, couple="number")
    x: Any = Out(type=NUMBERS, couple="number", component=True)
    y: Any = Out(type=NUMBERS, couple="number", component=True)

    def compute(self) -> None:
        self.x, self.y, _ = self.vector


class Multiply(Node, type="test.Multiply"):
    """Product of two numbers of one type."""

    a: Any = In(type=NUMBERS, couple="number")
    b: Any = In(type=NUMBERS, couple="number")
    product: Any = Out(type=NUMBERS, couple="number")

    def compute(self) -> None:
        self.product = self.a * self.b


class Vectors(Node, type="test.Vectors"):
    """Vectors of some types."""

    doubles: Any = Out(type="vectord[3]", default=[1.0, 2.0, 3.0])
    floats: Any = Out(type="float[3]", default=[1.0, 2.0, 3.0])
    wholes: Any = Out(type="int[3]", default=[1, 2, 3])
    whole: Any = Out(type="int", default=3)
    text: Any = Out(type="token", default="x")


for cls in (Break, Multiply, Vectors):
    harness.REGISTRY.add(cls, "tests", built_in=True)


def resolve(file: MakeFile, text: str, *overrides: Override) -> tuple[Graph, Findings]:
    findings = Findings()
    graph = harness.resolved(file(text), findings, overrides=overrides)
    assert graph is not None
    return graph, findings


def types_of(graph: Graph, node_id: str) -> dict[str, str]:
    instance = graph.by_id(node_id)
    ports = [port for port in instance.cls.fields.values() if isinstance(port.type, UnionType)]
    return {port.name: str(settled_type(instance, port)) for port in ports}


def codes(findings: Findings) -> list[str]:
    return [finding.code for finding in findings.items]


# Ports of several types


@pytest.mark.parametrize(("source", "number"), [("doubles", "double"), ("floats", "float"), ("wholes", "int")])
def test_a_wire_settles_a_union_port_and_the_ports_coupled_with_it(file: MakeFile, source: str, number: str) -> None:
    graph, findings = resolve(
        file, f"{{graph: g, nodes: {{V: Vectors, B: Break}}, connections: [V.{source} -> B.vector]}}"
    )
    assert codes(findings) == []
    types = types_of(graph, "B")
    assert types["vector"] in (f"{number}[3]", "vectord[3]")
    assert (types["x"], types["y"]) == (number, number)


def test_types_settle_along_chains_in_whatever_order_the_wires_are_written(file: MakeFile) -> None:
    graph, findings = resolve(
        file,
        """
        nodes: {V: Vectors, B: Break, M: Multiply, N: Multiply}
        connections:
          - M.product -> N.a
          - M.product -> N.b
          - B.x -> M.a
          - B.y -> M.b
          - V.floats -> B.vector
        """,
    )
    assert codes(findings) == []
    assert types_of(graph, "N") == {"a": "float", "b": "float", "product": "float"}


def test_types_settle_against_the_wires_too(file: MakeFile) -> None:
    graph, findings = resolve(file, "{graph: g, nodes: {M: Multiply, Show: Do}, connections: [M.product -> Show.a]}")
    assert types_of(graph, "M")["product"] == "double"
    assert types_of(graph, "M")["a"] == "double"
    assert codes(findings) == []


def test_a_literal_with_its_type_settles_a_port(file: MakeFile) -> None:
    graph, _ = resolve(file, "{graph: g, nodes: {M: {type: Multiply, inputs: {a: {type: int, value: 2}}}}}")
    assert types_of(graph, "M") == {"a": "int", "b": "int", "product": "int"}
    assert graph.by_id("M").make_node().a == 2  # type: ignore[attr-defined]


def test_a_literal_without_a_type_takes_the_first_alternative_that_fits(file: MakeFile) -> None:
    graph, _ = resolve(file, "{graph: g, nodes: {M: {type: Multiply, inputs: {a: 2}}}}")
    assert types_of(graph, "M")["a"] == "double"


def test_a_wire_into_a_settled_port_is_converted(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, V: Vectors, M: {type: Multiply, inputs: {a: {type: double, value: 0.5}}}, Show: Show}
        connections:
          - Tick.tick -> Show.execIn
          - V.whole -> M.b
          - M.product -> Show.value
    """)
    assert run.tick() == ["Show 1.5"]


def test_a_wire_from_a_wired_input_carries_the_converted_value(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Whole: {type: Whole, inputs: {value: 3}}, Middle: Do, Show: Show}
        connections:
          - Tick.tick -> Middle.execIn
          - Tick.tick -> Show.execIn
          - Whole.out -> Middle.a
          - Middle.inputs:a -> Show.value
    """)
    run.tick()
    assert isinstance(run["Show"].value, float)


def test_a_node_knows_its_settled_types_and_its_outputs_start_at_their_zero(file: MakeFile) -> None:
    graph, _ = resolve(file, "{graph: g, nodes: {V: Vectors, M: {type: Multiply, inputs: {a: {type: int, value: 2}}}}}")
    node: Any = graph.by_id("M").make_node()
    assert {field: str(settled) for field, settled in node.settled.items()} == {
        "a": "int",
        "b": "int",
        "product": "int",
    }
    assert repr(node.product) == "0"
    node.product = 7
    node.clear()
    assert repr(node.product) == "0"
    alone = Multiply(a=2, b=3)
    assert (alone.settled, alone.product) == ({}, None)


def test_before_its_first_pass_a_settled_output_can_be_converted_too(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, V: Vectors, M: {type: Multiply, inputs: {b: {type: int, value: 2}}}, Do: Do}
        connections:
          - Tick.tick -> Do.execIn
          - V.whole -> M.a
          - M.product -> Do.a
    """)
    assert run.tick() == ["Do 6"]


@pytest.mark.parametrize("role", ["pointd[3]", "colord[3]", "vectord[3]", "double[3]"])
def test_the_role_in_the_type_of_a_literal_does_not_matter(file: MakeFile, role: str) -> None:
    text = f"{{graph: g, nodes: {{B: {{type: Break, inputs: {{vector: {{type: '{role}', value: [1, 2, 3]}}}}}}}}}}"
    graph, findings = resolve(file, text)
    assert (codes(findings), types_of(graph, "B")["x"]) == ([], "double")


def test_the_name_of_a_long_union_is_shortened_in_messages() -> None:
    union = parse(
        "|".join(
            f"{base}{size}" for base in NUMBERS.split("|") for size in ("", "[]", "[2]", "[3]", "[2][]", "[3][]", "[4]")
        )
    )
    assert with_article(union) == (
        "a double | double[] | double[2] | double[3] | double[2][] | double[3][] | double[4] | float"
        " | … (20 more: `graphrun nodes --format json`)"
    )
    assert with_article(parse(NUMBERS)) == "a double | float | half | int"


def test_a_port_whose_type_nothing_settles_is_an_error_that_names_it(file: MakeFile) -> None:
    _, findings = resolve(file, "{graph: g, nodes: {M: Multiply, Show: Show}, connections: [M.product -> Show.value]}")
    assert "G213" in codes(findings)
    assert any("M.product" in finding.message for finding in findings.items)
    assert any("M.a" in finding.message for finding in findings.items)


@pytest.mark.parametrize("value", ["{type: token, value: x}", "{type: 'double[3]', value: [1, 2, 3]}", "[1, 2]", "x"])
def test_a_literal_that_no_alternative_takes_is_an_error(file: MakeFile, value: str) -> None:
    _, findings = resolve(file, f"{{graph: g, nodes: {{M: {{type: Multiply, inputs: {{a: {value}, b: 1}}}}}}}}")
    assert set(codes(findings)) <= {"G211", "G212", "G213"}
    assert findings.errors


@pytest.mark.parametrize("wire", ["V.text -> Show.a", "V.doubles -> Show.a", "V.text -> B.vector", "V.whole -> Text.a"])
def test_a_wire_between_types_that_do_not_match_is_an_error_at_the_wire(file: MakeFile, wire: str) -> None:
    _, findings = resolve(
        file,
        f"""
        nodes: {{V: Vectors, B: {{type: Break, inputs: {{vector: [1, 2, 3]}}}}, Show: Do, Text: Text}}
        connections:
          - {wire}
        """,
    )
    (found,) = findings.errors
    assert found.code == "G206"
    assert found.span is not None
    assert found.span.line == 4


# Dynamic ports


def test_literals_grow_ports_that_can_be_wired_and_set(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sums: {type: Sums, inputs: {count: 3, input2: 5.0}}, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.number -> Sums.input0
          - Tick.number -> Sums.input1
          - Sums.sum -> Show.a
    """)
    assert run.ticks(2) == [["Show 7"], ["Show 9"]]


def test_a_port_that_was_not_grown_is_unknown(file: MakeFile) -> None:
    _, findings = resolve(
        file, "{graph: g, nodes: {Tick: Tick, Sums: Sums}, connections: [Tick.number -> Sums.input2]}"
    )
    assert codes(findings) == ["G204"]


@pytest.mark.parametrize("count", ["0", "many", "1.5"])
def test_literals_from_which_no_ports_can_be_grown_are_an_error_at_the_inputs(file: MakeFile, count: str) -> None:
    _, findings = resolve(file, f"{{graph: g, nodes: {{Sums: {{type: Sums, inputs: {{count: {count}}}}}}}}}")
    assert codes(findings) == ["G211"]


# Literals


def test_a_literal_is_converted_to_the_representation_of_its_port(file: MakeFile) -> None:
    graph, findings = resolve(file, "{graph: g, nodes: {A: {type: Do, inputs: {a: 2, inputs:b: 3}}}}")
    assert codes(findings) == []
    assert (graph.by_id("A").make_node().a, graph.by_id("A").make_node().b) == (2.0, 3.0)  # type: ignore[attr-defined]
    assert isinstance(graph.by_id("A").make_node().a, float)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("inputs", "code"),
    [
        ("a: fast", "G211"),
        ("a: [1, 2]", "G211"),
        ("a: {x: 1}", "G211"),
        ("a: .nan", "G212"),
        ("speed: 1", "G204"),
        ("sum: 1.0", "G205"),
        ("execIn: 1", "G211"),
        ("exec_in: 1", "G204"),
    ],
)
def test_a_literal_that_is_not_legal_is_an_error_at_its_place(file: MakeFile, inputs: str, code: str) -> None:
    _, findings = resolve(file, f"graph: g\nnodes:\n  A:\n    type: Do\n    inputs: {{{inputs}}}\n")
    (found,) = findings.items
    assert (found.code, found.span and found.span.line) == (code, 5)


def test_every_mistake_in_a_file_is_reported(file: MakeFile) -> None:
    _, findings = resolve(
        file,
        """
        nodes: {Tick: Tick, A: {type: Do, inputs: {a: x}}, B: Dooo, C: Do}
        connections:
          - Tick.tick -> B.execIn
          - Tick.tick -> C.execOut
          - Tick.tick -> D.execIn
          - Tick.number -> C.execIn
          - Tick.number -> C.a
          - Tick.time -> C.a
          - C.nothing -> A.b
        """,
    )
    assert sorted(codes(findings)) == ["G201", "G203", "G204", "G205", "G206", "G207", "G211"]


def test_a_wire_with_a_wrong_type_causes_no_second_error(file: MakeFile) -> None:
    _, findings = resolve(
        file,
        """
        nodes: {V: Vectors, B: Break, S: omni.graph.action.SwitchToken}
        connections: [V.text -> B.vector, B.x -> S.value]
        """,
    )
    assert codes(findings) == ["G206"]


# Files that are parts of other graphs, looked at alone

PART = """
graph: part
inputs: {{go: A.execIn, value: M.a, {declared}}}
outputs: {{done: A.execOut, product: M.product}}
nodes: {{A: Do, M: {{type: Multiply, inputs: {{b: 2.0}}}}, N: Multiply, S: omni.graph.action.SwitchToken}}
connections: [M.product -> A.a]
"""


def test_a_declared_input_of_a_subgraph_is_not_reported_as_missing(file: MakeFile) -> None:
    graph, findings = resolve(file, PART.format(declared="a: N.a, b: N.b, branch: S.branch3"))
    assert codes(findings) == []
    assert list(graph.left_open) == ["N.a", "N.b"]


@pytest.mark.parametrize(
    ("declared", "code", "place"),
    [
        ("x: No.a", "G203", "No.a"),
        ("x: M.c", "G204", "M.c"),
        ("x: S.branch003", "G204", "S.branch003"),
        ("x: M.product", "G205", "M.product"),
        ("x: M a", "G202", "M a"),
    ],
)
def test_a_declared_port_that_does_not_exist_is_an_error(file: MakeFile, declared: str, code: str, place: str) -> None:
    _, findings = resolve(file, PART.format(declared=f"a: N.a, b: N.b, {declared}"))
    (found,) = findings.items
    assert found.span is not None
    line = found.span.source.lines[found.span.line - 1]
    assert (found.code, line[found.span.column - 1 :][: len(place)]) == (code, place)


def test_a_graph_with_open_inputs_cannot_run_alone(file: MakeFile) -> None:
    path = file("{graph: part, inputs: {angle: C.value}, nodes: {C: {type: omni.graph.nodes.Cos}}}")
    assembly = build.load(path)
    assert assembly.findings.items == []
    with pytest.raises(
        UsageError, match=r"part is a subgraph and gets C\.value from the graph that uses it; run that graph"
    ):
        build.start(assembly, Network())


def test_a_scene_that_uses_a_graph_with_open_inputs_is_an_error(file: MakeFile) -> None:
    part = file("{graph: part, inputs: {angle: C.value}, nodes: {C: {type: omni.graph.nodes.Cos}}}", "part.yaml")
    scene = part.with_name("scene.yaml")
    part.with_name("floor.xml").write_text("<mujoco/>")
    scene.write_text("scene: s\nworld: floor.xml\ngraphs: {part: {use: part.yaml}}\n")
    assembly = build.load(scene)
    assert codes(assembly.findings) == ["G208", "W102"]


@pytest.mark.parametrize("kind", ["any", "execution", "bundle", "double|float"])
def test_a_type_without_literals_is_an_error_in_a_value(file: MakeFile, kind: str) -> None:
    text = (
        f"graph: g\nnodes: {{A: {{type: omni.graph.nodes.ToString, inputs: {{value: {{type: {kind}, value: 1}}}}}}}}\n"
    )
    assembly = build.load(file(text))
    (found,) = assembly.findings.errors
    assert found.code in ("G211", "G212")


# Overrides


@pytest.mark.parametrize("text", ["A.a", "g/A.a", "*/A.a", "A.inputs:a", "?.a"])
def test_an_override_sets_the_matching_input(file: MakeFile, text: str) -> None:
    override = Override.parse(text, 5)
    graph, findings = resolve(file, "{graph: g, nodes: {A: {type: Do, inputs: {a: 1.0}}, BB: Do}}", override)
    assert codes(findings) == []
    assert override.used
    assert graph.by_id("A").make_node().a == 5.0  # type: ignore[attr-defined]
    assert graph.by_id("BB").make_node().a == 0.0  # type: ignore[attr-defined]


@pytest.mark.parametrize("text", ["B.a", "other/A.a", "A.c", "A.sum", "A.execIn", "robot/g/A.a"])
def test_an_override_without_a_matching_input_stays_unused(file: MakeFile, text: str) -> None:
    override = Override.parse(text, 5)
    resolve(file, "{graph: g, nodes: {A: Do}}", override)
    assert not override.used


@pytest.mark.parametrize(
    ("every", "text"), [("{hz: 20}", "A.every.hz"), ("{ticks: 2}", "g/A.every.ticks"), ("{ticks: 2}", "*.ticks")]
)
def test_an_override_can_set_the_value_of_every(file: MakeFile, every: str, text: str) -> None:
    override = Override.parse(text, 5)
    graph, findings = resolve(
        file,
        f"{{graph: g, nodes: {{T: Tick, A: {{type: Do, every: {every}}}}}, connections: [T.tick -> A.execIn]}}",
        override,
    )
    assert codes(findings) == []
    assert override.used
    assert getattr(graph.by_id("A.every").make_node(), override.port) == 5


@pytest.mark.parametrize(("text", "value"), [("A.every.hz", 0), ("A.every.hz", 20_000), ("A.every.hz", float("inf"))])
def test_an_override_of_every_has_the_bounds_of_the_file(file: MakeFile, text: str, value: float) -> None:
    _, findings = resolve(
        file,
        "{graph: g, nodes: {T: Tick, A: {type: Do, every: {hz: 1}}}, connections: [T.tick -> A.execIn]}",
        Override.parse(text, value),
    )
    assert codes(findings) == ["G212"]


def test_an_override_of_a_wrong_type_is_an_error(file: MakeFile) -> None:
    _, findings = resolve(file, "{graph: g, nodes: {A: Do}}", Override.parse("A.a", "fast"))
    assert codes(findings) == ["G211"]


# Variables


@pytest.mark.parametrize(("kind", "default"), [("double", "fast"), ("double|int", "1"), ("speed", "1"), ("int", "1.5")])
def test_a_variable_of_a_wrong_type_is_an_error(file: MakeFile, kind: str, default: str) -> None:
    _, findings = resolve(file, f"{{graph: g, variables: {{speed: {{type: {kind}, default: {default}}}}}}}")
    assert codes(findings) == ["G211"]


def test_variables_start_at_their_default_or_zero(file: MakeFile) -> None:
    graph, _ = resolve(
        file, "{graph: g, variables: {a: {type: 'double[3]'}, b: {type: int, default: 4}, c: {type: bool}}}"
    )
    assert graph.variables == {"a": (0.0, 0.0, 0.0), "b": 4, "c": False}
