"""Builds trees of the triangles of meshes. A ray walks a tree from the nearer to the farther child.

The trees are split by the surface area heuristic: the expected number of tests is the smallest where the areas of both parts,
each times the number of its triangles, have the smallest sum.

A tree is an array of nodes; both children of a node are neighbours, so that they are read together.
"""

from __future__ import annotations

import math

import numpy as np

from graphengine.descriptions.engine import Floats, Indices
from graphengine.physics.kernels.compiled import kernel, part
from graphengine.physics.ray_casting.fast.table import Records

LEAF = 4
"""Maximum number of triangles in a leaf."""
BINS = 16
"""Number of parts of a node's extent between which a split is considered, along each axis."""
DEEP = 64
"""Depth from which nodes are split in equal halves."""
DEEPEST = DEEP + 32
"""Maximum depth of a tree."""

MESH_NODE = np.dtype(
    [
        *((name, "f8") for name in ("low_x", "low_y", "low_z", "high_x", "high_y", "high_z")),
        ("first", "i4"),  # the first of its two children, or the row of a leaf's first triangle
        ("count", "i4"),  # number of a leaf's triangles; 0 for a node with children
    ],
    align=True,
)


WAITING = np.dtype([("entry", "f8"), ("node", "i8")], align=True)
"""A node that rays have yet to visit, and a distance before which they do not enter its box, m."""


def new_stack() -> Records:
    """Return memory for the nodes that a wide packet, a narrow packet and a single ray have yet to visit."""
    return np.empty(3 * (DEEPEST + 1), WAITING)


@kernel
def build_mesh_tree(nodes: Records, low: Floats, high: Floats, order: Indices) -> int:
    """Build the tree of n triangles and return its number of nodes.

    Args:
        nodes: output, at least 2 n - 1 nodes; indices count from the first node and the first triangle.
        low: lower corners of the triangles' boxes, shape (n, 3).
        high: upper corners.
        order: output, the triangles in the order in which the leaves refer to them; initially 0 to n - 1.
    """
    waiting = np.empty((DEEPEST, 4), np.int64)
    counts, boxes = np.empty(BINS, np.int64), np.empty((BINS, 6))
    above_cost = np.empty(BINS)
    box, centres = np.empty(6), np.empty(6)
    waiting[0] = 0, 0, len(order), 0
    depth, used = 1, 1
    while depth:
        depth -= 1
        index, first, end, level = waiting[depth]
        node = nodes[index]
        _enclose(box, centres, low, high, order, first, end)
        node.low_x, node.low_y, node.low_z = box[0], box[1], box[2]
        node.high_x, node.high_y, node.high_z = box[3], box[4], box[5]
        if end - first <= LEAF:
            node.first, node.count = first, end - first
            continue
        middle = 0
        if level < DEEP:
            middle = _split(low, high, order, first, end, centres, counts, boxes, above_cost)
        if not first < middle < end:
            middle = (first + end) // 2
        node.first, node.count = used, 0
        # The larger part waits longer, so that few nodes wait at once.
        left = middle - first < end - middle
        waiting[depth] = (used + 1, middle, end, level + 1) if left else (used, first, middle, level + 1)
        waiting[depth + 1] = (used, first, middle, level + 1) if left else (used + 1, middle, end, level + 1)
        depth, used = depth + 2, used + 2
    return used


@part
def _enclose(box: Floats, centres: Floats, low: Floats, high: Floats, order: Indices, first: int, end: int) -> None:
    """Write the bounds of some triangles, and the bounds of twice the centres of their boxes: low x, y, z, high x, y, z."""
    box[:3], box[3:], centres[:3], centres[3:] = math.inf, -math.inf, math.inf, -math.inf
    for place in range(first, end):
        row = order[place]
        for axis in range(3):
            least, most = low[row, axis], high[row, axis]
            box[axis], box[3 + axis] = min(box[axis], least), max(box[3 + axis], most)
            centres[axis] = min(centres[axis], least + most)
            centres[3 + axis] = max(centres[3 + axis], least + most)


@part
def _split(
    low: Floats,
    high: Floats,
    order: Indices,
    first: int,
    end: int,
    centres: Floats,
    counts: Indices,
    boxes: Floats,
    above_cost: Floats,
) -> int:
    """Reorder triangles so that those on the lower side of the cheapest plane come first; return where the others begin.

    The result is outside of (first, end) if all centres coincide.
    """
    cheapest, split_axis, split = math.inf, -1, 0
    for axis in range(3):
        extent = centres[3 + axis] - centres[axis]
        if extent <= 0.0:
            continue
        counts[:] = 0
        boxes[:, :3], boxes[:, 3:] = math.inf, -math.inf
        for place in range(first, end):
            row = order[place]
            number = _bin(low[row, axis] + high[row, axis], centres[axis], extent)
            counts[number] += 1
            for other in range(3):
                boxes[number, other] = min(boxes[number, other], low[row, other])
                boxes[number, 3 + other] = max(boxes[number, 3 + other], high[row, other])
        x, y, z, u, v, w, count = math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf, 0
        for number in range(BINS - 1, 0, -1):
            part_box = boxes[number]
            x, y, z = min(x, part_box[0]), min(y, part_box[1]), min(z, part_box[2])
            u, v, w = max(u, part_box[3]), max(v, part_box[4]), max(w, part_box[5])
            count += counts[number]
            above_cost[number] = count * _area(u - x, v - y, w - z) if count else math.inf
        x, y, z, u, v, w, count = math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf, 0
        for number in range(BINS - 1):
            part_box = boxes[number]
            x, y, z = min(x, part_box[0]), min(y, part_box[1]), min(z, part_box[2])
            u, v, w = max(u, part_box[3]), max(v, part_box[4]), max(w, part_box[5])
            count += counts[number]
            if count:
                cost = count * _area(u - x, v - y, w - z) + above_cost[number + 1]
                if cost < cheapest:
                    cheapest, split_axis, split = cost, axis, number
    if split_axis < 0:
        return first
    extent = centres[3 + split_axis] - centres[split_axis]
    while first < end:
        row = order[first]
        if _bin(low[row, split_axis] + high[row, split_axis], centres[split_axis], extent) <= split:
            first += 1
        else:
            end -= 1
            order[first], order[end] = order[end], row
    return first


@part
def _bin(centre: float, least: float, extent: float) -> int:
    return min(BINS - 1, int((centre - least) / extent * BINS))


@part
def _area(x: float, y: float, z: float) -> float:
    return x * y + y * z + z * x
