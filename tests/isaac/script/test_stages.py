"""Scripts that look at the stage before they build: what they make themselves is not there before they make it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.isaac.harness import read_text

START = """\
import omni.graph.core as og
import omni.usd
from isaacsim.core.utils.prims import create_prim, define_prim, is_prim_path_valid

keys = og.Controller.Keys
stage = omni.usd.get_context().get_stage()
BUILD = {
    keys.CREATE_NODES: [("Tick", "omni.graph.action.OnPlaybackTick"), ("Time", "isaacsim.core.nodes.IsaacReadSimulationTime")],
}
REST = {
    keys.CREATE_NODES: [("Clock", "isaacsim.ros2.bridge.ROS2PublishClock")],
    keys.CONNECT: [("/World/G/Tick.outputs:tick", "/World/G/Clock.inputs:execIn")],
}
"""
NEEDS_A_ROBOT = """
if not stage.GetPrimAtPath("/World/robot").IsValid():
    raise RuntimeError("load the robot first")
"""


@pytest.mark.parametrize(
    "text",
    [
        """
if not is_prim_path_valid("/World/G"):
    og.Controller.edit("/World/G", BUILD)
og.Controller.edit("/World/G", REST)
""",
        """
graph = og.Controller.create_graph({"graph_path": "/World/G"})
for name, kind in BUILD[keys.CREATE_NODES]:
    if not stage.GetPrimAtPath(f"/World/G/{name}"):
        og.Controller.create_node(f"/World/G/{name}", kind)
og.Controller.edit(graph, REST)
""",
        """
if not is_prim_path_valid("/World"):
    create_prim("/World", "Xform")
    if not is_prim_path_valid("/World/G/"):
        og.Controller.edit("/World/G", {**BUILD, keys.CREATE_NODES: BUILD[keys.CREATE_NODES] + REST[keys.CREATE_NODES]})
        og.Controller.edit("/World/G", {keys.CONNECT: REST[keys.CONNECT]})
""",
    ],
    ids=["the graph", "its nodes", "the prim above it"],
)
def test_a_graph_is_whole_that_is_built_where_it_is_not_there_yet(text: str, tmp_path: Path) -> None:
    (graph,), warnings, _ = read_text(tmp_path, START + text + NEEDS_A_ROBOT)
    assert warnings == []
    assert list(graph.nodes) == ["Tick", "Time", "Clock"]
    assert [str(wire) for wire in graph.wires] == ["Tick.outputs:tick -> Clock.inputs:execIn"]


def test_a_graph_that_a_fuller_stage_hides_is_kept_from_the_empty_one(tmp_path: Path) -> None:
    text = """
if not is_prim_path_valid("/World/robot"):
    og.Controller.edit("/World/G", BUILD)
og.Controller.edit("/World/H", BUILD)
range(omni.usd.get_stage_units())
"""
    assert [graph.path for graph in read_text(tmp_path, START + text).graphs] == ["/World/G", "/World/H"]
