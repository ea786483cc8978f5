"""The log topic of ROS 2, which `ros2 topic echo /rosout` and rqt_console show."""

from __future__ import annotations

import time

from graphengine.messages import messages
from graphengine.messages.qos import ROSOUT as QOS

__all__ = ["QOS", "TOPIC", "TYPE", "record"]

TOPIC = "/rosout"
TYPE = "rcl_interfaces/msg/Log"

_LEVELS = {"info": messages.Log.INFO, "warning": messages.Log.WARN, "error": messages.Log.ERROR}


def record(namespace: str, node: str, severity: str, text: str) -> bytes:
    """An encoded entry with the present time; severities are info, warning and error."""
    stamp = messages.Time(*divmod(time.time_ns(), 1_000_000_000))
    logger = f"{namespace}/{node}".strip("/").replace("/", ".")
    level = _LEVELS.get(severity, messages.Log.INFO)
    return messages.encode(messages.Log(stamp, level, logger, text, "", "", 0))
