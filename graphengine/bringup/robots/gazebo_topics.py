"""Derives ROS topics from Gazebo sensors.

In Gazebo Sim, a sensor has one `<topic>`; the names of further topics are derived from this topic. In Gazebo classic, plugins
publish: they remap topics (ROS 2), or have a tag for each topic (ROS 1). All names become relative, because the namespace of a
robot is put before relative names.
"""

from __future__ import annotations

import re

from graphengine.bringup.robots.gazebo_values import GAZEBO_NAMES, Values
from graphengine.descriptions.robot_files.draft import graph_defaults

_NEW = GAZEBO_NAMES["topics"]
"""For graphs and their parameters: patterns of topics that Gazebo Sim derives from a sensor's topic, `{topic}` by default."""
_CLASSIC = GAZEBO_NAMES["classic_topics"]
"""A dict from parameters of graphs to the name below the camera's name, and the tags, of a topic in Gazebo classic."""
_FRAMES = ("gz_frame_id", "ignition_frame_id", "ign_frame_id", "frame_id")
_PLUGIN_FRAMES = ("frameName", "frame_name", "frameId", "frame_id")


def topics(graph: str, values: Values) -> dict[str, str]:
    """Return a dict from the parameters of a sensor's graph to the topics in the description; empty without topics."""
    defaults = customary(graph)
    if topic := legal(values.text("topic") or values.text("contact", "topic") or values.text("camera", "topic")):
        above = topic[: topic.rfind("/") + 1]
        values.skip("plugin")  # for Gazebo classic; Gazebo Sim reads the topic
        patterns = _NEW.get(graph, {"topic": "{topic}"})
        found = {name: pattern.format(topic=topic, above=above) for name, pattern in patterns.items()}
        if info := legal(values.text("camera", "camera_info_topic")):
            found["info"] = info
        return {name: found[name] for name in defaults}
    return _of_plugin(defaults, values) if values.find("plugin") is not None else {}


def customary(graph: str) -> dict[str, str]:
    """Return a dict from the parameters of a graph in `graphs/publishers` to its default topics."""
    defaults = graph_defaults(f"graphs/publishers/{graph}.yaml")
    return {name: default for name, default in defaults.items() if name in _CLASSIC}


def frame(values: Values) -> str:
    """Return the frame of a sensor's messages; empty if the description names none."""
    written = [
        values.text("camera", "optical_frame_id"),
        *(values.text(tag) for tag in _FRAMES),
        *(values.text("camera", tag) for tag in _FRAMES),
        *(values.text("plugin", tag) for tag in _PLUGIN_FRAMES),
    ]
    return next((name for text in written if (name := _legal_frame(text))), "")


def legal(topic: str) -> str:
    """Return a topic as a legal relative ROS 2 name, in which `_` replaces illegal characters; empty for `__default_topic__`."""
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
    """Return a dict from original names, without `~/`, to new names in the remappings of a sensor's plugin."""
    found: dict[str, str] = {}
    ros = values.find("plugin", "ros")
    for element in ros.children if ros is not None else ():
        old, mapped, new = element.text.partition(":=")
        if element.tag in ("remapping", "argument") and mapped:
            found.setdefault(old.strip().removeprefix("~/").strip("/"), new.strip())
    values.skip("plugin", "ros")
    return found
