"""Values of ports as channels of a recording: their messages, their changes, and replays that ignore them."""

from __future__ import annotations

import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

import graphengine as ge
from graphengine.api.expectations.bag_file import BagFile
from graphengine.cli import main
from graphengine.messages import messages

GRAPH = """graph: values
nodes:
  Tick: OnPlaybackTick
  Half: {type: Divide, inputs: {b: 2}}
  Limit: {type: ConstantDouble, inputs: {value: 0.5}}
  Name: {type: ConstantString, inputs: {value: north}}
  Said: {type: ROS2Publisher, inputs: {topicName: half, messagePackage: std_msgs, messageName: Float64}}
connections:
  - Tick.tick -> Said.execIn
  - Tick.time -> Half.a
  - Half.result -> Said.data
"""


def record(folder: Path, *ports: str, ticks: int = 6) -> Path:
    (folder / "values.yaml").write_text(GRAPH, encoding="utf-8")
    path = folder / "out.mcap"
    with ge.load(folder / "values.yaml").session(record=path, ports=ports) as sim:
        sim.step(ticks)
    return path


def channels(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """The log time (ns) and the value of each message of a port, by address."""
    found: defaultdict[str, list[tuple[int, Any]]] = defaultdict(list)
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.topic.startswith("/_graph/"):
                assert schema is not None
                value = messages.decode(message.data, schema.name).data
                found[channel.topic.removeprefix("/_graph/")].append((message.log_time, value))
    return found


def test_a_recording_has_the_value_of_a_port_after_each_tick(tmp_path: Path) -> None:
    found = channels(record(tmp_path, "Half.result"))
    assert list(found) == ["values/Half.result"]
    times, values = zip(*found["values/Half.result"], strict=True)
    assert times == tuple(tick * 10**9 // 60 for tick in range(1, 7))
    assert values == tuple(pytest.approx(tick / 120) for tick in range(1, 7))


def test_a_constant_is_recorded_once(tmp_path: Path) -> None:
    found = channels(record(tmp_path, "Limit.value", "Name.value"))
    assert {address: [value for _, value in values] for address, values in found.items()} == {
        "values/Limit.value": [0.5],
        "values/Name.value": ["north"],
    }


def test_a_replay_of_a_recording_with_ports_is_identical(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(record(tmp_path, "*"))]) == 0
    assert capsys.readouterr().out == "identical: 6 messages in 6 ticks, 0.100 s\n"


def test_the_messages_of_topics_are_the_same_with_and_without_ports(tmp_path: Path) -> None:
    sent = []
    for name, ports in (("with", ("*",)), ("without", ())):
        (tmp_path / name).mkdir()
        with record(tmp_path / name, *ports).open("rb") as file:
            sent.append([(m.log_time, m.data) for _, _, m in make_reader(file).iter_messages(topics=["/half"])])
    assert sent[0] == sent[1]
    assert len(sent[0]) == 6


def test_rosbags_reads_a_recording_with_ports(tmp_path: Path) -> None:
    bag = BagFile(record(tmp_path, "*.result"))
    assert len(list(bag.messages(["/_graph/values/Half.result"]))) == 6
    assert bag.message_type("/_graph/values/Half.result")[0] == "std_msgs/msg/Float64"
    bag.close()


def test_channels_have_the_unit_and_the_description_of_their_port(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    with ge.load("dd100_flat", rays="mujoco").session(record=path, ports=["ComputeOdom.linearVelocity"]) as sim:
        sim.step(2)
        velocity = sim.value("ComputeOdom.linearVelocity")
    with path.open("rb") as file:
        reader = make_reader(file)
        (summary,) = [reader.get_summary()]
        assert summary is not None
        (channel,) = [one for one in summary.channels.values() if one.topic.startswith("/_graph/")]
        *_, (_, _, last) = reader.iter_messages(topics=[channel.topic])
    assert channel.topic == "/_graph/dd100/joint_states/ComputeOdom.linearVelocity"
    assert channel.metadata["unit"] == "m/s"
    assert channel.metadata["doc"]
    assert messages.decode(last.data, "std_msgs/msg/Float64MultiArray").data.tolist() == list(velocity)


def test_images_are_no_values_and_short_arrays_are(tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    with ge.load("dd100_flat", rays="mujoco").session(record=path, ports=["*"]) as sim:
        sim.step(4)
    found = channels(path)
    (wheels,) = {len(value) for _, value in found["dd100/cmd_vel/DiffController.velocityCommand"]}
    assert wheels == 2
    assert all(math.isfinite(value) for _, value in found["dd100/cmd_vel/DiffController.wheelRadius"])


def test_an_address_without_port_is_an_error_with_a_suggestion(tmp_path: Path) -> None:
    with pytest.raises(ge.UsageError, match=r"Half\.resalt: Divide has no port with a value 'resalt'"):
        record(tmp_path, "Half.resalt")


def test_a_reload_that_takes_away_all_chosen_ports_does_not_end_the_recording(tmp_path: Path) -> None:
    (tmp_path / "values.yaml").write_text(GRAPH, encoding="utf-8")
    path = tmp_path / "out.mcap"
    with ge.load(tmp_path / "values.yaml").session(record=path, ports=["Limit.value"]) as sim:
        sim.step(2)
        (tmp_path / "values.yaml").write_text(GRAPH.replace("Limit:", "Bound:"), encoding="utf-8")
        sim.reload()
        sim.step(2)
    assert [value for _, value in channels(path)["values/Limit.value"]] == [0.5]
    assert main(["replay", str(path)]) == 0


def test_all_ports_of_a_graph_with_a_node_that_never_runs_are_recorded(tmp_path: Path) -> None:
    unread = "  Sum: {type: Add, inputs: {a: {type: int64, value: 1}, b: {type: int64, value: 5}}}\nconnections:"
    (tmp_path / "values.yaml").write_text(GRAPH.replace("connections:", unread), encoding="utf-8")
    path = tmp_path / "out.mcap"
    with ge.load(tmp_path / "values.yaml").session(record=path, ports=["*"]) as sim:
        sim.step(2)
        assert sim.values("*")["values/Limit.value"] == 0.5
    assert channels(path)["values/Sum.a"]


def test_a_value_that_a_port_s_message_type_cannot_have_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "values.yaml").write_text(GRAPH, encoding="utf-8")
    path = tmp_path / "out.mcap"
    with ge.load(tmp_path / "values.yaml").session(record=path, ports=["Limit.value", "Name.value"]) as sim:
        sim.step()
        (graph,) = sim._runner.session.graphs
        limit: Any = graph.executor.node("Limit")
        name: Any = graph.executor.node("Name")
        limit.value, name.value = None, "\udc80"  # as a ScriptNode can
        sim.step()
        limit.value, name.value = 0.75, "south"
        sim.step()
    found = channels(path)
    assert [value for _, value in found["values/Limit.value"]] == [0.5, 0.75]
    assert [value for _, value in found["values/Name.value"]] == ["north", "south"]


def test_a_reload_records_the_ports_of_the_new_graph(tmp_path: Path) -> None:
    (tmp_path / "values.yaml").write_text(GRAPH, encoding="utf-8")
    path = tmp_path / "out.mcap"
    with ge.load(tmp_path / "values.yaml").session(record=path, ports=["*.value"]) as sim:
        sim.step(2)
        changed = GRAPH.replace("value: 0.5", "value: 0.75").replace(
            "  Name:", "  Other: {type: ConstantDouble}\n  Name:"
        )
        (tmp_path / "values.yaml").write_text(changed, encoding="utf-8")
        sim.reload()
        sim.step(2)
    found = channels(path)
    assert [value for _, value in found["values/Limit.value"]] == [0.5, 0.75]
    assert [value for _, value in found["values/Other.value"]] == [0.0]
    assert main(["replay", str(path)]) == 0
