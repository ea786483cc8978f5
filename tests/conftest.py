"""What all tests share: those that open networks or start programs run one after the other in one of pytest-xdist's processes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.waiting import reserved_domain

pytest.register_assert_rewrite(
    "tests.nodes.isaac", "tests.nodes.harness", "tests.nodes.firing"
)  # before any test imports them

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # each program that a test starts would compile all modules anew
ONE_AT_A_TIME = ("cli", "control", "interop", "jobs", "readme", "ros")


@pytest.fixture
def domain_id() -> Iterator[int]:
    with reserved_domain() as number:
        yield number


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the rooms that share sockets, ROS 2 domains and patience into one group."""
    if not config.pluginmanager.hasplugin("xdist"):
        return
    here = Path(__file__).parent
    for item in items:
        if item.path.is_relative_to(here) and item.path.relative_to(here).parts[0] in ONE_AT_A_TIME:
            item.add_marker(pytest.mark.xdist_group("network"))
