"""`project` is a small scene in a folder of its own, `ship` loads one that ships."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphengine.physics.loaded_world import LoadedWorld
from tests.physics.harness import SHIPPED, Project, load

Ship = Callable[[str], LoadedWorld]


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return Project(tmp_path)


@pytest.fixture
def ship() -> Ship:
    return lambda name: load(SHIPPED / name)
