from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.testing import RecordingContext
from tests.nodes.harness import Player


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Player]:
    player = Player(tmp_path)
    yield player
    player.close()


@pytest.fixture
def context() -> RecordingContext:
    """The context of a node alone."""
    return RecordingContext()
