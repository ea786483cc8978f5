"""`file` writes a graph file, `bench` makes a graph of a text that runs pass by pass, `play` makes a session."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.compiler.harness import Bench, Play, write

MakeFile = Callable[..., Path]
MakeBench = Callable[..., Bench]
MakePlay = Callable[..., Play]


@pytest.fixture
def file(tmp_path: Path) -> MakeFile:
    return lambda text, name="g.yaml": write(tmp_path, text, name)


@pytest.fixture
def bench(tmp_path: Path) -> MakeBench:
    def make(text: str, *, keep_going: bool = False) -> Bench:
        return Bench(write(tmp_path, text), keep_going=keep_going).setup()

    return make


@pytest.fixture
def play(tmp_path: Path) -> MakePlay:
    def make(*texts: str, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> Play:
        paths = [write(tmp_path, text, f"g{number}.yaml") for number, text in enumerate(texts)]
        return Play(*paths, tick_period=tick_period, substeps=substeps)

    return make
