"""Names the helper nodes that publish what Replicator's ROS 2 writers publish in Isaac Sim."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

_WRITER = re.compile(r"(?P<source>.*)ROS2Publish(?P<message>[A-Za-z0-9]+?)(Buffer)?\Z")
_HELPERS: dict[str, str] = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
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
