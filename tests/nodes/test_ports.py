"""Every implemented type against the reference's table of ports."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

from graphengine.compiler.registry import default_registry, short_names
from graphengine.devices.camera import CameraStub
from graphengine.devices.contact import ContactSensorStub
from graphengine.devices.force_torque import ForceTorqueStub
from graphengine.devices.holonomic_wheels import HolonomicWheel
from graphengine.devices.imu import ImuStub
from graphengine.devices.lidar import LidarStub
from graphengine.devices.light_beam import LightBeamStub
from graphengine.devices.navsat import NavSatStub
from graphengine.devices.radar import RadarStub
from graphengine.devices.range import RangeSensorStub
from graphengine.devices.raycast import RaycastSensorStub
from graphengine.devices.surface_gripper import SurfaceGripperStub
from graphengine.format.files import Files
from graphengine.format.permissions import Permissions
from graphengine.node import Node
from graphengine.node.port import Port
from graphengine.node.types import UnionType, coerce, equal, parse
from graphengine.node.variable import Variable
from graphengine.testing import RecordingContext, check_node
from tests.nodes.data import needed as data
from tests.nodes.harness import HERE, facts

REFERENCE: dict[str, Any] = facts("ports.json")["types"] | facts("kit_ports.json")["types"]
TYPES = {name: cls for name, cls in default_registry().types.items() if name == cls.type_name}
OURS = {name for name in TYPES if name.startswith("graphengine.")}

reference_type = pytest.mark.parametrize("name", sorted(REFERENCE))
every_type = pytest.mark.parametrize("name", sorted(TYPES))


def ports_of(name: str) -> dict[str, Port]:
    """A class's ports by `inputs:name`, without those of our own."""
    return {key: port for key, port in TYPES[name].ports.items() if port.side != "state" and not port.extension}


def reference_of(name: str) -> dict[str, Any]:
    """The reference's ports by `inputs:name`."""
    return {f"{side}:{port}": REFERENCE[name][side][port] for side in REFERENCE[name] for port in REFERENCE[name][side]}


def kinds(name: str | Any) -> set[str]:
    """A port type as a set of names, one for each alternative."""
    found = parse(name) if isinstance(name, str) else name
    return {str(alternative) for alternative in (found.alternatives if isinstance(found, UnionType) else (found,))}


def test_every_type_is_isaac_sims_or_has_the_prefix_graphengine() -> None:
    assert set(TYPES) == set(REFERENCE) | OURS


@reference_type
def test_a_type_has_exactly_the_ports_of_isaac_sims_type(name: str) -> None:
    assert set(ports_of(name)) == set(reference_of(name))


@reference_type
def test_ports_have_isaac_sims_types(name: str) -> None:
    expected = {key: kinds(port["type"]) for key, port in reference_of(name).items()}
    assert {key: kinds(port.type) for key, port in ports_of(name).items()} == expected


@reference_type
def test_ports_have_isaac_sims_defaults_or_the_zero_of_their_type(name: str) -> None:
    for key, port in reference_of(name).items():
        port_type, ours = parse(port["type"]), ports_of(name)[key]
        if ours.is_exec or isinstance(port_type, UnionType):
            continue
        expected = coerce(port["default"], port_type) if "default" in port else port_type.zero
        assert equal(ours.default, expected), key
        if isinstance(expected, np.ndarray):
            assert ours.default.dtype == expected.dtype


@reference_type
def test_ports_have_isaac_sims_legal_tokens(name: str) -> None:
    expected = {key: tuple(port.get("allowedTokens", ())) for key, port in reference_of(name).items()}
    assert {key: port.tokens for key, port in ports_of(name).items()} == expected


def test_extension_ports_are_exactly_those_of_the_list() -> None:
    listed = yaml.safe_load((HERE / "extension_ports.yaml").read_text("utf-8"))
    marked = {name: [p.name for p in cls.fields.values() if p.extension] for name, cls in TYPES.items()}
    assert {name: ports for name, ports in marked.items() if ports} == listed


def test_types_of_graphengine_mark_no_port_as_extension() -> None:
    assert not [port for name in OURS for port in TYPES[name].fields.values() if port.extension]


@every_type
def test_a_constructor_without_arguments_gives_every_port_its_default(name: str) -> None:
    node = TYPES[name]()
    for port in TYPES[name].fields.values():
        if not port.is_exec and port.side != "state":
            assert equal(getattr(node, port.field), port.default), port.name


def test_short_names_mean_one_type_each() -> None:
    meant: dict[str, list[str]] = {}
    for name in TYPES:
        for short in short_names(name):
            meant.setdefault(short, []).append(name)
    assert {short: names for short, names in meant.items() if len(names) > 1} == {}


HERE_AND_LEVEL = {"current_position": (0.0, 0.0, 0.0), "current_orientation": (0.0, 0.0, 0.0, 1.0)}

ONE, LINK = np.array([1.0]), "/robot/Geometry/base_link"
FIBONACCI = {"message_package": "example_interfaces", "message_name": "Fibonacci"}
SHARED: dict[str, dict[str, Any]] = {
    "ArrayRemoveIndex ArrayResize ArrayRotate ArraySlice": {"array_in": ONE},
    "ArrayAppendValue ArrayInsertValue ArraySetIndex": {"array_in": ONE, "value": 2.0},
    "ArrayGetSize ArrayIndex": {"array": ONE},
    "ToBool ToDouble ToFloat ToHalf ToInt ToInt64 ToUint ToUint64": {"value": 1.5},
    "ToString ToTarget ToToken ToUchar": {"value": "/robot"},
    "IsaacArticulationController IsaacArticulationState": {"target_prim": "/robot"},
    "ROS2FollowJointTrajectory ROS2PublishJointState RobotStatePublisher ROS2PublishGroundTruthTransform": {
        "target_prim": "/robot"
    },
    "IsaacComputeTransformTree ROS2PublishTransformTree": {"target_prims": "/robot"},
    "IsaacReadJointState IsaacReadWorldPose ReadPrimLocalTransform": {"prim": "/robot"},
    "GetPrimDirectionVector GetPrimLocalToWorldTransform": {"prim_path": "/robot"},
    "IsaacReadLidarBeams IsaacReadLidarPointCloud": {"lidar_prim": f"{LINK}/Lidar"},
    "IsaacComputeRTXLidarFlatScan ROS2RtxLidarHelper": {"render_product_path": f"{LINK}/Lidar"},
    "IsaacCreateRTXLidarScanBuffer ROS2RtxRadarHelper": {"render_product_path": f"{LINK}/Radar"},
    "IsaacConvertRGBAToRGB IsaacConvertDepthToPointCloud": {"render_product_path": f"{LINK}/Camera"},
    "IsaacReadCameraInfo ROS2CameraHelper ROS2CameraInfoHelper": {"render_product_path": f"{LINK}/Camera"},
    "OgnROS2ServiceClient OgnROS2ServiceServerRequest": {"message_package": "std_srvs", "message_name": "SetBool"},
    "ROS2ActionClient ROS2ActionServerGoal": FIBONACCI,
    "ROS2Publisher ROS2Subscriber": {"message_package": "geometry_msgs", "message_name": "Twist"},
    "OnVariableChange ReadVariable": {"variable_name": "speed"},
}
"""What nodes cannot do without, by the names of several classes."""
NEEDED: dict[str, dict[str, Any]] = {
    **data.NEEDED,
    **{name: inputs for classes, inputs in SHARED.items() for name in classes.split()},
    "ArrayFill": {"array_in": ONE, "fill_value": 2.0},
    "ArrayFindValue": {"array": ONE, "value": 1.0},
    "ArrayRemoveValue": {"array_in": ONE, "value": 1.0},
    "ArticulationActuators": {"robot_path": "/robot", "feedforward_command": [5.0, -3.0]},
    "AckermannController": {"wheel_base": 1.6, "track_width": 1.2, "front_wheel_radius": 0.25},
    "ForEach": {"array_in": [1.0, 2.0]},
    "ComputeWheelOdometry": {
        "target_prim": "/robot",
        "left_joints": ["left"],
        "right_joints": ["right"],
        "wheel_radius": 0.1,
        "wheel_distance": 0.5,
    },
    "DifferentialController": {"wheel_radius": 0.1, "wheel_distance": 0.5},
    "HolonomicController": {
        "wheel_radius": [0.05],
        "wheel_positions": [[0.1, 0.0, 0.0], [-0.05, 0.1, 0.0], [-0.05, -0.1, 0.0]],
        "wheel_orientations": [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.866], [0.5, 0.0, 0.0, -0.866]],
        "mecanum_angles": [90.0],
    },
    "HolonomicRobotUsdSetup": {"robot_prim": "/robot"},
    "IsaacComputeOdometry": {"chassis_prim": "/robot"},
    "IsaacConveyor": {"conveyor_prim": "/robot", "velocity": 0.5},
    "IsaacCreateRenderProduct": {"camera_prim": "/robot/Geometry/base_link/Lidar"},
    "IsaacGripperController": {
        "articulation_root_prim": "/robot",
        "joint_names_in": ["left"],
        "open_position": [0.04],
        "gripper_speed": [0.01],
    },
    "IsaacGetViewportRenderProduct": {"viewport": "Viewport"},
    "IsaacJointNameResolver": {"target_prim": "/robot", "joint_names": ["left"]},
    "IsaacReadContactSensor": {"cs_prim": "/robot/Geometry/base_link/Contact"},
    "IsaacReadEffortSensor": {"prim": "/robot/Physics/left"},
    "IsaacReadIMU": {"imu_prim": "/robot/Geometry/base_link/Imu"},
    "IsaacReadLightBeam": {"lightbeam_prim": "/robot/Geometry/base_link/Beam"},
    "IsaacReadRaycastSensor": {"raycast_sensor_prim": "/robot/Geometry/base_link/Rays"},
    "IsaacSetCameraOnRenderProduct": {
        "render_product_path": "/Render/robot_Geometry_base_link_Camera_64x48",
        "camera_prim": "/robot/Geometry/base_link/Camera",
    },
    "IsaacTestNode": {"input_in": "echo"},
    "IsaacTimeSplitter": {"time": 1.5},
    "OgnIsaacExtractRTXSensorPointCloud": {"render_product_path": f"{LINK}/Lidar"},
    "OgnIsaacScaleToFromStageUnit": {"value": 2.5},
    "OgnROS2ServiceServerResponse": {"message_package": "std_srvs", "message_name": "SetBool", "server_handle": 1},
    "ROS2ActionServerFeedback": {**FIBONACCI, "server_handle": 2},
    "ROS2ActionServerResult": {**FIBONACCI, "server_handle": 2},
    "ROS2GripperCommand": {"target_prim": "/robot", "joint_name": "left"},
    "ROS2SubscribeTransformTree": {"frame_names_map": ["/robot", "base_link"]},
    "ForceTorquePublisher": {"force_torque_prim": "/robot/Geometry/arm/hand/Wrist"},
    "NavSatPublisher": {"nav_sat_prim": "/robot/Geometry/base_link/NavSat"},
    "RangePublisher": {"range_prim": "/robot/Geometry/base_link/Range"},
    "SurfaceGripper": {"surface_gripper": "/robot/Geometry/base_link/Cup"},
    "WriteVariable": {"variable_name": "speed", "value_in": 2.0},
    "AppendArray": {"input0": np.array([1.0]), "input1": np.array([2.0])},
    "AppendString": {"value_in": "a", "suffix": "b"},
    "BuildString": {"a": "a", "b": "b"},
    "ConstructArray": {"input0": 1.0},
    "IsEmpty": {"input_in": ""},
    "MakeArray": dict.fromkeys("abcde", 1.0),
    "RandomGaussian": {"mean": 0.0, "stdev": 1.0},
    "RandomNumeric": {"minimum": 0.0, "maximum": 1.0},
    "SelectIf": {"condition": True, "if_true": 1.0, "if_false": 2.0},
    "SelectTargetIf": {"condition": True},
    "ReadPrimAttribute": {"prim": "/robot", "name": "xformOp:translate"},
    "WritePrimAttribute": {"prim": "/robot", "name": "xformOp:translate", "value": (1.0, 2.0, 3.0)},
    "IsaacReadEnvVar": {"env_var": "ROBOT"},
    "IsaacReadFilePath": {"path": "clock.yaml"},
    "CheckGoal2D": HERE_AND_LEVEL,
    "QuinticPathPlanner": {**HERE_AND_LEVEL, "target_position": (5.0, 0.0, 0.0)},
    "StanleyControlPID": {
        **HERE_AND_LEVEL,
        "path_arrays": [1.0, 1.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0],
        "target": (5.0, 0.0, 0.0),
    },
}
"""What a node cannot do without."""


def surroundings() -> RecordingContext:
    """A robot with a joint, one device of each kind, some of which measure something, and a surface gripper."""
    context = RecordingContext()
    context.variables["speed"] = Variable(1.0)
    context.services.permissions = Permissions(Files.of(HERE / "graph.yaml"), {"ROBOT": "dd100"}, scripts=True)
    wheel = HolonomicWheel("left", 0.05, (0.0, 0.1, 0.0), (0.0, 1.0, 0.0), 45.0)
    context.world.add_robot("/robot", ["left", "right"], holonomic_wheels=(wheel,))
    lidar = context.world.add_device(LidarStub, "/robot/Geometry/base_link/Lidar", angles=(0.0, 1.0, 1.0))
    lidar.see([1.0, np.inf])
    context.world.add_device(RadarStub, "/robot/Geometry/base_link/Radar").see([[1.0, 0.0, 0.0]], -0.5)
    context.world.add_device(CameraStub, "/robot/Geometry/base_link/Camera").show(np.zeros((3, 4, 3)), depth=2.0)
    context.render_product("/robot/Geometry/base_link/Camera", 64, 48)
    context.world.add_device(ImuStub, "/robot/Geometry/base_link/Imu")
    context.world.add_device(ContactSensorStub, "/robot/Geometry/base_link/Contact")
    context.world.add_device(RangeSensorStub, "/robot/Geometry/base_link/Range").measure(1.0)
    for path in ("/robot/Geometry/arm", "/robot/Geometry/arm/hand"):
        context.world.stage.add(path, "link")
    context.world.add_device(ForceTorqueStub, "/robot/Geometry/arm/hand/Wrist").measure(
        (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)
    )
    context.world.add_device(NavSatStub, "/robot/Geometry/base_link/NavSat").measure(47.4, 8.5, 400.0)
    for stub, name in ((RaycastSensorStub, "Rays"), (LightBeamStub, "Beam"), (SurfaceGripperStub, "Cup")):
        context.world.add_device(stub, f"{LINK}/{name}")
    context.world.stage.add("/robot/Physics/left", "joint", facts={"joint": "left"})
    return context


@every_type
def test_check_node_finds_nothing_wrong_with_a_built_in(name: str) -> None:
    """`NEEDED` gives a node its required inputs, `surroundings` the devices that it reads."""
    cls: type[Node] = TYPES[name]
    check_node(cls, surroundings, **NEEDED.get(cls.__name__, {}))
