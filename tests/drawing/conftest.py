"""`drawn` makes the drawing of a graph file and of others beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphengine.drawing import page, svg
from graphengine.drawing.scheme import make_scheme
from graphengine.scene import build

Draw = Callable[..., str]


@pytest.fixture
def drawn(tmp_path: Path) -> Draw:
    def draw(text: str, *, html: bool = False, **others: str) -> str:
        for name, content in {"main": text, **others}.items():
            (tmp_path / f"{name}.yaml").write_text(content, encoding="utf-8")
        assembly = build.load(tmp_path / "main.yaml")
        schemes = [make_scheme(graph, assembly.findings) for graph in assembly.graphs]
        return page.draw(schemes) if html else svg.draw(schemes)

    return draw
