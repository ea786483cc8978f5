"""/diagnostics: what it says of a session, its network and its robots, and that nothing of it is part of the results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.api.diagnostics import PERIOD, TOPIC, TYPE, Diagnostics
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from tests.jobs.harness import Job

SCENE = """scene: two
world: worlds/flat_grid.xml
robots:
  one: {use: robots/dd100.yaml, namespace: one, position: [0, 0, 0.025]}
  two: {use: robots/dd100.yaml, namespace: two, position: [0, 3, 0.025]}
"""


class Watched:
    """A job whose diagnostics are measured with a clock that the test moves."""

    def __init__(self, folder: Path, *, reader: bool = True) -> None:
        (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
        self.job = Job(folder / "scene.yaml", heard=False)
        self.now, self.faults = 0.0, list[str]()
        network: Any = self.job.session.services.network
        self.network = network
        self.diagnostics = Diagnostics(self.job.session, network, "two", self.faults, lambda: self.now)
        self.heard: list[Any] = []
        if reader:
            self.listen(TOPIC, TYPE, lambda data: self.heard.append(messages.decode(data, TYPE)))

    def listen(self, topic: str, message_type: str, deliver: Any = lambda data: None) -> None:
        self.job.transport.reader(topic, message_type, QoS(), deliver)

    def second(self) -> dict[str, Any]:
        """Run a second of simulation; return the statuses that were published after it, by name."""
        self.diagnostics.after_tick()
        self.job.run(1.0)
        self.now += PERIOD
        self.diagnostics.after_tick()
        return {status.name.partition(": ")[2]: status for status in self.heard[-1].status} if self.heard else {}


def values(status: Any) -> dict[str, str]:
    return {pair.key: pair.value for pair in status.values}


def test_there_is_one_status_for_the_simulation_the_network_and_each_robot(tmp_path: Path) -> None:
    watched = Watched(tmp_path)
    with watched.job:
        statuses = watched.second()
    assert [*statuses] == ["simulation", "network", "one", "two"]
    assert [status.hardware_id for status in statuses.values()] == ["two", "two", "one", "two"]
    assert {status.level for status in statuses.values()} == {0}
    assert values(statuses["simulation"])["simulation time (s)"] == "1.000"


def test_rates_of_topics_that_have_readers_are_those_of_simulation_time(tmp_path: Path) -> None:
    watched = Watched(tmp_path)
    with watched.job:
        watched.listen("/one/odom", "nav_msgs/msg/Odometry")
        statuses = watched.second()
    assert values(statuses["one"]) == {"/one/odom (Hz)": "60.0 of 60"}
    assert values(statuses["two"]) == {}


def test_a_topic_that_misses_its_rate_is_a_warning_of_its_robot(tmp_path: Path) -> None:
    watched = Watched(tmp_path)
    with watched.job:
        watched.listen("/one/odom", "nav_msgs/msg/Odometry")
        watched.diagnostics.after_tick()
        watched.network.untap(watched.diagnostics)  # so that no message is counted
        statuses = watched.second()
        watched.network.tap(watched.diagnostics)
    assert statuses["one"].level == 1
    assert statuses["one"].message == "/one/odom: 0.0 Hz instead of 60 Hz"


def test_values_that_nodes_dropped_are_a_warning_in_the_second_in_which_it_happens(tmp_path: Path) -> None:
    watched = Watched(tmp_path)
    with watched.job:
        watched.diagnostics.after_tick()
        dropped = watched.job.session.services.dropped
        assert dropped is not None
        dropped.add("/one/graph/Node", 1)
        first, second = watched.second(), watched.second()
    assert (first["one"].level, first["one"].message) == (1, "/one/graph/Node dropped values")
    assert (first["two"].level, second["one"].level) == (0, 0)
    assert values(second["one"])["dropped values of /one/graph/Node"] == "1"


def test_faults_of_peers_are_a_warning_of_the_network(tmp_path: Path) -> None:
    watched = Watched(tmp_path)
    with watched.job:
        watched.faults.append("/odom: no messages reach /rviz\n  use reliability best effort")
        network = watched.second()["network"]
    assert (network.level, network.message) == (1, "problems with peers: 1")
    assert values(network)["peer 1"] == "/odom: no messages reach /rviz   use reliability best effort"


def test_nothing_is_measured_without_a_subscriber(tmp_path: Path) -> None:
    watched = Watched(tmp_path, reader=False)
    with watched.job:
        watched.second()
        assert watched.network.taps == []
    assert watched.heard == []


def test_a_recording_does_not_contain_it(tmp_path: Path) -> None:
    watched = Watched(tmp_path)
    with watched.job:
        watched.network.sinks.append(watched.job.recorder)
        watched.second()
        assert watched.heard
    assert TOPIC not in watched.job.types()


@pytest.mark.parametrize(("transport", "there"), [("memory", False), ("dds", True)])
def test_only_runs_that_reach_others_publish_it(tmp_path: Path, domain_id: int, transport: str, there: bool) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")
    with ge.load(tmp_path / "scene.yaml").session(transport=transport, domain=domain_id) as sim:
        sim.run(0.1)
        graph = sim._runner.network.transport(0).graph()
        assert bool(list(graph.publishers(TOPIC))) is there
