"""Names that peers say: none of them steers a terminal or forges a line, wherever it is shown."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.messages import messages, names
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.network_graph import MAX_NAME, Endpoint, NetworkGraph, NetworkNode
from graphengine.ros.tf_tree import FrameTree
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import Graphrun

STRING = "std_msgs/msg/String"
EVIL = "evil\n/forged\x1b[31m\x9b2J\u202e\r"
CLEAN = "evil" + "\ufffd/forged\ufffd[31m\ufffd2J\ufffd\ufffd"


@pytest.fixture
def evil(domain_id: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[DdsTransport]:
    """A peer with this node name, whose message type has another definition."""
    with monkeypatch.context() as patch:
        patch.setattr(names, "check_node_name", lambda *_: None)
        transport = DdsTransport(JoinOptions(Domain(domain_id, "OFF"), EVIL))
        patch.setattr(type(DEFINITIONS), "type_hash", lambda self, name: "RIHS01_" + 64 * "0")
        transport.writer("/chatter", STRING, QoS(durability="transientLocal")).write(
            messages.encode(messages.String("a\x1b[31m"))
        )
    yield transport
    transport.close()


def test_every_name_of_an_endpoint_is_printable_and_short() -> None:
    end = Endpoint(b"", "publish", f"/{EVIL}", EVIL, QoS(), EVIL, EVIL, f"/{EVIL}")
    shown = (end.topic, end.message_type, end.type_hash, end.node, end.namespace, end.full_node)
    assert shown == (f"/{CLEAN}", CLEAN, CLEAN, CLEAN, f"/{CLEAN}", f"/{CLEAN}/{CLEAN}")
    assert NetworkGraph([], services=[(EVIL, EVIL)]).services == [(CLEAN, CLEAN)]
    node = NetworkNode(EVIL, [(EVIL, EVIL)])
    assert (node.name, node.servers) == (CLEAN, ((CLEAN, CLEAN),))
    assert len(Endpoint(b"", "publish", "/a" * MAX_NAME, STRING, QoS()).topic) == MAX_NAME


def test_frames_are_printable() -> None:
    tree = FrameTree()
    transform = messages.TransformStamped(
        messages.Header(messages.Time(0, 0), EVIL),
        "base",
        messages.Transform(messages.Vector3(0.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0)),
    )
    tree.add(messages.TFMessage([transform]), True, b"")
    assert [edge.parent for edge in tree.edges] == [CLEAN]


@pytest.mark.parametrize(
    ("verb", "code"),
    [(("list", "-v"), 0), (("info", "-v", "/chatter"), 0), (("echo", "--timeout", "0.5", "/chatter"), 1)],
)
def test_the_verbs_show_a_peer_on_one_line(
    graphrun: Graphrun, evil: DdsTransport, verb: tuple[str, ...], code: int
) -> None:
    result = graphrun("topic", *verb, "--transport", "dds")
    assert result.code == code
    said = result.out + result.err
    assert all(character.isprintable() or character == "\n" for character in said.replace("\\e", ""))
    assert "\n/forged" not in said
    assert (CLEAN.partition("/")[2] in said) == (verb[0] != "list")


HEARS = """graph: hears
nodes:
  Tick: OnPlaybackTick
  Hear: {type: ROS2Subscriber, inputs: {topicName: /chatter, messagePackage: std_msgs, messageName: Int32}}
connections: [Tick.tick -> Hear.execIn]
"""


@pytest.mark.usefixtures("evil")
def test_a_run_names_a_peer_on_one_line(graphrun: Graphrun, project: Path) -> None:
    (project / "hears.yaml").write_text(HEARS, encoding="utf-8")
    result = graphrun("run", "hears.yaml", "--transport", "dds", "--for", "2s", code=0)
    assert all(character.isprintable() or character == "\n" for character in result.err)
    (line,) = (line for line in result.err.splitlines() if "forged" in line)
    assert CLEAN in line
