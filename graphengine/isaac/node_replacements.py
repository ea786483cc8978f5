"""Suggests replacements for unavailable node types, and upgrades nodes of older versions of Isaac Sim."""

from __future__ import annotations

from graphengine.compiler.registry import Registry
from graphengine.format.diagnostics import Findings
from graphengine.isaac.recorded_graph import RecordedNode, RecordedValue

_PICTURES = "use ROS2CameraHelper, which publishes images and point clouds from a renderProductPath"
_IMAGES = "use ROS2CameraHelper, which publishes images as ROS 2 messages"
_EXAMPLE = "write a node in Python and name its module with `--import`; this type is only an example"
_STEPS = "use `graphrun ctl step`, or the service `step_simulation` of `graphrun run --simulation-interfaces`"
_POSES = "publish the poses of visible objects with ROS2CameraHelper, type: bbox_3d, and write them with `run --record`"
_WRITE = "write gravity, friction and poses with WritePrimAttribute, and a number from RandomNumeric or RandomGaussian"
_ON_A_SPHERE = "write RandomUnitVector times a radius from RandomNumeric to xformOp:translate with WritePrimAttribute"
_OUTSIDE = "publish to ROS 2 with ROS2PublishClock, ROS2PublishImu, ROS2PublishJointState or ROS2PublishOdometry"
_RANDOM = "use RandomNumeric, or WritePrimAttribute with values from a node of your own"
REPLACEMENTS = {
    "IsaacAttachHydraTexture": "use IsaacCreateRenderProduct, which outputs the renderProductPath; there are no Hydra textures",
    "IsaacGenerateRGBA": _PICTURES,
    "IsaacGenerate32FC1": _PICTURES,
    "IsaacPassthroughImagePtr": "leave the node out and wire the node before it to the node after it",
    "RTSPCameraHelper": _IMAGES,
    "HSBCameraHelper": _IMAGES,
    "HSBSend": "use ROS2PublishImage, which publishes a buffer of pixels; there is no Holoscan sensor bridge",
    "RGBToVB1940": "use ROS2PublishImage, which publishes rgb8 pixels unchanged; there is no Holoscan sensor bridge",
    "UCXCameraHelper": _IMAGES,
    "UCXPublishClock": "use ROS2PublishClock",
    "UCXPublishImage": "use ROS2PublishImage",
    "UCXPublishImu": "use ROS2PublishImu",
    "UCXPublishJointState": "use ROS2PublishJointState",
    "UCXPublishOdometry": "use ROS2PublishOdometry",
    "UCXSubscribeJointCommand": "use ROS2SubscribeJointState",
    "SimpleReceiveExternalStepCpp": _STEPS,
    "SimpleReceiveExternalStepPy": _STEPS,
    "SimpleSendSimulationClockCpp": "use ROS2PublishClock",
    "SimpleSendSimulationClockPy": "use ROS2PublishClock",
    "OgnCountIndices": "use ArrayGetSize",
    "OgnIntervalFiltering": "use IsaacSimulationGate, which fires once in a number of executions",
    "OgnOnRLFrame": "use OnPlaybackTick; a session of the Python API resets and steps one world",
    "OgnWritePhysicsArticulationView": _WRITE,
    "OgnWritePhysicsRigidPrimView": _WRITE,
    "OgnWritePhysicsSimulationContext": _WRITE,
    "Random3f": "use RandomNumeric, with min and max of type float[3]",
    "OgnSampleBetweenSpheres": _ON_A_SPHERE,
    "OgnSampleInSphere": _ON_A_SPHERE,
    "OgnSampleOnSphere": _ON_A_SPHERE,
    "Dope": _POSES,
    "Pose": _POSES,
    "ExampleCpp": _EXAMPLE,
    "ExamplePython": _EXAMPLE,
}
"""Advice for node types of Isaac Sim that graphengine does not have, by the last part of the type name."""
FAMILIES = {
    "isaacsim.ucx.nodes.": _OUTSIDE,
    "omni.isaac.ros_bridge.": "use the node of the same name with ROS2 for ROS1; ROS 1 is not supported",
    "isaacsim.replicator.": _RANDOM,
    "omni.replicator.": _RANDOM,
    "omni.graph.ui": "use OnImpulseEvent, which fires on `graphrun ctl impulse`, or key events; there are no windows",
}
"""Advice for unavailable node types that are not in `REPLACEMENTS`, by prefix of the type name."""
_CAMERA_HELPER = "isaacsim.ros2.bridge.ROS2CameraHelper"
_INFO_HELPER = "isaacsim.ros2.bridge.ROS2CameraInfoHelper"
_VERSIONS = {
    "isaacsim.core.nodes.IsaacCreateRenderProduct": 3,
    "isaacsim.core.nodes.IsaacCreateViewport": 2,
    "isaacsim.core.nodes.IsaacReadCameraInfo": 2,
    "isaacsim.core.nodes.IsaacReadWorldPose": 2,
    "isaacsim.robot.surface_gripper.SurfaceGripper": 3,
    "isaacsim.robot.wheeled_robots.AckermannController": 2,
    "isaacsim.robot.wheeled_robots.HolonomicController": 2,
    "isaacsim.ros2.bridge.ROS2CameraHelper": 3,
    "isaacsim.ros2.bridge.ROS2Context": 2,
    "isaacsim.ros2.bridge.ROS2PublishCameraInfo": 2,
    "isaacsim.ros2.bridge.ROS2PublishLaserScan": 3,
    "isaacsim.ros2.bridge.ROS2PublishPointCloud": 3,
    "isaacsim.ros2.bridge.ROS2RtxLidarHelper": 3,
    "isaacsim.ros2.bridge.ROS2SubscribeJointState": 2,
    "omni.graph.action.OnPlaybackTick": 2,
    "omni.graph.nodes.Add": 2,
    "omni.graph.nodes.Multiply": 2,
}
"""Versions of the node types of Isaac Sim 6.0.1 by registered name; types that are missing here have version 1."""

_CONTEXT = "isaacsim.ros2.bridge.ROS2Context"
_USE_DOMAIN = "inputs:useDomainIDEnvVar"


def replacement(type: str) -> str:
    """Return advice on how to replace a node of an unavailable type; empty if there is none."""
    families = (advice for prefix, advice in FAMILIES.items() if type.startswith(prefix))
    advice = REPLACEMENTS.get(type.rpartition(".")[2]) or next(families, "")
    return f"instead: {advice}" if advice else ""


def modernize(node: RecordedNode, registry: Registry, findings: Findings) -> None:
    """Convert a ROS2CameraHelper of type camera_info, which Isaac Sim before 4.5 has, to a ROS2CameraInfoHelper."""
    found, kind = registry.find(node.type), node.values.get("inputs:type")
    if found is None or found.cls.type_name != _CAMERA_HELPER or kind is None or kind.data != "camera_info":
        return
    del node.values["inputs:type"]
    node.type = _INFO_HELPER
    what = f"{node.name}: a ROS2CameraHelper of type camera_info is converted to a ROS2CameraInfoHelper"
    topic = "" if "inputs:topicName" in node.values else "its topic is camera_info, because topicName is not set"
    findings.add("N301", what, kind.span or node.span, topic)


def upgrade(node: RecordedNode, type: str, version: object, where: str, findings: Findings) -> None:
    """Upgrade a node that was saved with an old version of its type, as Isaac Sim does, and report the upgrade.

    Args:
        node: the node, whose values may be changed.
        type: current name of the node type.
        version: version of the node type in the stage.
        where: prim path of the node.
        findings: receives a note if the version is old.
    """
    current = _VERSIONS.get(type, 1)
    if not isinstance(version, int) or version >= current:
        return
    old = f"{where} was saved as version {version} of {type}, whose current version is {current}"
    if type == _CONTEXT and _USE_DOMAIN not in node.values:
        node.values[_USE_DOMAIN] = RecordedValue(False, "bool", node.span)
        findings.add("N301", f"{old}: useDomainIDEnvVar is set to false, the behaviour of the old version", node.span)
    else:
        findings.add("N301", f"{old}: check its input values, because their meaning may have changed", node.span)
