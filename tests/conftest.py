"""What all tests share."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.ros import needs
from tests.waiting import reserved_domain

pytest.register_assert_rewrite(
    "tests.nodes.isaac", "tests.nodes.harness", "tests.nodes.firing"
)  # before any test imports them

# A script that starts the suite with `&` or nohup leaves Ctrl-C ignored, and all programs that tests start would inherit this.
signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # each program that a test starts would compile all modules anew
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # to start threads takes a third of the time of an import of numpy

# The same examples in each run; `--hypothesis-profile=default` tries others. No limit of time, because machines are shared.
settings.register_profile(
    "tests", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow], database=None
)
settings.load_profile("tests")

SLOW = tuple(
    line for line in Path(__file__).with_name("slow.txt").read_text(encoding="utf-8").splitlines() if line[:1] != "#"
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that `slow.txt` lists: folders, files and functions."""
    for item in items:
        if item.nodeid.startswith(SLOW):
            item.add_marker("slow")


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip a test that is marked `ros` if rclpy, or what its mark names, is missing."""
    if marks := list(item.iter_markers("ros")):
        needs.skip_for(needs.rclpy(), *(reason for mark in marks for reason in mark.args))


@pytest.fixture
def domain_id() -> Iterator[int]:
    with reserved_domain() as number:
        yield number
