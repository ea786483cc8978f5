"""Names the helper nodes that publish what Replicator's ROS 2 writers publish in Isaac Sim."""

from __future__ import annotations

import re
from typing import Any

_WRITER = re.compile(r"(?P<source>.*)ROS2Publish(?P<message>[A-Za-z0-9]+?)(Buffer)?\Z")
_HELPERS = {
    r".* CameraInfo$": "ROS2CameraInfoHelper",
    r".* LaserScan$": "ROS2RtxLidarHelper with `type: laser_scan`",
    r".* SemanticLabels$": "ROS2CameraHelper with `enableSemanticLabels: true`",
    r"RtxRadar.* PointCloud$": "ROS2RtxRadarHelper",
    r"Rtx.* PointCloud$": "ROS2RtxLidarHelper with `type: point_cloud`",
    r".* PointCloud$": "ROS2CameraHelper with `type: depth_pcl`",
    r"BoundingBox2DTight": "ROS2CameraHelper with `type: bbox_2d_tight`",
    r"BoundingBox2DLoose": "ROS2CameraHelper with `type: bbox_2d_loose`",
    r"BoundingBox3D": "ROS2CameraHelper with `type: bbox_3d`",
    r"DistanceTo|Depth": "ROS2CameraHelper with `type: depth`",
    r"InstanceSegmentation": "ROS2CameraHelper with `type: instance_segmentation`",
    r"SemanticSegmentation": "ROS2CameraHelper with `type: semantic_segmentation`",
    r"": "ROS2CameraHelper with `type: rgb`",
}
"""Helper nodes, by patterns of the render variable and the message of a writer; the first pattern that matches counts."""


def is_ros_writer(name: Any) -> bool:
    """Return whether a text is the name of a ROS 2 writer, such as `RtxLidarROS2PublishPointCloud`."""
    return isinstance(name, str) and _WRITER.match(name) is not None


def helper_node(writer: str) -> str:
    """Return the node type, with the input that selects the message, that publishes the same messages as a ROS 2 writer."""
    found = _WRITER.match(writer)
    named = f"{found['source']} {found['message']}" if found else ""
    return next(node for pattern, node in _HELPERS.items() if re.match(pattern, named))


def render_variable(sensor: str) -> str:
    """Return the name of the render variable of a sensor type, such as `DepthSD` for `Depth`."""
    return f"{'LdrColor' if sensor == 'Rgb' else sensor}SD"
