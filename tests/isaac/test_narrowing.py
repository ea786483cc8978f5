"""Wires from double to float, which graph files need a converter for."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.isaac.recorded_graph import RecordedGraph, RecordedNode, RecordedValue, RecordedWire
from tests.isaac.harness import composed, graph, resolved

TICK = "omni.graph.action.OnPlaybackTick"
CONVEYOR = "isaacsim.asset.gen.conveyor.IsaacConveyor"


def conveyors(*names: str, **others: RecordedNode) -> RecordedGraph:
    """Conveyors that get their time from one event node."""
    belts = [RecordedNode(name, CONVEYOR, {"inputs:conveyorPrim": RecordedValue("/World/belt")}) for name in names]
    pairs = [("outputs:deltaSeconds", "inputs:delta"), ("outputs:tick", "inputs:onStep")]
    wires = [RecordedWire("Tick", source, name, target) for name in names for source, target in pairs]
    return graph(RecordedNode("Tick", TICK), *belts, *others.values(), wires=wires)


def test_one_converter_feeds_all_inputs_that_an_output_is_wired_to(tmp_path: Path) -> None:
    text, findings = composed(conveyors("One", "Two"))
    assert [finding.code for finding in findings.items] == ["N301"]
    assert findings.items[0].help == (
        "the node Tick_deltaSeconds_as_float of type ToFloat is inserted to convert the value",
    )
    (tmp_path / "g.yaml").write_text(text, "utf-8")
    found, told = resolved(tmp_path / "g.yaml")
    assert told.items == []
    assert len(found.instances) == 4
    assert text.count("Tick_deltaSeconds_as_float.converted ->") == 2
    assert text.count("-> Tick_deltaSeconds_as_float.value") == 1


def test_a_converter_takes_no_name_that_is_taken() -> None:
    taken = RecordedNode("Tick_deltaSeconds_as_float", TICK)
    text, _ = composed(conveyors("One", other=taken))
    assert "Tick_deltaSeconds_as_float_: omni.graph.nodes.ToFloat" in text


@pytest.mark.parametrize("source", ["outputs:frame", "outputs:nowhere"])
def test_other_wires_stay_as_they_are(source: str) -> None:
    """The frame is a double too, but goes to an input of any type."""
    wire = RecordedWire("Tick", source, "Text", "inputs:value")
    recorded = graph(RecordedNode("Tick", TICK), RecordedNode("Text", "omni.graph.nodes.ToString"), wires=[wire])
    text, _ = composed(recorded)
    assert "ToFloat" not in text
    assert recorded.wires == [wire]
