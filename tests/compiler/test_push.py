"""Push graphs: every node in every pass, in the order of all wires."""

from __future__ import annotations

import pytest

from graphengine.compiler.every_gates import rate
from graphengine.format.diagnostics import Findings
from tests.compiler.conftest import MakeFile
from tests.compiler.harness import planned


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("nodes: {A: Add, B: Add}\nconnections: [A.sum -> B.a, B.sum -> A.a]", "G209"),
        ("nodes: {A: Do, B: Do}\nconnections: [A.execOut -> B.execIn, B.execOut -> A.execIn]", "G210"),
    ],
)
def test_a_cycle_in_a_push_graph_is_an_error(file: MakeFile, text: str, code: str) -> None:
    findings = Findings()
    assert planned(file(f"evaluator: push\n{text}"), findings) is None
    assert [found.code for found in findings.errors] == [code]


@pytest.mark.parametrize("name", ["dirty_push", "lazy", "pull"])
def test_other_evaluators_are_refused(file: MakeFile, name: str) -> None:
    findings = Findings()
    planned(file(f"evaluator: {name}\nnodes: {{A: Do}}"), findings)
    (found,) = findings.items
    assert found.code == "G109"
    assert "push" in found.message


def test_no_node_of_a_push_graph_is_reported_as_idle(file: MakeFile) -> None:
    from graphengine.runtime import check

    findings = Findings()
    graph = planned(file("evaluator: push\nnodes: {A: Do, B: Add}"), findings)
    assert graph is not None
    check.lint_structure(graph, findings)
    assert findings.items == []
    assert rate(graph, 0, 60.0) == 60.0
