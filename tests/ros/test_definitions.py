"""Message types: what files define, what folders add, and hashes that are those of ROS 2."""

from __future__ import annotations

import json
import os
import sys
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys.msg import get_types_from_msg

from graphengine.format.errors import GraphError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, MAX_NESTING, MAX_VALUES, Definitions
from graphengine.messages.interfaces import MAX_BYTES, MessageTypeError
from graphengine.ros.transports.dds.idl import idl_type

# From the files that rosidl of ROS 2 Jazzy generates, <package>/<kind>/<name>.json; those of simulation_interfaces 1.5.1,
# vision_msgs 4.1.1, control_msgs 5.8.0, example_interfaces 0.12.0 and of TAG and its like were generated for this test.
HASHES = {
    "ackermann_msgs/msg/AckermannDrive": "acf287a224a947dd1b0b87d6d76cdb73f497b0237b8fc73be2173b2ebbb82c99",
    "ackermann_msgs/msg/AckermannDriveStamped": "48ca7612a08d3bb72744fd98b71b7cf2ea24c6ad50fa4e1aa0bbad963c90d8cf",
    "control_msgs/action/FollowJointTrajectory": "738ebcb7a2d7cfa42f9f1001cc99ce3a4383d1cfe508015d9be8485e4b1c66f6",
    "control_msgs/action/FollowJointTrajectory_GetResult": "e3ceb38e3e1867c8dc0f46014df26e90eb93422f27e9e97f936e07f94be4bc8b",
    "control_msgs/action/GripperCommand": "e17c0e644eccf14bea84a0a93e0977182872c2eb7873ca6694900059b46dbc84",
    "control_msgs/action/JointTrajectory": "8db0176d9778d501036234e238568b82af95ce3f69271592fbf9887ca9421380",
    "control_msgs/action/ParallelGripperCommand": "adfd3c1ebe8abc38ebcc0e454b6423d291d4010dd5697d14eca5b9be4726ae18",
    "control_msgs/action/PointHead": "7074c3bddad393f3db72da02a8bb0fe3d832c21447452694b496965bdbfc9cc1",
    "control_msgs/action/SingleJointPosition": "1b330d11638c0b1d3228cc80b1123e5b3db3d24592e95429812bf30056e3db7b",
    "control_msgs/msg/DynamicJointState": "18024c98a62697680f581108eeed40b28fb4542fa0ac5a8e36f56c62b6813d26",
    "control_msgs/msg/JointComponentTolerance": "739ea7566931944d33830fa10f1bf5e7a7fbdc3172bce7a7eaac642bd6e3ffa4",
    "control_msgs/msg/JointJog": "ba249455a20f70168a1acb7bf43b776b72ff1f7eb5fc4cfea443f749e963c6e7",
    "control_msgs/msg/JointTolerance": "c254f9cece0f3b733017b6990fd46d1326e25242d6b8844398c97d9a88e7d648",
    "control_msgs/msg/JointTrajectoryControllerState": "51d8dd89cc624cbe9daaeeb4d80d6de9b86168ffdc3be41fefc0953e3c26e480",
    "control_msgs/srv/QueryTrajectoryState": "4a0935dffef18bc5b9e101c9d03d84e681ecd4cebd724b8f11fde008751a325a",
    "example_interfaces/action/Fibonacci": "9508051da1ea4658de144b09bd0690ff3de52104683d847aed764d2915906f51",
    "example_interfaces/msg/Float64MultiArray": "62a0985e7920b7bc489d1392f08c06ba0080fff5b8eaa09b27dcac122f50ad95",
    "example_interfaces/msg/WString": "32033e06d9dfe5468c5d6e1dc8b7a23c8910bad071cfd4e151a951d580e68dd8",
    "example_interfaces/srv/AddTwoInts": "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
    "nav_msgs/msg/Goals": "02305a51633b5c04d8979b878a7577cafd422f8a07465c878b17a920af3759e9",
    "std_srvs/srv/Trigger": "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    "std_srvs/srv/Trigger_Event": "ec4a1d26b0575e61906890342aba9523a2360e9845857c5590fa6e23bc39e1c2",
    "std_srvs/srv/Trigger_Request": "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199",
    "std_srvs/srv/Empty": "5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19",
    "rcl_interfaces/srv/SetParameters": "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
    "tf2_msgs/action/LookupTransform": "0b8adf6bc0b5958879e3265b41a457e03558fe523890a81252c70eba97a82c5d",
    "tf2_msgs/action/LookupTransform_FeedbackMessage": "10cb89922dcb103e95c185d43e8a5efa3d38db996f733151a2f3e2ac133f4839",
    "tf2_msgs/action/LookupTransform_SendGoal_Event": "5ab93d3d6c35b56390325099cb088c73bae176a39123f2f6dfe119582436acc5",
    "vision_msgs/msg/Detection2DArray": "214274120007f4a683866481336b70310268cfa107aebe9d594a6acf75bda968",
    "vision_msgs/msg/Detection3DArray": "793f5eab9595ac1c0da07873cc859db42eae51f0ee76056db8562515d830e018",
    "simulation_interfaces/msg/SimulatorFeatures": "8b101c8529bc0ea3dcf056078254768f39832b9ef0adaf93bd5cea96c0de3305",
    "simulation_interfaces/srv/SpawnEntity": "d4c086345d4194a5fc4c9ae45095736ca4062b5cdac4d06a42dec93d683e03cf",
    "simulation_interfaces/srv/StepSimulation_Request": "cda33f6887815f3dce0f90e61fd8efd39bda13ae264ddede15c33fbad890630e",
    "simulation_interfaces/action/SimulateSteps": "f0837c898e1219cd73bf4c041feab41e8c533e8e1057e982744dba7b093467eb",
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "nav_msgs/msg/Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    "sensor_msgs/msg/LaserScan": "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "geometry_msgs/msg/Twist": "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "rosgraph_msgs/msg/Clock": "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "sensor_msgs/msg/PointCloud2": "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    "rcl_interfaces/msg/Log": "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
    "rcl_interfaces/msg/ParameterEvent": "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204",
    "rmw_dds_common/msg/ParticipantEntitiesInfo": "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e",
    "std_msgs/msg/Char": "3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9",
    "service_msgs/msg/ServiceEventInfo": "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
}
OF_MY_MSGS = {
    "my_msgs/msg/Tag": "bd73570bdc3b40439b4bab1337c25629c792a69a9cfbe380917901de00113887",
    "my_msgs/srv/Ask": "bfd075f14f707f9d939ca452bacaeb0b5e6738e1528a0b2bc245bac764aff602",
    "my_msgs/action/Dock": "62973f3e7fbee83a5bb947b2bcedfec6e557e158ee236c5b969a17bafd504f23",
    "my_msgs/action/Dock_FeedbackMessage": "98b776cfdc23246db7e900b775bcd1fa77663a882e2a14afb75794662bd5d7a7",
}
MY_MSGS = {
    "msg/Part.msg": "geometry_msgs/Pose pose\nstring<=5[] words\n",
    "msg/Tag.msg": """\
        # a tag
        uint8 KIND_A=1
        string name "none"
        float32 lambda  # a keyword of Python
        byte[4] raw
        int16[<=3] few
        Part[] parts
        Part[2] two
        char letter
        string<=7 short
        string[2] pair
        string<=3[<=2] tiny
        Part[<=2] some
        bool[] flags
        """,
    "srv/Ask.srv": "---\nTag[] tags\n",
    "action/Dock.action": "Part goal_part\n---\nbool docked\n---\nfloat32 distance\n",
}


def package(folder: Path, files: dict[str, str], name: str = "my_msgs") -> Path:
    """Files of a package below a folder of its name."""
    for path, text in files.items():
        (folder / name / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / name / path).write_text(textwrap.dedent(text), "utf-8")
    return folder / name


@pytest.fixture
def mine(tmp_path: Path) -> Definitions:
    """What is known with the folder of a user's package."""
    return DEFINITIONS.extended([package(tmp_path, MY_MSGS)])


def given(folder: Path, text: str, name: str = "my_msgs/msg/Thing") -> Definitions:
    """One message, from a file."""
    parts = name.split("/")
    return DEFINITIONS.extended([package(folder, {f"{parts[1]}/{parts[2]}.{parts[1]}": text}, parts[0])])


def refusal(definitions: Definitions, message_type: str = "my_msgs/msg/Thing") -> str:
    with pytest.raises(MessageTypeError) as caught:
        definitions.definition(message_type)
    with pytest.raises(MessageTypeError) as again:  # a failure leaves nothing behind
        definitions.message_class(message_type)
    assert str(again.value) == str(caught.value)
    return str(caught.value)


# Hashes


@pytest.mark.parametrize(("name", "value"), HASHES.items())
def test_type_hashes_of_included_types_equal_those_of_ros_2(name: str, value: str) -> None:
    assert DEFINITIONS.type_hash(name) == f"RIHS01_{value}"


def test_type_hashes_of_user_types_equal_those_of_ros_2(mine: Definitions) -> None:
    assert {name: mine.type_hash(name) for name in OF_MY_MSGS} == {k: f"RIHS01_{v}" for k, v in OF_MY_MSGS.items()}


INSTALLED = [Path(prefix, "share") for prefix in (os.environ.get("AMENT_PREFIX_PATH") or sys.prefix).split(os.pathsep)]
"""Folders of types: of the ROS 2 that is sourced, else of wheels."""


@pytest.mark.ros
def test_type_hashes_of_installed_types_equal_those_of_rosidl() -> None:
    definitions, compared = DEFINITIONS.extended(installed=INSTALLED), 0
    folders = [folder for share in INSTALLED for kind in ("msg", "srv", "action") for folder in share.glob(f"*/{kind}")]
    for path in (file for folder in folders for file in folder.glob("*.json")):
        for entry in json.loads(path.read_text("utf-8"))["type_hashes"]:
            assert definitions.type_hash(entry["type_name"]) == entry["hash_string"], entry["type_name"]
            compared += 1
    assert compared > 100


# What a file defines


def test_the_class_of_a_users_message_has_the_fields_of_the_file(mine: Definitions) -> None:
    tag = mine.initial("my_msgs/msg/Tag")
    assert (tag.KIND_A, tag.name, tag.lambda_, tag.letter, tag.short) == (1, "none", 0.0, 0, "")
    assert (tag.parts, tag.pair, tag.tiny) == ([], ["", ""], [])
    assert [part.pose.orientation.w for part in tag.two] == [1.0, 1.0]
    assert (tag.raw.dtype, tag.raw.tolist(), tag.few.dtype, tag.flags.dtype) == (np.int8, [0] * 4, np.int16, np.bool_)
    messages.check(tag, mine)


def test_a_users_message_is_encoded_and_decoded(mine: Definitions) -> None:
    part = mine.initial("my_msgs/msg/Part")
    part.words = ["one", "two"]
    # A pose of 7 doubles; then the number of words, and each with its length and a zero behind it, on words of 4 bytes.
    words = b"\x02\0\0\0" + b"\x04\0\0\0one\0" + b"\x04\0\0\0two\0"
    pose = np.array([0, 0, 0, 0, 0, 0, 1], "<f8").tobytes()
    data = messages.encode(part, mine)
    assert data == b"\0\1\0\0" + pose + words
    assert messages.decode(data, "my_msgs/msg/Part", mine) == part


def test_a_users_message_can_be_described_to_dds(mine: Definitions) -> None:
    for name in ("my_msgs/msg/Tag", "my_msgs/srv/Ask_Request", "my_msgs/action/Dock_FeedbackMessage"):
        package_name, kind, last = name.split("/")
        described = idl_type(name, mine)
        assert described.__idl_typename__ == f"{package_name}.{kind}.dds_.{last}_"
        assert idl_type(name, mine) is described


def test_services_and_actions_have_the_same_messages_as_in_ros_2(mine: Definitions) -> None:
    response = mine.initial("my_msgs/srv/Ask_Response")
    assert response.tags == []
    assert mine.fields("my_msgs/srv/Ask_Request") == []
    goal = mine.initial("my_msgs/action/Dock_SendGoal_Request")
    assert (goal.goal_id.uuid.tolist(), goal.goal.goal_part.words) == ([0] * 16, [])
    assert mine.initial("my_msgs/action/Dock_FeedbackMessage").feedback.distance == 0.0
    assert not mine.definition("my_msgs/srv/Ask").is_message
    with pytest.raises(MessageTypeError, match=r"Ask is not a message type\nit has: my_msgs/srv/Ask_Request, "):
        mine.message_class("my_msgs/srv/Ask")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("int32 x 5", 5),
        ("int32 x -0x10", -16),
        ("float64 x 1", 1.0),
        ("bool x true", True),
        ("string x 'a # b'", "a # b"),
        (r'string x "a \"b\" c"', 'a "b" c'),
        (r"string x 'it\'s'", "it's"),
        ("byte x 255", -1),  # a byte of ROS 2 counts to 255, one of the encoder from -128
        ("byte[] x [1, 255]", [1, -1]),
        ("int32[] x [1, 2]", [1, 2]),
        ("float32[2] x [0.5, 1.5]", [0.5, 1.5]),
        ('string[] x ["a", "b"]', ["a", "b"]),
    ],
)
def test_a_field_begins_with_the_default_of_its_definition(tmp_path: Path, text: str, expected: Any) -> None:
    definitions = given(tmp_path, text)
    value = definitions.initial("my_msgs/msg/Thing").x
    assert (value.tolist() if isinstance(value, np.ndarray) else value) == expected
    messages.check(definitions.initial("my_msgs/msg/Thing"), definitions)


def test_quaternions_begin_upright_as_in_ros_2() -> None:
    # geometry_msgs/msg/Quaternion.msg and sensor_msgs/msg/NavSatStatus.msg are the messages of Jazzy with such values
    upright = messages.Quaternion(0.0, 0.0, 0.0, 1.0)
    assert DEFINITIONS.initial("geometry_msgs/msg/PoseStamped").pose.orientation == upright
    assert DEFINITIONS.initial("sensor_msgs/msg/NavSatFix").status.status == -2


def test_every_known_message_begins_with_legal_values() -> None:
    names = [name for name in DEFINITIONS.names() if DEFINITIONS.definition(name).is_message]
    assert len(names) > 200
    for name in names:
        messages.check(DEFINITIONS.initial(name))


def test_line_ends_of_windows_are_accepted(tmp_path: Path) -> None:
    definitions = given(tmp_path, "int32 a\r\nint32 b\r\n")
    assert [name for name, _ in definitions.fields("my_msgs/msg/Thing")] == ["a", "b"]


def test_a_file_without_fields_is_a_message_without_fields(tmp_path: Path) -> None:
    definitions = given(tmp_path, "# nothing\n")
    assert messages.encode(definitions.initial("my_msgs/msg/Thing"), definitions) == b"\0\1\0\0" + bytes(4)


def test_the_text_for_recordings_defines_the_same_type(mine: Definitions) -> None:
    found = get_types_from_msg(mine.text("my_msgs/msg/Tag"), "my_msgs/msg/Tag")
    parts = {f"geometry_msgs/msg/{part}" for part in ("Pose", "Point", "Quaternion")}
    assert set(found) == {"my_msgs/msg/Tag", "my_msgs/msg/Part", *parts}
    for name, (constants, fields) in found.items():
        assert (constants, fields) == mine.definition(name)[:2]


# Where files lie


@pytest.mark.parametrize("path", ["src/my_msgs", "src", "", "src/my_msgs/msg"])
def test_a_path_may_be_a_package_or_a_folder_of_packages(tmp_path: Path, path: str) -> None:
    package(tmp_path / "src", MY_MSGS)
    assert DEFINITIONS.extended([tmp_path / path]).initial("my_msgs/msg/Part").words == []


def test_a_path_may_be_a_single_file(tmp_path: Path) -> None:
    folder = package(tmp_path, MY_MSGS)
    definitions = DEFINITIONS.extended([folder / "msg" / "Part.msg"])
    assert definitions.initial("my_msgs/msg/Part").words == []
    assert refusal(definitions, "my_msgs/msg/Tag") == "no message type 'my_msgs/msg/Tag'\nmy_msgs/msg: Part"


def test_the_manifest_gives_the_name_of_a_package(tmp_path: Path) -> None:
    folder = package(tmp_path, {**MY_MSGS, "package.xml": "<package><name>other_msgs</name></package>"})
    definitions = DEFINITIONS.extended([folder])
    assert definitions.initial("other_msgs/msg/Part").words == []
    assert "no message type" in refusal(definitions, "my_msgs/msg/Part")


def test_folders_that_colcon_ignores_are_not_searched(tmp_path: Path) -> None:
    package(tmp_path / "build", {"msg/Part.msg": "int32 stale"})
    (tmp_path / "build" / "COLCON_IGNORE").touch()
    package(tmp_path / "src", MY_MSGS)
    assert DEFINITIONS.extended([tmp_path]).initial("my_msgs/msg/Part").words == []


def test_the_first_folder_wins_and_installed_packages_come_last(tmp_path: Path) -> None:
    places = {name: {"msg/Thing.msg": f"int32 {name}"} for name in ("one", "other", "share")}
    one, other, share = (package(tmp_path / name, files).parent for name, files in places.items())
    assert DEFINITIONS.extended([one, other], [share]).fields("my_msgs/msg/Thing")[0][0] == "one"
    assert DEFINITIONS.extended([other], [share]).fields("my_msgs/msg/Thing")[0][0] == "other"
    assert DEFINITIONS.extended([], [share]).fields("my_msgs/msg/Thing")[0][0] == "share"


def test_installed_packages_may_have_only_idl_files(tmp_path: Path) -> None:
    text = """
        module my_msgs { module msg {
          @verbatim (language="comment", text="a thing")
          struct Thing { int32 number; sequence<double, 3> few; };
        }; };
        """
    package(tmp_path, {"msg/Thing.idl": text})
    thing = DEFINITIONS.extended(installed=[tmp_path]).initial("my_msgs/msg/Thing")
    assert (thing.number, thing.few.dtype) == (0, np.float64)


def test_folders_add_types_to_one_registry_only(tmp_path: Path) -> None:
    before = DEFINITIONS.names()
    mine = DEFINITIONS.extended([package(tmp_path, MY_MSGS)])
    mine.message_class("my_msgs/msg/Tag")
    assert mine.message_class("nav_msgs/msg/Odometry") is messages.Odometry
    added = {"my_msgs/msg/Tag", "my_msgs/msg/Part", "my_msgs/srv/Ask", "my_msgs/action/Dock"}
    assert set(mine.names()) == {*before, *added}
    assert DEFINITIONS.names() == before
    assert "no message type" in refusal(DEFINITIONS, "my_msgs/msg/Tag")


def test_two_registries_may_have_different_types_with_one_name(tmp_path: Path) -> None:
    one, other = given(tmp_path / "one", "int32 a"), given(tmp_path / "other", "float64 b")
    first, second = (definitions.initial("my_msgs/msg/Thing") for definitions in (one, other))
    assert len(messages.encode(first, one)) == 8
    assert len(messages.encode(second, other)) == 12
    assert (first.a, second.b) == (0, 0.0)
    assert (hasattr(first, "b"), hasattr(second, "a")) == (False, False)


def test_without_folders_extended_returns_the_same_definitions() -> None:
    assert DEFINITIONS.extended() is DEFINITIONS


# What is refused


def test_another_definition_of_an_included_type_is_refused_at_its_first_use(tmp_path: Path) -> None:
    twist, vector = "Vector3 linear\nVector3 rotation\n", "float64 x\nfloat64 y\nfloat64 z\n"
    files = {"msg/Twist.msg": twist, "msg/Vector3.msg": vector}
    definitions = DEFINITIONS.extended([package(tmp_path, files, "geometry_msgs")])
    message = refusal(definitions, "geometry_msgs/msg/Twist")
    told = "Twist.msg differs from ROS 2 Jazzy's definition of geometry_msgs/msg/Twist in 'rotation'"
    assert told in message
    assert definitions.message_class("geometry_msgs/msg/Vector3") is messages.Vector3


@pytest.mark.parametrize(
    "name",
    ["", "/", "Thing", "my_msgs/Thing", "my_msgs/msg/../Thing", "../my_msgs/msg/Thing", "my_msgs/msg/thing", "a/b/C"],
)
def test_an_illegal_type_name_is_refused_and_leaves_no_folder(tmp_path: Path, name: str) -> None:
    package(tmp_path, MY_MSGS)
    (tmp_path / "Thing.msg").write_text("int32 a")
    assert "no message type" in refusal(DEFINITIONS.extended(installed=[tmp_path / "my_msgs" / "msg"]), name)


def test_a_very_long_name_is_refused_quickly_with_a_short_message() -> None:
    assert len(refusal(DEFINITIONS, "a" * 100_000 + "!/msg/Thing")) < 300
    assert len(refusal(DEFINITIONS, "a/msg/" + "A" * 100_000 + "!")) < 300


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("sensor_msgs/msg/Rang", "did you mean 'Range'?"),
        ("sensor_msg/msg/Range", "did you mean 'sensor_msgs/msg/Range'?"),
        ("sensor_msgs/Range", "did you mean 'sensor_msgs/msg/Range'?"),
        ("rosgraph_msgs/msg/Xyzzy", "rosgraph_msgs/msg: Clock"),
        ("xyzzy/msg/Xyzzy", "give the folder of its package with --msg-path, or source the workspace"),
    ],
)
def test_the_error_about_an_unknown_type_suggests_similar_types(name: str, hint: str) -> None:
    assert hint in refusal(DEFINITIONS, name)


def test_the_error_about_an_unknown_field_type_names_the_message(tmp_path: Path) -> None:
    message = refusal(given(tmp_path, "other_msgs/Part part"))
    assert "no message type 'other_msgs/msg/Part', which my_msgs/msg/Thing contains" in message


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("int32 a\nint32 1b\nfloat64", ":2: 'int32 1b' is not a definition of a field or constant"),
        ("float a", "'a' has the unknown type 'float'\ndid you mean 'float32' or 'float64'?"),
        ("int32 a b", "a cannot be 'b'"),
        ("int32", ":1: 'int32' is not a definition"),
        ("int32 Upper", "the field name 'Upper' is not legal"),
        ("int32 two__underscores", "the field name 'two__underscores' is not legal"),
        ("int32 last_", "the field name 'last_' is not legal"),
        ("int32 a\nfloat64 a", "defines 'a' twice"),
        ("wchar a", "'a' is a my_msgs/wchar, which is not supported"),
        ("Thing[] things", "contain each other without end: my_msgs/msg/Thing"),
        ("byte a 256", "a cannot be 256: 256 is not a byte"),
        ("byte[2] a [1, -1]", "a cannot be [1, -1]: -1 is not a byte"),
        ("int8 a 300", "invalid default value: a is 300, not a int8"),
        ("int8[2] a [1, 2, 3]", "invalid default value: a has 3 elements, not 2"),
        ("int8[] a [1, 300]", "cannot be [1, 300]"),
        (f"float64[{MAX_VALUES + 1}] a", f"has more than {MAX_VALUES} values"),
        ("geometry_msgs/Pose[200000] a", f"has more than {MAX_VALUES} values"),
        ("int32 a\n---\nint32 b", "has 2 parts, a .msg file has 1"),
        (f"int32 a\n{'=' * 80}\nMSG: my_msgs/Other\nint32 b", "is not a definition of a field or constant"),
    ],
)
def test_the_error_about_an_unusable_file_has_the_position(tmp_path: Path, text: str, fault: str) -> None:
    message = refusal(given(tmp_path, text))
    assert str(tmp_path / "my_msgs" / "msg" / "Thing.msg") in message
    assert fault in message


def test_a_service_without_its_separator_is_reported(tmp_path: Path) -> None:
    message = refusal(given(tmp_path, "int32 a", "my_msgs/srv/Ask"), "my_msgs/srv/Ask_Request")
    assert "has 1 parts, a .srv file has 2\nseparate the parts by a line with three dashes" in message


def test_an_error_has_its_line_in_the_whole_file(tmp_path: Path) -> None:
    definitions = given(tmp_path, "int32 a\n---\nint32 b\nint32\n", "my_msgs/srv/Ask")
    assert "Ask.srv:4: 'int32'" in refusal(definitions, "my_msgs/srv/Ask_Response")


def test_types_that_contain_each_other_are_refused(tmp_path: Path) -> None:
    folder = package(tmp_path, {"msg/One.msg": "Other other", "msg/Other.msg": "One one"})
    told = refusal(DEFINITIONS.extended([folder]), "my_msgs/msg/One")
    assert "without end: my_msgs/msg/One in my_msgs/msg/Other" in told


def test_types_with_too_deep_nesting_are_refused(tmp_path: Path) -> None:
    files = {f"msg/Level{number}.msg": f"Level{number + 1} next" for number in range(MAX_NESTING + 5)}
    assert "without end" in refusal(DEFINITIONS.extended([package(tmp_path, files)]), "my_msgs/msg/Level0")


def test_a_short_file_cannot_define_a_huge_message(tmp_path: Path) -> None:
    files = {f"msg/Level{number}.msg": f"Level{number + 1} one\nLevel{number + 1} other" for number in range(25)}
    definitions = DEFINITIONS.extended([package(tmp_path, {**files, "msg/Level25.msg": "int32 a"})])
    assert f"more than {MAX_VALUES} values" in refusal(definitions, "my_msgs/msg/Level0")


@pytest.mark.parametrize(
    ("data", "fault"), [(b"\xff\xfe", "cannot be read"), (b"#" * (MAX_BYTES + 1), "is larger than 256 kB")]
)
def test_a_binary_or_too_long_file_is_refused(tmp_path: Path, data: bytes, fault: str) -> None:
    folder = package(tmp_path, {"msg/Thing.msg": ""})
    (folder / "msg" / "Thing.msg").write_bytes(data)
    assert fault in refusal(DEFINITIONS.extended([folder]))


def test_all_errors_are_graph_errors() -> None:
    assert issubclass(MessageTypeError, GraphError)
    assert MessageTypeError.code == "G308"
