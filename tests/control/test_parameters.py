"""The parameters of a session behind the six parameter services, and what is said of their changes."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.control.parameter_messages import descriptor
from graphengine.control.parameter_services import MAX_REQUEST, ParameterServices
from graphengine.control.parameters import ParameterNodes, node_name
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.names import check_topic
from graphengine.messages.parameters import (
    EVENT,
    EVENTS,
    SERVICES,
    ParameterType,
    fitting_type,
    parameter_message,
    python_value,
)
from graphengine.messages.qos import PARAMETER_EVENTS
from graphengine.node.types import PortType
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.ros.transports.memory.memory_services import MemoryServer
from graphengine.runtime.commands import Assign
from graphengine.runtime.parameter_table import Parameter, graph_parameters
from graphengine.scene import build
from tests.control.harness import Controlled, controlled
from tests.control.simulators import Client
from tests.parameter_scene import DRIVE, LIMIT, NODES, write_scene
from tests.waiting import eventually

SPEED, RADIUS = "drive.variables.speed", "drive.Control.wheelRadius"
SCENE, BOT = NODES


class NodeTransport(MemoryTransport):
    """A memory transport that names a node, as those on a network do."""

    node = SCENE

    def server(self, service: str, *how: Any, **more: Any) -> MemoryServer:
        """A server, whose name must be legal as on a network."""
        check_topic(service)
        return super().server(service, *how, **more)


class Parameters(Client):
    """A run that offers its parameters."""

    def __init__(self, run: Controlled, transport: MemoryTransport, events: list[Any], told: list[str]) -> None:
        super().__init__(transport)
        self.run = run
        self.session = run.session
        self.events = events
        self.told = told
        self.transport = transport
        self.listen()

    def listen(self) -> None:
        """Subscribe to the changes."""

        def hear(data: bytes) -> None:
            self.events.append(messages.decode(data, EVENT))

        self.hearing = self.transport.reader(EVENTS, EVENT, PARAMETER_EVENTS, hear)

    def to(self, node: str, service: str, **fields: Any) -> Any:
        return self.ask(f"{node.strip('/')}/{service}", SERVICES[service], **fields)

    def value(self, name: str, node: str = BOT) -> Any:
        (value,) = self.to(node, "get_parameters", names=[name]).values
        return python_value(value)

    def put(self, values: Mapping[str, Any], node: str = BOT) -> list[str]:
        """Set parameters one by one; the reasons of refusals, empty for those that were set."""
        results = self.to(node, "set_parameters", parameters=[given(*item) for item in values.items()]).results
        assert all(result.successful != bool(result.reason) for result in results)
        return [result.reason for result in results]

    def ready(self, service: str) -> bool:
        """Whether a service has a server."""
        client = self.transport.client(service, SERVICES[service.rpartition("/")[2]], QoS(), lambda number, data: None)
        with contextlib.closing(client):
            return client.ready

    def heard(self, node: str = BOT) -> list[tuple[list[str], dict[str, Any], list[str]]]:
        """Names of new parameters, values of changed ones, and names of deleted ones, of each event of a node."""
        return [
            (
                [each.name for each in event.new_parameters],
                {each.name: python_value(each.value) for each in event.changed_parameters},
                [each.name for each in event.deleted_parameters],
            )
            for event in tuple(self.events)
            if event.node == node
        ]


def given(name: str, value: Any) -> Any:
    return parameter_message(name, fitting_type(value), value)


@contextlib.contextmanager
def offered(folder: Path, **how: Any) -> Iterator[Parameters]:
    scene = build.load(write_scene(folder))
    transport, events = NodeTransport(), list[Any]()
    told: list[str] = []
    session = build.start(scene, LiveNetwork(lambda _: transport, 0, print))
    with controlled(session, **{"paused": True, **how}) as run:
        running = Parameters(run, transport, events, told)
        nodes = ParameterNodes(session, run.queue, transport, told.append)
        try:
            assert eventually(lambda: len(events) == 2)
            events.clear()
            yield running
        finally:
            nodes.close()


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[Parameters]:
    with offered(tmp_path) as running:
        yield running


def test_a_robots_node_has_inputs_and_variables_and_the_sessions_node_the_real_time_factor(sim: Parameters) -> None:
    assert list(sim.to(SCENE, "list_parameters").result.names) == ["real_time_factor", "use_sim_time"]
    names = sim.to(BOT, "list_parameters").result.names
    assert {SPEED, RADIUS, LIMIT, "use_sim_time"} <= set(names)
    assert {"drive.Control.linearVelocity", "drive.Read.variableName", "real_time_factor"}.isdisjoint(names)
    assert names == sorted(names)


def test_names_are_listed_below_prefixes_and_down_to_a_depth(sim: Parameters) -> None:
    def listed(depth: int, *prefixes: str) -> list[str]:
        return list(sim.to(BOT, "list_parameters", prefixes=list(prefixes), depth=depth).result.names)

    assert listed(1) == ["use_sim_time"]
    assert listed(0, "drive.variables") == listed(1, "drive.variables") == [SPEED]
    assert listed(1, "drive") == []
    assert listed(0, RADIUS, "use_sim_time", "drive.Cont") == [RADIUS, "use_sim_time"]


def test_types_values_and_descriptors_are_those_of_the_ports(sim: Parameters) -> None:
    names = [SPEED, LIMIT, "use_sim_time", "nothing"]
    assert sim.to(BOT, "get_parameter_types", names=names).types.tolist() == [3, 3, 1, 0]
    assert [sim.value(name) for name in names] == [1.5, 0.0, True, None]
    speed, limit, stamps, unknown = sim.to(BOT, "describe_parameters", names=names).descriptors
    assert (limit.name, limit.type) == (LIMIT, ParameterType.DOUBLE)
    assert limit.description == "largest speed of the base; 0: no limit [m/s]"
    assert (speed.read_only, stamps.read_only, unknown.type) == (False, True, 0)


@pytest.mark.parametrize(
    ("kind", "limits", "real", "whole"),
    [
        (PortType("double"), (0.0, 2.5), [(0.0, 2.5)], []),
        (PortType("int"), (-3, 7), [], [(-3, 7)]),
        (PortType("double"), None, [], []),
    ],
)
def test_a_descriptor_has_the_range_of_a_number_with_limits(
    kind: PortType, limits: tuple[float, float] | None, real: list[Any], whole: list[Any]
) -> None:
    found = descriptor("a", Parameter("a", kind, lambda: 0, None, limits=limits))
    assert [(one.from_value, one.to_value) for one in found.floating_point_range] == real
    assert [(one.from_value, one.to_value) for one in found.integer_range] == whole


@pytest.mark.parametrize("value", [0.5, 2, "1e-5", math.inf])
def test_a_set_value_can_be_read_and_is_announced(sim: Parameters, value: Any) -> None:
    assert sim.put({LIMIT: value}) == [""]
    assert sim.value(LIMIT) == float(value)
    assert eventually(lambda: sim.heard() == [([], {LIMIT: float(value)}, [])])


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        (LIMIT, "fast", "is a double: expected a number, got 'fast'"),
        (LIMIT, [1.0], "is a double: expected a number"),
        (LIMIT, f"[1{'0' * 400}]", "is a double: expected a number"),
        (LIMIT, True, "is a double: expected a number"),
        (LIMIT, None, "parameters cannot be deleted"),
        (
            "drive.Control.maxLinearSped",
            1.0,
            f"unknown parameter 'drive.Control.maxLinearSped'; did you mean '{LIMIT}'?",
        ),
        ("drive.Read.variableName", "speed", "unknown parameter"),
        ("use_sim_time", False, "use_sim_time is read-only"),
    ],
)
def test_a_refused_value_has_a_reason_and_does_not_affect_the_others(
    sim: Parameters, name: str, value: Any, words: str
) -> None:
    first, reason, last = sim.put({RADIUS: 0.2, name: value, SPEED: 3.0})
    assert (first, last) == ("", "")
    assert words in reason
    assert (sim.value(RADIUS), sim.value(SPEED), sim.value(LIMIT)) == (0.2, 3.0, 0.0)


def test_an_atomic_set_changes_all_parameters_or_none(sim: Parameters) -> None:
    good = [given(RADIUS, 0.2), given(SPEED, 3.0), given("use_sim_time", True)]
    refused = sim.to(BOT, "set_parameters_atomically", parameters=[*good, given(LIMIT, "fast")]).result
    assert (refused.successful, sim.value(RADIUS), sim.value(SPEED)) == (False, 0.1, 1.5)
    assert "expected a number" in refused.reason
    assert sim.to(BOT, "set_parameters_atomically", parameters=good).result.successful
    assert (sim.value(RADIUS), sim.value(SPEED)) == (0.2, 3.0)


def test_an_array_that_an_atomic_set_changed_is_set_back_and_recorded(
    sim: Parameters, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded: list[str] = []
    way = "drive.variables.way"
    more = DRIVE.replace("{speed:", "{way: {type: 'double[]', default: [1.0, 2.0]}, speed:")
    (tmp_path / "drive.yaml").write_text(more, encoding="utf-8")
    sim.run.ask("reload")
    table = graph_parameters(sim.session.graphs, "bot")
    table["lost"] = Parameter(
        "lost",
        PortType("double"),
        lambda: 0.0,
        lambda value: Assign(graph="bot/drive", variable="lost", value=value),
    )
    monkeypatch.setattr(sim.session, "note", lambda name, arguments: recorded.append(json.dumps(arguments)))
    with contextlib.closing(ParameterServices("/other", table, sim.run.queue, sim.transport, print)):
        values = [given(way, [3.0]), given("lost", 1.0)]
        result = sim.to("/other", "set_parameters_atomically", parameters=values).result
        assert (result.successful, sim.value(way, "/other")) == (False, [1.0, 2.0])
    assert "no variable 'lost'" in result.reason
    assert [json.loads(text)["value"] for text in recorded] == [[3.0], [1.0, 2.0]]


def test_an_empty_request_changes_nothing(sim: Parameters) -> None:
    assert sim.put({}) == []
    assert sim.to(BOT, "set_parameters_atomically").result.successful
    assert sim.heard() == []


def test_a_request_with_too_many_parameters_changes_none(sim: Parameters) -> None:
    many = [given(RADIUS, 1.0)] * (MAX_REQUEST + 1)
    (result,) = sim.to(BOT, "set_parameters", parameters=many).results
    assert not result.successful
    assert result.reason == f"{MAX_REQUEST + 1} parameters in one request; legal: up to {MAX_REQUEST}"
    assert sim.to(BOT, "set_parameters_atomically", parameters=many).result.reason == result.reason
    assert sim.value(RADIUS) == 0.1


def test_a_request_with_too_many_names_gets_an_empty_response(sim: Parameters) -> None:
    names = [RADIUS] * (MAX_REQUEST + 1)
    assert len(sim.to(BOT, "get_parameters", names=names[1:]).values) == MAX_REQUEST
    assert not len(sim.to(BOT, "get_parameters", names=names).values)
    assert not len(sim.to(BOT, "get_parameter_types", names=names).types)
    assert not len(sim.to(BOT, "describe_parameters", names=names).descriptors)
    assert not len(sim.to(BOT, "list_parameters", prefixes=names).result.names)


def test_similar_names_are_suggested_for_the_first_three_failures(sim: Parameters) -> None:
    reasons = sim.put({f"{LIMIT}{end}": 1.0 for end in "abcde"})
    assert ["did you mean" in reason for reason in reasons] == [True] * 3 + [False] * 2
    assert all("unknown parameter" in reason for reason in reasons)


def test_changes_by_other_commands_are_announced(sim: Parameters) -> None:
    sim.run.ask("set", address="Control.maxLinearSpeed", value=0.25)
    assert eventually(lambda: sim.heard() == [([], {LIMIT: 0.25}, [])])
    sim.run.ask("rate", factor=0.5)
    assert eventually(lambda: sim.heard(SCENE) == [([], {"real_time_factor": 0.5}, [])])
    sim.run.ask("assign", graph="bot/drive", variable="speed", value=2.0)
    assert eventually(lambda: sim.heard()[1:] == [([], {SPEED: 2.0}, [])])


def test_the_first_subscriber_receives_the_changes_since_the_last_announcement(sim: Parameters) -> None:
    sim.hearing.close()
    sim.put({LIMIT: 0.5})
    assert sim.heard() == []
    sim.listen()
    sim.put({RADIUS: 0.25})
    changes = {LIMIT: 0.5, RADIUS: 0.25}
    assert eventually(lambda: {name: value for _, new, _ in sim.heard() for name, value in new.items()} == changes)


def test_the_stamp_of_an_event_is_simulation_time(sim: Parameters) -> None:
    sim.run.ask("step", ticks=30)
    sim.put({LIMIT: 0.5})
    assert eventually(lambda: sim.events)
    stamp = sim.events[0].stamp
    assert stamp.sec + 1e-9 * stamp.nanosec == pytest.approx(sim.session.time) != 0.0


def test_a_reset_keeps_inputs_and_returns_variables(sim: Parameters) -> None:
    sim.put({LIMIT: 0.5, SPEED: 3.0})
    sim.run.ask("reset")
    assert (sim.value(LIMIT), sim.value(SPEED)) == (0.5, 1.5)


def test_a_spawned_robot_has_a_node_while_it_exists(sim: Parameters) -> None:
    use = {"use": "bot.yaml", "position": [0, 3, 0.1], "namespace": "three"}
    sim.run.ask("spawn", name="second", use=use)
    there = "/three/second"
    assert eventually(lambda: sim.heard(there))
    assert SPEED in sim.heard(there)[0][0]
    assert sim.put({SPEED: 7.0}, there) == [""]
    assert (sim.value(SPEED, there), sim.value(SPEED)) == (7.0, 1.5)
    sim.run.ask("delete", name="second")
    assert eventually(lambda: sim.heard(there)[-1][2])
    assert eventually(lambda: not any(sim.ready(f"{there}/{service}") for service in SERVICES))
    assert sim.ready(f"{BOT}/set_parameters")


@pytest.mark.parametrize("namespace", ["/three", "three/", "~three"])
def test_namespaces_of_nodes_are_trimmed_like_those_of_topics(sim: Parameters, namespace: str) -> None:
    use = {"use": "bot.yaml", "position": [0, 3, 0.1], "namespace": namespace}
    sim.run.ask("spawn", name="second", use=use)
    assert eventually(lambda: sim.heard("/three/second"))


def test_an_illegal_node_name_is_reported_once_and_other_nodes_work(sim: Parameters) -> None:
    for name, namespace in (("bad", "n" * 230), ("good", "three")):
        use = {"use": "bot.yaml", "position": [0, 3 if name == "bad" else 6, 0.1], "namespace": namespace}
        sim.run.ask("spawn", name=name, use=use)
    assert eventually(lambda: sim.heard("/three/good"))
    assert len(sim.told) == 1
    assert sim.told[0].startswith(f"/{'n' * 230}/bad: its parameters are not offered: ")
    assert sim.put({LIMIT: 0.5}) == [""]


def test_a_reload_exchanges_the_parameters_of_a_changed_graph(sim: Parameters, tmp_path: Path) -> None:
    sim.put({LIMIT: 0.5})
    (tmp_path / "drive.yaml").write_text(DRIVE.replace("Name: {", "Other: {"), encoding="utf-8")
    sim.run.ask("reload")
    assert eventually(lambda: any("drive.Other.depth" in new for new, _, _ in sim.heard()))
    assert any("drive.Name.depth" in deleted for _, _, deleted in sim.heard())
    assert sim.value(LIMIT) == 0.5
    assert sim.put({LIMIT: 0.75}) == [""]
    assert sim.value(LIMIT) == 0.75


def test_an_ended_session_refuses_to_set_parameters_with_the_reason(sim: Parameters) -> None:
    sim.run.queue.close("the run has ended")
    assert sim.put({LIMIT: 0.5}) == ["the run has ended"]
    assert sim.to(BOT, "set_parameters_atomically", parameters=[given(LIMIT, 0.5)]).result.reason == "the run has ended"


@pytest.mark.parametrize(
    ("namespace", "robot", "taken", "name"),
    [
        ("dd100_0000", "dd100", (), "/dd100_0000/dd100"),
        ("", "dd100", (), "/dd100"),
        ("", "dd100", ("/dd100",), "/dd100_2"),
        ("a/b", "my robot-1", (), "/a/b/my_robot_1"),
        ("", "1st", (), "/robot_1st"),
    ],
)
def test_a_robots_node_has_its_name_in_its_namespace(
    namespace: str, robot: str, taken: tuple[str, ...], name: str
) -> None:
    assert node_name(namespace, robot, set(taken)) == name


def test_values_are_unchanged_after_encoding_and_decoding() -> None:
    for value in (True, -5, 2.5, "text", [True, False], [1, -2], [1.0, 2.5], ["a", "b"]):
        assert python_value(given("x", value).value) == value
    assert fitting_type([1, 2.5]) is ParameterType.DOUBLE_ARRAY
    assert fitting_type({"a": 1}) is fitting_type([1, "a"]) is ParameterType.NOT_SET
    assert python_value(parameter_message("x", ParameterType.INTEGER, 2**63).value) is None
    strange = DEFINITIONS.initial("rcl_interfaces/msg/ParameterValue")
    strange.type = 99
    assert python_value(strange) is None


def test_a_float_has_the_shortest_decimal_in_a_message() -> None:
    gains = Parameter("gains", PortType("float", array=True), lambda: np.array([0.45, 0.1], np.float32), None)
    assert python_value(gains.message(gains.read()).value) == [0.45, 0.1]
