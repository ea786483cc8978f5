"""`graphrun topic`: what a live network says, in the form of ros2cli.

Where it can be, the peer lives in this process, in a domain that nobody else is in.
"""

from __future__ import annotations

import contextlib
import io
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import Graphrun, command, environment, live
from tests.waiting import PATIENCE, eventually

STRING, TWIST, SCAN = "std_msgs/msg/String", "geometry_msgs/msg/Twist", "sensor_msgs/msg/LaserScan"
SENSOR = QoS(depth=5, reliability="bestEffort")


@pytest.fixture
def peer(domain_id: int) -> Iterator[DdsTransport]:
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "OFF"), "peer", "/robots"))) as transport:
        yield transport


@contextlib.contextmanager
def repeating(action: Callable[[], object]) -> Iterator[None]:
    """Do something 50 times a second meanwhile."""
    stop = threading.Event()

    def repeat() -> None:
        while not stop.wait(0.02):
            action()

    thread = threading.Thread(target=repeat)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@pytest.fixture
def topic(graphrun: Graphrun) -> Graphrun:
    """`graphrun topic` in this process."""
    return lambda verb, *arguments, **ended: graphrun("topic", verb, *arguments, "--transport", "dds", **ended)


def latch(peer: DdsTransport, name: str, message: Any) -> None:
    """A message that whoever comes gets."""
    peer.writer(name, messages.message_type(message), LATCHED).write(messages.encode(message))


class Inbox:
    """What a peer was told."""

    def __init__(self, peer: DdsTransport, name: str, message_type: str) -> None:
        self.messages: list[Any] = []
        peer.reader(name, message_type, QoS(), lambda data: self.messages.append(messages.decode(data, message_type)))

    def wait(self, number: int) -> list[Any]:
        """So many messages."""
        eventually(lambda: len(self.messages) >= number)
        return self.messages


# list


@pytest.fixture
def crowd(peer: DdsTransport) -> DdsTransport:
    peer.writer("/scan", SCAN, SENSOR)
    peer.writer("/scan", SCAN, SENSOR)
    peer.reader("/cmd_vel", TWIST, QoS(), lambda data: None)
    peer.writer("/robot/_private", STRING, QoS())
    return peer


def test_list_names_every_topic_in_order(topic: Graphrun, crowd: DdsTransport) -> None:
    result = topic("list", code=0, err="")
    assert result.lines == ["/cmd_vel", "/parameter_events", "/rosout", "/scan"]


def test_commands_written_for_ros2_may_ask_for_no_daemon(topic: Graphrun, crowd: DdsTransport) -> None:
    assert topic("list", "--no-daemon") == topic("list")


def test_list_shows_types_and_hidden_topics_when_asked(topic: Graphrun, crowd: DdsTransport) -> None:
    assert f"/cmd_vel [{TWIST}]" in topic("list", "-t").lines
    assert f"/robot/_private [{STRING}]" in topic("list", "-t", "--include-hidden-topics").lines
    assert topic("list", "-c").lines == ["4"]


def test_list_counts_publishers_and_subscribers(topic: Graphrun, crowd: DdsTransport) -> None:
    assert topic("list", "-v").out == (
        "Published topics:\n"
        " * /parameter_events [rcl_interfaces/msg/ParameterEvent] 1 publisher\n"
        " * /rosout [rcl_interfaces/msg/Log] 1 publisher\n"
        f" * /scan [{SCAN}] 2 publishers\n"
        "\n"
        "Subscribed topics:\n"
        f" * /cmd_vel [{TWIST}] 1 subscriber\n"
        "\n"
    )


def test_an_empty_list_names_the_searched_domain(topic: Graphrun, domain_id: int) -> None:
    result = topic("list", code=0, out="")
    assert result.err.startswith("no topics on domain ")


# info


def test_info_prints_the_type_and_the_counts(topic: Graphrun, crowd: DdsTransport) -> None:
    assert topic("info", "/scan").out == f"Type: {SCAN}\nPublisher count: 2\nSubscription count: 0\n"


def test_verbose_info_describes_every_endpoint(topic: Graphrun, peer: DdsTransport) -> None:
    peer.reader("/chatter", STRING, replace(SENSOR, depth=2000, deadline=0.5), lambda data: None)
    result = topic("info", "-v", "chatter")
    assert re.sub(r"(GID: )[0-9a-f.]+", r"\1…", result.out) == (
        f"Type: {STRING}\n\nPublisher count: 0\n\nSubscription count: 1\n\n"
        f"Node name: peer\nNode namespace: /robots\nTopic type: {STRING}\n"
        f"Topic type hash: {DEFINITIONS.type_hash(STRING)}\n"
        "Endpoint type: SUBSCRIPTION\nGID: …\nQoS profile:\n  Reliability: BEST_EFFORT\n"
        "  History (Depth): KEEP_LAST (2000)\n  Durability: VOLATILE\n  Lifespan: Infinite\n"
        "  Deadline: 500000000 nanoseconds\n  Liveliness: AUTOMATIC\n  Liveliness lease duration: Infinite\n\n"
    )
    assert re.search(r"^GID: ([0-9a-f]{2}\.){15}[0-9a-f]{2}$", result.out, re.MULTILINE)


@pytest.mark.parametrize(
    ("name", "hint"), [("/scna", "did you mean '/scan'?"), ("/robot/scan", "did you mean '/scan'?")]
)
def test_an_unknown_topic_is_reported_with_the_nearest_names(
    topic: Graphrun, crowd: DdsTransport, name: str, hint: str
) -> None:
    result = topic("info", name, code=1, out="")
    assert result.err.startswith(f"error: unknown topic {name!r}\n{hint}\nsearched domain ")


# echo


def test_echo_prints_yaml_and_a_line_of_dashes(topic: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/chatter", messages.String("hello"))
    result = topic("echo", "--once", "/chatter")
    assert (result.code, result.out, result.err) == (0, "data: hello\n---\n", "")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["-l", "2"], "ranges:\n- 0.0\n- 0.5\n- '...'\n"),
        (["--full-length"], "ranges:\n" + "".join(f"- {i / 2}\n" for i in range(200))),
        (["--no-arr"], "ranges: '<sequence type: float, length: 200>'\n"),
        (["--flow-style", "-l", "1"], "ranges: [0.0, '...']\n"),
        (["--no-str"], "frame_id: '<string length: <5>>'\n"),
    ],
)
def test_echo_leaves_out_the_fields_that_its_options_exclude(
    topic: Graphrun, peer: DdsTransport, options: list[str], expected: str
) -> None:
    scan = DEFINITIONS.initial(SCAN)
    scan.header.frame_id, scan.ranges = "laser", np.arange(200, dtype=np.float32) / 2
    latch(peer, "/scan", scan)
    assert expected in topic("echo", "--once", "/scan", *options).out


def test_echo_can_show_one_field_and_csv(topic: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/cmd_vel", messages.Twist(messages.Vector3(0.5, 0.0, 0.0), messages.Vector3(0.0, 0.0, 1.0)))
    assert topic("echo", "--once", "/cmd_vel", "--field", "linear").out == "x: 0.5\ny: 0.0\nz: 0.0\n---\n"
    assert topic("echo", "--once", "/cmd_vel", "--field", "linear.x").out == "0.5\n---\n"
    assert topic("echo", "--once", "/cmd_vel", "--csv").out == "0.5,0.0,0.0,0.0,0.0,1.0\n"
    assert topic("echo", "--once", "/cmd_vel", "--raw").out.startswith("b'\\x00\\x01\\x00\\x00")


def test_echo_shows_only_messages_that_pass_the_filter(topic: Graphrun, peer: DdsTransport) -> None:
    writer = peer.writer("/count", "std_msgs/msg/Int32", replace(LATCHED, depth=20))
    for number in range(10):
        writer.write(messages.encode(messages.message_class("std_msgs/msg/Int32")(number)))
    options = ["--qos-depth", "20", "--qos-durability", "transient_local", "--qos-reliability", "reliable"]
    assert topic("echo", "--once", "/count", "--filter", "m.data == 7", *options).out == "data: 7\n---\n"


def test_echo_requests_a_qos_that_all_publishers_offer(topic: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/chatter", messages.String("latched"))
    volatile = peer.writer("/chatter", STRING, SENSOR)
    with repeating(lambda: volatile.write(messages.encode(messages.String("passing")))):
        result = topic("echo", "--once", "/chatter")
    assert result.out == "data: passing\n---\n"
    assert result.err.splitlines() == [
        f"WARNING: only some publishers offer {more}; subscribing with {less}, which matches all"
        for more, less in (("RELIABLE", "BEST_EFFORT"), ("TRANSIENT_LOCAL", "VOLATILE"))
    ]


def test_echo_with_a_type_needs_no_publisher(topic: Graphrun, peer: DdsTransport) -> None:
    result = topic("echo", "--once", "/later", STRING, "--timeout", "0.05")
    assert (result.code, result.out, result.err) == (1, "", "no message to print arrived on /later within 0.05 s\n")


def make_scan() -> Any:
    """A scan of 1000 beams."""
    ranges = np.linspace(1.0, 10.0, 1000, dtype=np.float32)
    header = messages.header(12.5, "lidar")
    return messages.LaserScan(header, -1.0, 1.0, 0.002, 0.0, 0.1, 0.1, 25.0, ranges, ranges[:0])


def test_echo_of_a_scan_is_a_summary_when_asked_and_yaml_for_scripts(topic: Graphrun, peer: DdsTransport) -> None:
    latch(peer, "/scan", make_scan())
    assert topic("echo", "--once", "--summary", "/scan", code=0, err="").lines == [
        "LaserScan of frame 'lidar' at 12.500 s",
        "  1000 beams from -57.3 to 57.3 deg, 10 Hz, can measure 0.1 to 25 m",
        "  ranges 1 to 10 m, 0 without return",
        *topic("echo", "--once", "--summary", "/scan").lines[3:4],
        "---",
    ]
    document = yaml.safe_load(topic("echo", "--once", "/scan").out.removesuffix("---\n"))
    assert (len(document["ranges"]), document["range_max"]) == (129, 25.0)
    assert len(yaml.safe_load(topic("echo", "--once", "-f", "/scan").out.removesuffix("---\n"))["ranges"]) == 1000


@pytest.mark.parametrize("columns", [80, 40])
def test_on_a_terminal_echo_of_a_scan_is_a_summary_that_fits(domain_id: int, columns: int) -> None:
    run = ("topic", "echo", "--once", "/scan", "--transport", "dds", "--spin-time", str(PATIENCE))
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as peer:
        latch(peer, "/scan", make_scan())
        with live(*run, columns=columns, out=True, env=env) as echo:
            echo.hear(lambda said: False)
            *_, line, end = echo.said.splitlines()
        assert (line[:13], line[-9:], len(line), end) == ("  -57.3 deg ▁", " 57.3 deg", columns, "---")
        with live(*run, "-l", "3", columns=columns, out=True, env=env) as echo:
            echo.hear(lambda said: False)
            assert "ranges:" in echo.said


def test_echo_drops_messages_of_peers_with_another_definition_and_warns(
    topic: Graphrun, peer: DdsTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = "RIHS01_" + 64 * "0"
    with monkeypatch.context() as patch:
        patch.setattr(type(DEFINITIONS), "type_hash", lambda self, name: other)
        latch(peer, "/chatter", messages.String("hello"))
    result = topic("echo", "--once", "--timeout", "1", "/chatter", code=1, out="")
    assert result.err.splitlines() == [
        f"WARNING: /robots/peer has another definition of {STRING} ({other}): its messages are dropped",
        "no message to print arrived on /chatter within 1 s",
        "WARNING: /chatter: dropped messages that do not fit the topic's type: 1",
    ]


# pub


def test_pub_publishes_once_when_somebody_reads(topic: Graphrun, peer: DdsTransport) -> None:
    inbox = Inbox(peer, "/cmd_vel", TWIST)
    result = topic("pub", "--once", "/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 1.0}, angular: {z: -1}}")
    assert (result.code, result.err) == (0, "")
    assert result.out == (
        "publisher: beginning loop\n"
        "publishing #1: geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=1.0, y=0.0, z=0.0), "
        "angular=geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=-1.0))\n\n"
    )
    (twist,) = inbox.wait(1)
    assert (twist.linear.x, twist.angular.z) == (1.0, -1.0)


def test_pub_publishes_n_messages_and_prints_each_nth(topic: Graphrun, peer: DdsTransport) -> None:
    inbox = Inbox(peer, "/chatter", STRING)
    result = topic("pub", "-t", "5", "-r", "200", "-p", "2", "/chatter", STRING, "data: hi")
    assert re.findall(r"^publishing #(\d+): ", result.out, re.MULTILINE) == ["2", "4"]
    assert [message.data for message in inbox.wait(5)] == ["hi"] * 5


def test_pub_that_is_late_does_not_send_a_burst(topic: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    now, sent = 0.0, [0.0]

    def sleep(seconds: float) -> None:
        nonlocal now
        now += seconds + (5.0 if len(sent) == 3 else 0.0)  # once, the process is held up for five seconds
        sent.append(now)

    monkeypatch.setattr("graphengine.cli.topic.time", SimpleNamespace(monotonic=lambda: now, sleep=sleep))
    topic("pub", "-t", "12", "-r", "10", "-w", "0", "--keep-alive", "0", "/chatter", STRING, code=0)
    gaps = [round(after - before, 6) for before, after in pairwise(sent[:12])]
    assert gaps == [0.1, 0.1, 5.1, 0.0, *[0.1] * 7]


def test_pub_stamps_each_message_when_it_is_sent(topic: Graphrun, peer: DdsTransport) -> None:
    inbox = Inbox(peer, "/cmd_vel", "geometry_msgs/msg/TwistStamped")
    before = time.time_ns()
    topic("pub", "-t", "2", "-r", "200", "/cmd_vel", "geometry_msgs/msg/TwistStamped", "header: auto")
    first, second = (m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in inbox.wait(2))
    assert before <= first < second <= time.time_ns()


def test_pub_stamps_with_the_time_of_a_simulation_when_asked(topic: Graphrun, peer: DdsTransport) -> None:
    inbox = Inbox(peer, "/cmd_vel", "geometry_msgs/msg/TwistStamped")
    clock = peer.writer("/clock", "rosgraph_msgs/msg/Clock", QoS())
    arguments = ("/cmd_vel", "geometry_msgs/msg/TwistStamped", "header: auto", "--spin-time", "20")
    with repeating(lambda: clock.write(messages.encode(messages.Clock(messages.Time(7, 5))))):
        topic("pub", "--once", "-s", *arguments)
    (message,) = inbox.wait(1)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (7, 5)


def test_pub_reads_values_from_the_standard_input(
    topic: Graphrun, peer: DdsTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    inbox = Inbox(peer, "/chatter", STRING)
    monkeypatch.setattr(sys, "stdin", io.StringIO("data: >\n  two\n  lines\n"))
    assert topic("pub", "--once", "--stdin", "/chatter", STRING).code == 0
    assert inbox.wait(1)[0].data == "two lines\n"


def test_echo_prints_the_reason_if_no_message_arrives(topic: Graphrun, peer: DdsTransport) -> None:
    peer.writer("/chatter", STRING, QoS())
    result = topic("echo", "/chatter", "--qos-durability", "transient_local", "--timeout", "0.1")
    assert result.err.splitlines()[0] == (
        "WARNING: this subscription asks for transientLocal, /robots/peer offers volatile: no messages arrive from it"
    )


@pytest.mark.parametrize(
    ("name", "message_type", "options", "reason"),
    [
        ("/cmd_vel", "geometry_msgs/msg/TwistStamped", [], "/robots/peer subscribes to geometry_msgs/msg/Twist"),
        (
            "/cmd_vel",
            TWIST,
            ["--qos-reliability", "best_effort"],
            "/robots/peer asks for reliable, this publisher offers bestEffort",
        ),
        ("/cmd_vle", TWIST, [], "did you mean '/cmd_vel'?"),
    ],
)
def test_pub_says_why_no_subscriber_matches(
    topic: Graphrun, peer: DdsTransport, name: str, message_type: str, options: list[str], reason: str
) -> None:
    peer.reader("/cmd_vel", TWIST, QoS(), lambda data: None)
    result = topic("pub", "--once", name, message_type, "--max-wait-time-secs", "0.1", *options, code=1)
    assert result.out.startswith(f"Waiting for at least 1 matching subscription(s)...\n  {reason}")
    assert result.err.startswith("error: Timed out waiting for subscribers: Expected 1 subscribers but only got 0 ")
    assert reason in result.err


def test_pub_that_waits_for_a_reader_says_how_to_leave(domain_id: int) -> None:
    env = {"ROS_DOMAIN_ID": str(domain_id)}
    with live("topic", "pub", "--once", "/cmd_vel", TWIST, "--transport", "dds", env=env) as pub:
        assert pub.hear(lambda said: "-w 0" in said)
        assert "--max-wait-time-secs SECONDS" in pub.said
        assert pub.stop(signal.SIGINT) == 0
        assert pub.said.count("-w 0") == 1


def test_pub_with_a_time_limit_prints_no_hint_to_leave(topic: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.cli.topic.PATIENCE", 0.01)
    result = topic("pub", "--once", "/cmd_vel", TWIST, "--max-wait-time-secs", "1", code=1)
    assert "-w 0" not in result.err


def test_message_types_of_the_user_are_read_from_msg_path(topic: Graphrun, peer: DdsTransport, tmp_path: Path) -> None:
    (tmp_path / "my_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "my_msgs" / "msg" / "Speed.msg").write_text("float32 v 0.5\n", encoding="utf-8")
    result = topic("pub", "--once", "-w", "0", "/speed", "my_msgs/Speed", "--msg-path", str(tmp_path))
    assert "publishing #1: my_msgs.msg.Speed(v=0.5)\n" in result.out


# Mistakes


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (["echo", "/a b"], 1, "topic name '/a b' has ' ' at character 3\nlegal: letters"),
        (["echo", "/nope"], 1, "unknown topic '/nope'"),
        (["echo", "/chatter", "std_msgs/msg/Strin"], 1, "no message type 'std_msgs/msg/Strin'"),
        (["echo", "/chatter", "--field", "dta"], 1, "no field 'dta' in 'dta'\ndid you mean 'data'?"),
        (["echo", "/chatter", "--filter", "m +"], 2, "--filter 'm +' is not an expression"),
        (
            ["echo", "/chatter", "--filter", "m.x"],
            2,
            "'m.x': the attribute 'x' of a std_msgs__msg__String is not allowed in an expression\nlegal: data",
        ),
        (["echo", "/chatter", "--filter", "m.data + 1"], 2, "--filter 'm.data + 1': TypeError"),
        (
            ["hz", "/chatter", "--filter", "__import__('os')"],
            2,
            "the name '__import__' is not allowed in an expression",
        ),
        (["echo", "/chatter", "--filter", "msg.data"], 2, "there is no name 'msg'\nlegal: m, "),
        (["echo", "/chatter", "--truncate-length", "-1"], 2, "write a whole number, 0 or more"),
        (["echo", "/chatter", "--spin-time", "nan"], 2, "write seconds, such as 0.5"),
        (["delay", "/chatter"], 1, "std_msgs/msg/String has no header"),
        (["hz", "/chatter", "-w", "0"], 2, "write a whole number, 1 or more"),
        (
            ["pub", "/chatter", STRING, "{date: 1}"],
            1,
            "message:1:2: error G106: std_msgs/msg/String has no field 'date'",
        ),
        (["pub", "/chatter", "std_msgs/Strin"], 1, "no message type 'std_msgs/msg/Strin'"),
        (["pub", "/chatter", STRING, "-r", "0"], 2, "write a number above 0"),
        (["pub", "/chatter", STRING, "-n", "a b"], 1, "node name 'a b' has ' ' at character 2"),
        (["pub", "/chatter", STRING, "--max-wait-time-secs", "1"], 2, "needs --wait-matching-subscriptions"),
        (["pub", "/chatter", STRING, "--msg-path", "/nowhere"], 2, "--msg-path /nowhere: no such file or folder"),
        (["list", "--transport", "zenoh"], 2, "invalid choice: 'zenoh'"),
    ],
)
def test_mistakes_are_reported_without_a_traceback(
    graphrun: Graphrun, peer: DdsTransport, arguments: list[str], code: int, complaint: str
) -> None:
    latch(peer, "/chatter", messages.String("hello"))
    transport = [] if "--transport" in arguments else ["--transport", "dds"]
    result = graphrun("topic", *arguments, *transport)
    assert (result.code, result.out) == (code, "")
    assert complaint in result.err
    assert "Traceback" not in result.err


def test_without_ros_rclpy_is_refused_with_the_reason(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "rclpy"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if not (Path(path) / "rclpy").is_dir()])
    result = graphrun("topic", "list", "--transport", "rclpy", code=1, out="")
    assert result.err.startswith("error: rclpy cannot be used: no ROS 2 is sourced\n")


# Verbs that go on until they are ended


@pytest.fixture
def ticking(domain_id: int) -> Iterator[dict[str, str]]:
    """The environment of a peer that says 50 times a second what time it is."""
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as transport:
        writer = transport.writer("/pose", "geometry_msgs/msg/PoseStamped", QoS())

        def tick() -> None:
            pose = DEFINITIONS.initial("geometry_msgs/msg/PoseStamped")
            pose.header.stamp = messages.Time(*divmod(time.time_ns(), 10**9))
            writer.write(messages.encode(pose))

        with repeating(tick):
            yield {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


STATISTICS = r"\tmin: -?\d+\.\d{3}s max: -?\d+\.\d{3}s std dev: \d+\.\d{5}s window: \d+\n"


@pytest.mark.parametrize(
    ("arguments", "form", "number"),
    [
        (["hz", "/pose"], rf"(average rate: \d+\.\d{{3}}\n{STATISTICS})+", signal.SIGINT),
        (["delay", "/pose"], rf"(average delay: -?\d+\.\d{{3}}\n{STATISTICS})+", signal.SIGINT),
        (["echo", "/pose", "--field", "pose.position"], r"(x: 0\.0\ny: 0\.0\nz: 0\.0\n---\n)+", signal.SIGTERM),
        (["pub", "/x", STRING, "-r", "50"], r"publisher: beginning loop\n(publishing #\d+: .*\n\n){2,}", signal.SIGINT),
    ],
    ids=["hz", "delay", "echo", "pub"],
)
def test_a_signal_ends_a_running_verb_without_an_error_message(
    ticking: dict[str, str], arguments: list[str], form: str, number: signal.Signals
) -> None:
    with live("topic", *arguments, "--transport", "dds", "--spin-time", "20", env=ticking, out=True) as running:
        assert running.hear(lambda said: re.fullmatch(form, said) is not None), running.said
        assert running.stop(number) == 0
    assert re.fullmatch(form, running.said), running.said


def test_a_signal_ends_a_command_that_a_script_runs_in_the_background(domain_id: int) -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell without job control leaves it to the program
    try:
        with live(
            "topic", "hz", "/pos", "--transport", "dds", env={"ROS_DOMAIN_ID": str(domain_id)}, out=True
        ) as running:
            assert running.hear(lambda said: said.endswith("\n"))
            assert running.stop(signal.SIGINT) == 0
    finally:
        signal.signal(signal.SIGINT, before)


def test_hz_waits_for_a_topic_with_a_warning(ticking: dict[str, str]) -> None:
    with live("topic", "hz", "/pos", "--transport", "dds", env=ticking, out=True) as running:
        assert running.hear(lambda said: said.endswith("\n"))
        assert running.stop(signal.SIGINT) == 0
    assert running.said.startswith("WARNING: topic [/pos] does not appear to be published yet\n")


def test_hz_reports_missing_messages(domain_id: int) -> None:
    local = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as silent:
        silent.writer("/pose", "geometry_msgs/msg/PoseStamped", QoS())
        with live("topic", "hz", "/pose", "--transport", "dds", "--spin-time", "20", env=local) as running:
            assert running.hear(lambda said: said == "no message after 3 s; still waiting\n"), running.said
            assert running.stop(signal.SIGINT) == 0


def test_echo_ends_when_its_pipe_is_closed(ticking: dict[str, str]) -> None:
    running = subprocess.Popen(
        command("topic", "echo", "/pose", "--transport", "dds", "--spin-time", "20"),
        env=environment(ticking),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert running.stdout
    assert running.stderr
    assert running.stdout.readline() == b"header:\n"
    running.stdout.close()
    assert running.stderr.read() == b""
    assert running.wait(PATIENCE) == 0
    running.stderr.close()
