"""A graph file names the scene in which it runs as the command line does."""

from __future__ import annotations

from pathlib import Path

from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

GRAPH = "graph: alone\nscene: {scene}\nnodes:\n  Tick: OnPlaybackTick\nconnections: []\n"


def test_an_included_scene_is_found_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "alone.yaml"
    for name in ("dd100_flat", "dd100_flat.yaml", "tutorial/flat_grid"):
        path.write_text(GRAPH.format(scene=name), encoding="utf-8")
        scene = build.load(path, Options())
        assert not scene.findings.errors, scene.findings.errors
        assert scene.world is not None


def test_a_file_beside_the_graph_takes_precedence_over_an_included_scene(tmp_path: Path) -> None:
    (tmp_path / "dd100_flat.yaml").write_text("scene: mine\nworld: worlds/flat_grid.xml\n", encoding="utf-8")
    path = tmp_path / "alone.yaml"
    path.write_text(GRAPH.format(scene="dd100_flat.yaml"), encoding="utf-8")
    world = build.load(path, Options()).world
    assert world is not None
    assert not world.robots
