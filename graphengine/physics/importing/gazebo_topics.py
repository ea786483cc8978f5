"""Derives ROS topics from Gazebo's sensors.

New Gazebo writes one `<topic>` in the sensor and makes the names of others from it. Classic Gazebo has plugins, which remap names
(ROS 2), or have a tag for each (ROS 1). Names are relative here, so that the namespace of a robot precedes them.
"""

from __future__ import annotations

import re

from graphengine.physics.importing.gazebo_values import Values

_DEFAULT = {
    "scan": {"topic": "scan"},
    "points": {"topic": "points"},
    "imu": {"topic": "imu"},
    "range": {"topic": "range"},
    "contact": {"topic": "contact"},
    "camera": {"image": "camera/image_raw", "info": "camera/camera_info"},
    "depth_camera": {"depth": "depth/image_raw", "points": "depth/points", "info": "depth/camera_info"},
    "rgbd_camera": {
        "image": "camera/image_raw",
        "depth": "camera/depth/image_raw",
        "points": "camera/depth/points",
        "info": "camera/camera_info",
    },
}
"""Customary topics of each graph in `graphs/publishers`, by parameter."""
_NEW = {
    "points": {"topic": "{topic}/points"},
    "camera": {"image": "{topic}", "info": "{above}camera_info"},
    "depth_camera": {"depth": "{topic}", "points": "{topic}/points", "info": "{above}camera_info"},
    "rgbd_camera": {
        "image": "{topic}/image",
        "depth": "{topic}/depth_image",
        "points": "{topic}/points",
        "info": "{topic}/camera_info",
    },
}
"""Those that new Gazebo makes of a sensor's topic, where it is not the topic itself."""
_CLASSIC = {
    "image": ("image_raw", "imageTopicName|image_topic_name"),
    "depth": ("depth/image_raw", "depthImageTopicName|depth_image_topic_name"),
    "points": ("points", "pointCloudTopicName|point_cloud_topic_name"),
    "info": ("camera_info", "cameraInfoTopicName|camera_info_topic_name"),
    "topic": ("out", "topicName|topic_name|bumperTopicName|bumper_topic_name"),
}
"""Names below a classic camera's, which remappings use, and tags, by parameter."""
_FRAMES = ("gz_frame_id", "ignition_frame_id", "ign_frame_id", "frame_id")
_PLUGIN_FRAMES = ("frameName", "frame_name", "frameId", "frame_id")


def topics(graph: str, values: Values) -> dict[str, str]:
    """Return the topics that a description gives to a sensor, by parameter of its graph; empty if it gives none."""
    defaults = _DEFAULT[graph]
    if topic := legal(values.text("topic") or values.text("contact", "topic") or values.text("camera", "topic")):
        above = topic.rpartition("/")[0]
        values.skip("plugin")  # of classic Gazebo, beside what new Gazebo reads
        patterns = _NEW.get(graph, {"topic": "{topic}"})
        found = {
            name: pattern.format(topic=topic, above=f"{above}/" if above else "") for name, pattern in patterns.items()
        }
        if info := legal(values.text("camera", "camera_info_topic")):
            found["info"] = info
        return {name: found[name] for name in defaults}
    return _of_plugin(defaults, values) if values.find("plugin") is not None else {}


def customary(graph: str) -> dict[str, str]:
    """Return the customary topics of a sensor type, by parameter of its graph."""
    return dict(_DEFAULT[graph])


def frame(values: Values) -> str:
    """Return the frame of a sensor's messages; empty if the description gives none."""
    written = [
        values.text("camera", "optical_frame_id"),
        *(values.text(tag) for tag in _FRAMES),
        *(values.text("camera", tag) for tag in _FRAMES),
        *(values.text("plugin", tag) for tag in _PLUGIN_FRAMES),
    ]
    return next((name for text in written if (name := _legal_frame(text))), "")


def legal(topic: str) -> str:
    """Return a topic as a legal relative name of ROS 2, with '_' for illegal characters; empty for Gazebo's default topic."""
    if topic.strip() == "__default_topic__":
        return ""
    parts = [re.sub(r"[^A-Za-z0-9_]", "_", part) for part in topic.strip().lstrip("~").split("/")]
    return "/".join(f"_{part}" if part[0].isdigit() else part for part in parts if part)[:200].rstrip("/")


def _legal_frame(frame_id: str) -> str:
    parts = re.sub(r"[^A-Za-z0-9_/-]", "_", frame_id.replace("::", "/")).split("/")
    return "/".join(part for part in parts if part)[:200]


def _of_plugin(defaults: dict[str, str], values: Values) -> dict[str, str]:
    remapped = _remappings(values)
    namespace = legal(values.text("plugin", "ros", "namespace") or values.text("plugin", "robotNamespace"))
    camera = values.text("plugin", "camera_name|cameraName")
    found: dict[str, str] = {}
    for name in defaults:
        default, tags = _CLASSIC[name]
        written = values.text("plugin", tags)
        if given := remapped.get(default) or remapped.get(f"{camera}/{default}"):
            topic = given
        elif name == "topic" or written.startswith("/"):
            topic = written
        else:
            topic = f"{camera}/{written or default}" if camera or written else ""
        if namespace and topic and not topic.startswith("/"):
            topic = f"{namespace}/{topic}"
        if not (topic := legal(topic)):
            return {}
        found[name] = topic
    return found


def _remappings(values: Values) -> dict[str, str]:
    """Return new names by remapped name, without `~/`."""
    found: dict[str, str] = {}
    ros = values.find("plugin", "ros")
    for element in ros.children if ros is not None else ():
        old, mapped, new = element.text.partition(":=")
        if element.tag in ("remapping", "argument") and mapped:
            found.setdefault(old.strip().removeprefix("~/").strip("/"), new.strip())
    values.skip("plugin", "ros")
    return found
