"""The page in a real browser while files of the run change."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from tests.waiting import PATIENCE

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.view import chromium

ROOT = Path(__file__).parents[2]
pytestmark = chromium.needs_chromium


def test_the_page_shows_changed_graphs_and_another_world(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    graph, scene = tmp_path / "scenes/robots/graphs/dd100/cmd_vel.yaml", tmp_path / "scenes/dd100_flat.yaml"
    graph.parent.mkdir(parents=True)
    text = (ROOT / "graphs/dd100/cmd_vel.yaml").read_text(encoding="utf-8")
    graph.write_text(text, encoding="utf-8")

    def look(page: Any) -> None:
        chromium.until(page, "document.querySelector('[data-node=\"DiffController\"].ran')")
        page.click('[data-node="DiffController"]')
        row = "document.querySelector('tr[data-port=\"DiffController.inputs:maxLinearSpeed\"] input')"
        chromium.until(page, f"{row}?.value === '1.3'")
        changed = text.replace("maxLinearSpeed: 1.3", "maxLinearSpeed: 0.7")
        graph.write_text(changed.replace("nodes:\n", "nodes:\n  Added: ConstantDouble\n", 1), encoding="utf-8")
        sim.submit("reload").result(PATIENCE)
        chromium.until(page, "document.querySelector('[data-node=\"Added\"]')")
        chromium.until(page, "document.querySelector('[data-node=\"DiffController\"].ran')")
        page.click('[data-node="DiffController"]')
        chromium.until(page, f"{row}?.value === '0.7'")
        before = chromium.seconds(page)
        moved = scene.read_text(encoding="utf-8").replace("position: [0", "position: [3")
        scene.write_text(moved, encoding="utf-8")
        assert sim.submit("reload").result(PATIENCE)["restarted"]
        chromium.until(page, f"parseFloat(document.querySelector('#time').innerText) < {before}")
        chromium.until(page, "document.querySelector('[data-node=\"DiffController\"].ran')")

    with ge.load(scene).session() as sim:
        chromium.seen(sim, look)
        assert sim.robots["dd100"].pose.position[0] > 2.9
