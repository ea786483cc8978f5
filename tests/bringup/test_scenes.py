"""Maps of scenes that are loaded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine import bringup


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("dd100_flat", rays="mujoco")


def test_an_occupancy_map_is_an_array_and_the_files_that_graphrun_map_writes(scene: ge.Scene, tmp_path: Path) -> None:
    area: dict[str, Any] = {"bounds": ((-2.0, -1.0), (2.0, 1.0)), "cell": 0.5}
    floor = bringup.occupancy_map(scene, tmp_path / "floor", **area)
    assert (floor.cells == 0).all()
    assert floor.cells.shape == (4, 8)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["floor.png", "floor.yaml"]
    around = bringup.occupancy_map(scene, **area, heights=(0.05, 0.62), include=["/dd100"], free=[(1.5, 0.5)])
    assert around.cells[2, 4] == 100
    assert bringup.occupancy_map(scene, **area, heights=(0.5, 1.0), convention="isaac").window == (0.25, 1.25)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"cell": 0.0}, "cell: 0 m is less than 0.0001 m"),
        ({"heights": (0.62, 0.2)}, "z: the lower bound 0.62 is not below the upper bound 0.2"),
        ({"image": "jpg"}, "image: unknown value 'jpg'; legal: png, pgm"),
        ({"convention": "isac"}, "convention: unknown value 'isac'; legal: ros, isaac"),
    ],
)
def test_illegal_map_arguments_are_refused(scene: ge.Scene, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ge.UsageError) as caught:
        bringup.occupancy_map(scene, **arguments)
    assert words in str(caught.value)


def test_a_graph_without_a_scene_has_no_map() -> None:
    with pytest.raises(ge.UsageError, match="without a scene and has no world"):
        bringup.occupancy_map(ge.load("clock"))
