"""ROS2Publisher and ROS2Subscriber: any message through ports made from its fields."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.node import BadValueError, ContextError, Node
from graphengine.node.node_class import grown
from graphengine.nodes.ros2.fields import MAX_PORTS
from graphengine.nodes.ros2.generic import ROS2Publisher, ROS2Subscriber
from graphengine.scene.loaded_scene import Options
from graphengine.testing import RecordingContext
from tests.messages.test_messages import TYPES, random_message
from tests.nodes.harness import Player, checked, names, ready, twist, write

RANGE, TWIST, TF = "sensor_msgs/msg/Range", "geometry_msgs/msg/Twist", "tf2_msgs/msg/TFMessage"


def of(cls: type[Node], message_type: str, context: RecordingContext, /, **inputs: Any) -> Any:
    """A node of a message, set up; inputs of fields by their ports."""
    made: Any = grown(cls, names(message_type), DEFINITIONS)
    fields = {port.name: port.field for port in made.fields.values() if port.side == "inputs"}
    given = {fields[name]: value for name, value in {**names(message_type), **inputs}.items()}
    return ready(made, context, **given)


def ports(cls: type[Node], message_type: str) -> dict[str, str]:
    """Types of the ports that a message makes, by their names."""
    made = grown(cls, names(message_type), DEFINITIONS)
    own = {port.field for port in cls.fields.values()}
    return {port.name: str(port.type) for port in made.fields.values() if port.field not in own}


# Ports


# isaacsim.ros2.core/library/backend/Ros2DynamicMessage.cpp, parseMessageFields
@pytest.mark.parametrize("cls", [ROS2Publisher, ROS2Subscriber])
def test_the_port_of_a_field_is_named_by_the_path_of_the_field(cls: type[Node]) -> None:
    assert ports(cls, RANGE) == {
        "header:stamp:sec": "int",
        "header:stamp:nanosec": "uint",
        "header:frame_id": "token",
        "radiation_type": "uint",
        "field_of_view": "float",
        "min_range": "float",
        "max_range": "float",
        "range": "float",
        "variance": "float",
    }


@pytest.mark.parametrize(
    ("ros", "ours"),
    [
        ("Bool", "bool"),
        ("Byte", "uchar"),
        ("Char", "uchar"),
        ("Int8", "int"),
        ("UInt8", "uint"),
        ("Int16", "int"),
        ("UInt16", "uint"),
        ("Int32", "int"),
        ("UInt32", "uint"),
        ("Int64", "int64"),
        ("UInt64", "uint64"),
        ("Float32", "float"),
        ("Float64", "double"),
        ("String", "token"),
    ],
)
def test_the_port_of_every_kind_of_field_has_isaac_sims_type(ros: str, ours: str) -> None:
    assert ports(ROS2Subscriber, f"std_msgs/msg/{ros}") == {"data": ours}
    if ros not in ("Bool", "Char", "String"):  # which have no message of an array
        assert ports(ROS2Subscriber, f"std_msgs/msg/{ros}MultiArray")["data"] == f"{ours}[]"


def test_an_array_of_messages_is_an_array_of_tokens() -> None:
    assert ports(ROS2Publisher, TF) == {"transforms": "token[]"}


def test_a_port_has_the_ros_type_as_doc_and_the_bounds_of_the_type() -> None:
    made = grown(ROS2Publisher, names("nav_msgs/msg/Odometry"), DEFINITIONS)
    assert made.ports["inputs:pose:covariance"].doc == "float64[36]"
    made = grown(ROS2Publisher, names(RANGE), DEFINITIONS)
    assert made.ports["inputs:radiation_type"].constraint == "≥ 0 and ≤ 255"


def test_the_initial_values_of_a_publishers_ports_are_the_defaults_of_ros() -> None:
    made = grown(ROS2Publisher, names("geometry_msgs/msg/PoseWithCovariance"), DEFINITIONS)
    assert made.ports["inputs:pose:orientation:w"].default == 1.0
    assert made.ports["inputs:covariance"].default.tolist() == [0.0] * 36


def test_the_same_message_gives_the_same_class() -> None:
    one = grown(ROS2Publisher, names(TWIST), DEFINITIONS)
    assert grown(ROS2Publisher, names(TWIST), DEFINITIONS) is one
    assert grown(ROS2Publisher, names(RANGE), DEFINITIONS) is not one


@pytest.mark.parametrize("missing", ["messagePackage", "messageName"])
def test_without_package_or_name_of_the_message_creating_ports_is_an_error(missing: str) -> None:
    with pytest.raises(ContextError, match="the inputs name no message type") as caught:
        grown(ROS2Publisher, {**names(TWIST), missing: ""}, DEFINITIONS)
    assert caught.value.code == "G208"


def test_the_default_subfolder_is_msg() -> None:
    made = grown(ROS2Publisher, {"messagePackage": "std_msgs", "messageName": "String"}, DEFINITIONS)
    assert "inputs:data" in made.ports


def test_an_unknown_message_type_is_an_error() -> None:
    with pytest.raises(MessageTypeError, match="no message type 'sensor_msgs/msg/Rang'") as caught:
        grown(ROS2Publisher, names("sensor_msgs/msg/Rang"), DEFINITIONS)
    assert (caught.value.value, caught.value.help) == ("Rang", ("did you mean 'Range'?",))


def test_a_field_with_the_name_of_another_port_gets_a_prefix(tmp_path: Path) -> None:
    write(tmp_path, {"my_msgs/msg/Plan.msg": "string context\nstring goal\n"})
    definitions = DEFINITIONS.extended([tmp_path])
    made = grown(ROS2Publisher, names("my_msgs/msg/Plan"), definitions)
    assert str(made.ports["inputs:context"].type) == "uint64"
    assert str(made.ports["inputs:message:context"].type) == "token"
    assert "outputs:context" in grown(ROS2Subscriber, names("my_msgs/msg/Plan"), definitions).ports


def test_a_message_with_too_many_fields_is_an_error(tmp_path: Path) -> None:
    write(tmp_path, {"my_msgs/msg/Long.msg": "".join(f"int32 field{number}\n" for number in range(MAX_PORTS + 1))})
    with pytest.raises(MessageTypeError, match=f"more than {MAX_PORTS} fields"):
        grown(ROS2Publisher, names("my_msgs/msg/Long"), DEFINITIONS.extended([tmp_path]))


# From ports to bytes, and back


def echo(message_type: str, data: bytes) -> bytes:
    """What a publisher sends that is fed with all that a subscriber delivers."""
    context = RecordingContext()
    hearing = of(ROS2Subscriber, message_type, context, topicName="heard")
    saying = of(ROS2Publisher, message_type, context, topicName="said")
    context.transport.inject("/heard", data)
    context.tick()
    fired = list(hearing.compute())
    assert fired == [hearing.exec_out]
    for name in (name for name in type(saying).fields if name.startswith("message__")):
        setattr(saying, name, getattr(hearing, name))
    saying.compute()
    (sent,) = context.transport.raw("/said")
    return sent


@pytest.mark.parametrize("message_type", TYPES)
def test_every_message_type_passes_through_the_ports_unchanged(message_type: str) -> None:
    draw = np.random.default_rng(3)
    data = messages.encode(random_message(message_type, draw))
    assert echo(message_type, data) == data


@settings(max_examples=60)
@given(st.sampled_from(TYPES), st.integers(0, 2**32))
def test_any_content_passes_through_the_ports_unchanged(message_type: str, seed: int) -> None:
    data = messages.encode(random_message(message_type, np.random.default_rng(seed)))
    assert echo(message_type, data) == data


ODD = """string<=5 name
string<=3[<=2] words
string[2] pair
bool[3] flags
byte[] raw
char letter
int8[4] small
uint64 big
float32[<=3] few
geometry_msgs/Point32[2] ends
std_msgs/Empty nothing
std_msgs/Empty[] nothings
Part one
Part[<=2] more
int32 from 7
int32 LIMIT=7
"""


def test_any_content_of_a_message_with_every_kind_of_field_passes_through_the_ports_unchanged(tmp_path: Path) -> None:
    part = "string[] texts\nsensor_msgs/RegionOfInterest[1] regions\nfloat64 value\n"
    write(tmp_path, {"my_msgs/msg/Odd.msg": ODD, "my_msgs/msg/Part.msg": part})
    definitions, name = DEFINITIONS.extended([tmp_path]), "my_msgs/msg/Odd"
    hearing: Any = grown(ROS2Subscriber, names(name), definitions)()
    saying: Any = grown(ROS2Publisher, names(name), definitions)()
    for seed in range(40):
        data = messages.encode(random_message(name, np.random.default_rng(seed), definitions), definitions)
        hearing.message.write(hearing, messages.decode(data, name, definitions))
        for port in (port for port in type(saying).fields if port.startswith("message__")):
            setattr(saying, port, getattr(hearing, port))
        assert messages.encode(saying.message.read(saying), definitions) == data


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.0, 5e-324, 1.7976931348623157e308])
def test_nan_and_infinity_pass_through_the_ports_also_within_arrays_of_messages(value: float) -> None:
    vector = messages.Vector3(value, value, value)
    edge = messages.TransformStamped(
        messages.header(0.0, "é\n\"'"), "", messages.Transform(vector, messages.Quaternion(value, 0.0, 0.0, 1.0))
    )
    for message_type, message in ((TWIST, messages.Twist(vector, vector)), (TF, messages.TFMessage([edge, edge]))):
        data = messages.encode(message)
        assert echo(message_type, data) == data


def test_messages_of_big_endian_peers_are_output_with_the_types_of_the_ports(context: RecordingContext) -> None:
    node = of(ROS2Subscriber, "std_msgs/msg/Float64MultiArray", context)
    # No dimensions, an offset of 0, and two doubles.
    body = b"".join(number.to_bytes(4, "big") for number in (0, 0, 2, 0)) + np.array([1.0, 2.0], ">f8").tobytes()
    context.transport.inject("/topic", b"\0\0\0\0" + body)
    context.tick()
    list(node.compute())
    data = node.message__data
    assert (data.dtype, data.tolist()) == (np.dtype(np.float64), [1.0, 2.0])


# The publisher


def test_set_fields_are_published_and_the_others_have_the_defaults_of_ros(context: RecordingContext) -> None:
    node = of(
        ROS2Publisher,
        "geometry_msgs/msg/PoseStamped",
        context,
        topicName="pose",
        **{"header:frame_id": "map", "pose:position:x": 2.0},
    )
    node.compute()
    (sent,) = context.transport.messages("/pose")
    expected = messages.Pose(messages.Point(2.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
    assert (sent.header, sent.pose) == (messages.header(0.0, "map"), expected)


def test_messages_in_an_array_may_leave_fields_out(context: RecordingContext) -> None:
    node = of(
        ROS2Publisher, TF, context, transforms=['{"child_frame_id": "base", "transform": {"translation": {"x": 1}}}']
    )
    node.compute()
    (edge,) = context.transport.messages("/topic")[0].transforms
    assert (edge.child_frame_id, edge.transform.translation.x, edge.transform.rotation.w) == ("base", 1.0, 1.0)


@pytest.mark.parametrize(
    ("message_type", "inputs", "fault"),
    [
        (TF, {"transforms": ["{"]}, "transforms[0] is not JSON: "),
        (TF, {"transforms": ["[" * 100_000]}, "transforms[0] is not JSON: "),
        (
            TF,
            {"transforms": ["{}", "3"]},
            "transforms[1]: geometry_msgs/msg/TransformStamped must be a mapping of fields",
        ),
        (TF, {"transforms": ['{"child_frame": ""}']}, "has no field 'child_frame'; did you mean 'child_frame_id'?"),
        ("sensor_msgs/msg/Image", {"data": [1, 256]}, "data contains 256, which is out of the range of uint8"),
        ("geometry_msgs/msg/PoseWithCovariance", {"covariance": [1.0]}, "covariance has 1 elements, not 36"),
    ],
)
def test_a_literal_that_does_not_fit_its_field_is_refused_in_setup(
    message_type: str, inputs: dict[str, Any], fault: str
) -> None:
    with pytest.raises(ContextError) as caught:
        of(ROS2Publisher, message_type, RecordingContext(), **inputs)
    assert fault in str(caught.value)


def test_a_wired_value_that_does_not_fit_its_field_is_refused(context: RecordingContext) -> None:
    node = of(ROS2Publisher, "std_msgs/msg/UInt8MultiArray", context)
    node.message__data = np.array([1, 2, 1000], np.uint32)
    with pytest.raises(
        BadValueError, match=r"data cannot be .* data contains 1000, which is out of the range of uint8"
    ):
        node.compute()
    node = of(ROS2Publisher, "std_msgs/msg/UInt8", context, topicName="other")
    node.message__data = 1000
    with pytest.raises(BadValueError, match=r"data cannot be 1000: .*data is 1000, not a uint8"):
        node.compute()


def test_an_array_need_not_be_contiguous(context: RecordingContext) -> None:
    node = of(ROS2Publisher, "std_msgs/msg/Float64MultiArray", context)
    node.message__data = np.arange(6.0)[::2]
    node.compute()
    assert context.transport.messages("/topic")[0].data.tolist() == [0.0, 2.0, 4.0]


def test_without_subscribers_no_message_is_built() -> None:
    context = RecordingContext(wanted=False)
    node = of(ROS2Publisher, "std_msgs/msg/UInt8", context)
    node.message__data = 1000
    node.compute()


@pytest.mark.parametrize("cls", [ROS2Publisher, ROS2Subscriber])
def test_namespace_and_qos_come_from_the_inputs(cls: type[Node], context: RecordingContext) -> None:
    of(cls, TWIST, context, topicName="a/b", nodeNamespace="robot", queueSize=3)
    (claim,) = context.services.claims
    assert (claim.topic, claim.message_type, claim.qos) == ("/robot/a/b", TWIST, QoS(depth=3))


@pytest.mark.parametrize("cls", [ROS2Publisher, ROS2Subscriber])
def test_inputs_that_name_another_message_than_the_ports_are_refused(cls: type[Node]) -> None:
    made: Any = grown(cls, names(TWIST), DEFINITIONS)
    with pytest.raises(
        ContextError, match="the ports are those of geometry_msgs/msg/Twist, but the inputs name a/msg/B"
    ):
        ready(made, RecordingContext(), message_package="a", message_name="B")
    with pytest.raises(ContextError, match="the ports are those of no message"):
        ready(cls, RecordingContext(), message_package="geometry_msgs", message_name="Twist")


# The subscriber


def hear(context: RecordingContext, node: Any, *speeds: float) -> list[float]:
    """The x of each message that the node fires with."""
    for speed in speeds:
        context.transport.inject("/topic", twist(speed, 0.0))
    context.tick()
    return [node.message__linear__x for _ in node.compute()]


def test_each_message_of_a_tick_fires_oldest_first(context: RecordingContext) -> None:
    node = of(ROS2Subscriber, TWIST, context)
    assert hear(context, node) == []
    assert hear(context, node, 1.0, 2.0, 3.0) == [1.0, 2.0, 3.0]
    assert hear(context, node) == []
    assert node.message__linear__x == 3.0


def test_with_delivery_newest_only_the_newest_message_fires(context: RecordingContext) -> None:
    node = of(ROS2Subscriber, TWIST, context, delivery="newest")
    assert hear(context, node, 1.0, 2.0, 3.0) == [3.0]
    assert node.subscription.skipped == 2
    assert hear(context, node) == []


def test_if_the_queue_is_full_the_oldest_messages_are_lost(context: RecordingContext) -> None:
    node = of(ROS2Subscriber, TWIST, context, queueSize=2)
    assert hear(context, node, 1.0, 2.0, 3.0) == [2.0, 3.0]


def test_a_stop_resets_the_outputs(context: RecordingContext) -> None:
    node = of(ROS2Subscriber, "geometry_msgs/msg/Quaternion", context)
    context.transport.inject("/topic", messages.Quaternion(1.0, 0.0, 0.0, 0.5))
    context.tick()
    list(node.compute())
    context.stop(node)
    assert (node.message__x, node.message__w) == (0.0, 1.0)


# In graphs


ECHO = """
    nodes:
      Tick: OnPlaybackTick
      Hear: {type: ROS2Subscriber, inputs: {messagePackage: geometry_msgs, messageName: Twist, topicName: heard}}
      Say: {type: ROS2Publisher, inputs: {messagePackage: geometry_msgs, messageName: Twist, topicName: said}}
    connections:
      - Tick.tick -> Hear.execIn
      - Hear.execOut -> Say.execIn
      - Hear.linear:x -> Say.linear:y
      - Hear.outputs:angular:z -> Say.inputs:angular:z
    """


def test_in_a_graph_each_message_executes_the_nodes_downstream(play: Player) -> None:
    playing = play.graph(ECHO)
    for number in (1.0, 2.0):
        playing.transport.inject("/heard", twist(number, -number))
    playing.tick(3)
    assert [(m.linear.x, m.linear.y, m.angular.z) for m in playing.published("/said")] == [
        (0.0, 1.0, -1.0),
        (0.0, 2.0, -2.0),
    ]


def test_in_a_graph_messages_of_a_users_type_are_received_and_published(play: Player, tmp_path: Path) -> None:
    tag, part = "string from\nPart[] parts\n", "float32[2] size\n"
    write(tmp_path, {"my_msgs/msg/Tag.msg": tag, "my_msgs/msg/Part.msg": part})
    text = """
        nodes:
          Tick: OnPlaybackTick
          Hear: {type: ROS2Subscriber, inputs: {messagePackage: my_msgs, messageName: Tag, topicName: heard}}
          Say: {type: ROS2Publisher, inputs: {messagePackage: my_msgs, messageName: Tag, topicName: said, from: me}}
        connections: [Tick.tick -> Hear.execIn, Hear.execOut -> Say.execIn, Hear.parts -> Say.parts]
        """
    playing = play.graph(text, options=Options(message_paths=[tmp_path / "my_msgs"]))
    definitions = playing.definitions
    heard = definitions.initial("my_msgs/msg/Tag")
    heard.parts = [definitions.message_class("my_msgs/msg/Part")(np.array([1.0, 2.5], np.float32))]
    playing.transport.inject("/heard", messages.encode(heard, definitions))
    playing.tick(2)
    (sent,) = playing.transport.raw("/said")
    said = messages.decode(sent, "my_msgs/msg/Tag", definitions)
    assert (said.from_, said.parts[0].size.tolist()) == ("me", [1.0, 2.5])


def test_in_a_graph_messages_of_a_sourced_workspace_are_known(play: Player, tmp_path: Path) -> None:
    write(tmp_path, {"share/geometry_msgs/msg/Stride.msg": "float64 length\n"})
    text = ECHO.replace("Twist", "Stride").replace("linear:x", "length").replace("linear:y", "length")
    text = text.replace("      - Hear.outputs:angular:z -> Say.inputs:angular:z\n", "")
    playing = play.graph(text, options=Options(installed=[tmp_path / "share"]))
    assert {claim.message_type for claim in playing.session.services.claims} == {"geometry_msgs/msg/Stride"}


SAY = """
nodes:
  Tick: OnPlaybackTick
  Say:
    type: ROS2Publisher
    inputs: {inputs}
connections: [{wires}]
"""


def test_in_a_graph_an_array_that_does_not_fit_its_field_is_reported_at_its_position(tmp_path: Path) -> None:
    inputs = "messagePackage: geometry_msgs\n      messageName: PoseWithCovariance\n      covariance: [1.0, 2.0]"
    (finding,) = checked(tmp_path, SAY.format(inputs=f"\n      {inputs}", wires="Tick.tick -> Say.execIn")).items
    assert (finding.code, finding.message) == ("G307", "Say: covariance has 2 elements, not 36")
    assert finding.span is not None
    assert finding.span.line == 10


@pytest.mark.parametrize(
    ("inputs", "code", "message"),
    [
        ({"messageName": "Twit"}, "G308", "Say: no message type 'geometry_msgs/msg/Twit'"),
        ({"messagePackage": "geometry_msg"}, "G308", "Say: no message type 'geometry_msg/msg/Twist'"),
        (
            {"messageName": ""},
            "G208",
            "Say: the inputs name no message type, but the node's ports are the fields of a message",
        ),
        ({"messageName": "$(nothing)"}, "G111", "the graph has no parameter 'nothing'"),
        ({"linear:q": 1.0}, "G204", "ROS2Publisher has no input 'linear:q'"),
        ({"linear:y": "fast"}, "G211", "Say.linear:y is a double: expected a number, got 'fast'"),
    ],
)
def test_in_a_graph_one_mistake_gives_one_finding(
    tmp_path: Path, inputs: dict[str, Any], code: str, message: str
) -> None:
    given = {"messagePackage": "geometry_msgs", "messageName": "Twist", **inputs}
    text = SAY.format(inputs=json.dumps(given), wires="Tick.tick -> Say.execIn, Tick.time -> Say.linear:x")
    (finding,) = checked(tmp_path, text).items
    assert (finding.code, finding.message) == (code, message)
