"""Replicator's ROS 2 writers: each lost topic is reported with the helper node that publishes it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from graphengine.compiler.registry import default_registry
from tests.isaac.harness import read_text

START = """\
import omni.graph.core as og
import omni.replicator.core as rep
import omni.syntheticdata
import omni.syntheticdata._syntheticdata as sd
from isaacsim.sensors.rtx import LidarRtx
og.Controller.edit("/G", {"create_nodes": ("a", "x.A")})
def variable(sensor):
    return omni.syntheticdata.SyntheticData.convert_sensor_type_to_rendervar(sensor.name)
"""
WRITERS = {
    "variable(sd.SensorType.Rgb) + 'ROS2PublishImage'": ("ROS2CameraHelper", "type", "rgb"),
    "variable(sd.SensorType.DistanceToImagePlane) + 'ROS2PublishImage'": ("ROS2CameraHelper", "type", "depth"),
    "variable(sd.SensorType.DistanceToImagePlane) + 'ROS2PublishPointCloud'": ("ROS2CameraHelper", "type", "depth_pcl"),
    "f'{variable(sd.SensorType.InstanceSegmentation)}ROS2PublishImage'": (
        "ROS2CameraHelper",
        "type",
        "instance_segmentation",
    ),
    "variable(sd.SensorType.BoundingBox2DTight) + 'ROS2PublishBoundingBox2D'": (
        "ROS2CameraHelper",
        "type",
        "bbox_2d_tight",
    ),
    "'LdrColorSDROS2PublishImage'": ("ROS2CameraHelper", "type", "rgb"),
    "'ROS2PublishCameraInfo'": ("ROS2CameraInfoHelper",),
    "'ROS2PublishSemanticLabels'": ("ROS2CameraHelper", "enableSemanticLabels", "true"),
    "'RtxLidar' + 'ROS2PublishLaserScan'": ("ROS2RtxLidarHelper", "type", "laser_scan"),
    "'RtxLidarROS2PublishPointCloudBuffer'": ("ROS2RtxLidarHelper", "type", "point_cloud"),
    "'RtxRadarROS2PublishPointCloud'": ("ROS2RtxRadarHelper",),
}
USES = (
    "writer = rep.writers.get({})\nwriter.initialize(topicName='/top', frameId='f')\nwriter.attach(['/Render/r'])",
    "writer = rep.WriterRegistry.get({})\nwriter.initialize(\n  topicName='/top')\nwriter.attach('/Render/r')",
    "lidar = LidarRtx('/World/l')\nlidar.attach_writer({}, topicName='/top')",
)


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("name", WRITERS)
def test_the_topic_of_a_writer_is_told_with_the_node_that_publishes_it(name: str, use: str, tmp_path: Path) -> None:
    _, (warning,), findings = read_text(tmp_path, use.format(name), START)
    assert re.match(r"[1-4]: the topic '/top' that the writer \w*ROS2Publish\w+ publishes is left out", warning)
    ((advice,),) = [finding.help for finding in findings.warnings]
    words = re.findall(r"\w+", advice)
    assert words[1:].index(WRITERS[name][0]) == 0
    assert all(word in words for word in WRITERS[name])
    assert not [note.message for note in findings.items if "writer" in note.message and note.code == "N302"]


@pytest.mark.parametrize("node", sorted(set(WRITERS.values())))
def test_the_node_that_is_named_has_that_input_and_value(node: tuple[str, ...]) -> None:
    found = default_registry().find(node[0])
    assert found is not None
    if node[1:2] == ("type",):
        assert node[2] in (found.cls.ports["inputs:type"].tokens or ())
    elif node[1:]:
        assert str(found.cls.ports[f"inputs:{node[1]}"].type) == "bool"


def test_a_namespace_is_part_of_the_lost_topic(tmp_path: Path) -> None:
    text = "rep.writers.get('ROS2PublishImage').initialize(nodeNamespace='robot', topicName='rgb')"
    _, (warning,), _ = read_text(tmp_path, text, START)
    assert warning.startswith("1: the topic 'robot/rgb' that")
