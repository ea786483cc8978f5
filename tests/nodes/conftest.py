from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from graphengine.testing import RecordingContext
from tests.nodes.harness import Player

# Machines are shared, so an example may take its time; and a failure is the same wherever it is looked at.
settings.register_profile("nodes", deadline=None, derandomize=True, database=None)
settings.load_profile("nodes")


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Player]:
    player = Player(tmp_path)
    yield player
    player.close()


@pytest.fixture
def context() -> RecordingContext:
    """The context of a node alone."""
    return RecordingContext()
