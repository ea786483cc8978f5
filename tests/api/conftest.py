"""`sim` is a session of the dd100 on a floor; `start` starts one of a graph file without a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.testing import session_fixture
from tests.api import nodes_for_api

Start = Callable[..., ge.Session]

sim = session_fixture("dd100_flat", rays="mujoco")


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    with ExitStack() as sessions:

        def begin(text: str, **arguments: Any) -> ge.Session:
            path = tmp_path / "g.yaml"
            path.write_text(f"graph: g\n{text}", encoding="utf-8")
            return sessions.enter_context(ge.load(path, modules=[nodes_for_api]).session(**arguments))

        yield begin
