"""The plain layout of large graphs: no box over another, no line through a box, and the library left alone."""

from __future__ import annotations

import random
from itertools import combinations, pairwise

import numpy as np
import pytest

from graphengine.drawing import column_layout, layered_layout, nested_layout
from graphengine.drawing.geometry import Arrangement, LayoutBox, LayoutLink
from graphengine.drawing.view_model import GraphView


def tangle(count: int, seed: int) -> tuple[list[LayoutBox], list[LayoutLink]]:
    chance = random.Random(seed)
    boxes = [LayoutBox(chance.uniform(80, 200), chance.uniform(60, 150)) for _ in range(count)]
    boxes += [LayoutBox(0.0, 2.0, "first"), LayoutBox(0.0, 2.0, "last")]
    links = [LayoutLink(chance.randrange(count), 20.0, chance.randrange(count), 40.0) for _ in range(2 * count)]
    return boxes, [*links, LayoutLink(count, 1.0, 0, 40.0), LayoutLink(0, 20.0, count + 1, 1.0)]


def crossings(boxes: list[LayoutBox], made: Arrangement) -> int:
    low = np.array(made.corners)
    high = low + np.array([(box.width, box.height) for box in boxes])
    ends = [(np.min(pair, axis=0), np.max(pair, axis=0)) for route in made.routes for pair in pairwise(route)]
    return sum(bool(np.all((begin < high - 0.01) & (end > low + 0.01), axis=1).any()) for begin, end in ends)


@pytest.mark.parametrize("seed", range(5))
def test_boxes_stand_apart_and_lines_run_around_them(seed: int) -> None:
    boxes, links = tangle(60, seed)
    made = column_layout.arrange(boxes, links)
    assert crossings(boxes, made) == 0
    assert all(a[0] == b[0] or a[1] == b[1] for route in made.routes for a, b in pairwise(route))
    placed = zip(made.corners, boxes, strict=True)
    outlines = [(x, y, x + box.width, y + box.height) for (x, y), box in placed]
    for one, other in combinations(outlines, 2):
        assert not all(one[axis] < other[axis + 2] and other[axis] < one[axis + 2] for axis in (0, 1))


def test_a_chain_reads_from_left_to_right() -> None:
    made = column_layout.arrange([LayoutBox(100.0, 60.0)] * 5, [LayoutLink(i, 20.0, i + 1, 20.0) for i in range(4)])
    xs = [x for x, _ in made.corners]
    assert xs == sorted(set(xs))


def test_a_link_of_a_box_to_itself_does_not_change_the_order() -> None:
    ports = [(2, 1), (1, 1), (1, 0)]
    made = column_layout.arrange([LayoutBox(100.0, 60.0)] * 3, [LayoutLink(a, 20.0, b, 40.0) for a, b in ports])
    (last, _), (middle, _), (first, _) = made.corners
    assert first < middle < last


def test_the_size_of_a_graph_decides_how_it_is_laid_out() -> None:
    view = GraphView.__new__(GraphView)
    view.nodes, view.wires = [], []
    box, link = LayoutBox(1.0, 1.0), LayoutLink(0, 0.0, 1, 0.0)
    assert nested_layout._way(view, [box] * 100, [link] * 100) is layered_layout.arrange
    assert nested_layout._way(view, [box] * 100, [link] * 101) is column_layout.arrange
