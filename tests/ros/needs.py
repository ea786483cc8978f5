"""What tests of ROS 2 need: `@pytest.mark.ros(program("ros2", "ros2cli"))` skips a test where rclpy or `ros2` is missing.

Each function returns the reason for the skip, or an empty text where nothing is missing. With `-p tests.ros.needs`, pytest
counts at the end how many tests were skipped for each reason.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
from collections import Counter

import pytest

from graphengine.ros.transports.rcl import installation
from graphengine.ros.transports.vendors import CYCLONE_RMW

RMW = os.environ.get("RMW_IMPLEMENTATION") or "rmw_fastrtps_cpp"
"""The RMW that rclpy loads in this process."""


def rclpy() -> str:
    reason = (installation.missing() or "").partition("\n")[0]
    return f"needs rclpy: {reason}" if reason else ""


def module(name: str) -> str:
    return f"needs {name}" if importlib.util.find_spec(name) is None else ""


def types(package: str) -> str:
    return f"needs types of {package}" if importlib.util.find_spec(package) is None else ""


def carried(package: str) -> str:
    """For tests without ends of rclpy's own: rclpy from PyPI has embedded DDS carry the types that it lacks."""
    return "" if installation.is_from_wheels() else types(package)


def program(name: str, package: str) -> str:
    return f"needs {package}" if shutil.which(name) is None else ""


def ros2cli() -> str:
    return program("ros2", "ros2cli")


def cyclone() -> str:
    return "" if RMW == CYCLONE_RMW else f"needs {CYCLONE_RMW}: services do not cross between RMWs"


def fast_dds() -> str:
    return "" if RMW == "rmw_fastrtps_cpp" else "needs rmw_fastrtps_cpp"


def wheels() -> str:
    return "" if rclpy() or installation.is_from_wheels() else "needs rclpy from PyPI"


def sourced() -> str:
    return "" if os.environ.get("AMENT_PREFIX_PATH") else "needs a sourced ROS 2"


def skip_for(*reasons: str) -> None:
    """Skip the running test with the first reason that is not empty."""
    if reason := next(filter(None, reasons), ""):
        pytest.skip(reason)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print how many tests passed, and how many were skipped for each reason."""
    reports = terminalreporter.stats
    skipped = Counter(str(report.longrepr[2]).removeprefix("Skipped: ") for report in reports.get("skipped", []))
    terminalreporter.section("tests against rclpy")
    terminalreporter.write_line(f"{len(reports.get('passed', []))} passed, {skipped.total()} skipped")
    for reason, number in skipped.most_common():
        terminalreporter.write_line(f"{number:5} {reason}")
