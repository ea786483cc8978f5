"""Versions of node types, of which a stage saves those that its nodes were written for."""

from __future__ import annotations

from graphengine.format.diagnostics import Findings
from graphengine.isaac.recorded import RecordedNode, RecordedValue

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
"""Those above 1, of Isaac Sim 6.0.1, by registered name."""

_CONTEXT = "isaacsim.ros2.bridge.ROS2Context"
_USE_DOMAIN = "inputs:useDomainIDEnvVar"


def upgrade(node: RecordedNode, type: str, version: object, where: str, findings: Findings) -> None:
    """Bring a node of an old version up to date as far as Isaac Sim does it, and tell of it.

    Args:
        node: the node.
        type: its type's current name.
        version: as the stage has it.
        where: the node's prim.
        findings: takes what was changed, and what may have to be.
    """
    current = _VERSIONS.get(type, 1)
    if not isinstance(version, int) or version >= current:
        return
    old = f"{where} was saved as version {version} of {type}, which is at version {current}"
    if type == _CONTEXT and _USE_DOMAIN not in node.values:
        node.values[_USE_DOMAIN] = RecordedValue(False, "bool", node.span)
        findings.add("N301", f"{old}: useDomainIDEnvVar becomes false, as it was without it", node.span)
    else:
        findings.add("N301", f"{old}: look at its values, whose meaning may have changed", node.span)
