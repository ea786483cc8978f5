"""`graphrun nodes`: what node types there are, and all about one."""

from __future__ import annotations

import importlib.util
import json
import os
import re
from pathlib import Path

import pytest

from graphengine.compiler.registry import default_registry
from tests.cli.harness import ROOT, Graphrun, live, process

TUTORIAL = {
    "isaacsim.core.nodes.IsaacArticulationController",
    "isaacsim.core.nodes.IsaacComputeOdometry",
    "isaacsim.core.nodes.IsaacComputeTransformTree",
    "isaacsim.core.nodes.IsaacCreateRenderProduct",
    "isaacsim.core.nodes.IsaacReadSimulationTime",
    "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame",
    "isaacsim.robot.wheeled_robots.DifferentialController",
    "isaacsim.ros2.bridge.ROS2Context",
    "isaacsim.ros2.bridge.ROS2PublishClock",
    "isaacsim.ros2.bridge.ROS2PublishJointState",
    "isaacsim.ros2.bridge.ROS2PublishOdometry",
    "isaacsim.ros2.bridge.ROS2PublishRawTransformTree",
    "isaacsim.ros2.bridge.ROS2PublishTransformTree",
    "isaacsim.ros2.bridge.ROS2RtxLidarHelper",
    "isaacsim.ros2.bridge.ROS2SubscribeTwist",
    "omni.graph.action.OnPlaybackTick",
    "omni.graph.nodes.BreakVector3",
}


def test_the_list_has_kind_and_summary_of_every_type(graphrun: Graphrun) -> None:
    result = graphrun("nodes", code=0, err="")
    names = [line.split()[0] for line in result.lines]
    assert names == sorted(names)
    assert set(names) >= TUTORIAL
    for line in result.lines:
        _, kind, about = line.split(maxsplit=2)
        assert kind in ("action", "data", "event", "latent", "pusher")
        assert about.endswith(".")


@pytest.mark.parametrize(
    "name",
    [
        "isaacsim.ros2.bridge.ROS2SubscribeTwist",
        "ROS2SubscribeTwist",
        "SubscribeTwist",
        "omni.isaac.ros2_bridge.ROS2SubscribeTwist",
    ],
)
def test_a_type_is_found_by_registered_short_and_old_name(graphrun: Graphrun, name: str) -> None:
    result = graphrun("nodes", name, code=0)
    assert result.lines[0] == "isaacsim.ros2.bridge.ROS2SubscribeTwist  (action)"


def test_the_description_of_a_type_has_ports_units_defaults_and_extensions(graphrun: Graphrun) -> None:
    lines = graphrun("nodes", "SubscribeTwist").lines
    rows = [line.split() for line in lines]
    assert ["inputs"] in rows
    assert ["outputs"] in rows
    timeout = next(line for line in lines if line.startswith("  timeout "))
    assert timeout.split()[:4] == ["timeout", "double", "s", "0.0"]
    assert timeout.endswith("; extension")
    assert ["linearVelocity", "vectord[3]", "m/s"] in rows


def test_alternative_inputs_name_each_other(graphrun: Graphrun) -> None:
    said = {line.split()[0]: line for line in graphrun("nodes", "ArticulationState").lines if line.startswith("  ")}
    assert said["targetPrim"].endswith("; required unless robotPath is given")
    assert said["robotPath"].endswith("; required unless targetPrim is given")
    assert graphrun("nodes", "ComputeOdometry").out.count("; required\n") == 1


def test_json_of_a_type_is_one_record_and_of_all_a_list(graphrun: Graphrun) -> None:
    record = json.loads(graphrun("nodes", "DifferentialController", "--format", "json").out)
    assert (record["type"], record["kind"]) == ("isaacsim.robot.wheeled_robots.DifferentialController", "action")
    radius = next(port for port in record["ports"] if port["name"] == "wheelRadius")
    assert (radius["side"], radius["type"], radius["unit"], radius["default"]) == ("inputs", "double", "m", 0.0)
    everything = json.loads(graphrun("nodes", "--format", "json").out)
    assert record in everything
    assert {one["type"] for one in everything} >= TUTORIAL


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("DifferentialControler", "did you mean 'DifferentialController'?"),
        ("isaacsim.ros2.bridge.ROS2SubscribeTwst", "did you mean 'isaacsim.ros2.bridge.ROS2SubscribeTwist'?"),
        ("odometry", "3 names contain it:\n  graphengine.wheeled_robots.ComputeWheelOdometry\n  isaacsim."),
        ("xyzzy", "`graphrun nodes` lists every type"),
        ("", "`graphrun nodes` lists every type"),
    ],
)
def test_an_unknown_type_gets_suggestions(graphrun: Graphrun, name: str, hint: str) -> None:
    result = graphrun("nodes", name, code=2, out="")
    assert result.err.startswith(f"graphrun nodes: no node type {name!r}; {hint}")


@pytest.mark.parametrize("part", ["Diff", "differential", "robots.Diff"])
def test_a_unique_part_of_a_name_finds_the_node_type(graphrun: Graphrun, part: str) -> None:
    name = "isaacsim.robot.wheeled_robots.DifferentialController"
    assert graphrun("nodes", part, code=0, err="").lines[0] == f"{name}  (action)"


def test_of_many_names_that_contain_a_part_twenty_are_listed(graphrun: Graphrun) -> None:
    *listed, more = graphrun("nodes", "bridge", code=2).err.splitlines()[1:]
    assert len(listed) == 20
    assert re.fullmatch(r"  … \(\d+ more\): graphrun nodes --search bridge", more)


def test_a_search_finds_names_documentation_and_ports(graphrun: Graphrun) -> None:
    lines = graphrun("nodes", "--search", "Odometr", code=0, err="").lines
    names = [line.split()[0].rpartition(".")[2] for line in lines]
    assert names[:3] == ["ComputeWheelOdometry", "IsaacComputeOdometry", "ROS2PublishOdometry"]  # by name
    assert "ROS2PublishGroundTruthTransform" in names[3:]  # by one of its ports
    ports = next(line for line in lines if "ROS2PublishGroundTruthTransform" in line)
    assert re.search(r"ports: .*odometry", ports)
    found = json.loads(graphrun("nodes", "--search", "odometr", "--format", "json").out)
    assert [record["type"].rpartition(".")[2] for record in found] == names


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--search", "xyzzy"], "--search xyzzy: no name, documentation or port contains it; `graphrun nodes` lists"),
        (["--search", "ROS2PublishOdometri"], "did you mean 'ROS2PublishOdometry'?"),
        (["OnTick", "--search", "tick"], "NAME describes one node type, and --search lists several"),
    ],
)
def test_a_search_without_results_gets_a_suggestion(graphrun: Graphrun, arguments: list[str], said: str) -> None:
    assert said in graphrun("nodes", *arguments, code=2, out="").err


@pytest.mark.parametrize("arguments", [("--search", "wheel"), ("SubscribeTwist",), ("DifferentialController",)])
def test_a_terminal_of_80_columns_shows_all_without_breaking_words(arguments: tuple[str, ...]) -> None:
    with live("nodes", *arguments, columns=80, out=True) as running:
        running.hear(lambda said: False)
    lines = running.said.replace("\r", "").splitlines()
    assert max(map(len, lines)) <= 80
    piped = process("nodes", *arguments).out
    assert sorted(re.findall(r"\w+", running.said)) == sorted(re.findall(r"\w+", piped))


def test_types_of_a_module_in_the_working_directory_are_listed_too(graphrun: Graphrun, project: Path) -> None:
    text = (
        "from graphengine.node import In, Node, Out\n\n\n"
        'class Double(Node, type="cli_test.Double"):\n'
        '    """Twice a number."""\n\n'
        '    value: float = In(default=0.0, doc="a number")\n'
        '    twice: float = Out(doc="twice as much")\n\n'
        "    def compute(self) -> None:\n"
        '        """Double it."""\n'
        "        self.twice = 2.0 * self.value\n"
    )
    (project / "cli_test_nodes.py").write_text(text, encoding="utf-8")
    result = graphrun("nodes", "--import", "cli_test_nodes", "cli_test.Double")
    assert (result.code, result.lines[0]) == (0, "cli_test.Double  (data)")
    assert "cli_test.Double" in graphrun("nodes", "--import", "cli_test_nodes").out
    assert "cli_test.Double" not in graphrun("nodes").out


def test_a_file_of_the_working_directory_hides_no_installed_module(graphrun: Graphrun, project: Path) -> None:
    """The working directory may be a stranger's."""
    (project / "antigravity.py").touch()
    assert graphrun("nodes", "--import", "graphengine.nodes.core").code == 0
    found = importlib.util.find_spec("antigravity")
    assert found is not None
    assert found.origin == str(Path(os.__file__).with_name("antigravity.py"))


def test_every_type_that_the_graphs_that_ship_name_is_in_the_list(graphrun: Graphrun) -> None:
    import yaml

    known = {line.split()[0] for line in graphrun("nodes").lines}
    for path in (ROOT / "graphs").rglob("*.yaml"):
        nodes = yaml.safe_load(path.read_text(encoding="utf-8"))["nodes"].values()
        typed = [node for node in nodes if "subgraph" not in node]
        assert {node if isinstance(node, str) else node["type"] for node in typed} <= known


# Ports made from a message


def rows(lines: list[str]) -> dict[str, str]:
    """What is said of each port after its name."""
    ports = lines[: lines.index("constants")] if "constants" in lines else lines
    found = [line.split(maxsplit=1) for line in ports if line.startswith("  ")]
    return {name: " ".join(rest.split()) for name, rest in found}


def test_the_ports_that_a_message_makes_are_shown_with_types_and_values(graphrun: Graphrun) -> None:
    result = graphrun("nodes", "ROS2Publisher", "--message", "sensor_msgs/msg/Range")
    shown = rows(result.lines)
    assert (result.code, result.err) == (0, "")
    assert shown["header:frame_id"] == "token '' string"
    assert shown["radiation_type"] == "uint 0 ≥ 0 and ≤ 255; uint8"
    assert shown["max_range"] == "float 0.0 float32"
    assert set(shown) - set(rows(graphrun("nodes", "ROS2Publisher").lines)) == {
        "header:stamp:sec",
        "header:stamp:nanosec",
        "header:frame_id",
        "radiation_type",
        "field_of_view",
        "min_range",
        "max_range",
        "range",
        "variance",
    }


def test_a_long_value_that_repeats_is_counted(graphrun: Graphrun) -> None:
    shown = rows(graphrun("nodes", "Publisher", "--message", "nav_msgs/msg/Odometry").lines)
    assert shown["pose:covariance"] == "double[] 36 times 0.0 float64[36]"


def test_a_value_of_up_to_four_numbers_is_shown_in_full(graphrun: Graphrun, project: Path) -> None:
    (project / "my_msgs" / "msg").mkdir(parents=True)
    (project / "my_msgs" / "msg" / "Gains.msg").write_text("float64[4] four\nfloat64[5] five\n", encoding="utf-8")
    result = graphrun("nodes", "Publisher", "--message", "my_msgs/msg/Gains", "--msg-path", "my_msgs")
    assert rows(result.lines)["four"] == "double[] [0.0, 0.0, 0.0, 0.0] float64[4]"
    assert rows(result.lines)["five"] == "double[] 5 times 0.0 float64[5]"


def test_a_message_in_an_array_is_shown_as_text(graphrun: Graphrun, project: Path) -> None:
    (project / "my_msgs" / "msg").mkdir(parents=True)
    (project / "my_msgs" / "msg" / "Edge.msg").write_text("geometry_msgs/Point32[2] ends\n", encoding="utf-8")
    result = graphrun("nodes", "Publisher", "--message", "my_msgs/msg/Edge", "--msg-path", "my_msgs")
    text = '{"x": 0.0, "y": 0.0, "z": 0.0}'
    assert rows(result.lines)["ends"] == f"token[] 2 times '{text}' geometry_msgs/Point32[2]"


def test_names_that_a_message_has_for_values_are_shown(graphrun: Graphrun) -> None:
    lines = graphrun("nodes", "Publisher", "--message", "sensor_msgs/msg/Range").lines
    assert [line.split() for line in lines[lines.index("constants") + 1 :]] == [
        ["ULTRASOUND", "uint8", "0"],
        ["INFRARED", "uint8", "1"],
    ]
    assert "constants" not in graphrun("nodes", "Publisher", "--message", "geometry_msgs/msg/Twist").lines


def test_a_message_may_be_named_without_its_folder(graphrun: Graphrun) -> None:
    one, other = (graphrun("nodes", "Publisher", "--message", name) for name in ("std_msgs/Bool", "std_msgs/msg/Bool"))
    assert (one.code, one.out) == (0, other.out)


def test_a_message_of_a_workspace_that_was_sourced_is_shown(
    graphrun: Graphrun, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = project / "install" / "share" / "my_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Tag.msg").write_text("int16 number 7\n", encoding="utf-8")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere{os.pathsep}{project / 'install'}")
    result = graphrun("nodes", "Publisher", "--message", "my_msgs/msg/Tag")
    assert rows(result.lines)["number"] == "int 7 ≥ -32768 and ≤ 32767; int16"


def test_message_fields_are_outputs_of_a_subscriber(graphrun: Graphrun) -> None:
    record = json.loads(graphrun("nodes", "Subscriber", "--message", "std_msgs/msg/String", "--format", "json").out)
    assert [port["name"] for port in record["ports"] if port["side"] == "outputs"] == ["execOut", "data"]


def test_a_message_of_a_users_package_is_shown(graphrun: Graphrun, project: Path) -> None:
    (project / "my_msgs" / "msg").mkdir(parents=True)
    (project / "my_msgs" / "msg" / "Tag.msg").write_text("string<=8[<=2] words\n", encoding="utf-8")
    result = graphrun("nodes", "Publisher", "--message", "my_msgs/msg/Tag", "--msg-path", "my_msgs")
    assert rows(result.lines)["words"] == "token[] [] string<=8[<=2]"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["Publisher", "--message", "sensor_msgs/msg/Rang"],
            "no message type 'sensor_msgs/msg/Rang'\n  did you mean 'Range'?",
        ),
        (
            ["Publisher", "--message", "Range"],
            "--message Range: write PACKAGE/msg/NAME, such as geometry_msgs/msg/Twist",
        ),
        (["Publisher", "--message", ""], "--message : write PACKAGE/msg/NAME, such as geometry_msgs/msg/Twist"),
        (
            ["Publisher", "--message", "std_srvs/srv/Trigger"],
            "std_srvs/srv/Trigger is not a message type\n  it has: std_srvs",
        ),
        (
            ["PublishClock", "--message", "std_msgs/msg/String"],
            "ROS2PublishClock gets no ports from message types",
        ),
        (
            ["--message", "std_msgs/msg/String"],
            "--message needs NAME, a node type with ports for a message type, such as ROS2Publisher",
        ),
        (["Publisher", "--message", "a/msg/B", "--msg-path", "x"], "--msg-path x: no such file or folder"),
    ],
)
def test_a_message_that_gives_no_ports_is_refused(graphrun: Graphrun, arguments: list[str], message: str) -> None:
    result = graphrun("nodes", *arguments, code=2, out="")
    assert message in result.err


def test_a_graph_with_a_users_message_is_checked_shown_and_run(graphrun: Graphrun, project: Path) -> None:
    (project / "msgs" / "my_msgs" / "msg").mkdir(parents=True)
    (project / "msgs" / "my_msgs" / "msg" / "Tag.msg").write_text("float64 number\n", encoding="utf-8")
    (project / "tag.yaml").write_text(
        "graph: tag\nnodes:\n  Tick: OnPlaybackTick\n"
        "  Say: {type: ROS2Publisher, inputs: {messagePackage: my_msgs, messageName: Tag, topicName: tag}}\n"
        "connections: [Tick.tick -> Say.execIn, Tick.time -> Say.number]\n",
        encoding="utf-8",
    )
    known = ("--msg-path", "msgs")
    assert graphrun("check", "tag.yaml", *known).code == 0
    assert "Tick.time -> Say.number" in graphrun("show", "tag.yaml", *known).out
    assert graphrun("topics", "tag.yaml", *known).lines[1].split()[:3] == ["/tag", "pub", "my_msgs/msg/Tag"]
    assert graphrun("run", "tag.yaml", *known, "--transport", "memory", "--for", "0.1").code == 0
    unknown = graphrun("check", "tag.yaml", code=1)
    assert "error G308: Say: no message type 'my_msgs/msg/Tag'" in unknown.out + unknown.err


# The reference


def test_the_reference_has_every_type_once_with_an_anchor_that_is_its_name(graphrun: Graphrun) -> None:
    text = graphrun("nodes", "--markdown").out
    names = [line.split()[0] for line in graphrun("nodes").lines]
    anchors = re.findall(r'^<a id="([^"]+)"></a>$', text, re.MULTILINE)
    families = {name.rpartition(".")[0] for name in names}
    assert sorted(anchors) == sorted([*names, *families])
    assert set(re.findall(r"\]\(#([^)]+)\)", text)) == set(anchors)


def test_the_reference_has_type_unit_default_and_legal_values_of_each_port(graphrun: Graphrun) -> None:
    records = json.loads(graphrun("nodes", "--format", "json").out)
    text = graphrun("nodes", "--markdown").out
    sections = dict(re.findall(r'^<a id="([^"]+)"></a>\n\n### (.*?)(?=^<a |\Z)', text, re.MULTILINE | re.DOTALL))
    assert sections.keys() == {record["type"] for record in records}
    for record in records:
        rows = [line for line in sections[record["type"]].splitlines() if line.startswith("| `")]
        assert sorted(row.split("`")[1] for row in rows) == sorted(port["name"] for port in record["ports"])
    assert (
        "| `wheelRadius` | `double` | m | `0.0` |" in sections["isaacsim.robot.wheeled_robots.DifferentialController"]
    )
    assert "| `timeout` | `double` | s | `0.0` | ≥ 0; " in sections["isaacsim.ros2.bridge.ROS2SubscribeTwist"]
    assert "| one of laser_scan, point_cloud; " in sections["isaacsim.ros2.bridge.ROS2RtxLidarHelper"]


def test_every_row_of_the_reference_has_as_many_cells_as_its_head(graphrun: Graphrun) -> None:
    cells = 0
    for line in graphrun("nodes", "--markdown").lines:
        if not line.startswith("|"):
            cells = 0
            continue
        count = len(re.findall(r"(?<!\\)\|", line))
        cells = cells or count
        assert count == cells, line


def test_what_a_type_says_of_itself_is_text_in_the_reference(graphrun: Graphrun, project: Path) -> None:
    (project / "odd_nodes.py").write_text(
        "from graphengine.node import In, Node, Out\n\n\n"
        'class Odd(Node, type="cli_odd.Odd"):\n'
        '    """Not <b>bold</b> nor [a](link) | a `code | x`."""\n\n'
        '    value: str = In(default="``|<i>", doc="*stars*")\n'
        "    other: float = Out()\n",
        encoding="utf-8",
    )
    lines = graphrun("nodes", "--import", "odd_nodes", "--markdown", "cli_odd.Odd").lines
    assert "Not &lt;b&gt;bold&lt;/b&gt; nor \\[a\\](link) | a `code | x`." in lines
    assert "| `value` | `string` |  | ``` '``\\|<i>' ``` | \\*stars\\* |" in lines


def test_markdown_and_json_are_not_asked_for_at_once(graphrun: Graphrun) -> None:
    assert graphrun("nodes", "--markdown", "--format", "json").code == 2


def test_of_many_types_of_a_port_the_first_are_named_and_all_are_counted(graphrun: Graphrun) -> None:
    result = graphrun("nodes", "Add")
    (port,) = (
        port for port in json.loads(graphrun("nodes", "Add", "--format", "json").out)["ports"] if port["name"] == "a"
    )
    kinds = port["type"].split(" | ")
    assert len(kinds) > 4
    assert f"  a  {' | '.join(kinds[:3])} | … ({len(kinds)} types)  " in result.out
    assert result.lines[-1] == "all types of a port: graphrun nodes omni.graph.nodes.Add --format json"
    assert "null" not in result.out


def test_up_to_four_types_of_a_port_are_all_named(graphrun: Graphrun) -> None:
    result = graphrun("nodes", "BuildString")
    assert "  a  string | token | token[]  " in result.out
    assert "all types" not in result.out


def test_a_project_may_have_a_folder_called_nodes(tmp_path: Path) -> None:
    (tmp_path / "nodes").mkdir()
    (tmp_path / "nodes/__init__.py").write_text("raise SystemExit('imported')")
    assert process("nodes", "Add", cwd=tmp_path).code == 0


@pytest.mark.parametrize("form", [(), ("--format", "json"), ("--markdown",)])
def test_a_node_package_that_cannot_be_imported_is_a_warning_beside_the_list(
    graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch, form: tuple[str, ...]
) -> None:
    before = graphrun("nodes", *form)
    monkeypatch.setitem(default_registry().broken, "acme: acme.nodes", "ImportError: no module named 'torch'")
    result = graphrun("nodes", *form)
    assert (result.code, result.out) == (0, before.out)
    assert result.err == "warning: acme: acme.nodes could not be imported: ImportError: no module named 'torch'\n"
