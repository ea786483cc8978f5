"""`graphrun show`: the parts, the order, the source and the picture. The goldens were read by eye."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

from tests.cli.harness import GRAPHS, SCENES, Graphrun

GOLDEN = Path(__file__).parent / "golden"


def check_against_golden(text: str, name: str) -> None:
    """`UPDATE_GOLDENS=1` writes anew; read it before it is committed."""
    golden = GOLDEN / name
    if os.environ.get("UPDATE_GOLDENS"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize("form", ["schedule", "plan", "mermaid"])
def test_cmd_vel_is_shown_as_the_golden_has_it(graphrun: Graphrun, form: str) -> None:
    result = graphrun("show", "dd100/cmd_vel", f"--{form}", code=0, err="")
    check_against_golden(result.out, f"cmd_vel.{form}.txt")


SCAN = """graph: scan
nodes:
  Tick: OnPlaybackTick
  Scan: {type: ROS2Publisher, inputs: {messagePackage: sensor_msgs, messageName: LaserScan, ranges: [0.45, 0.1]}}
connections: [Tick.tick -> Scan.execIn]
"""


def test_a_float_is_shown_by_its_shortest_decimal_in_text_and_drawings(graphrun: Graphrun, project: Path) -> None:
    (project / "scan.yaml").write_text(SCAN, encoding="utf-8")
    assert "    ranges = [0.45, 0.1]" in graphrun("show", "scan.yaml").lines
    graphrun("show", "scan.yaml", "--svg", "scan.svg", code=0)
    assert "[0.45, 0.1]" in (project / "scan.svg").read_text(encoding="utf-8")
    assert '("Scan.inputs:ranges", [0.45, 0.1])' in graphrun("export", "scan.yaml", "--to", "isaac-script").out


def test_without_a_format_show_prints_types_values_units_and_wires(graphrun: Graphrun) -> None:
    result = graphrun("show", "dd100/cmd_vel")
    assert result.lines[0] == "cmd_vel  at /dd100/Geometry/base_link/chassis_link/cmd_vel, every tick"
    assert "  DiffController: isaacsim.robot.wheeled_robots.DifferentialController" in result.lines
    assert "    maxAcceleration = 1.0 m/s2" in result.lines
    assert '    targetPrim = ["/dd100"]' in result.lines
    assert result.lines[-1] == "  Context.context -> SubscribeTwist.context"
    wires = [line for line in result.lines if " -> " in line]
    source = Path(__file__).parents[2] / "graphs/dd100/cmd_vel.yaml"
    assert len(wires) == source.read_text(encoding="utf-8").count(" -> ")


@pytest.mark.parametrize("name", [*SCENES, *GRAPHS])
def test_the_code_of_all_shipped_graphs_is_python(graphrun: Graphrun, name: str) -> None:
    source = graphrun("show", name, "--plan").out
    assert "def pass_(" in source
    compile(source, name, "exec")


def test_a_node_comes_after_every_node_that_it_reads_from(graphrun: Graphrun) -> None:
    lines = graphrun("show", "dd100/joint_states", "--schedule").lines
    order = [line.split()[0] for line in lines if re.match(r" {4}\S", line)]
    for earlier, later in [
        ("ComputeOdom", "PublishRawTF"),
        ("ComputeTransformTree", "PublishTF"),
        ("ReadSimTime", "PublishOdom"),
    ]:
        assert order.index(earlier) < order.index(later)


def test_a_schedule_has_the_condition_of_each_node(graphrun: Graphrun) -> None:
    lines = graphrun("show", "dd100/scan", "--schedule").lines
    assert "    CreateRenderProduct          action  when RunOneFrame.step fires" in lines


def test_the_graphs_of_a_scene_come_in_the_order_in_which_they_run(graphrun: Graphrun) -> None:
    lines = graphrun("show", "dd100_warehouse", "--schedule").lines
    heads = [line.split()[0] for line in lines if line and not line.startswith(" ")]
    assert heads == ["clock", "dd100/joint_states", "dd100/scan", "dd100/cmd_vel"]


OWN = """
graph: own
nodes:
  Tick: OnPlaybackTick
  Impulse: OnImpulseEvent
  Loop: {type: ForLoop, inputs: {stop: 3}}
  Order: Multisequence
  Gate: Gate
  Wait: Delay
  Once: Once
  Branch: Branch
  Count: Counter
  Print: {type: PrintText, inputs: {text: hi}}
connections:
  - Tick.tick -> Loop.execIn
  - Loop.loopBody -> Loop.breakLoop
  - Loop.finished -> Order.execIn
  - Order.output0 -> Gate.toggle
  - Order.output1 -> Wait.execIn
  - Impulse.execOut -> Gate.enter
  - Gate.exit -> Branch.execIn
  - Branch.execTrue -> Gate.toggle
  - Branch.execFalse -> Print.execIn
  - Wait.finished -> Print.execIn
  - Loop.finished -> Print.execIn
  - Tick.tick -> Once.execIn
  - Once.after -> Once.reset
  - Tick.tick -> Count.execIn
  - Tick.tick -> Count.reset
"""


def test_the_schedule_of_a_node_names_only_wires_of_its_region(graphrun: Graphrun, project: Path) -> None:
    (project / "own.yaml").write_text(OWN, encoding="utf-8")
    lines = [" ".join(line.split()) for line in graphrun("show", "own.yaml", "--schedule").lines]
    assert "Gate action when Impulse.execOut fires" in lines
    assert "Branch action when Gate.exit fires" in lines
    assert "Print action when Branch.execFalse or Wait.finished fires" in lines
    assert lines[lines.index("each time Loop.finished fires") + 1 :][:2] == ["Order pusher", "Print action"]
    assert {"Once action when Tick.tick fires", "Count action when Tick.tick fires"} <= set(lines)


def test_the_picture_of_a_scene_is_one_flowchart_with_a_part_for_each_graph(graphrun: Graphrun) -> None:
    lines = graphrun("show", "dd100_warehouse", "--mermaid").lines
    assert [line for line in lines if not line.startswith(" ")] == ["flowchart LR"]
    parts = [line.split("[")[0].strip() for line in lines if line.startswith("  subgraph ")]
    assert parts == [f"subgraph {name}" for name in ("clock", "dd100_joint_states", "dd100_scan", "dd100_cmd_vel")]
    assert lines.count("  end") == 4
    boxes = [line.split("[")[0].strip() for line in lines if "<small>" in line]
    ends = {end for line in lines if "|" in line for end in (line.split()[0], line.split()[-1])}
    assert len(boxes) == len(set(boxes))
    assert ends <= set(boxes)


def test_two_output_formats_are_refused(graphrun: Graphrun) -> None:
    assert graphrun("show", "clock", "--plan", "--mermaid").code == 2


def test_errors_of_a_graph_are_printed_instead_of_its_nodes(graphrun: Graphrun, project: Path) -> None:
    (project / "mine.yaml").write_text("graph: mine\nnodes: {Tick: OnPlaybackTik}\n", encoding="utf-8")
    result = graphrun("show", "mine.yaml", code=1, out="")
    assert result.err.startswith("mine.yaml:2:15: error G201")


# Drawings


@pytest.mark.parametrize("form", ["svg", "html"])
def test_a_scene_is_drawn_into_one_file_with_all_of_its_graphs(graphrun: Graphrun, project: Path, form: str) -> None:
    result = graphrun("show", "dd100_warehouse", f"--{form}", f"out.{form}")
    assert (result.code, result.err, result.out) == (0, "", f"out.{form}: 4 graphs\n")
    text = (project / f"out.{form}").read_text(encoding="utf-8")
    titles = re.findall(r'<text class="title"[^>]*>([^<]*)<', text)
    assert titles == ["clock", "dd100/joint_states", "dd100/scan", "dd100/cmd_vel"]
    assert sorted(path.name for path in project.iterdir()) == ["mine.yaml", f"out.{form}"]


def test_a_graph_with_errors_is_drawn_and_its_errors_are_printed(graphrun: Graphrun, project: Path) -> None:
    (project / "bad.yaml").write_text("graph: bad\nnodes: {Tick: OnPlaybackTik}\n", encoding="utf-8")
    result = graphrun("show", "bad.yaml", "--svg", "bad.svg", code=1)
    assert result.err.startswith("bad.yaml:2:15: error G201")
    assert "error G201</text>" in (project / "bad.svg").read_text(encoding="utf-8")


def test_show_draws_nothing_for_a_file_that_is_not_a_graph(graphrun: Graphrun, project: Path) -> None:
    (project / "bad.yaml").write_text("graph: [\n", encoding="utf-8")
    assert graphrun("show", "bad.yaml", "--svg", "bad.svg").code == 1
    assert not (project / "bad.svg").exists()


def test_a_drawing_that_cannot_be_written_is_reported(graphrun: Graphrun, project: Path) -> None:
    result = graphrun("show", "mine.yaml", "--svg", "mine.yaml/out.svg", code=1, out="")
    assert "mine.yaml/out.svg: Not a directory" in result.err


def test_a_link_in_the_place_of_a_drawing_is_replaced(graphrun: Graphrun, project: Path) -> None:
    victim = project / "victim"
    victim.write_text("mine", encoding="utf-8")
    for planted in ("out.svg", ".out.svg.part"):
        (project / planted).symlink_to(victim)
    assert graphrun("show", "mine.yaml", "--svg", "out.svg").code == 0
    assert victim.read_text(encoding="utf-8") == "mine"


def test_values_of_the_option_set_are_drawn(graphrun: Graphrun, project: Path) -> None:
    assert graphrun("show", "dd100/cmd_vel", "--set", "DiffController.wheelRadius=0.0625", "--svg", "out.svg").code == 0
    assert " 0.0625 m</tspan>" in (project / "out.svg").read_text(encoding="utf-8")


def test_show_says_how_to_install_a_missing_layout_library(
    graphrun: Graphrun, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "graphlay", None)
    result = graphrun("show", "mine.yaml", "--svg", "out.svg", code=2)
    assert "pip install '.[draw]'" in result.err


def test_a_graph_with_too_many_nodes_is_not_drawn(graphrun: Graphrun, project: Path) -> None:
    nodes = "\n".join(f"  N{number}: BooleanNot" for number in range(3001))
    (project / "large.yaml").write_text(f"graph: large\nnodes:\n{nodes}\n", encoding="utf-8")
    result = graphrun("show", "large.yaml", "--svg", "out.svg")
    assert (result.code, "large has 3001 nodes; a drawing can have at most 3000" in result.err) == (2, True)


@pytest.mark.parametrize("option", ["--svg", "--html"])
def test_a_drawing_does_not_write_over_a_file_of_another_kind(graphrun: Graphrun, tmp_path: Path, option: str) -> None:
    graph = tmp_path / "mine.yaml"
    graph.write_text("kept")
    result = graphrun("show", "tutorial/clock", option, str(graph), code=2)
    assert "the name must end in" in result.err
    assert graph.read_text() == "kept"
