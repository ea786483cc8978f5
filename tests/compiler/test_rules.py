"""The rules of a pass by example: graphs, and what their nodes write in each tick, in `rules.yaml`.

Beside the keys of a graph file, an example has

    play        each step is a tick, as the lines that nodes write in it, or one of
                `set` and `holds`: what ports get, or must have; `post`: messages for the next tick;
                `computes`: how often data nodes were computed since this was last stated; `stop`
    setup       the lines that nodes write in setup, if they matter
    order       all nodes that can run, in the order of their setup
    findings    codes of all findings, with their messages where they matter; none unless stated
    faults      the nodes that raise, one after the other, in a run that keeps going
    dropped     the number of ticks in which each node dropped values; none unless stated
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from tests.compiler.conftest import MakeBench
from tests.compiler.harness import Bench

RULES = document.load(Path(__file__).with_name("rules.yaml"), Findings())
assert RULES is not None
EXAMPLES = {f"{rule}: {name}": case for rule, cases in RULES.root.to_data().items() for name, case in cases.items()}

STATED = ("play", "setup", "order", "findings", "faults", "dropped")


@pytest.mark.parametrize("example", EXAMPLES.values(), ids=EXAMPLES)
def test_a_graph_keeps_to_the_rules(bench: MakeBench, example: dict[str, Any]) -> None:
    stated = {key: example[key] for key in STATED if key in example}
    graph = {key: value for key, value in example.items() if key not in stated}
    run = bench(yaml.safe_dump(graph, sort_keys=False), keep_going="faults" in stated)
    written = run.journal.read()
    assert written == stated.get("setup", written)
    for step in stated["play"]:
        if isinstance(step, list):
            assert run.tick() == step
        elif step == "stop":
            run.stop()
        else:
            (action,) = step
            take(run, action, step[action])
    findings = stated.get("findings", [])
    assert run.codes == [text.partition(" ")[0] for text in findings]
    messages = {f"{finding.code} {finding.message}" for finding in run.findings.items}
    assert {text for text in findings if " " in text} <= messages
    ids = [run.graph.instances[index].id for index in run.plan.order]
    assert ids == stated.get("order", ids)
    assert [str(fault).partition(": node ")[2].partition(" ")[0] for fault in run.faults] == stated.get("faults", [])
    assert all(type(fault.__cause__).__name__ in str(fault) for fault in run.faults)
    assert run.services.dropped is not None
    dropped = {path.rpartition("/")[2]: ticks for path, ticks in run.services.dropped.ticks.items()}
    assert dropped == stated.get("dropped", {})


def take(run: Bench, action: str, arguments: Any) -> None:
    """A step that is no tick."""
    if action == "post":
        for value in arguments:
            run.services.queues["messages"].post(value)
        return
    for address, value in arguments.items():
        node, _, field = address.partition(".")
        if action == "set":
            setattr(run[node], field, value)
        elif action == "holds":
            assert getattr(run[node], field) == value
        else:
            assert action == "computes"
            assert run[node].computes == value
            run[node].computes = 0
