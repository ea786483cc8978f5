"""Parameters and subgraphs: what they become, and where their mistakes are told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.compiler.graph import Graph
from graphengine.format.diagnostics import Finding, Findings
from tests.compiler.conftest import MakeFile
from tests.compiler.harness import Bench, planned, resolved


def resolve(path: Path, **bindings: Any) -> tuple[Graph | None, list[Finding]]:
    findings = Findings()
    return resolved(path, findings, bindings), findings.items


def literal(graph: Graph | None, node: str, field: str) -> Any:
    assert graph is not None
    return getattr(graph.by_id(node).make_node(), field)


# Parameters


PARAMETERS = """
    parameters:
      robot: {type: target, default: /dd100}
      speed: {type: double, default: 1}
      name: {type: string, default: scan}
    nodes:
      A: {type: Do, inputs: {a: $(speed)}}
      T: {type: Text, inputs: {a: $(robot)/Geometry, b: $(name)_$(speed)_$$(name)}}
"""


def test_a_value_that_is_only_a_parameter_keeps_the_type_of_the_parameter(file: MakeFile) -> None:
    graph, findings = resolve(file(PARAMETERS))
    assert findings == []
    assert literal(graph, "A", "a") == 1.0


def test_parameters_within_a_text_become_text_and_two_dollars_become_one(file: MakeFile) -> None:
    graph, _ = resolve(file(PARAMETERS))
    assert literal(graph, "T", "a") == "/dd100/Geometry"
    assert literal(graph, "T", "b") == "scan_1.0_$(name)"


def test_a_use_of_a_graph_can_set_other_values(file: MakeFile) -> None:
    graph, findings = resolve(file(PARAMETERS), speed=2, robot="/other", name="odom")
    assert findings == []
    assert literal(graph, "A", "a") == 2.0
    assert literal(graph, "T", "a") == "/other/Geometry"


@pytest.mark.parametrize(("bindings", "code"), [({"sped": 1}, "G111"), ({"speed": "fast"}, "G211")])
def test_a_value_for_no_parameter_or_of_a_wrong_type_is_an_error(
    file: MakeFile, bindings: dict[str, Any], code: str
) -> None:
    _, findings = resolve(file(PARAMETERS), **bindings)
    assert code in [finding.code for finding in findings]


def test_an_unknown_parameter_is_an_error_at_its_place_with_the_nearest_name(file: MakeFile) -> None:
    _, findings = resolve(
        file(
            "graph: g\nparameters: {speed: {type: double, default: 1}}\nnodes:\n  A: {type: Text, inputs: {a: a$(sped)b}}\n"
        )
    )
    (found,) = findings
    assert (found.code, found.span and (found.span.line, found.span.column, found.span.length)) == ("G111", (4, 32, 7))
    assert found.help == ("did you mean 'speed'?",)


def test_parameters_in_keys_and_types_are_not_replaced(file: MakeFile) -> None:
    _, findings = resolve(file("graph: g\nparameters: {kind: {type: string, default: Do}}\nnodes:\n  A: $(kind)\n"))
    assert [found.code for found in findings] == ["G201"]


# Subgraphs


INNER = """
    graph: inner
    inputs: {go: First.execIn, speed: First.a}
    outputs: {done: Second.execOut, sum: Second.sum}
    nodes:
      First: Do
      Second: {type: Do, inputs: {b: 1.0}}
    connections:
      - First.execOut -> Second.execIn
      - First.sum -> Second.a
"""
OUTER = """
    graph: outer
    nodes:
      Tick: Tick
      One: {subgraph: inner.yaml}
      Two: {subgraph: inner.yaml}
      Show: Do
    connections:
      - Tick.tick -> One.go
      - Tick.number -> One.speed
      - One.done -> Two.go
      - One.sum -> Two.speed
      - Two.done -> Show.execIn
      - Two.sum -> Show.a
"""


def test_a_subgraph_stands_for_its_nodes(file: MakeFile) -> None:
    file(INNER, "inner.yaml")
    run = Bench(file(OUTER, "outer.yaml")).setup()
    assert [instance.id for instance in run.graph.instances] == [
        *("Tick", "One/First", "One/Second", "Two/First", "Two/Second", "Show")
    ]
    assert run.tick() == ["First 1", "Second 2", "First 2", "Second 3", "Show 3"]


def test_subgraphs_nest(file: MakeFile) -> None:
    file(INNER, "inner.yaml")
    file(
        """
        graph: middle
        nodes: {Tick: Tick, Inner: {subgraph: inner.yaml}}
        connections: [Tick.tick -> Inner.go, Tick.number -> Inner.speed]
        """,
        "middle.yaml",
    )
    run = Bench(file("{graph: outer, nodes: {Middle: {subgraph: middle.yaml}}}", "outer.yaml")).setup()
    assert [instance.id for instance in run.graph.instances][1] == "Middle/Inner/First"
    assert run.tick() == ["First 1", "Second 2"]


def tell(file: MakeFile, inner: str, outer: str = OUTER) -> list[Finding]:
    file(inner, "inner.yaml")
    findings = Findings()
    planned(file(outer, "outer.yaml"), findings)
    return findings.items


def place(finding: Finding) -> tuple[str, int]:
    assert finding.span is not None
    return Path(finding.span.source.path).name, finding.span.line


def through(finding: Finding) -> list[str]:
    return [label for _, label in finding.related if label.startswith("in subgraph")]


@pytest.mark.parametrize(
    ("before", "after", "code", "line"),
    [
        ("First: Do", "First: Dooo", "G201", 5),
        ("b: 1.0", "b: fast", "G211", 6),
        ("b: 1.0", "c: 1.0", "G204", 6),
        ("First.execOut ->", "Fist.execOut ->", "G203", 8),
        ("-> Second.a", "-> Second.z", "G204", 9),
        ("First.sum -> Second.a", "First.sum -> Second.execIn", "G206", 9),
        ("First.sum -> Second.a", "Second.sum -> First.b", "W104", 9),
        ("First.sum -> Second.a", "First.sum -> Second.b", "W103", 6),
        ("First.execOut -> Second.execIn", "First.a -> Second.a", "G207", 9),
        ("First.execOut ->", "First.inputs:execIn ->", "G205", 8),
        ("First.sum -> Second.a", "Second.execOut -> First.execIn", "G210", 8),
    ],
)
def test_a_mistake_in_a_subgraph_is_reported_at_its_position_with_the_instance(
    file: MakeFile, before: str, after: str, code: str, line: int
) -> None:
    findings = [finding for finding in tell(file, INNER.replace(before, after)) if finding.code == code]
    assert [place(finding) for finding in findings] == [("inner.yaml", line)] * 2
    assert [through(finding) for finding in findings] == [["in subgraph One"], ["in subgraph Two"]]


def test_a_declared_port_of_an_unknown_node_is_an_error_at_its_declaration(file: MakeFile) -> None:
    found = tell(file, INNER.replace("sum: Second.sum", "sum: Third.sum"))[0]
    assert (found.code, place(found)) == ("G203", ("inner.yaml", 3))


@pytest.mark.parametrize("declared", ["Second", "Second.a.b", "-> Second.sum", ""])
def test_a_malformed_declared_port_is_an_error_at_its_declaration(file: MakeFile, declared: str) -> None:
    found = tell(file, INNER.replace("sum: Second.sum", f"sum: '{declared}'"))[0]
    assert (found.code, place(found)) == ("G202", ("inner.yaml", 3))


def test_an_undeclared_port_of_a_subgraph_is_an_error_at_the_wire(file: MakeFile) -> None:
    found = tell(file, INNER, OUTER.replace("One.sum", "One.total"))[0]
    assert (found.code, place(found)) == ("G204", ("outer.yaml", 11))


SET = """
    graph: outer
    nodes:
      Tick: Tick
      One: {subgraph: inner.yaml, inputs: {speed: 5}}
      Two: {subgraph: inner.yaml, inputs: {inputs:speed: 7}}
    connections: [Tick.tick -> One.go, One.done -> Two.go]
"""


def test_values_of_a_subgraphs_inputs_are_set_where_it_is_used(file: MakeFile) -> None:
    file(INNER, "inner.yaml")
    run = Bench(file(SET, "outer.yaml")).setup()
    assert run.tick() == ["First 5", "Second 6", "First 7", "Second 8"]


def test_a_value_from_outside_takes_the_place_of_one_inside(file: MakeFile) -> None:
    file(INNER.replace("First: Do", "First: {type: Do, inputs: {inputs:a: 2.0}}"), "inner.yaml")
    assert Bench(file(SET, "outer.yaml")).setup().tick()[0] == "First 5"


@pytest.mark.parametrize(
    ("value", "code", "column"),
    [("speed: fast", "G211", 47), ("sped: 5", "G204", 40), ("go: 1", "G211", 40), ("speed: [1, fast]", "G211", 47)],
)
def test_a_wrong_value_for_an_input_of_a_subgraph_is_an_error_at_the_value(
    file: MakeFile, value: str, code: str, column: int
) -> None:
    found = tell(file, INNER, SET.replace("speed: 5", value))[0]
    assert (found.code, place(found)) == (code, ("outer.yaml", 4))
    assert found.span is not None
    assert found.span.column == column


SCALED = """
    graph: scaled
    parameters: {factor: {type: double, default: 2.0}, label: {type: string}}
    inputs: {go: Do.execIn}
    nodes:
      Do: {type: Do, inputs: {a: $(factor)}}
      Text: {type: Text, inputs: {a: of $(label)}}
"""
USES = """
    graph: outer
    parameters: {side: {type: string, default: left}}
    nodes:
      Tick: Tick
      One: {subgraph: scaled.yaml, parameters: {factor: 3, label: $(side)}}
      Two: {subgraph: scaled.yaml, parameters: {label: right}}
    connections: [Tick.tick -> One.go, Tick.tick -> Two.go]
"""


def test_each_use_of_a_subgraph_gives_values_for_its_parameters(file: MakeFile) -> None:
    file(SCALED, "scaled.yaml")
    graph, findings = resolve(file(USES, "outer.yaml"))
    assert findings == []
    assert [literal(graph, f"{use}/Do", "a") for use in ("One", "Two")] == [3.0, 2.0]
    assert [literal(graph, f"{use}/Text", "a") for use in ("One", "Two")] == ["of left", "of right"]


@pytest.mark.parametrize(
    ("given", "code", "underlined"),
    [
        ("factor: fast, label: a", "G211", "fast"),
        ("factr: 3, label: a", "G111", "factr"),
        ("factor: 3", "G107", "scaled.yaml"),
        ("label: $(sid)", "G111", "$(sid)"),
    ],
)
def test_a_wrong_value_for_a_parameter_of_a_subgraph_is_one_error_at_the_value(
    file: MakeFile, given: str, code: str, underlined: str
) -> None:
    file(SCALED, "scaled.yaml")
    _, (found,) = resolve(file(USES.replace("factor: 3, label: $(side)", given), "outer.yaml"))
    assert (found.code, place(found)) == (code, ("outer.yaml", 5))
    span = found.span
    assert span is not None
    assert span.source.lines[4][span.column - 1 : span.column - 1 + span.length] == underlined


def test_parameters_of_a_node_that_is_no_subgraph_are_an_error(file: MakeFile) -> None:
    _, (found,) = resolve(file("{graph: g, nodes: {A: {type: Do, parameters: {a: 1}}}}"))
    assert (found.code, found.message) == (
        "G109",
        "A: only a node with a `subgraph` has `parameters`; set port values under `inputs:`",
    )


def test_a_value_and_a_wire_at_one_input_of_a_subgraph_are_a_warning(file: MakeFile) -> None:
    found = tell(
        file, INNER, OUTER.replace("Two: {subgraph: inner.yaml}", "Two: {subgraph: inner.yaml, inputs: {speed: 1}}")
    )
    assert [(finding.code, place(finding)) for finding in found] == [("W103", ("outer.yaml", 5))]


SHARED = """
    graph: shared
    inputs: {go: [First.execIn, Second.execIn], speed: [First.a, Second.a, Second.b]}
    nodes: {First: Do, Second: Do}
"""


def test_an_input_of_a_subgraph_leads_to_all_ports_that_it_names(file: MakeFile) -> None:
    file(SHARED, "shared.yaml")
    file(
        "{graph: middle, inputs: {go: [A.go, B.go], speed: [A.speed, B.speed]}, "
        "nodes: {A: {subgraph: shared.yaml}, B: {subgraph: shared.yaml}}}",
        "middle.yaml",
    )
    wired = "connections: [Tick.tick -> M.go, Tick.number -> M.speed]"
    outer = "graph: outer\nnodes: {{Tick: Tick, M: {{subgraph: middle.yaml{}}}}}\n{}\n"
    run = Bench(file(outer.format("", wired), "outer.yaml")).setup()
    assert run.tick() == ["First 1", "Second 2", "First 1", "Second 2"]
    given = outer.format(", inputs: {speed: 5}", "connections: [Tick.tick -> M.go]")
    assert Bench(file(given, "set.yaml")).setup().tick() == ["First 5", "Second 10"] * 2


@pytest.mark.parametrize("declared", ["[]", "[First.execIn, nonsense]", "[First.execIn, 'A.b.c']"])
def test_a_declared_input_without_ports_is_an_error_at_its_declaration(declared: str, file: MakeFile) -> None:
    path = file(SHARED.replace("[First.execIn, Second.execIn]", declared), "shared.yaml")
    assert [finding.code for finding in resolve(path)[1]] == ["G202"]


def test_inputs_that_double_at_each_level_are_refused_before_they_fill_the_memory(file: MakeFile) -> None:
    file(SHARED, "level0.yaml")
    for level in range(1, 16):
        inner = f"{{subgraph: level{level - 1}.yaml}}"
        text = f"graph: l\ninputs: {{go: [A.go, A.go, A.go, A.go]}}\nnodes: {{A: {inner}}}\n"
        path = file(text, f"level{level}.yaml")
    assert [finding.code for finding in resolve(path)[1]] == ["G105"]


MIDDLE = """
    graph: middle
    inputs: {run: Inner.go, speed: Inner.speed}
    outputs: {end: Inner.done, total: Inner.sum}
    nodes: {Inner: {subgraph: inner.yaml}}
"""


def test_ports_of_a_subgraph_lead_into_another_subgraph(file: MakeFile) -> None:
    file(INNER, "inner.yaml")
    file(MIDDLE, "middle.yaml")
    run = Bench(
        file(
            """
            graph: outer
            nodes:
              Tick: Tick
              Wired: {subgraph: middle.yaml}
              Set: {subgraph: middle.yaml, inputs: {speed: 10}}
            connections:
              - Tick.tick -> Wired.run
              - Tick.number -> Wired.speed
              - Wired.end -> Set.run
            """,
            "outer.yaml",
        )
    ).setup()
    assert run.tick() == ["First 1", "Second 2", "First 10", "Second 11"]


def test_a_mistake_two_subgraphs_deep_is_reported_with_both_instances(file: MakeFile) -> None:
    file(MIDDLE.replace("speed: Inner.speed", "speed: Inner.sped"), "middle.yaml")
    outer = "{graph: o, nodes: {T: Tick, A: {subgraph: middle.yaml}}, connections: [T.number -> A.speed]}"
    found = tell(file, INNER, outer)[0]
    assert (found.code, place(found)) == ("G204", ("middle.yaml", 2))


STORE = """
    graph: store
    variables: {speed: {type: double, default: 1}}
    inputs: {go: Write.execIn, value: Write.value}
    outputs: {done: Show.execOut}
    nodes:
      Read: ReadVariable
      Write: WriteVariable
      Show: Do
    connections: [Write.execOut -> Show.execIn, Read.value -> Show.a]
"""
STORES = """
    graph: outer
    variables: {speed: {type: double, default: 9}}
    nodes:
      Tick: Tick
      Here: ReadVariable
      Show: Do
      A: {subgraph: store.yaml, inputs: {value: 3}}
      B: {subgraph: store.yaml, inputs: {value: 4}}
    connections:
      - Tick.tick -> A.go
      - A.done -> B.go
      - B.done -> Show.execIn
      - Here.value -> Show.a
"""


def test_each_use_of_a_subgraph_has_variables_of_its_own(file: MakeFile) -> None:
    file(STORE, "store.yaml")
    run = Bench(file(STORES, "outer.yaml")).setup()
    assert run.tick() == ["Write 3", "Show 3", "Write 4", "Show 4", "Show 9"]
    assert {name: variable.value for name, variable in run.variables.items()} == {
        "speed": 9,
        "A/speed": 3,
        "B/speed": 4,
    }
    assert run.findings.items == []


def test_a_subgraph_without_a_variable_uses_the_variable_of_the_graph_around_it(file: MakeFile) -> None:
    file(STORE.replace("variables: {speed: {type: double, default: 1}}", "doc: none"), "store.yaml")
    run = Bench(file(STORES, "outer.yaml")).setup()
    assert run.tick()[-1] == "Show 4"
    assert list(run.variables) == ["speed"]


def test_a_wrong_default_of_a_variable_of_a_subgraph_is_an_error_at_the_default(file: MakeFile) -> None:
    file(STORE.replace("default: 1", "default: fast"), "store.yaml")
    findings = Findings()
    planned(file("{graph: o, nodes: {A: {subgraph: store.yaml}}}", "o.yaml"), findings)
    assert [(found.code, place(found)) for found in findings.errors] == [("G211", ("store.yaml", 2))]


def test_a_missing_subgraph_file_is_an_error_at_its_name(file: MakeFile) -> None:
    found = tell(file, INNER, "{graph: outer, nodes: {One: {subgraph: innr.yaml}}}")[0]
    assert (found.code, place(found)) == ("G214", ("outer.yaml", 1))


def test_a_subgraph_that_contains_itself_is_an_error(file: MakeFile) -> None:
    found = tell(
        file, "{graph: inner, nodes: {Again: {subgraph: inner.yaml}}}", "{graph: o, nodes: {A: {subgraph: inner.yaml}}}"
    )[0]
    assert found.code == "G214"
    assert "inner.yaml -> inner.yaml" in found.message


def test_two_subgraphs_that_contain_each_other_are_an_error(file: MakeFile) -> None:
    file("{graph: b, nodes: {A: {subgraph: a.yaml}}}", "b.yaml")
    findings = Findings()
    planned(file("{graph: a, nodes: {B: {subgraph: b.yaml}}}", "a.yaml"), findings)
    assert [found.code for found in findings.items] == ["G214"]
    assert "a.yaml -> b.yaml -> a.yaml" in findings.items[0].message


def test_subgraphs_nest_16_deep_and_no_deeper(file: MakeFile) -> None:
    file("{graph: last, nodes: {A: Do}}", "g0.yaml")
    for depth in range(1, 20):
        file(f"{{graph: g, nodes: {{A: {{subgraph: g{depth - 1}.yaml}}}}}}", f"g{depth}.yaml")
    for depth, expected in ((16, []), (17, ["G214"])):
        findings = Findings()
        planned(file(f"{{graph: g, nodes: {{A: {{subgraph: g{depth - 1}.yaml}}}}}}", "top.yaml"), findings)
        assert [found.code for found in findings.items] == expected


# Wires


@pytest.mark.parametrize(
    "wire", ["A.execOut", "A.execOut -> ", "A.execOut -> B", "A -> B.execIn", "A.x -> B.y -> C.z", "->"]
)
def test_a_malformed_wire_is_an_error_at_its_place(file: MakeFile, wire: str) -> None:
    path = file(f"graph: g\nnodes: {{A: Do, B: Do}}\nconnections:\n  - '{wire}'\n")
    _, findings = resolve(path)
    assert [(found.code, place(found)) for found in findings] == [("G202", ("g.yaml", 4))]


def test_ends_of_wires_can_state_the_side_of_the_port(file: MakeFile) -> None:
    graph, findings = resolve(
        file("""
        nodes: {A: Do, B: Do}
        connections:
          - A.outputs:execOut -> B.inputs:execIn
          - A.outputs:sum -> B.inputs:a
          - A.inputs:a -> B.inputs:b
        """)
    )
    assert findings == []
    assert graph is not None
    assert len(graph.exec_wires) + len(graph.data_wires) == 3
