"""The transport over DDS without ROS."""

import importlib

from graphengine.format.errors import TransportError

try:
    importlib.import_module("cyclonedds")
except ImportError as error:
    where = "PyPI has it for Linux on x86_64, for macOS and for Windows, and for Python 3.11 to 3.13"
    remedy = "source a ROS 2 and use --transport rclpy, or do without a network: --transport memory"
    raise TransportError(f"dds needs cyclonedds, which cannot be imported: {error}\n{where}\n{remedy}") from None
