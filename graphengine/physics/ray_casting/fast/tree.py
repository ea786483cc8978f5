"""Trees of bounding boxes: a ray that misses a box also misses everything in it.

A tree is an array of nodes in depth-first order. To walk a tree, a ray needs only an index. A ray that hits a node's box
continues with the next node, any other ray with the node after the last descendant.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, Indices
from graphengine.physics.kernels.compiled import kernel, part

Tree = NDArray[Any]
"""Array of `NODE` records in depth-first order; the first is the root."""

NODE = np.dtype(
    [
        ("low", "f8", 3),
        ("high", "f8", 3),
        ("skip", "i8"),  # the node after the last descendant
        ("item", "i8"),  # what a leaf holds; -1 for a node with descendants
    ],
    align=True,
)


@kernel
def build(tree: Tree, low: Floats, high: Floats, items: Indices) -> None:
    """Build a tree over n boxes, with one box in each leaf.

    The boxes of a node are split in the middle of the axis along which their centres are spread most.

    Args:
        tree: output, 2 n - 1 nodes.
        low: lower corners of the boxes, shape (n, 3).
        high: upper corners of the boxes.
        items: number to store in the leaf of each box, for example the id of the geom in the box.
    """
    order = np.arange(len(items))
    # The larger part waits while the smaller one is built, so there are never more than log2(n).
    waiting = np.empty((64, 2), np.int64)
    waiting[0] = 0, len(items)
    depth = min(len(items), 1)
    count = 0
    while depth:
        depth -= 1
        first, end = waiting[depth]
        node = tree[count]
        _enclose(node.low, node.high, low, high, order[first:end])
        node.skip = count + 2 * (end - first) - 1
        node.item = items[order[first]] if end - first == 1 else -1
        count += 1
        if end - first > 1:
            middle = first + _split(low, high, order[first:end])
            smaller_first = middle - first < end - middle
            waiting[depth] = (middle, end) if smaller_first else (first, middle)
            waiting[depth + 1] = (first, middle) if smaller_first else (middle, end)
            depth += 2


@part
def _enclose(lowest: Floats, highest: Floats, low: Floats, high: Floats, boxes: Indices) -> None:
    """Write the corners of the smallest box that contains some boxes to `lowest` and `highest`."""
    for axis in range(3):
        least, most = math.inf, -math.inf
        for box in boxes:
            least, most = min(least, low[box, axis]), max(most, high[box, axis])
        lowest[axis], highest[axis] = least, most


@part
def _split(low: Floats, high: Floats, boxes: Indices) -> int:
    """Reorder boxes so that the boxes on the lower side of a dividing plane come first; return the number of these boxes."""
    widest, axis, plane = -1.0, 0, 0.0
    for candidate in range(3):
        least, most = math.inf, -math.inf
        for box in boxes:
            centre = low[box, candidate] + high[box, candidate]
            least, most = min(least, centre), max(most, centre)
        if most - least > widest:
            widest, axis, plane = most - least, candidate, (least + most) / 2
    first, end = 0, len(boxes)
    while first < end:
        box = boxes[first]
        if low[box, axis] + high[box, axis] < plane:
            first += 1
        else:
            end -= 1
            boxes[first], boxes[end] = boxes[end], box
    return first if 0 < first < len(boxes) else len(boxes) // 2
