"""`graphrun param`: the parameters of a run, in the form of ros2cli."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from graphengine.cli.param import current, report
from graphengine.cli.parameter_file import flat, nested, read
from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.parameters import SERVICES, ParameterType, parameter_message, value_message
from graphengine.ros.parameter_client import ParameterClient
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.cli.harness import Graphrun, Live, live
from tests.parameter_scene import LIMIT, NODE, NODES, write_scene
from tests.waiting import eventually


@pytest.fixture
def param(graphrun: Graphrun, domain_id: int, monkeypatch: pytest.MonkeyPatch) -> Graphrun:
    """`graphrun param` in this process."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    return lambda verb, *arguments, **ended: graphrun("param", verb, *arguments, "--transport", "dds", **ended)


@pytest.fixture
def running(tmp_path: Path, domain_id: int, param: Graphrun) -> Iterator[Live]:
    scene, env = write_scene(tmp_path), {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    recording = str(tmp_path / "out.mcap")
    with live("run", str(scene), "--transport", "dds", "--record", recording, "--verbose", env=env) as run:
        assert run.hear(lambda said: "services, actions, parameters: with Cyclone DDS only" in said)
        assert eventually(lambda: all(f"{node}:" in param("list").lines for node in NODES))
        yield run


def test_every_verb_prints_the_same_as_ros2_param(
    param: Graphrun, running: Live, tmp_path: Path, graphrun: Graphrun
) -> None:
    assert f"  {LIMIT}" in param("list", code=0, err="").lines
    typed = param("list", NODE, "--param-type", "--filter", LIMIT, code=0, err="")
    assert typed.out == f"  {LIMIT} (type: double)\n"
    assert param("list", NODE, "--param-prefixes", "drive.variables", code=0).out == "  drive.variables.speed\n"
    assert param("get", NODE, LIMIT, code=0, err="").out == "Double value is: 0.0\n"
    assert param("get", NODE.lstrip("/"), LIMIT, "--hide-type", code=0, err="").out == "0.0\n"
    assert param("set", NODE, LIMIT, "1e-3", code=0, err="").out == "Set parameter successful\n"
    assert param("get", NODE, LIMIT, code=0, err="").out == "Double value is: 0.001\n"
    refused = param("set", NODE, LIMIT, "fast", code=1, out="").err
    assert refused == (
        "Setting parameter failed: bot/drive/Control.maxLinearSpeed is a double: expected a number, got 'fast'\n"
    )
    assert param("describe", NODE, LIMIT, "use_sim_time", code=0, err="").lines == [
        f"Parameter name: {LIMIT}",
        "  Type: double",
        "  Description: largest speed of the base; 0: no limit [m/s]",
        "  Constraints:",
        "    Additional constraints: ≥ 0",
        "Parameter name: use_sim_time",
        "  Type: boolean",
        "  Description: message stamps are simulation time",
        "  Constraints:",
        "    Read only: true",
    ]
    dumped = param("dump", NODE, code=0, err="").out
    assert yaml.safe_load(dumped)[NODE]["ros__parameters"]["drive"]["Control"]["maxLinearSpeed"] == 0.001
    (tmp_path / "dump.yaml").write_text(dumped.replace("0.001", "0.75"), encoding="utf-8")
    loaded = param("load", NODE, str(tmp_path / "dump.yaml"), code=0, err="")
    assert all(line.endswith(" successful") for line in loaded.lines)
    assert param("get", NODE, LIMIT, "--hide-type", code=0).out == "0.75\n"
    running.stop(signal.SIGINT)
    assert "identical" in graphrun("replay", str(tmp_path / "out.mcap"), code=0).out


def test_no_parameter_from_the_network_ends_a_run(param: Graphrun, domain_id: int) -> None:
    node, effort = "/dd100_0000/dd100", "cmd_vel.ArtController.effortCommand"
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with live("run", "dd100_flat", "--transport", "dds", env=env) as run:
        assert eventually(lambda: node in param("list").out)
        assert param("set", node, effort, "[1.0, 2.0, 3.0]", code=0).out == "Set parameter successful\n"
        assert run.hear(lambda line: "effortCommand has one number for each of 2 joints" in line)
        refused = param("set", node, "cmd_vel.DiffController.maxLinearSpeed", "-1.0", code=1, out="").err
        assert refused.endswith("maxLinearSpeed: expected a value ≥ 0, got -1.0 (unit: m/s)\n")
        assert param("set", node, effort, "[]", code=0)
        refused = param("set", node, "cmd_vel.DiffController.wheelRadius", "0.0", code=1, out="").err
        assert refused.endswith("wheelRadius: expected a value > 0, got 0.0 (unit: m)\n")
        assert run.stop(signal.SIGINT) == 0


def test_unknown_nodes_and_parameters_are_reported_with_similar_ones(param: Graphrun, running: Live) -> None:
    assert f"did you mean '{NODE}'?" in param("get", "/two/bott", LIMIT, code=1, out="").err
    assert f"did you mean '{LIMIT}'?" in param("get", NODE, f"{LIMIT}s", code=1, out="").err
    assert "cannot be" not in param("list", NODE, "--filter", "(", code=2, out="").out


def test_a_file_without_parameters_is_refused_before_the_network_is_joined(param: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "empty.yaml"
    path.write_text("/node: {}\n", encoding="utf-8")
    assert (
        "no parameters; write them below NODE: ros__parameters:" in param("load", NODE, str(path), code=2, out="").err
    )


@pytest.mark.parametrize("value", ["[1, a]", "[[1], [2]]", "[1, null]"])
def test_a_list_of_mixed_types_is_refused_before_the_network_is_joined(
    param: Graphrun, tmp_path: Path, value: str
) -> None:
    path = tmp_path / "mixed.yaml"
    path.write_text(f"/node: {{ros__parameters: {{a: {{b: {value}}}}}}}\n", encoding="utf-8")
    assert "a.b is not a list of values of one type" in param("load", NODE, str(path), code=2, out="").err


def test_nulls_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "nulls.yaml"
    path.write_text("/node: {ros__parameters: {a: null, b: [1, 2.5]}}\n", encoding="utf-8")
    assert read(path, wildcard=True) == {"b": [1, 2.5]}


def test_a_dump_with_a_name_below_that_of_a_value_can_be_loaded() -> None:
    values = {"a.b.c": 3, "a": 1, "a.b": 2, "d.e": 4}
    assert nested(values) == {"a": 1, "a.b": 2, "a.b.c": 3, "d": {"e": 4}}
    assert dict(flat(nested(values))) == values


class Peer(ParameterClient):
    """A client of a node that answers as rclcpp does: nothing if one of the names has no value."""

    def __init__(self, values: dict[str, int | None], results: Sequence[str] = ()) -> None:
        super().__init__(MemoryTransport(), "/peer")
        self.values, self.results = values, results

    def _call(self, service: str, **fields: Any) -> Any:
        response = DEFINITIONS.initial(f"{SERVICES[service]}_Response")
        if service == "list_parameters":
            response.result.names = list(self.values)
        elif service == "get_parameters" and all(self.values[name] is not None for name in fields["names"]):
            response.values = [value_message(ParameterType.INTEGER, self.values[name]) for name in fields["names"]]
        elif service == "set_parameters":
            response.results = [DEFINITIONS.initial("rcl_interfaces/msg/SetParametersResult") for _ in self.results]
            for result, reason in zip(response.results, self.results, strict=True):
                result.reason = reason
        return response


def test_parameters_without_a_value_are_left_out_of_a_dump() -> None:
    assert current(Peer({"a": 1, "b": None, "c": 3})) == {"a": 1, "c": 3}
    assert current(Peer({"a": 1, "c": 3})) == {"a": 1, "c": 3}
    assert current(Peer({})) == {}


def test_a_wrong_number_of_results_is_an_error_that_shows_the_response() -> None:
    with pytest.raises(TransportError, match="/peer returned 1 results for 2 parameters: too many"):
        Peer({}, ["too many"]).set([parameter_message(name, ParameterType.INTEGER, 1) for name in "ab"])


def test_the_reason_of_a_peer_has_no_control_characters_on_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    result = DEFINITIONS.initial("rcl_interfaces/msg/SetParametersResult")
    result.reason = "no\x1b[2J"
    assert report(result, "done", "failed") == 1
    assert capsys.readouterr().err == "failed: no\N{REPLACEMENT CHARACTER}[2J\n"


def test_an_empty_list_names_the_searched_domain(param: Graphrun) -> None:
    assert param("list", code=0, out="").err.startswith("no nodes with parameters on domain ")
