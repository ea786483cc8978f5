"""Wide strings: as the RMWs of ROS 2 write them, in and out, over DDS and over rclpy."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.messages.messages import MessageError, decode, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.rcl.rcl import RclTransport, discovery
from tests.ros import needs
from tests.ros.conftest import OpenDds
from tests.waiting import eventually

WIDE, MANY = "example_interfaces/msg/WString", "my_msgs/msg/Many"
TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="".join(map(chr, range(17)))))


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Definitions:
    folder = tmp_path_factory.mktemp("share")
    for path, text in (
        (WIDE, "wstring data\n"),
        (MANY, "uint8 before\nwstring[] many\nwstring[2] two\nuint32 number\nwstring last 'Grüße'\nfloat64 after\n"),
    ):
        file = folder / f"{path}.msg"
        file.parent.mkdir(parents=True)
        file.write_text(text, encoding="utf-8")
    return DEFINITIONS.extended([folder])


def wide(known: Definitions, text: str) -> bytes:
    message = known.initial(WIDE)
    message.data = text
    return encode(message, known)


def test_each_utf_16_code_unit_of_a_wstring_takes_four_bytes(known: Definitions) -> None:
    text = "Grüße 😀"
    units = struct.unpack(f"<{len(text) + 1}H", text.encode("utf-16-le"))  # the last character takes two
    data = wide(known, text)
    assert data == struct.pack(f"<BBHI{len(units)}I", 0, 1, 0, len(units), *units)
    assert decode(data, WIDE, known).data == text
    swapped = struct.pack(f">BBHI{len(units)}I", 0, 0, 0, len(units), *units)
    assert decode(swapped, WIDE, known).data == text


@given(many=st.lists(TEXTS, max_size=4), two=st.lists(TEXTS, min_size=2, max_size=2), last=TEXTS)
def test_a_written_wide_string_is_read_back(known: Definitions, many: list[str], two: list[str], last: str) -> None:
    message = known.initial(MANY)
    assert message.last == "Grüße"
    message.before, message.number, message.after = 255, 2**32 - 1, -1.5
    message.many, message.two, message.last = many, two, last
    assert decode(encode(message, known), MANY, known) == message


@pytest.mark.parametrize(
    ("count", "unit", "match"), [(3, 2, "3 units"), (2**32 - 1, 2, "units"), (2, 65536, "16 bits")]
)
def test_illegal_wide_strings_are_refused(known: Definitions, count: int, unit: int, match: str) -> None:
    with pytest.raises(MessageError, match=match):
        decode(struct.pack("<BBHI2I", 0, 1, 0, count, 1, unit), WIDE, known)


@pytest.mark.parametrize("field", ["wchar a", "wchar[] a"])
def test_single_wide_characters_are_not_supported(tmp_path: Path, field: str) -> None:
    (tmp_path / "my_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "my_msgs" / "msg" / "Odd.msg").write_text(f"{field}\n")
    with pytest.raises(MessageTypeError, match="which is not supported"):
        DEFINITIONS.extended([tmp_path]).definition("my_msgs/msg/Odd")


def test_wide_strings_arrive_at_another_node(known: Definitions, dds: OpenDds) -> None:
    alice, bob = (dds(name, definitions=known) for name in ("alice", "bob"))
    heard: list[str] = []
    bob.reader("/wide", WIDE, QoS(), lambda data: heard.append(decode(data, WIDE, known).data))
    writer = alice.writer("/wide", WIDE, QoS())
    assert eventually(lambda: writer.matched)
    assert eventually(lambda: heard, lambda: writer.write(wide(known, "Grüße")))
    assert set(heard) == {"Grüße"}


@pytest.mark.ros(needs.types("example_interfaces"))
@pytest.mark.parametrize("own", ["dds", "rclpy"])
def test_wide_strings_arrive_from_and_at_a_ros_node(known: Definitions, domain: Domain, own: str) -> None:
    import rclpy
    from example_interfaces.msg import WString
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node

    context = rclpy.Context()
    with discovery(domain):
        context.init(args=[], domain_id=domain.id)
    node, executor = Node("ros", context=context), SingleThreadedExecutor(context=context)
    executor.add_node(node)
    theirs: list[str] = []
    ours: list[str] = []
    talk = node.create_publisher(WString, "/theirs", 10)
    node.create_subscription(WString, "/ours", lambda message: theirs.append(message.data), 10)
    transport = (DdsTransport if own == "dds" else RclTransport)(JoinOptions(domain, "ours", definitions=known))
    transport.reader("/theirs", WIDE, QoS(), lambda data: ours.append(decode(data, WIDE, known).data))
    writer = transport.writer("/ours", WIDE, QoS())
    assert eventually(lambda: writer.matched)

    def crossed() -> bool:
        writer.write(wide(known, "Grüße"))
        talk.publish(WString(data="Grüße"))
        executor.spin_once(0.05)
        return bool(ours and theirs)

    assert eventually(crossed)
    hashes = {end.type_hash for end in transport.graph().publishers("/theirs")}
    transport.close()
    node.destroy_node()
    context.try_shutdown()
    assert set(ours) == set(theirs) == {"Grüße"}
    assert hashes == {known.type_hash(WIDE)}
