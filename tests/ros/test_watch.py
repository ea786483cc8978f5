"""What a session is told of peers that do not fit, with peers in memory and peers that are played."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from typing import cast

import pytest

from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.ros.endpoint_faults import MOST
from graphengine.ros.network import LiveNetwork
from graphengine.ros.network_graph import PATIENCE, Direction, Endpoint, NetworkGraph
from graphengine.ros.qos_diagnostics import LONGEST_PERIOD, PERIOD, RECEIVE_BUFFER, REPORTED_A_TICK, SHARE, Watch
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.waiting import eventually

TWIST, STAMPED, ODOMETRY = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "nav_msgs/msg/Odometry"
CLOCK = "rosgraph_msgs/msg/Clock"
DEFAULT, BEST_EFFORT = QoS(), QoS(reliability="bestEffort")
CYCLONE, FAST_DDS = bytes.fromhex("0110") + bytes(13), bytes.fromhex("010f") + bytes(13)
BUFFER = 212992


@dataclass
class Ours:
    claim: EndpointClaim
    largest: int = 0


class Played(MemoryTransport):
    """A network on which whoever is written down is there."""

    node = "/session"

    def __init__(self) -> None:
        super().__init__()
        self.present: list[Endpoint] = []
        self.rival_services: list[str] = []
        self.looks = 0

    def graph(self, asked: object = None) -> NetworkGraph:
        self.looks += 1
        return NetworkGraph(self.present)


class Watched:
    def __init__(self, *ends: Ours, buffer: int = BUFFER) -> None:
        self.network = Played()
        self.ends = list(ends)
        self.seconds = 0.0
        self.said: list[str] = []
        self.now = 100.0
        self.watch = Watch(self.network, self.find_ends, self.said.append, lambda: self.now, buffer)

    def find_ends(self) -> list[Ours]:
        """The session's ends, which takes some seconds."""
        self.now += self.seconds
        return self.ends

    def look(self, *present: Endpoint) -> list[str]:
        """What is said of those who are there, and were not before."""
        self.network.present = list(present)
        self.said.clear()
        self.now += PERIOD
        self.watch.look()
        self.watch.finish()
        return self.said


def ours(direction: str, topic: str, message_type: str, qos: QoS = DEFAULT, largest: int = 0) -> Ours:
    return Ours(EndpointClaim(f"/World/{direction}", "graph", topic, message_type, direction, qos), largest)


def peer(
    direction: Direction, topic: str, message_type: str, qos: QoS = DEFAULT, node: str = "rviz", gid: bytes = CYCLONE
) -> Endpoint:
    return Endpoint(gid + bytes([len(node)]), direction, topic, message_type, qos, "", node, "/" if node else "")


def test_a_qos_mismatch_is_reported_with_both_profiles_and_a_remedy() -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY, BEST_EFFORT))
    (said,) = watched.look(peer("subscribe", "/odom", ODOMETRY))
    assert said == (
        "/odom: /rviz asks for reliable, /World/publish offers bestEffort: no messages arrive\n"
        '  write "reliability": "reliable" in the qosProfile of /World/publish, or change the profile of /rviz'
    )


def test_a_peer_that_offers_too_little_is_reported() -> None:
    watched = Watched(ours("subscribe", "/cmd_vel", TWIST))
    (said,) = watched.look(peer("publish", "/cmd_vel", TWIST, BEST_EFFORT))
    assert said == (
        "/cmd_vel: /World/subscribe asks for reliable, /rviz offers bestEffort: no messages arrive\n"
        '  write "reliability": "bestEffort" in the qosProfile of /World/subscribe, or change the profile of /rviz'
    )


def test_another_message_type_is_reported() -> None:
    watched = Watched(ours("subscribe", "/cmd_vel", TWIST), ours("publish", "/odom", ODOMETRY))
    said = watched.look(peer("publish", "/cmd_vel", STAMPED), peer("subscribe", "/odom", TWIST))
    assert [line.partition("\n")[0] for line in said] == [
        f"/cmd_vel: /rviz publishes {STAMPED}, /World/subscribe reads {TWIST}: no messages arrive",
        f"/odom: /World/publish publishes {ODOMETRY}, /rviz reads {TWIST}: no messages arrive",
    ]


def test_matching_peers_and_other_topics_are_not_reported() -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY), ours("subscribe", "/cmd_vel", TWIST))
    present = (
        peer("subscribe", "/odom", ODOMETRY, BEST_EFFORT),
        peer("publish", "/odom", ODOMETRY, BEST_EFFORT),
        peer("publish", "/cmd_vel", TWIST),
        peer("subscribe", "/cmd_vel", STAMPED),
        peer("subscribe", "/scan", TWIST, QoS(durability="transientLocal")),
    )
    assert watched.look(*present) == []


def test_an_alternative_type_is_not_reported() -> None:
    subscription = ours("subscribe", "/cmd_vel", TWIST)
    subscription.claim = replace(subscription.claim, alternatives=(STAMPED,))
    watched = Watched(subscription)
    stamped = peer("publish", "/cmd_vel", STAMPED)
    assert watched.look(stamped) == []
    assert len(watched.look(stamped, peer("publish", "/cmd_vel", TWIST, node="teleop"))) == 1


def test_a_mismatch_is_reported_once_even_if_the_peer_returns() -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY, BEST_EFFORT))
    reader = peer("subscribe", "/odom", ODOMETRY)
    looks = (reader,), (reader,), (), (replace(reader, gid=FAST_DDS),)
    assert [len(watched.look(*present)) for present in looks] == [1, 0, 0, 0]
    assert len(watched.look(reader, peer("subscribe", "/odom", ODOMETRY, node="nav"))) == 1


def test_a_mismatch_within_the_session_is_reported_with_prim_paths() -> None:
    publisher, subscription = ours("publish", "/speed", TWIST, BEST_EFFORT), ours("subscribe", "/speed", TWIST)
    watched = Watched(publisher, subscription)
    own = [peer("publish", "/speed", TWIST, BEST_EFFORT, "session"), peer("subscribe", "/speed", TWIST, node="session")]
    (said,) = watched.look(*own)
    why = "/World/subscribe asks for reliable, /World/publish offers bestEffort"
    assert said.startswith(f"/speed: {why}: no messages arrive\n")


def test_a_peer_without_a_node_name_is_reported_after_some_time() -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY, BEST_EFFORT))
    nameless = peer("subscribe", "/odom", ODOMETRY, node="")
    assert watched.look(nameless) == []
    watched.now += PATIENCE
    (said,) = watched.look(nameless)
    assert said.startswith("/odom: a program that is not a ROS node asks for reliable")


def test_another_publisher_of_the_clock_is_reported() -> None:
    watched = Watched(ours("publish", "/clock", CLOCK))
    own = peer("publish", "/clock", CLOCK, node="session")
    assert watched.look(own) == []
    (said,) = watched.look(own, peer("publish", "/clock", CLOCK, node="gazebo"))
    assert said.startswith("/clock: /gazebo also publishes this topic")
    assert "ROS_DOMAIN_ID" in said


def test_another_clock_publisher_with_the_same_node_name_is_reported() -> None:
    watched = Watched(ours("publish", "/clock", CLOCK))
    own = peer("publish", "/clock", CLOCK, node="session")
    (said,) = watched.look(own, replace(own, gid=bytes(16)))
    assert said.startswith("/clock: another process named /session also publishes this topic")


def test_services_that_another_program_offers_too_are_reported_once() -> None:
    watched = Watched()
    assert watched.look() == []
    watched.network.rival_services = ["/spawn_entity", *(f"/service_{i}" for i in range(30))]
    (said,) = watched.look()
    what, remedy = said.splitlines()
    assert what == "another program also offers services of this run: either program may answer a call"
    assert "/spawn_entity" in remedy
    assert "ROS_DOMAIN_ID" in remedy
    watched.network.rival_services.append("/another")
    assert watched.look() == []


@pytest.mark.parametrize(
    ("size", "buffer", "reader", "told"),
    [
        (922_000, BUFFER, FAST_DDS, 1),
        (200_000, BUFFER, FAST_DDS, 1),
        (160_000, BUFFER, FAST_DDS, 0),
        (922_000, BUFFER, CYCLONE, 0),
        (922_000, 4_194_304, FAST_DDS, 0),
        (922_000, 0, FAST_DDS, 0),  # a system that does not tell
    ],
)
def test_large_messages_to_fast_dds_are_reported_with_a_remedy(
    size: int, buffer: int, reader: bytes, told: int
) -> None:
    watched = Watched(ours("publish", "/rgb", ODOMETRY, largest=size), buffer=buffer)
    own = peer("publish", "/rgb", ODOMETRY, node="session")
    said = watched.look(own, peer("subscribe", "/rgb", ODOMETRY, gid=reader))
    assert [line.partition(" ")[0] for line in said] == ["/rgb:"] * told
    assert all("sudo sysctl -w net.core.rmem_default=4194304" in line for line in said)
    watched.ends[0].largest += 1
    assert watched.look(own, peer("subscribe", "/rgb", ODOMETRY, gid=reader)) == []


def test_large_messages_between_fast_dds_endpoints_are_not_reported() -> None:
    watched = Watched(ours("publish", "/rgb", ODOMETRY, largest=922_000))
    own = peer("publish", "/rgb", ODOMETRY, node="session", gid=FAST_DDS)
    assert watched.look(own, peer("subscribe", "/rgb", ODOMETRY, gid=FAST_DDS)) == []


def test_searches_are_rare_unless_topics_change() -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY))
    for looks in (1, 2):
        for _ in range(100):
            watched.watch.look()
            watched.watch.finish()
        assert watched.network.looks == looks
        watched.watch.hurry()


@pytest.mark.parametrize("seconds", [0.0, 0.01, 1.0])
def test_slow_searches_are_rarer_within_limits(seconds: float) -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY))
    watched.seconds = seconds
    begun = watched.now
    watched.watch.look()
    watched.watch.finish()
    watched.seconds = 0.0
    due = begun + min(max(PERIOD, seconds / SHARE), LONGEST_PERIOD)
    for watched.now, looks in ((due - 0.01, 1), (due + 0.01, 2)):
        watched.watch.look()
        watched.watch.finish()
        assert watched.network.looks == looks


@dataclass
class Counted:
    """A peer that counts how often something is compared with it."""

    end: Endpoint
    read: list[str]

    def __getattr__(self, name: str) -> object:
        if name == "qos":
            self.read.append(name)
        return getattr(self.end, name)


@pytest.mark.parametrize("offered", [DEFAULT, BEST_EFFORT])
def test_equal_endpoints_of_a_topic_are_compared_once(offered: QoS) -> None:
    network, said, read = Played(), list[str](), list[str]()
    ends = (peer("subscribe", "/odom", ODOMETRY, node=f"rviz_{number:02}") for number in range(100))
    network.present = [cast("Endpoint", Counted(end, read)) for end in ends]
    session = LiveNetwork(lambda domain: network, 0, said.append)
    for number in range(100):
        claim = EndpointClaim(f"/World/robot_{number}", "graph", "/odom", ODOMETRY, "publish", offered)
        session.publisher(claim)
    session.freeze()
    session.close()
    assert network.looks == 1
    assert 0 < len(read) <= 4 * 100
    assert bool(said) == (offered == BEST_EFFORT)


def test_the_number_of_reports_for_a_topic_is_limited() -> None:
    watched = Watched(*(ours("publish", "/odom", ODOMETRY, qos) for qos in (BEST_EFFORT, DEFAULT)))
    readers = [peer("subscribe", "/odom", ODOMETRY, node=f"rviz_{number:02}") for number in range(2 * MOST)]
    said = watched.look(*readers)
    assert [line.split()[1] for line in said] == [*(f"/rviz_{number:02}" for number in range(MOST)), "more"]
    assert watched.look(*readers, peer("subscribe", "/odom", ODOMETRY, node="nav")) == []


def test_faults_are_reported_a_few_in_each_tick_in_the_order_of_the_ends() -> None:
    topics = [f"/robot_{number}/odom" for number in range(2 * REPORTED_A_TICK + 1)]
    watched = Watched(*(ours("publish", topic, ODOMETRY, BEST_EFFORT) for topic in topics))
    watched.network.present = [peer("subscribe", topic, ODOMETRY) for topic in reversed(topics)]
    watched.watch.look()
    ticks = list[list[str]]()
    while watched.network.looks < 1 or sum(map(len, ticks)) < len(topics):
        watched.said.clear()
        watched.watch.look()
        ticks += [[line.partition(":")[0] for line in watched.said]] if watched.said else []
    assert [len(tick) for tick in ticks] == [REPORTED_A_TICK, REPORTED_A_TICK, 1]
    assert [topic for tick in ticks for topic in tick] == topics
    watched.watch.close()


def test_only_the_end_of_the_session_waits_for_a_search() -> None:
    begun, go_on = threading.Event(), threading.Event()
    threads = list[threading.Thread]()

    class Slow(Played):
        def graph(self, asked: object = None) -> NetworkGraph:
            threads.append(threading.current_thread())
            begun.set()
            assert go_on.wait(20.0)
            return super().graph(asked)

    network, said = Slow(), list[str]()
    network.present = [peer("subscribe", "/odom", ODOMETRY)]
    session = LiveNetwork(lambda domain: network, 0, said.append)
    session.publisher(ours("publish", "/odom", ODOMETRY, BEST_EFFORT).claim)
    for _ in range(3):
        session.freeze()
        assert begun.wait(20.0)
    assert said == []
    go_on.set()
    session.close()
    assert [line.partition(":")[0] for line in said] == ["/odom"]
    assert threading.current_thread() not in threads
    assert not any(thread.is_alive() for thread in threads)


def test_a_transport_may_be_closed_before_the_session() -> None:
    transport = MemoryTransport()
    session = LiveNetwork(lambda domain: transport, 0, print)
    transport.close()
    session.look()
    session.close()


def test_an_exception_of_a_search_is_raised_in_the_thread_of_the_ticks() -> None:
    watched = Watched(ours("publish", "/odom", ODOMETRY))
    watched.network.graph = None  # type: ignore[assignment]
    watched.watch.look()
    with pytest.raises(TypeError):
        watched.watch.finish()


def test_the_receive_buffer_is_read_from_linux() -> None:
    if not RECEIVE_BUFFER.exists():
        pytest.skip("no Linux")
    assert int(RECEIVE_BUFFER.read_text()) > 2048


def test_new_topics_and_new_peers_are_checked() -> None:
    said: list[str] = []
    transport = MemoryTransport()
    network = LiveNetwork(lambda domain: transport, 0, said.append)
    network.publisher(ours("publish", "/speed", TWIST, BEST_EFFORT).claim)
    network.freeze()
    assert said == []
    subscription = network.subscription(ours("subscribe", "/speed", TWIST).claim)
    assert eventually(lambda: said, network.freeze)
    assert [line.partition(":")[0] for line in said] == ["/speed"]
    subscription.close()
    assert len(network.subscriptions) == 0
    network.close()


READS = ours("subscribe", "/dd100/cmd_vel", TWIST)
STRAY = f"/cmd_vel: /rviz publishes {TWIST}, but no node reads this topic; /World/subscribe reads /dd100/cmd_vel"  # one line


def after_patience(watched: Watched, *present: Endpoint) -> list[str]:
    """What is said at once and when the peers have been there for a while."""
    said = list(watched.look(*present))
    watched.now += PATIENCE
    return said + list(watched.look(*present))


def test_an_unread_topic_is_reported_once_with_a_similar_subscription() -> None:
    watched = Watched(READS)
    stray = peer("publish", "/cmd_vel", TWIST)
    assert watched.look(stray) == []
    watched.now += PATIENCE
    assert watched.look(stray) == [STRAY]
    watched.now += PATIENCE
    assert watched.look(stray, peer("publish", "/cmd_vel", TWIST, node="teleop")) == []


def test_a_topic_in_another_namespace_is_similar_and_one_subscriber_is_named() -> None:
    watched = Watched(*(ours("subscribe", f"/robot_{number}/cmd_vel", TWIST) for number in range(5)))
    (said,) = after_patience(watched, peer("publish", "/robot_9/cmd_vel", TWIST))
    assert said == (
        f"/robot_9/cmd_vel: /rviz publishes {TWIST}, but no node reads this topic; /World/subscribe reads /robot_0/cmd_vel, "
        "and 4 more topics of this name have subscribers"
    )


@pytest.mark.parametrize(
    "present",
    [
        [peer("publish", "/cmd_vel", TWIST), peer("subscribe", "/cmd_vel", TWIST, node="real_robot")],
        [peer("publish", "/cmd_vel", STAMPED)],
        [peer("publish", "/speed", TWIST)],
        [peer("publish", "/cmd_vel", TWIST, node="session")],
        [peer("publish", "/cmd_vel", TWIST, node="")],
        [peer("publish", "/cmd_vel", TWIST), peer("publish", "/dd100/cmd_vel", TWIST, node="teleop")],
    ],
    ids=["read elsewhere", "another type", "another name", "own", "no node", "the robot is driven"],
)
def test_read_topics_and_topics_of_other_systems_are_not_reported(present: list[Endpoint]) -> None:
    assert after_patience(Watched(READS), *present) == []


def test_a_late_subscriber_prevents_the_report() -> None:
    watched = Watched(READS)
    stray, reader = peer("publish", "/cmd_vel", TWIST), peer("subscribe", "/cmd_vel", TWIST, node="late")
    watched.look(stray)
    watched.now += PATIENCE
    assert watched.look(stray, reader) == []
    assert watched.look(stray) == []
