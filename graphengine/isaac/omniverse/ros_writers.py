"""Names the helper nodes that publish what Replicator's ROS 2 writers publish in Isaac Sim."""

from __future__ import annotations

import re
from typing import Any

_WRITER = re.compile(r"(?P<source>.*)ROS2Publish(?P<message>[A-Za-z0-9]+?)(Buffer)?\Z")
_CAMERA = "ROS2CameraHelper with `type: {}`"
_BOXES = {"BoundingBox2DTight": "bbox_2d_tight", "BoundingBox2DLoose": "bbox_2d_loose", "BoundingBox3D": "bbox_3d"}
_IMAGES = {
    "DistanceTo": "depth",
    "Depth": "depth",
    "InstanceSegmentation": "instance_segmentation",
    "SemanticSegmentation": "semantic_segmentation",
}
"""Values of `type` of ROS2CameraHelper, by the beginning of the name of the writer's render variable; others are `rgb`."""
_NODES = {
    "CameraInfo": "ROS2CameraInfoHelper",
    "LaserScan": "ROS2RtxLidarHelper with `type: laser_scan`",
    "SemanticLabels": "ROS2CameraHelper with `enableSemanticLabels: true`",
}


def is_ros_writer(name: Any) -> bool:
    """Return whether a text is the name of a ROS 2 writer, such as `RtxLidarROS2PublishPointCloud`."""
    return isinstance(name, str) and _WRITER.match(name) is not None


def helper_node(writer: str) -> str:
    """Return the node type, with the input that selects the message, that publishes the same messages as a ROS 2 writer."""
    found = _WRITER.match(writer)
    source, message = (found["source"], found["message"]) if found else ("", "")
    if message in _NODES:
        return _NODES[message]
    if message == "PointCloud" and source.startswith("RtxRadar"):
        return "ROS2RtxRadarHelper"
    if message == "PointCloud":
        return (
            "ROS2RtxLidarHelper with `type: point_cloud`" if source.startswith("Rtx") else _CAMERA.format("depth_pcl")
        )
    kinds = _BOXES | _IMAGES
    return _CAMERA.format(next((kinds[start] for start in kinds if source.startswith(start)), "rgb"))


def render_variable(sensor: str) -> str:
    """Return the name of the render variable of a sensor type, such as `DepthSD` for `Depth`."""
    return f"{'LdrColor' if sensor == 'Rgb' else sensor}SD"
