from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.register_assert_rewrite("tests.nodes.isaac", "tests.nodes.harness")

from tests.nodes.harness import Player  # noqa: E402  (what is imported before is not rewritten)


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Player]:
    player = Player(tmp_path)
    yield player
    player.close()
