"""ROS2ServicePrim: prims and attributes as clients of isaac_ros2_messages see them."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from graphengine.devices.camera import CameraStub
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.service_prim import ROS2ServicePrim
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, ready, yaw

PACKAGE = "isaac_ros2_messages/srv"
ARM = """
robot: arm
urdf: arm.urdf
joints:
  turn: {drive: {stiffness: 100.0, damping: 10.0}}
"""
URDF = """
<robot name="arm">
  <link name="base_link"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper"><inertial><mass value="0.5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="revolute">
    <parent link="base_link"/><child link="upper"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="100" velocity="10"/>
  </joint>
</robot>
"""
SCENE = """
scene: hall
world: world.xml
robots:
  arm: {use: arm.yaml, position: [1.0, 2.0, 0.5]}
graphs:
  prims: {use: prims.yaml, at: /World/prims}
"""
WORLD = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody><body name="box" pos="0 3 1"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/></body></worldbody>
</mujoco>
"""
GRAPH = """
graph: prims
nodes:
  Tick: OnPlaybackTick
  Serve: ROS2ServicePrim
connections:
  - Tick.tick -> Serve.execIn
"""
FILES = {"arm.yaml": ARM, "arm.urdf": URDF, "scene.yaml": SCENE, "world.xml": WORLD, "prims.yaml": GRAPH}


class Asking:
    """Calls of all four services, and their answers."""

    def __init__(self, transport: MemoryTransport, namespace: str = "") -> None:
        self._answer: Any = None
        self._clients = {
            name: transport.client(
                f"{namespace}/{service}", f"{PACKAGE}/{name}", QoS(), self._take(f"{PACKAGE}/{name}_Response")
            )
            for name, service in {
                "GetPrims": "get_prims",
                "GetPrimAttributes": "get_prim_attributes",
                "GetPrimAttribute": "get_prim_attribute",
                "SetPrimAttribute": "set_prim_attribute",
            }.items()
        }

    def ask(self, name: str, *fields: str) -> None:
        self._clients[name].call(messages.encode(messages.message_class(f"{PACKAGE}/{name}_Request")(*fields)))

    def answer(self) -> Any:
        answer, self._answer = self._answer, None
        return answer

    def _take(self, kind: str) -> Any:
        def take(number: int, data: bytes) -> None:
            self._answer = messages.decode(data, kind)

        return take


class Alone:
    """The node, and a client."""

    def __init__(self, world: RecordingWorld | None = None, **inputs: Any) -> None:
        self.context = RecordingContext("/robot/graph/node")
        if world is not None:
            self.context.world = self.context.services.world = world
        self.node = ready(ROS2ServicePrim, self.context, **inputs)
        self.asking = Asking(self.context.transport, f"/{inputs['node_namespace']}" if inputs else "")

    def ask(self, name: str, *fields: str) -> Any:
        self.asking.ask(name, *fields)
        self.context.tick()
        assert self.node.compute() == self.node.exec_out
        self.context.services.network.flush()
        return self.asking.answer()


def world() -> RecordingWorld:
    made = RecordingWorld()
    made.add_robot("/robot", ["left", "right"])
    made.stage.add("/robot/Physics/left", "joint", facts={"joint": "left", "type": "continuous"})
    made.stage.add("/robot/Physics/right", "joint", facts={"joint": "right", "type": "continuous"})
    made.add_device(CameraStub, "/robot/Geometry/base_link/Camera", clip=(0.5, 20.0))
    return made


def test_prims_are_listed_with_their_types_depth_first() -> None:
    answer = Alone(world()).ask("GetPrims", "/robot")
    assert (answer.success, answer.message) == (True, "")
    assert list(zip(answer.paths, answer.types, strict=True)) == [
        ("/robot", "Xform"),
        ("/robot/Geometry", "Scope"),
        ("/robot/Geometry/base_link", "Xform"),
        ("/robot/Geometry/base_link/Camera", "Camera"),
        ("/robot/Physics", "Scope"),
        ("/robot/Physics/left", "PhysicsRevoluteJoint"),
        ("/robot/Physics/right", "PhysicsRevoluteJoint"),
    ]


@pytest.mark.parametrize("service", ["GetPrims", "GetPrimAttributes"])
def test_the_error_of_an_unknown_prim_lists_similar_prims(service: str) -> None:
    answer = Alone(world()).ask(service, "/robt")
    assert answer.success is False
    assert answer.message == "no prim at '/robt': / has no child 'robt'; did you mean 'robot'?"


def test_only_supported_attributes_are_listed() -> None:
    answer = Alone(world()).ask("GetPrimAttributes", "/robot/Physics/left")
    assert dict(zip(answer.names, answer.types, strict=True)) == {
        "physics:jointEnabled": "bool",
        "state:angular:physics:position": "float",
        "state:angular:physics:velocity": "float",
        "drive:angular:physics:targetPosition": "float",
        "drive:angular:physics:targetVelocity": "float",
    }
    assert answer.displays == answer.names


def test_a_value_is_returned_as_json_with_its_usd_type() -> None:
    stage = world()
    stage.stage.find("/robot/base_link").namespace = "r2"
    alone = Alone(stage)
    found = {}
    for prim, attribute in (("/robot/base_link", "isaac:namespace"), ("/robot/base_link/Camera", "clippingRange")):
        answer = alone.ask("GetPrimAttribute", prim, attribute)
        found[attribute] = (answer.type, json.loads(answer.value), answer.success)
    assert found == {"isaac:namespace": ("string", "r2", True), "clippingRange": ("float2", [0.5, 20.0], True)}


def test_a_pose_is_relative_to_the_parent_and_its_quaternion_begins_with_the_real_part() -> None:
    stage = RecordingWorld()
    stage.add_body("/World/table", (1.0, 2.0, 0.0), yaw(math.pi / 2))
    stage.stage.add("/World/table/mark", "frame", position=(0.5, 0.0, 1.0), orientation=yaw(math.pi / 2))
    alone = Alone(stage)
    for prim, position in (("/World/table", [1.0, 2.0, 0.0]), ("/World/table/mark", [0.5, 0.0, 1.0])):
        translate = json.loads(alone.ask("GetPrimAttribute", prim, "xformOp:translate").value)
        orient = json.loads(alone.ask("GetPrimAttribute", prim, "xformOp:orient").value)
        assert translate == pytest.approx(position)
        assert orient == pytest.approx([math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)])


def test_angles_of_joints_are_degrees() -> None:
    stage = world()
    stage.articulation(stage.stage.find("/robot")).state["position"] = [0.0, math.pi / 2]
    answer = Alone(stage).ask("GetPrimAttribute", "/robot/Physics/right", "state:angular:physics:position")
    assert json.loads(answer.value) == pytest.approx(90.0)


@pytest.mark.parametrize(
    ("attribute", "value", "fault"),
    [
        ("clippingRnge", "[0, 1]", "has no attribute 'clippingRnge'; did you mean 'clippingRange'?"),
        (
            "clippingRange",
            "[0, 1]",
            "clippingRange of /robot/base_link/Camera cannot be changed while the simulation runs",
        ),
        ("clippingRange", "[0, 1", "the value is not JSON: "),
        ("clippingRange", "[" * 100_000, "the value is not JSON: "),
    ],
)
def test_a_refused_write_returns_the_reason(attribute: str, value: str, fault: str) -> None:
    answer = Alone(world()).ask("SetPrimAttribute", "/robot/base_link/Camera", attribute, value)
    assert answer.success is False
    assert fault in answer.message


def test_services_have_the_namespace_of_the_ancestor_prims_or_of_the_node() -> None:
    context = RecordingContext("/robot/graph/node")
    context.world.stage.add("/robot", "robot", namespace="r2")
    ready(ROS2ServicePrim, context)
    ready(ROS2ServicePrim, context, node_namespace="own", prims_service_name="prims")
    assert [claim.topic for claim in context.services.claims if claim.message_type.endswith("GetPrims")] == [
        "/r2/get_prims",
        "/own/prims",
    ]


def test_nothing_fires_in_a_tick_without_a_request(context: RecordingContext) -> None:
    node = ready(ROS2ServicePrim, context)
    context.tick()
    assert node.compute() is None


class Served:
    """The node in a scene, and a client."""

    def __init__(self, play: Player) -> None:
        self.playing = play.scene(FILES)
        self.asking = Asking(self.playing.transport)

    def ask(self, name: str, *fields: str) -> Any:
        self.asking.ask(name, *fields)
        self.playing.tick()
        return self.asking.answer()

    def read(self, prim: str, attribute: str) -> Any:
        return json.loads(self.ask("GetPrimAttribute", prim, attribute).value)

    def write(self, prim: str, attribute: str, value: str) -> Any:
        return self.ask("SetPrimAttribute", prim, attribute, value)


def test_the_targets_of_a_drive_are_written_in_degrees_and_move_the_joint(play: Player) -> None:
    served = Served(play)
    joint, target = "/arm/Physics/turn", "drive:angular:physics:targetPosition"
    assert served.write(joint, target, "45").success
    assert served.read(joint, target) == pytest.approx(45.0)
    served.playing.tick(600)
    assert served.read(joint, "state:angular:physics:position") == pytest.approx(45.0, abs=1.0)
    assert served.read("/arm/Geometry/base_link/upper", "physics:mass") == 0.5
    for wrong in ("true", "[1]", '"x"', "NaN", "1e400", "1e20"):
        answer = served.write(joint, target, wrong)
        assert not answer.success
        assert answer.message
    assert served.read(joint, target) == pytest.approx(45.0)


def test_poses_of_free_bodies_and_robots_can_be_written_and_poses_of_links_cannot(play: Player) -> None:
    served, half = Served(play), math.sqrt(0.5)
    for prim in ("/World/box", "/arm"):
        assert served.write(prim, "xformOp:translate", "[4.0, 5.0, 6.0]").message == ""
        assert served.write(prim, "xformOp:orient", "[1, 0, 0, 1]").message == ""
        assert served.read(prim, "xformOp:translate") == pytest.approx([4.0, 5.0, 6.0], abs=1e-6)
        assert served.read(prim, "xformOp:orient") == pytest.approx([half, 0.0, 0.0, half])
    for value in ("[1, 2]", "[1, 2, NaN]", "[true, 0, 0]", "[1e300, 0, 0]", "7"):
        assert not served.write("/World/box", "xformOp:translate", value).success
    assert not served.write("/World/box", "xformOp:orient", "[0, 0, 0, 0]").success
    refused = served.write("/arm/Geometry/base_link/upper", "xformOp:translate", "[0, 0, 0]")
    assert "cannot be changed while the simulation runs" in refused.message
    assert served.read("/World/box", "xformOp:translate") == pytest.approx([4.0, 5.0, 6.0], abs=1e-6)


def test_a_robot_added_during_the_run_is_listed(play: Player) -> None:
    served = Served(play)

    def second() -> bool:
        return "/second" in served.ask("GetPrims", "/").paths

    assert not second()
    served.playing.command("spawn", name="second", use={"use": "arm.yaml", "position": [3.0, 3.0, 0.5]})
    assert second()
    served.playing.command("delete", name="second")
    assert not second()
