"""`ticking` makes a session that shows each tick, `sim` is a paused scene with its services, `runtime` a folder for sockets."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.compiler.harness import Play, write
from tests.control.simulators import Simulator, simulator

MakeTicking = Callable[..., Play]
SHOWS_TIME = """
    nodes: {Tick: Tick, Show: Do}
    connections:
      - Tick.tick -> Show.execIn
      - Tick.time -> Show.a
"""


@pytest.fixture
def ticking(tmp_path: Path) -> MakeTicking:
    def make(text: str = SHOWS_TIME) -> Play:
        return Play(write(tmp_path, text), tick_period=(1, 4))

    return make


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[Simulator]:
    with simulator(tmp_path) as running:
        yield running


@pytest.fixture
def runtime() -> Iterator[dict[str, str]]:
    with tempfile.TemporaryDirectory(prefix="graphrun-") as folder:  # pytest's own are too long for a socket's path
        yield {"XDG_RUNTIME_DIR": folder}
