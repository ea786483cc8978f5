"""Callbacks that scripts register: they run after the script, and each edit of a graph in them is reported at its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.isaac.script.script_reader import ScriptOptions
from tests.isaac.harness import Read, read_text

START = """\
from isaacsim import SimulationApp
app = SimulationApp()
import functools
import carb, omni.kit.app, omni.physx, rclpy
import omni.graph.core as og
from isaacsim.core.api import World
from isaacsim.core.simulation_manager import SimulationManager
keys, world = og.Controller.Keys, World()
og.Controller.edit("/G", {keys.CREATE_NODES: [("a", "x.A"), ("b", "x.B")], keys.SET_VALUES: [("a.inputs:x", 1.0)]})
x = og.Controller.attribute("/G/a.inputs:x")
"""
LOOP = "\nwhile app.is_running():\n    world.step(render=True)\napp.close()\n"
SETS = "the script sets /G/a.inputs:x while it runs the simulation; the graph file keeps the previous value"


def read(folder: Path, text: str, **options: int) -> Read:
    return read_text(folder, text + LOOP, START, seconds=5.0, options=ScriptOptions(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "registers",
    [
        "world.add_physics_callback('drive', step)",
        "world.add_render_callback('drive', callback_fn=step)",
        "sub = omni.physx.get_physx_interface().subscribe_physics_step_events(step)\nsub.unsubscribe()",
        "omni.physx.get_physx_simulation_interface().subscribe_physics_on_step_events(step, False, 0)",
        "omni.kit.app.get_app().get_update_event_stream().create_subscription_to_pop(step, name='drive')",
        "SimulationManager.register_callback(step, event=1)",
        "carb.eventdispatcher.get_eventdispatcher().observe_event(event_name='update', on_event=step)",
        "world.add_physics_callback('drive', functools.partial(step))",
        "world.add_physics_callback('drive', lambda dt: step(dt))",
        "rclpy.create_node('n').create_subscription(object, 'topic', step, 10)",
        "rclpy.create_node('n').create_timer(0.1, functools.partial(step, 0.1))",
    ],
)
@pytest.mark.parametrize(
    "sets",
    ["x.set(2.0)", "og.Controller.set(x, 2.0)", "og.Controller.edit('/G', {keys.SET_VALUES: [('a.inputs:x', 2.0)]})"],
)
def test_what_a_callback_sets_is_told_at_its_line_and_is_not_frozen(registers: str, sets: str, tmp_path: Path) -> None:
    (graph,), warnings, _ = read(tmp_path, f"def step(dt):\n    {sets}\n{registers}")
    assert warnings == [f"2: {SETS}"]
    assert graph.nodes["a"].values["inputs:x"].data == 1.0


def test_methods_and_coroutines_are_callbacks_too(tmp_path: Path) -> None:
    text = """
class Robot:
    def __init__(self):
        self.steps = 0
        world.add_physics_callback("a", self.step)
        world.add_physics_callback("b", self.later)
    def step(self, dt, *, scale):
        self.steps += 1
        if self.steps == 50:
            x.set(scale)
    async def later(self, dt):
        og.Controller.attribute("/G/b.inputs:y").set(1)
Robot()
"""
    _, warnings, _ = read(tmp_path, text)
    assert sorted(warnings) == [f"10: {SETS}", f"12: {SETS.replace('a.inputs:x', 'b.inputs:y')}"]


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        ("og.Controller.create_node('/G/c', 'x.C')", "3: a callback of the script adds the node c of /G"),
        (
            "og.Controller.connect(x, '/G/b.inputs:x')",
            "3: a callback of the script adds the wire a.inputs:x -> b.inputs:x",
        ),
        ("og.Controller.create_variable('/G', 'v', 'int')", "3: a callback of the script adds the variable v of /G"),
    ],
)
def test_what_a_callback_builds_in_a_graph_stays_out_of_the_file(edit: str, told: str, tmp_path: Path) -> None:
    text = f"def step(dt):\n    pass\n    {edit}\nworld.add_physics_callback('drive', step)"
    (graph,), (warning,), _ = read(tmp_path, text)
    assert warning.startswith(told)
    assert (list(graph.nodes), graph.wires, graph.variables) == (["a", "b"], [], {})


def test_a_node_that_a_callback_removes_stays(tmp_path: Path) -> None:
    text = "def step(dt):\n    og.Controller.delete_node('/G/a')\nworld.add_physics_callback('drive', step)"
    (graph,), _, findings = read(tmp_path, text)
    assert [finding.message.partition(";")[0] for finding in findings.warnings] == [
        "a callback of the script removes the node a of /G"
    ]
    assert graph.nodes["a"].values["inputs:x"].data == 1.0


def test_a_graph_that_a_callback_builds_is_imported(tmp_path: Path) -> None:
    text = "def play(event):\n    og.Controller.edit('/H', {keys.CREATE_NODES: [('c', 'x.C')]})\n"
    (_, graph), warnings, _ = read(tmp_path, f"{text}world.add_timeline_callback('play', play)")
    assert (graph.path, list(graph.nodes), warnings) == ("/H", ["c"], [])


@pytest.mark.parametrize(
    ("before", "why"),
    [("if dt > 1:", "the condition at line 12"), ("{}['b']\n    if True:", "the error at line 12: KeyError: 'b'")],
)
def test_what_a_callback_does_not_reach_is_told_with_the_reason(before: str, why: str, tmp_path: Path) -> None:
    text = f"def step(dt):\n    {before}\n        x.set(2.0)\nworld.add_physics_callback('drive', step)"
    (graph,), (warning,), _ = read(tmp_path, text)
    assert warning.endswith(f"set() is never reached, because of {why}")
    assert graph.nodes["a"].values["inputs:x"].data == 1.0


@pytest.mark.parametrize("body", ["while True: pass", "while True: world.get_physics_dt()"])
def test_a_callback_without_end_leaves_what_was_built(body: str, tmp_path: Path) -> None:
    text = f"def step(dt):\n    {body}\nworld.add_physics_callback('drive', step)"
    graphs, _, findings = read(tmp_path, text)
    assert [graph.path for graph in graphs] == ["/G"]
    assert [finding.message for finding in findings.warnings] == [
        "the callback step of the script does not end in time"
    ]


def test_impulses_of_a_callback_become_ticks_where_that_is_asked_for(tmp_path: Path) -> None:
    text = "def step(dt):\n    og.Controller.attribute('/G/a.state:enableImpulse').set(True)\n"
    text += "world.add_physics_callback('drive', step)"
    (graph,), warnings, _ = read(tmp_path, text, impulse_every=2)
    assert (graph.nodes["a"].type, warnings) == ("omni.graph.action.OnTick", [])
