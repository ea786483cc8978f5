"""`graphrun topics`: what a scene says and hears, without running it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.action_graph import BOTH, FIBONACCI
from tests.cli import screen
from tests.cli.harness import Graphrun, live, process

WAREHOUSE = {
    "/clock": ("pub", "rosgraph_msgs/msg/Clock", "60 Hz", "reliable, volatile, 10", ""),
    "/dd100_0000/cmd_vel": ("sub", "geometry_msgs/msg/Twist", "", "reliable, volatile, 10", ""),
    "/dd100_0000/odom": ("pub", "nav_msgs/msg/Odometry", "60 Hz", "reliable, volatile, 10", "odom"),
    "/dd100_0000/platform/joint_states": (
        "pub",
        "sensor_msgs/msg/JointState",
        "60 Hz",
        "reliable, volatile, 10",
        "",
    ),
    "/dd100_0000/sim_lidar/scan": ("pub", "sensor_msgs/msg/LaserScan", "20 Hz", "reliable, volatile, 10", "sim_lidar"),
    "/dd100_0000/tf": ("pub", "tf2_msgs/msg/TFMessage", "60 Hz", "reliable, volatile, 10", "odom -> base_link"),
    "/dd100_0000/tf_static": (
        "pub",
        "tf2_msgs/msg/TFMessage",
        "once",
        "reliable, transientLocal, 1",
        "base_link -> sim_lidar",
    ),
}


def test_the_table_has_type_rate_qos_frame_and_node_of_every_topic(graphrun: Graphrun) -> None:
    result = graphrun("topics", "dd100_warehouse", code=0, err="")
    head, *lines = result.lines
    starts = [match.start() for match in re.finditer(r"\S+", head)]
    direction = next(match.start() for match in re.finditer(r"(pub|sub) ", lines[0]))
    starts.insert(1, direction)
    rows = {}
    for line in lines:
        topic, *cells, node = [line[a:b].strip() for a, b in zip(starts, [*starts[1:], None], strict=True)]
        rows[topic] = tuple(cells)
        assert node.startswith("/")
    assert rows == WAREHOUSE


@pytest.mark.parametrize("scene", ["dd100_flat", "dd100_fleet"])
def test_a_terminal_of_80_columns_shows_all_in_more_lines(scene: str) -> None:
    with live("topics", scene, columns=80, out=True) as running:
        running.hear(lambda said: False)
    lines = screen.shown(running.said, 1000)  # of which a line that is too wide would show
    assert max(map(len, lines)) <= 80
    piped = process("topics", scene).out
    assert sorted(re.findall(r"[\w/]+", "\n".join(lines))) == sorted(re.findall(r"[\w/]+", piped))


def test_a_wide_terminal_shows_the_table_of_a_pipe() -> None:
    with live("topics", "dd100_flat", columns=300, out=True) as running:
        running.hear(lambda said: False)
    assert process("topics", "dd100_flat").out.splitlines()[-1] in running.said


def test_json_has_the_topics_of_the_table(graphrun: Graphrun) -> None:
    claims = json.loads(graphrun("topics", "dd100_warehouse", "--format", "json").out)
    directions = {"publish": "pub", "subscribe": "sub"}
    told = {c["topic"]: (directions[c["direction"]], c["message_type"]) for c in claims}
    assert told == {topic: row[:2] for topic, row in WAREHOUSE.items()}
    scan = next(claim for claim in claims if claim["topic"].endswith("scan"))
    assert (scan["rate"], scan["frame_id"], scan["latched"]) == (20.0, "sim_lidar", False)
    assert scan["qos"]["depth"] == 10
    odometry = next(claim for claim in claims if claim["topic"].endswith("/tf"))
    assert odometry["transforms"] == [["odom", "base_link"]]


def test_a_publisher_of_many_transforms_does_not_widen_the_table(graphrun: Graphrun) -> None:
    result = graphrun("topics", "dd100_warehouse", "--robot-state")
    assert max(map(len, result.lines)) < 260
    assert "base_link -> chassis_link, chassis_link -> rear_caster, … (10 more)" in result.out
    claims = json.loads(graphrun("topics", "dd100_warehouse", "--robot-state", "--format", "json").out)
    assert max(len(claim["transforms"]) for claim in claims) == 12


def test_topics_of_a_graph_without_a_scene_have_a_note_on_namespaces(graphrun: Graphrun) -> None:
    alone = graphrun("topics", "dd100/cmd_vel")
    assert alone.lines[1].startswith("/cmd_vel ")
    assert alone.err == "the namespaces of topics are unknown without a scene; give one with --scene\n"
    in_scene = graphrun("topics", "dd100/cmd_vel", "--scene", "dd100_flat")
    assert in_scene.lines[1].startswith("/dd100_0000/cmd_vel ")
    assert in_scene.err == ""


def test_a_scene_with_errors_is_explained_instead(graphrun: Graphrun) -> None:
    result = graphrun("topics", "dd100_flat", "--set", "SubscribeTwist.topicName='a b'", code=1, out="")
    assert "error G304" in result.err
    assert "note N" not in result.err


def test_a_layout_for_foxglove_has_panels_of_the_topics(graphrun: Graphrun) -> None:
    layout = json.loads(graphrun("topics", "dd100_warehouse", "--format", "foxglove-layout", code=0).out)
    assert "/dd100_0000/cmd_vel" in json.dumps(layout)
    assert {name.partition("!")[0] for name in layout["configById"]} >= {"3D", "Plot", "Teleop"}


def test_an_action_is_one_row(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text(f"graph: graph\n{BOTH}", "utf-8")
    assert [line.split() for line in graphrun("topics", str(path), code=0).lines[1:]] == [
        ["/fibonacci", "goal", FIBONACCI, "/World/graph/Client"],
        ["/fibonacci", "act", FIBONACCI, "/World/graph/Server"],
    ]
