"""`drawn` makes the drawing of a graph file and of others beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphengine.drawing import page, svg
from graphengine.drawing.view_model import make_graph_view
from graphengine.scene import build

Draw = Callable[..., str]


@pytest.fixture
def drawn(tmp_path: Path) -> Draw:
    def draw(text: str, *, html: bool = False, **others: str) -> str:
        for name, content in {"main": text, **others}.items():
            (tmp_path / f"{name}.yaml").write_text(content, encoding="utf-8")
        assembly = build.load(tmp_path / "main.yaml")
        views = [make_graph_view(graph, assembly.findings) for graph in assembly.graphs]
        return page.draw(views) if html else svg.draw(views)

    return draw
