"""Replaces node types that are not available, and upgrades nodes of older versions of Isaac Sim."""

from __future__ import annotations

from graphengine.compiler.registry import Registry
from graphengine.format.diagnostics import Findings
from graphengine.isaac.recorded_graph import RecordedNode, RecordedValue

_PICTURES = "ROS2CameraHelper publishes pictures and point clouds from a renderProductPath; leave the node out"
_IMAGES = "ROS2CameraHelper publishes pictures as ROS 2 messages"
_EXAMPLE = "an example of a node in an extension; write a node in Python and name its module with `--import`"
_STEPS = "`graphrun ctl step`, or the service `step_simulation` of `graphrun run --simulation-interfaces`, steps from outside"
_POSES = "ROS2CameraHelper with type: bbox_3d publishes the poses of what a camera sees, and `graphrun run --record` writes them"
_WRITE = "WritePrimAttribute writes gravity, friction and poses, with a number from RandomNumeric or RandomGaussian"
_ON_A_SPHERE = "RandomUnitVector times a radius from RandomNumeric, into WritePrimAttribute of xformOp:translate"
_OUTSIDE = "publish to ROS 2 in its place: ROS2PublishClock, ROS2PublishImu, ROS2PublishJointState, ROS2PublishOdometry"
_RANDOM = "RandomNumeric, or WritePrimAttribute from a node of your own"
REPLACEMENTS = {
    "IsaacAttachHydraTexture": "IsaacCreateRenderProduct outputs the renderProductPath; there are no textures",
    "IsaacGenerateRGBA": _PICTURES,
    "IsaacGenerate32FC1": _PICTURES,
    "IsaacPassthroughImagePtr": "leave the node out, and wire the node before it to the node after it",
    "RTSPCameraHelper": _IMAGES,
    "HSBCameraHelper": _IMAGES,
    "HSBSend": "ROS2PublishImage publishes a buffer of pixels as a ROS 2 message; there is no Holoscan sensor bridge",
    "RGBToVB1940": "ROS2PublishImage publishes rgb8 pixels as they are; there is no Holoscan sensor bridge",
    "UCXCameraHelper": _IMAGES,
    "UCXPublishClock": "ROS2PublishClock",
    "UCXPublishImage": "ROS2PublishImage",
    "UCXPublishImu": "ROS2PublishImu",
    "UCXPublishJointState": "ROS2PublishJointState",
    "UCXPublishOdometry": "ROS2PublishOdometry",
    "UCXSubscribeJointCommand": "ROS2SubscribeJointState",
    "SimpleReceiveExternalStepCpp": _STEPS,
    "SimpleReceiveExternalStepPy": _STEPS,
    "SimpleSendSimulationClockCpp": "ROS2PublishClock",
    "SimpleSendSimulationClockPy": "ROS2PublishClock",
    "OgnCountIndices": "ArrayGetSize",
    "OgnIntervalFiltering": "IsaacSimulationGate fires once in a number of executions",
    "OgnOnRLFrame": "OnPlaybackTick; a session of the Python API resets and steps one world",
    "OgnWritePhysicsArticulationView": _WRITE,
    "OgnWritePhysicsRigidPrimView": _WRITE,
    "OgnWritePhysicsSimulationContext": _WRITE,
    "Random3f": "RandomNumeric, with min and max of type float[3]",
    "OgnSampleBetweenSpheres": _ON_A_SPHERE,
    "OgnSampleInSphere": _ON_A_SPHERE,
    "OgnSampleOnSphere": _ON_A_SPHERE,
    "Dope": _POSES,
    "Pose": _POSES,
    "ExampleCpp": _EXAMPLE,
    "ExamplePython": _EXAMPLE,
}
"""Replacements for node types of Isaac Sim that are not available, by the last part of the type's name."""
FAMILIES = {
    "isaacsim.ucx.nodes.": _OUTSIDE,
    "omni.isaac.ros_bridge.": "ROS 1 is not spoken here: use the node of the same name with ROS2 in the place of ROS1",
    "isaacsim.replicator.": _RANDOM,
    "omni.replicator.": _RANDOM,
    "omni.graph.ui": "there are no windows; an OnImpulseEvent fires on `graphrun ctl impulse`, keys on `ctl press`",
}
"""Replacements for node types that are not in `REPLACEMENTS`, by the beginning of the type's name."""
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
"""Versions above 1 of node types in Isaac Sim 6.0.1, by registered name."""

_CONTEXT = "isaacsim.ros2.bridge.ROS2Context"
_USE_DOMAIN = "inputs:useDomainIDEnvVar"


def replacement(type: str) -> str:
    """Return a description of the replacement for a node type that is not available; empty if none is known."""
    families = (advice for prefix, advice in FAMILIES.items() if type.startswith(prefix))
    advice = REPLACEMENTS.get(type.rpartition(".")[2]) or next(families, "")
    return f"in its place: {advice}" if advice else ""


def modernize(node: RecordedNode, registry: Registry, findings: Findings) -> None:
    """Convert a camera helper that publishes CameraInfo, as before Isaac Sim 4.5, to a ROS2CameraInfoHelper."""
    found, kind = registry.find(node.type), node.values.get("inputs:type")
    if found is None or found.cls.type_name != _CAMERA_HELPER or kind is None or kind.data != "camera_info":
        return
    del node.values["inputs:type"]
    node.type = _INFO_HELPER
    what = f"{node.name}: ROS2CameraHelper of type camera_info is now ROS2CameraInfoHelper"
    topic = "" if "inputs:topicName" in node.values else "its topic is camera_info, as topicName was not given"
    findings.add("N301", what, kind.span or node.span, topic)


def upgrade(node: RecordedNode, type: str, version: object, where: str, findings: Findings) -> None:
    """Upgrade a node of an old version as Isaac Sim does, and report it.

    Args:
        node: the node.
        type: current name of its type.
        version: version in the stage.
        where: prim path of the node.
        findings: receives what was changed, and what the user may have to change.
    """
    current = _VERSIONS.get(type, 1)
    if not isinstance(version, int) or version >= current:
        return
    old = f"{where} was saved as version {version} of {type}, which is at version {current}"
    if type == _CONTEXT and _USE_DOMAIN not in node.values:
        node.values[_USE_DOMAIN] = RecordedValue(False, "bool", node.span)
        findings.add("N301", f"{old}: useDomainIDEnvVar is set to false, as in that version", node.span)
    else:
        findings.add("N301", f"{old}: check its values, whose meaning may have changed", node.span)
