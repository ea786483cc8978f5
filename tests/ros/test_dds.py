"""What only the DDS transport does: being a ROS 2 node without ROS."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

import graphengine
from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import String, decode, encode
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds import cyclone, discovery
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.dds.idl import dds_name, idl_type
from tests.cli.harness import process
from tests.ros.conftest import OpenDds, StartPeer, end_peer
from tests.waiting import PATIENCE, eventually

STRING = "std_msgs/msg/String"
NO_SUCH = '<General><Interfaces><NetworkInterface name="none9"/></Interfaces></General>'
MESSAGES = [name for name in DEFINITIONS.names() if DEFINITIONS.definition(name).is_message]


@pytest.fixture
def alice(dds: OpenDds) -> DdsTransport:
    return dds("alice", node_namespace="/robots")


def test_two_processes_exchange_messages(alice: DdsTransport, start_peer: StartPeer) -> None:
    heard: list[bytes] = []
    alice.reader("/pong", STRING, QoS(), heard.append)
    ping = alice.writer("/ping", STRING, QoS())
    process = start_peer("echo")
    assert eventually(lambda: ping.matched)
    assert eventually(lambda: heard, lambda: ping.write(encode(String("hello"))))
    assert decode(heard[0], STRING) == String("hello")
    end_peer(process)
    assert eventually(lambda: not ping.matched)


def test_messages_that_arrive_while_the_process_is_busy_are_all_delivered(alice: DdsTransport) -> None:
    heard: list[bytes] = []
    busy, free = threading.Event(), threading.Event()

    def dawdle(data: bytes) -> None:
        heard.append(data)
        busy.set()
        free.wait()

    alice.reader("/chatter", STRING, QoS(depth=2), dawdle)
    writer = alice.writer("/chatter", STRING, QoS(depth=2))
    assert eventually(lambda: writer.matched)
    writer.write(encode(String("first")))
    assert busy.wait(PATIENCE)
    for number in range(500):
        writer.write(encode(String(str(number))))
    free.set()
    assert eventually(lambda: len(heard) == 501)


def test_a_patient_writer_loses_only_the_messages_that_it_counts(dds: OpenDds, start_peer: StartPeer) -> None:
    patient, heard, number = dds("patient", patient=True), set(), 0
    patient.reader("/pong", STRING, QoS(), lambda data: heard.add(data[8:10]))
    ping = patient.writer("/ping", STRING, QoS(depth=2))
    process = start_peer("echo")

    assert eventually(lambda: ping.matched)
    assert eventually(lambda: heard, lambda: ping.write(encode(String("first"))))
    heard.clear()
    process.send_signal(signal.SIGSTOP)
    while ping.dropped < 3 and number < 99:
        ping.write(encode(String(f"{number:02}" + "x" * 60_000)))
        number += 1
    process.send_signal(signal.SIGCONT)
    assert ping.dropped == 3
    assert eventually(lambda: len(heard - {b"fi"}) == number - ping.dropped)
    end_peer(process)


def test_two_writers_of_one_topic_do_not_deadlock(start_peer: StartPeer) -> None:
    start_peer("flood")
    assert start_peer("crowd").wait(timeout=2 * PATIENCE) == 0


class Graph:
    """The ROS graph as another participant sees it."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.participant = cyclone.join(domain, "enclave=/;")
        topic = Topic(self.participant, discovery.TOPIC, idl_type(discovery.TYPE))
        self.reader = DataReader(self.participant, topic, qos=cyclone.endpoint_qos(LATCHED, ""))
        self.newest: dict[bytes, Any] = {}

    def nodes(self) -> dict[str, Any]:
        while batch := cyclone.take(self.reader):
            for info in (decode(data, discovery.TYPE) for data, _ in batch):
                self.newest[info.gid.data.tobytes()] = info
        infos = [node for info in self.newest.values() for node in info.node_entities_info_seq]
        return {f"{node.node_namespace}/{node.node_name}": node for node in infos}


@pytest.fixture
def graph(domain: Domain) -> Iterator[Graph]:
    seen = Graph(domain)
    yield seen
    cyclone.leave(domain, seen.participant)


def test_the_node_and_its_endpoints_are_in_the_ros_graph_until_it_closes(alice: DdsTransport, graph: Graph) -> None:
    def endpoints() -> tuple[int, int] | None:
        node = graph.nodes().get("/robots/alice")
        return (len(node.reader_gid_seq), len(node.writer_gid_seq)) if node else None

    # Every node has the topics /rosout and /parameter_events.
    assert eventually(lambda: endpoints() == (0, 2))
    writer = alice.writer("/odom", "nav_msgs/msg/Odometry", QoS())
    reader = alice.reader("/cmd_vel", "geometry_msgs/msg/Twist", QoS(), lambda data: None)
    assert eventually(lambda: endpoints() == (1, 3))
    announced = {gid.data.tobytes() for gid in graph.nodes()["/robots/alice"].writer_gid_seq}
    assert writer.entity.guid.bytes in announced
    writer.close()
    reader.close()
    assert eventually(lambda: endpoints() == (0, 2))
    alice.close()
    assert eventually(lambda: graph.nodes() == {})


def test_nodes_of_other_processes_are_in_the_ros_graph(graph: Graph, start_peer: StartPeer) -> None:
    process = start_peer("echo")
    assert eventually(lambda: "//peer_echo" in graph.nodes())
    end_peer(process)
    assert eventually(lambda: graph.nodes() == {})


def test_names_types_and_hashes_are_announced_as_ros_2_does(alice: DdsTransport) -> None:
    writer = alice.writer("/robot/odom", "nav_msgs/msg/Odometry", QoS())
    assert writer.entity.topic.get_name() == "rt/robot/odom"
    assert writer.entity.topic.get_type_name() == dds_name("nav_msgs/msg/Odometry")
    policies = {type(policy).__name__: policy for policy in writer.entity.get_qos()}
    assert policies["Userdata"].data == f"typehash={DEFINITIONS.type_hash('nav_msgs/msg/Odometry')};".encode()
    assert not policies["WriterDataLifecycle"].autodispose
    assert policies["DataRepresentation"].use_cdrv0_representation
    assert not policies["DataRepresentation"].use_xcdrv2_representation


def test_dds_type_names_are_those_of_ros_2() -> None:
    assert dds_name("nav_msgs/msg/Odometry") == "nav_msgs::msg::dds_::Odometry_"


@pytest.mark.parametrize("message_type", MESSAGES)
def test_every_message_type_can_be_described_to_dds(message_type: str, alice: DdsTransport) -> None:
    writer = alice.writer("/any", message_type, QoS())
    assert writer.entity.topic.get_type_name() == dds_name(message_type)


def test_a_message_of_another_type_is_refused_by_the_writer(alice: DdsTransport) -> None:
    writer = alice.writer("/odom", "nav_msgs/msg/Odometry", QoS())
    with pytest.raises(TransportError, match="/odom: 12 bytes were not sent"):
        writer.write(encode(String("hi")))


def test_an_unpadded_message_is_padded_to_four_bytes(alice: DdsTransport) -> None:
    heard: list[bytes] = []
    alice.reader("/chatter", STRING, QoS(), heard.append)
    writer = alice.writer("/chatter", STRING, QoS())
    assert eventually(lambda: writer.matched)
    writer.write(encode(String("hi"))[:-1])
    assert eventually(lambda: heard == [encode(String("hi"))])


def test_a_topic_has_one_type(alice: DdsTransport) -> None:
    alice.writer("/chatter", STRING, QoS())
    with pytest.raises(TransportError, match=r"^/chatter has the type std_msgs/msg/String in this process"):
        alice.reader("/chatter", "std_msgs/msg/Bool", QoS(), lambda data: None)


def test_a_topic_without_endpoints_may_get_another_type(alice: DdsTransport) -> None:
    first, second = alice.writer("/chatter", STRING, QoS()), alice.writer("/chatter", STRING, QoS())
    first.close()
    with pytest.raises(TransportError, match="chatter has the type"):
        alice.writer("/chatter", "std_msgs/msg/Bool", QoS())
    second.close()
    alice.writer("/chatter", "std_msgs/msg/Bool", QoS())


def test_a_process_joins_a_domain_with_one_configuration_only(alice: DdsTransport, domain: Domain) -> None:
    with pytest.raises(TransportError, match="already joined domain"):
        DdsTransport(JoinOptions(Domain(domain.id, "SUBNET"), "bob"))


def test_close_leaves_no_thread_and_no_socket(domain: Domain) -> None:
    def sockets() -> int:
        links = (os.readlink(link) for link in Path("/proc/self/fd").iterdir() if link.is_symlink())
        return sum(target.startswith("socket:") for target in links)

    python_threads, threads, open_sockets = threading.active_count(), len(os.listdir("/proc/self/task")), sockets()
    transport = DdsTransport(JoinOptions(domain, "alice"))
    transport.reader("/chatter", STRING, QoS(), lambda data: None)
    assert len(os.listdir("/proc/self/task")) > threads
    assert sockets() > open_sockets
    transport.close()
    assert threading.active_count() == python_threads
    assert eventually(lambda: len(os.listdir("/proc/self/task")) <= threads)  # those that ended are listed a moment
    assert sockets() == open_sockets


def test_a_process_that_ends_without_closing_leaves_the_graph(graph: Graph) -> None:
    program = f"""
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.domain import Domain
DdsTransport(JoinOptions(Domain({graph.domain.id}, "LOCALHOST"), "careless"))
input()
raise SystemExit(3)
"""
    path = {**os.environ, "PYTHONPATH": str(Path(graphengine.__file__).parents[1])}
    with subprocess.Popen([sys.executable, "-W", "error", "-c", program], env=path, stdin=subprocess.PIPE) as process:
        assert eventually(lambda: "//careless" in graph.nodes())
        process.communicate(b"\n", timeout=PATIENCE)
    assert process.returncode == 3
    assert eventually(lambda: graph.nodes() == {})


def test_a_transport_that_cannot_join_leaves_no_entities(domain: Domain, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise TransportError("on purpose")

    before = len(os.listdir("/proc/self/task"))
    monkeypatch.setattr(DdsTransport, "_announce", fail)
    with pytest.raises(TransportError, match="on purpose"):
        DdsTransport(JoinOptions(domain, "alice"))
    assert eventually(lambda: len(os.listdir("/proc/self/task")) <= before)  # threads that ended are listed a moment


@pytest.mark.parametrize(
    ("configuration", "reason"),
    [
        ("<CycloneDDS><Domain", "parser error"),
        ("<CycloneDDS><Domain><Bad/></Domain></CycloneDDS>", "Bad: unknown element"),
        (f"<CycloneDDS><Domain>{NO_SUCH}</Domain></CycloneDDS>", "none9: does not match an available interface"),
    ],
)
def test_a_configuration_that_cyclone_refuses_is_reported_with_the_reason(configuration: str, reason: str) -> None:
    result = process("topic", "list", "--transport", "dds", env={"CYCLONEDDS_URI": configuration})
    (said,) = result.err.splitlines()
    assert result.code == 1
    assert said.startswith("error: cannot join domain 0, discovery range OFF, with CYCLONEDDS_URI: ")
    assert reason in said
