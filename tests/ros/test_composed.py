"""rclpy and embedded DDS as one transport: one node to others, no stranger to itself. The contract is in test_contract_*.py."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.errors import TransportError
from graphengine.messages import goals
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.messages.messages import decode, encode
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions, discover
from graphengine.ros.transports.composed import ComposedTransport
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.rcl.rcl import RclTransport, discovery
from graphengine.ros.transports.rcl.rcl_profiles import is_installed
from graphengine.ros.transports.select import open_transport
from graphengine.ros.transports.vendors import CYCLONE, FAST_DDS
from tests.action_graph import FIBONACCI
from tests.action_graph import SERVER as FIBONACCI_SERVER
from tests.jobs.harness import ROOT
from tests.ros import needs
from tests.ros.conftest import OpenDds
from tests.ros.contract import STRING, Inbox, composed, connect
from tests.ros.service_contract import NAME, TYPE, Client, Server
from tests.ros.test_actions import running
from tests.service_graph import SERVER, extended
from tests.waiting import PATIENCE, eventually

pytestmark = pytest.mark.ros

TF, ODOMETRY = "tf2_msgs/msg/TFMessage", "nav_msgs/msg/Odometry"
SET_BOOL = "std_srvs/srv/SetBool"
LACKING = ("std_msgs", "diagnostic_msgs", "example_interfaces", "tf2_msgs")
"""Packages whose types are on embedded DDS in these tests."""

needs_wheels = pytest.mark.ros(needs.wheels())
needs_fast_dds = pytest.mark.ros(needs.fast_dds())


@pytest.fixture
def robot(domain: Domain) -> Iterator[ComposedTransport]:
    """A node with both transports open: /apart is on embedded DDS."""
    transport = composed(JoinOptions(domain, "robot"), *LACKING)
    yield transport
    transport.close()


@pytest.fixture
def looker(domain: Domain) -> Iterator[Any]:
    """A node of rclpy itself, in a context of its own."""
    import rclpy
    from rclpy.node import Node

    context = rclpy.Context()
    with discovery(domain):
        context.init(args=[], domain_id=domain.id)
    node = Node("looker", context=context, start_parameter_services=False)
    yield node
    node.destroy_node()
    context.try_shutdown()


@pytest.fixture
def wheels(domain: Domain) -> Iterator[Callable[..., Any]]:
    """Opens what `--transport rclpy` is."""
    opened: list[Any] = []

    def join(name: str, **options: Any) -> Any:
        opened.append(open_transport("rclpy", JoinOptions(domain, name, **options)))
        return opened[-1]

    yield join
    for transport in opened:
        transport.close()


def vendors_of(looker: Any, topic: str) -> set[bytes]:
    """RTPS vendor ids of the publishers of a topic, whose name has no prefix added."""
    return {bytes(info.endpoint_gid)[:2] for info in looker.get_publishers_info_by_topic(topic, no_mangle=True)}


# One node to others


@needs_fast_dds
def test_rclpy_sees_one_node_and_topics_of_both_transports(robot: ComposedTransport, looker: Any) -> None:
    robot.writer("/odom", ODOMETRY, QoS())
    robot.writer("/tf", TF, QoS())
    Server(robot)
    robot.server("/light", SET_BOOL, QoS(), lambda request_id, data: None)
    topics = {("/odom", ODOMETRY), ("/tf", TF), ("/apart", "std_msgs/msg/Bool")}
    services = {(NAME, TYPE), ("/light", SET_BOOL)}
    assert eventually(lambda: topics <= {(name, *kinds) for name, kinds in looker.get_topic_names_and_types()})
    assert eventually(lambda: services <= {(name, *kinds) for name, kinds in looker.get_service_names_and_types()})
    assert eventually(lambda: "robot" in looker.get_node_names())
    assert sorted(looker.get_node_names()) == ["looker", "robot"]
    assert vendors_of(looker, "rt/tf") == {CYCLONE}
    for topic in ("ros_discovery_info", "rt/rosout", "rt/parameter_events"):
        assert vendors_of(looker, topic) == {FAST_DDS}, topic


@needs_fast_dds
def test_embedded_dds_sees_one_node_with_the_endpoints_of_both(robot: ComposedTransport, dds: OpenDds) -> None:
    robot.writer("/odom", ODOMETRY, QoS())
    robot.reader("/tf", TF, QoS(), print)
    Server(robot)
    client = robot.client("/light", SET_BOOL, QoS(), lambda number, data: None)
    bob = dds("bob")

    def ends() -> dict[str, str]:
        return {end.topic: end.full_node for end in bob.graph().endpoints if end.topic in ("/odom", "/tf")}

    assert eventually(lambda: ends() == {"/odom": "/robot", "/tf": "/robot"})
    (node,) = [node for node in bob.graph().nodes if node.name == "/robot"]
    assert (NAME, TYPE) in node.servers
    assert ("/light", SET_BOOL) in node.clients
    client.close()
    assert [node.name for node in bob.graph().nodes] == ["/bob", "/robot"]


def test_messages_cross_to_peers_on_either_transport(robot: ComposedTransport, domain: Domain, dds: OpenDds) -> None:
    fast = RclTransport(JoinOptions(domain, "fast"))
    try:
        for peer in (fast, dds("bob")):
            heard, sent = Inbox(), Inbox()
            name = peer.node
            peer.reader(f"{name}/to", STRING, QoS(), heard)
            connect(robot.writer(f"{name}/to", STRING, QoS()), heard)
            robot.reader(f"{name}/from", STRING, QoS(), sent)
            connect(peer.writer(f"{name}/from", STRING, QoS()), sent)
    finally:
        fast.close()


@needs_fast_dds
def test_services_reach_peers_on_the_transport_of_their_type(
    robot: ComposedTransport, domain: Domain, dds: OpenDds
) -> None:
    answers: list[bytes] = []
    response = encode(DEFINITIONS.initial(f"{SET_BOOL}_Response"))
    light = robot.server("/light", SET_BOOL, QoS(), lambda request_id, _: light.answer(request_id, response))
    server = Server(robot)
    fast = RclTransport(JoinOptions(domain, "fast"))
    try:
        switch = fast.client("/light", SET_BOOL, QoS(), lambda number, data: answers.append(data))
        assert eventually(lambda: switch.ready)
        request = encode(DEFINITIONS.initial(f"{SET_BOOL}_Request"))
        assert eventually(lambda: answers, lambda: switch.call(request))
    finally:
        fast.close()
    client = Client(dds("bob"))
    assert eventually(lambda: client.end.ready)
    client.call("a")
    assert eventually(lambda: server.texts == ["a"])
    server.answer(0)
    assert eventually(lambda: client.answers == {1: "a!"})


def test_all_parts_of_an_action_are_on_one_transport(robot: ComposedTransport, dds: OpenDds) -> None:
    parts = goals.parts("/count", FIBONACCI)
    asked: list[str] = []
    for role in ("send_goal", "cancel_goal", "get_result"):
        robot.server(*parts[role], QoS(), lambda request_id, data, role=role: asked.append(role))  # type: ignore[misc]
    for role in ("feedback", "status"):
        robot.writer(*parts[role], QoS())
    bob = dds("bob")
    cancel = bob.client(*parts["cancel_goal"], QoS(), lambda number, data: None)
    assert eventually(lambda: cancel.ready)
    request = encode(DEFINITIONS.initial(f"{parts['cancel_goal'].message_type}_Request"))
    assert eventually(lambda: asked, lambda: cancel.call(request))
    assert asked[0] == "cancel_goal"
    vendors = {end.gid[:2] for end in robot.graph().endpoints if end.topic.startswith("/count/")}
    assert vendors == {CYCLONE}
    assert "can use the services and actions: /count" in robot.notices[0]


def test_an_endpoint_without_a_ros_node_does_not_delay_discovery(domain: Domain, dds: OpenDds) -> None:
    dds("bare", announces=False).writer("/chatter", STRING, QoS())
    fast = RclTransport(JoinOptions(domain, "fast"))
    try:
        assert eventually(lambda: fast.graph().publishers("/chatter"))
        assert [end.full_node for end in fast.graph().publishers("/chatter")] == [""]
        assert eventually(lambda: fast.graph().named)
    finally:
        fast.close()


# Neither transport is a stranger to the other


class Fellows:
    """A session with endpoints on both transports, and the faults that it reports."""

    def __init__(self, transport: ComposedTransport) -> None:
        self.told: list[str] = []
        self.network = LiveNetwork(lambda domain: transport, 0, self.told.append)
        for topic, kind in (("/clock", "rosgraph_msgs/msg/Clock"), ("/chatter", STRING)):
            for direction, open_end in (("publish", self.network.publisher), ("subscribe", self.network.subscription)):
                claim = EndpointClaim("/node", "graph", topic, kind, direction, QoS())
                open_end(claim)


def test_endpoints_on_the_other_transport_are_not_reported(robot: ComposedTransport) -> None:
    fellows = Fellows(robot)
    for service, kind in ((NAME, TYPE), ("/light", SET_BOOL)):
        robot.server(service, kind, QoS(), lambda request_id, data: None)
        client = robot.client(service, kind, QoS(), lambda number, data: None)
        assert eventually(lambda client=client: client.ready)  # type: ignore[misc]
    topics = ["/apart", "/chatter", "/chatter", "/clock", "/clock"]

    def own() -> list[str]:
        ends = (end for end in robot.graph().endpoints if end.full_node == "/robot")
        return sorted(end.topic for end in ends if end.topic in topics)

    # Each transport discovers the endpoints of the other after a while; and then each is there once.
    first, second = robot._first, robot._second
    assert second is not None
    assert eventually(lambda: second.graph().publishers("/clock") and first.graph().publishers("/chatter"))
    assert own() == topics
    assert eventually(lambda: [node.name for node in robot.graph().nodes] == ["/robot"])
    (node,) = robot.graph().nodes
    assert {(NAME, TYPE), ("/light", SET_BOOL)} <= set(node.servers) & set(node.clients)
    for _ in range(3):
        fellows.network.freeze()
        for watch in fellows.network._watches.values():
            watch.finish()
            watch.hurry()
    assert fellows.told == []
    assert (dict(robot.foreign_services), list(robot.rival_services), dict(robot.malformed)) == ({}, [], {})


def test_conflicting_endpoints_on_either_transport_are_reported(robot: ComposedTransport, domain: Domain) -> None:
    other = composed(JoinOptions(domain, "other"), *LACKING)
    try:
        for transport in (robot, other):
            Server(transport)
            transport.server("/light", SET_BOOL, QoS(), lambda request_id, data: None)

        def rivals() -> list[str]:
            robot.graph()
            return sorted(robot.rival_services)

        assert eventually(lambda: rivals() == sorted(["/light", NAME]))
    finally:
        other.close()


@needs_fast_dds
def test_unreachable_peers_are_reported_for_both_transports(
    robot: ComposedTransport, domain: Domain, dds: OpenDds
) -> None:
    Server(robot)
    robot.server("/light", SET_BOOL, QoS(), lambda request_id, data: None)
    fast, bob = RclTransport(JoinOptions(domain, "fast")), dds("bob")
    try:
        Client(fast)
        bob.client("/light", SET_BOOL, QoS(), lambda number, data: None)
        assert eventually(lambda: set(robot.foreign_services) == {NAME, "/light"})
    finally:
        fast.close()


def test_the_source_of_a_message_is_known_if_its_transport_knows_it(robot: ComposedTransport, dds: OpenDds) -> None:
    sources: dict[str, bytes] = {}

    def note(data: bytes, kind: str) -> None:
        sources[kind] = robot.source

    robot.reader("/tf", TF, LATCHED, lambda data: note(data, TF))
    robot.reader("/odom", ODOMETRY, LATCHED, lambda data: note(data, ODOMETRY))
    writers = {kind: robot.writer(topic, kind, LATCHED) for topic, kind in (("/tf", TF), ("/odom", ODOMETRY))}
    for kind in (TF, ODOMETRY):  # of the second, nothing is known, and not that it is as the first
        writers[kind].write(encode(DEFINITIONS.initial(kind)))
        assert eventually(lambda kind=kind: kind in sources)  # type: ignore[misc]
    assert sources[ODOMETRY] == b""
    assert [end.gid for end in robot.graph().publishers("/tf")] == [sources[TF]]


def test_malformed_messages_of_both_transports_are_counted(domain: Domain, dds: OpenDds, tmp_path: Path) -> None:
    others = DEFINITIONS.extended([tmp_path])
    others.type_hash = lambda message_type: "RIHS01_00"  # type: ignore[method-assign]
    robot = composed(JoinOptions(domain, "robot", definitions=others), *LACKING)
    try:
        bob = dds("bob")
        writers = []
        for topic, kind in (("/chatter", STRING), ("/twist", "geometry_msgs/msg/Twist")):
            robot.reader(topic, kind, QoS(), lambda data: None)
            writers.append((bob.writer(topic, kind, QoS()), encode(DEFINITIONS.initial(kind))))

        def write() -> None:
            for writer, data in writers:
                writer.write(data)

        assert eventually(lambda: {"/chatter", "/twist"} <= set(robot.malformed), write)
    finally:
        robot.close()


# When there is a second one


@needs_wheels
def test_embedded_dds_joins_at_the_first_message_type_that_the_rcl_wheels_lack(
    wheels: Callable[..., Any], looker: Any
) -> None:
    robot = wheels("robot")
    robot.writer("/odom", ODOMETRY, QoS())
    assert eventually(lambda: "/odom" in dict(looker.get_topic_names_and_types()))
    assert ";" not in robot.description
    assert vendors_of(looker, "rt/odom") == {FAST_DDS}
    assert not is_installed(TF)
    robot.writer("/tf", TF, QoS())
    robot.server("/look", "tf2_msgs/srv/FrameGraph", QoS(), lambda request_id, data: None)
    assert robot.description.endswith("; types of tf2_msgs on dds (Eclipse Cyclone DDS)")
    assert robot.notices == ["only nodes on rmw_cyclonedds_cpp can use the services and actions: /look"]


@needs_wheels
def test_the_error_names_a_type_that_both_transports_lack(wheels: Callable[..., Any]) -> None:
    with pytest.raises(MessageTypeError, match="no_msgs/msg/Nothing"):
        wheels("robot").writer("/nothing", "no_msgs/msg/Nothing", QoS())


@needs_wheels
def test_a_run_that_does_not_wait_for_slow_readers_says_so(wheels: Callable[..., Any]) -> None:
    assert "publishers on rclpy do not wait for slow readers" in wheels("hasty", patient=True).description
    assert "slow readers" not in wheels("live").description


@needs_wheels
def test_a_peer_learns_the_nodes_name_even_if_it_lacks_no_type(
    wheels: Callable[..., Any], robot: ComposedTransport
) -> None:
    robot.writer("/tf", TF, QoS())
    watcher = wheels("watcher")
    graph = discover(watcher, 60.0, lambda graph: [end.node for end in graph.publishers("/tf")] == ["robot"])
    assert [end.node for end in graph.publishers("/tf")] == ["robot"]


def graphrun(domain_id: int, *arguments: str) -> str:
    """What `graphrun … --transport rclpy` prints in the test's domain, errors too."""
    done = subprocess.run(
        [sys.executable, "-m", "graphengine.cli", *arguments, "--transport", "rclpy"],
        cwd=ROOT,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    return done.stdout


@needs_wheels
def test_the_verbs_read_topics_whose_type_the_wheels_lack(dds: OpenDds, domain_id: int) -> None:
    message = DEFINITIONS.initial(TF)
    message.transforms = [DEFINITIONS.initial("geometry_msgs/msg/TransformStamped")]
    message.transforms[0].child_frame_id = "wheel"
    dds("robot").writer("/tf", TF, LATCHED).write(encode(message))
    assert "child_frame_id: wheel" in graphrun(domain_id, "topic", "echo", "/tf", "--once")


@needs_wheels
def test_at_its_start_a_run_lists_actions_that_only_some_peers_can_use(tmp_path: Path, domain_id: int) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text(f"format: 1\ngraph: graph\n{FIBONACCI_SERVER}", "utf-8")
    printed = graphrun(domain_id, "run", str(path), "--for", "0.1", "--no-control")
    assert printed.splitlines()[1] == "only nodes on rmw_cyclonedds_cpp can use the services and actions: /fibonacci"


@needs_wheels
def test_nodes_on_both_transports_can_use_parameters_services_and_transforms(
    tmp_path: Path, domain_id: int, looker: Any, dds: OpenDds
) -> None:
    from rcl_interfaces.msg import Parameter, ParameterValue
    from rcl_interfaces.srv import ListParameters, SetParameters
    from rclpy.executors import SingleThreadedExecutor
    from std_srvs.srv import SetBool

    executor = SingleThreadedExecutor(context=looker.context)
    executor.add_node(looker)

    def asked(kind: Any, name: str, **fields: Any) -> Any:
        client = looker.create_client(kind, name)
        assert eventually(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        assert eventually(future.done, lambda: executor.spin_once(0.01))
        return future.result()

    graph = extended(SERVER, "  Transform: {type: ROS2PublishRawTransformTree}\n", "Tick.tick -> Transform.execIn")
    with running(tmp_path, "rclpy", domain_id, graph):
        heard: list[bytes] = []
        dds("bob").reader("/tf", TF, QoS(), heard.append)
        names = asked(ListParameters, "/graph/list_parameters").result.names
        assert "graph.Transform.translation" in names
        moved = Parameter(name="graph.Transform.translation")
        moved.value = ParameterValue(type=8, double_array_value=[1.0, 2.0, 3.0])
        assert asked(SetParameters, "/graph/set_parameters", parameters=[moved]).results[0].successful
        assert asked(SetBool, "/light", data=True).message == "done"
        assert eventually(lambda: heard and decode(heard[-1], TF).transforms[0].transform.translation.y == 2.0)
        assert eventually(lambda: sorted(looker.get_node_names()) == ["bob", "graph", "looker"])


def test_of_22_services_on_the_second_transport_20_are_listed(robot: ComposedTransport) -> None:
    for number in range(22):
        Server(robot, f"/service_{number}")
    assert "services and actions: /service_0, /service_1, " in robot.notices[0]
    assert robot.notices[0].endswith("/service_19, … (2 more)")


def test_a_state_saved_before_the_second_transport_was_opened_can_be_restored(domain: Domain) -> None:
    options = JoinOptions(domain, "robot")
    transport = ComposedTransport(
        RclTransport(options), lambda kind: kind != TF, lambda: DdsTransport(options, announces=False)
    )
    try:
        early = transport.save()
        transport.writer("/tf", TF, QoS())
        transport.restore(early)
        transport.restore(transport.save())
    finally:
        transport.close()


def test_a_closed_network_opens_no_second_transport(domain: Domain) -> None:
    opened: list[str] = []

    def open_second() -> DdsTransport:
        opened.append("second")
        return DdsTransport(JoinOptions(domain, "robot"), announces=False)

    transport = ComposedTransport(RclTransport(JoinOptions(domain, "robot")), lambda kind: False, open_second)
    transport.close()
    with pytest.raises(TransportError, match=r"^/chatter: the transport is closed"):
        transport.writer("/chatter", STRING, QoS())
    assert opened == []


def test_the_first_transport_survives_an_error_of_the_second(domain: Domain) -> None:
    def open_second() -> DdsTransport:
        raise TransportError("no room")

    transport = ComposedTransport(RclTransport(JoinOptions(domain, "robot")), lambda kind: kind != TF, open_second)
    try:
        with pytest.raises(TransportError, match="no room"):
            transport.writer("/tf", TF, QoS())
        inbox = Inbox()
        transport.reader("/chatter", STRING, QoS(), inbox)
        connect(transport.writer("/chatter", STRING, QoS()), inbox)
    finally:
        transport.close()
