"""Scripts that run the simulation: their loops run, and values set there are reported and stay out of the files."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.format.diagnostics import Findings
from graphengine.isaac.script.script_reader import ScriptOptions, read_script
from tests.isaac.harness import SCRIPTS, read_text

START = """\
from isaacsim import SimulationApp
app = SimulationApp()
import asyncio, time
import omni.graph.core as og
import omni.kit.app
import omni.timeline
keys = og.Controller.Keys
kit, timeline = omni.kit.app.get_app(), omni.timeline.get_timeline_interface()
og.Controller.edit("/G", {keys.CREATE_NODES: [("a", "x.A"), ("b", "x.B")], keys.SET_VALUES: [("a.inputs:x", 1.0)]})
x = og.Controller.attribute("/G/a.inputs:x")
def step():
    app.update()
"""


SETS = "the script sets /G/a.inputs:x while it runs the simulation; the graph file keeps the previous value"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("while app.is_running():\n    x.set(2.0)\n    app.update()", 2),
        ("while app.is_running():\n    app.update()\n    x.set(2.0)", 3),
        ("while kit.is_running() and not kit.is_exiting():\n    x.set(2.0)", 2),
        ("while not app.is_exiting():\n    x.set(2.0)", 2),
        ("timeline.play()\nwhile timeline.is_playing():\n    x.set(2.0)\n    kit.update()", 3),
        ("while True:\n    x.set(2.0)\n    step()", 2),
        ("while True:\n    step()\n    x.set(2.0)", 3),
        ("while True:\n    x.set(2.0)\n    time.sleep(0.1)", 2),
        ("for frame in range(1000):\n    if frame == 500: x.set(2.0)\n    step()", 2),
        ("while app.is_running():\n    app.update()\n    for value in (2.0, 3.0):\n        x.set(value)", 4),
        ("while app.is_running():\n    app.update()\nx.set(0.0)", 3),
        (
            "async def run():\n    while True:\n        x.set(2.0)\n        await kit.next_update_async()\nasyncio.run(run())",
            3,
        ),
        ("while True:\n    og.Controller.set(x, 2.0)\n    og.Controller.evaluate_sync('/G')", 2),
    ],
)
def test_what_is_set_while_frames_go_by_is_told_and_is_not_frozen(text: str, line: int, tmp_path: Path) -> None:
    (graph,), warnings, _ = read_text(tmp_path, text, START)
    assert warnings == [f"{line}: {SETS}"]
    assert graph.nodes["a"].values["inputs:x"].data == 1.0


@pytest.mark.parametrize(
    "text",
    [
        "for _ in range(20): app.update()\nx.set(2.0)",
        "while app.is_running():\n    app.update()\n    break\nx.set(2.0)",
        "for attribute in (x, x):\n    attribute.set(2.0)\n    step()",
        "for _ in range(2): x.set(2.0)",
        "for _ in range(2):\n    x.set(2.0)\n    print(timeline.get_current_time())",
    ],
)
def test_what_is_set_before_or_between_frames_is_how_the_graph_is_built(text: str, tmp_path: Path) -> None:
    (graph,), warnings, _ = read_text(tmp_path, text, START)
    assert warnings == []
    assert graph.nodes["a"].values["inputs:x"].data == 2.0


@pytest.mark.parametrize(
    "loop",
    ["while app.is_running():", "while True:", "for frame in range(50):", "while timeline.is_playing():"],
)
def test_a_graph_that_a_loop_builds_is_whole(loop: str, tmp_path: Path) -> None:
    text = """
    step()
    if not built:
        og.Controller.edit("/H", {keys.CREATE_NODES: [("c", "x.C")], keys.SET_VALUES: [("c.inputs:x", 1)]})
        og.Controller.attribute("/H/c.inputs:y").set(2)
        built = True
    else:
        og.Controller.attribute("/H/c.inputs:y").set(3)
"""
    (_, graph), warnings, _ = read_text(tmp_path, f"built = False\n{loop}{text}", START)
    assert {name: value.data for name, value in graph.nodes["c"].values.items()} == {"inputs:x": 1, "inputs:y": 2}
    assert [warning.partition(":")[0] for warning in warnings] == ["9"]


def test_a_variable_keeps_its_default(tmp_path: Path) -> None:
    text = """
graph = og.Controller.graph("/G")
speed = graph.create_variable("speed", og.Type(og.BaseDataType.DOUBLE))
speed.set(graph, 0.5)
while app.is_running():
    og.Controller.set_variable_default_value(("speed", graph), 0.0)
"""
    (graph,), warnings, _ = read_text(tmp_path, text, START)
    assert graph.variables["speed"].data == 0.5
    assert [warning[: warning.index(" while")] for warning in warnings] == ["6: the script sets /G/speed"]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("while app.is_running():\n    og.Controller.set('/G/c.inputs:x', 1)", "OmniGraphError"),
        ("while app.is_running():\n    kit.update()\n    memoryview(timeline.get_current_time())", "TypeError"),
        (
            "while app.is_running():\n    app.update()\n    while True: pass",
            "the script takes longer than its time limit",
        ),
        ("while app.is_running():\n    app.update()\n    open('/etc/passwd')", "not allowed for scripts"),
    ],
)
def test_a_loop_that_fails_leaves_what_was_built(text: str, complaint: str, tmp_path: Path) -> None:
    (graph,), (warning,), _ = read_text(tmp_path, text, START, seconds=2.0)
    assert complaint in warning
    assert list(graph.nodes) == ["a", "b"]


def test_a_graph_that_is_removed_after_the_loop_is_kept(tmp_path: Path) -> None:
    text = "while app.is_running():\n    app.update()\nomni.usd.get_context().get_stage().RemovePrim('/G')"
    graphs, warnings, _ = read_text(tmp_path, text, START)
    assert ([graph.path for graph in graphs], warnings) == (["/G"], [])


def test_impulses_of_a_loop_become_ticks_where_that_is_asked_for() -> None:
    script = SCRIPTS / "main_loop.py"
    findings, asked = Findings(), Findings()
    drive, _ = read_script(script, findings)
    assert drive.nodes["Impulse"].type == "omni.graph.action.OnImpulseEvent"
    (advice,) = [finding.help for finding in findings.warnings if "impulses" in finding.message]
    assert "--impulse-every 1 lets the node fire every tick" in advice
    drive, _ = read_script(script, asked, options=ScriptOptions(impulse_every=3))
    assert drive.nodes["Impulse"].type == "omni.graph.action.OnTick"
    assert drive.nodes["Impulse"].values["inputs:framePeriod"].data == 2
    assert "Impulse.outputs:tick -> Clock.inputs:execIn" in map(str, drive.wires)
    assert not [finding for finding in asked.warnings if "mpulse" in finding.message]
