"""Finds where rays hit a mesh.

Packets of `WIDE` rays walk the tree of a mesh. How many of its rays reach the same triangles depends on the size and distance of
the triangles and on the angle between the rays, so the work is counted: after `TESTS` tests of boxes and triangles for each ray
of a packet, packets of `NARROW` rays continue where it stopped, and after as many tests again, single rays do.
"""

from __future__ import annotations

import math
from typing import Any

from graphengine.descriptions.engine import Floats
from graphengine.physics.kernels.compiled import part
from graphengine.physics.ray_casting.fast.directions import TINY, Spread, Vector, cross, dot, over, reach
from graphengine.physics.ray_casting.fast.table import Records

Meshes = tuple[Records, Floats, Records, Floats]
"""Nodes of the trees of all meshes; corners of their triangles; memory for nodes that rays have yet to visit, and for lanes.

A lane is a column for one ray of a packet: its direction in the frame of a mesh (3 rows), the distance beyond which hits do not
matter, and the distance of its first hit on the mesh; infinity if there is none.
"""

WIDE, NARROW = 16, 4
"""Numbers of rays that walk the tree of a mesh together."""
TESTS = 6
"""Number of tests of boxes and triangles, per ray, after which a packet in the tree of a mesh is divided."""
WIDEST = 0.5
"""Rays do not walk the tree of a mesh together if a component of their unit vectors differs by this number or more."""
SEAM = 1e-12
"""Fraction by which triangles extend beyond their edges. It prevents rays from passing between two neighbouring triangles."""
SLACK = 1e-11
"""Fraction by which the cone around a triangle is wider than the triangle; it exceeds `SEAM` and the rounding errors."""


@part
def meet_mesh(meshes: Meshes, root: int, start: Vector, count: int) -> None:
    """Write the first hits on a mesh to the first lanes.

    Args:
        meshes: trees, triangles and memory.
        root: index of the root of the mesh's tree.
        start: common origin of the rays in the frame of the mesh.
        count: number of rays.
    """
    nodes, corners, stack, lanes = meshes
    tests = TESTS
    stack[0].node = root
    for first in range(0, count, WIDE):
        end = min(first + WIDE, count)
        top = _walk_mesh(nodes, corners, stack, lanes, start, first, end, 0, 1, tests)
        width = NARROW if tests > 0 else WIDE
        for few in range(first, end if top > 1 else first, width):
            last = min(few + width, end)
            height = _walk_mesh(nodes, corners, stack, lanes, start, few, last, 1, top, tests)
            if height == top:
                continue
            tests = 0  # the next rays will hardly agree more
            for index in range(few, last):
                way = (lanes[0, index], lanes[1, index], lanes[2, index])
                for waiting in range(height - 1, top - 1, -1):
                    distance = _nearest_triangle(meshes, stack[waiting].node, start, way, lanes[3, index], height)
                    if distance <= lanes[3, index]:
                        lanes[3, index] = lanes[4, index] = distance


@part
def _walk_mesh(
    nodes: Records,
    corners: Floats,
    stack: Records,
    lanes: Floats,
    start: Vector,
    first: int,
    end: int,
    bottom: int,
    top: int,
    tests: int,
) -> int:
    """Test the packet of the lanes from `first` to `end` against the subtrees that are on the stack from `bottom` to `top`.

    Returns:
        The height of the stack after at most `tests` tests per lane. The nodes on it from `top` on are left to test.
    """
    (spread, difference), farthest = _lanes_spread(lanes, first, end), _lanes_farthest(lanes, first, end)
    height, tests = top, tests * (end - first) if difference < WIDEST else 0
    for waiting in range(bottom, top):
        height = _push(stack, stack[waiting].node, _enter(nodes[stack[waiting].node], spread, start, farthest), height)
    while height > top:
        height -= 1
        index = stack[height].node if stack[height].entry <= farthest else -1
        while index >= 0:
            node = nodes[index]
            tests -= 1 + node.count
            if tests < 0:
                return _push(stack, index, 0.0, height)
            if node.count > 0:
                farthest = _meet_leaf(corners, lanes, node.first, node.count, start, first, end)
                break
            near, far = node.first, node.first + 1
            entry, later = _enter(nodes[near], spread, start, farthest), _enter(nodes[far], spread, start, farthest)
            if later < entry:
                near, far, entry, later = far, near, later, entry
            height = _push(stack, far, later, height)
            index = near if entry < math.inf else -1
    return top


@part
def _push(stack: Records, node: int, entry: float, height: int) -> int:
    """Put a node on the stack, unless its entry is infinity; return the height of the stack."""
    if entry == math.inf:
        return height
    stack[height].entry, stack[height].node = entry, node
    return height + 1


@part
def _enter(node: Any, spread: Spread, start: Vector, farthest: float) -> float:
    """Return the distance from which rays with directions within the bounds can hit the box of a node of a mesh."""
    low, high = (node.low_x, node.low_y, node.low_z), (node.high_x, node.high_y, node.high_z)
    return reach(spread, start, low, high, farthest)


@part
def _lanes_farthest(lanes: Floats, first: int, end: int) -> float:
    """Return the greatest distance beyond which hits of a packet do not matter."""
    farthest = 0.0
    for index in range(first, end):
        farthest = max(farthest, lanes[3, index])
    return farthest


@part
def _lanes_spread(lanes: Floats, first: int, end: int) -> tuple[Spread, float]:
    """Return the bounds of a packet's directions in the frame of the mesh, and their greatest difference along an axis."""
    x, y, z = -math.inf, -math.inf, -math.inf
    u, v, w = math.inf, math.inf, math.inf
    for index in range(first, end):
        x, y, z = max(x, lanes[0, index]), max(y, lanes[1, index]), max(z, lanes[2, index])
        u, v, w = min(u, lanes[0, index]), min(v, lanes[1, index]), min(w, lanes[2, index])
    spread = over(x, 1.0), over(y, 1.0), over(z, 1.0), over(u, -1.0), over(v, -1.0), over(w, -1.0)
    return spread, max(x - u, y - v, z - w)


@part
def _meet_leaf(corners: Floats, lanes: Floats, row: int, rows: int, start: Vector, first: int, end: int) -> float:
    """Test a packet against the triangles of a leaf; return its new `_lanes_farthest`.

    The planes through the origin and each edge of a triangle bound a cone. Only the rays in a slightly wider cone are tested
    further; all rays are if the origin lies in the plane of the triangle, where there is no cone.
    """
    x, y, z = lanes[0, first:end], lanes[1, first:end], lanes[2, first:end]
    bounds, found = lanes[3, first:end], lanes[4, first:end]
    for triangle in range(row, row + rows):
        a = (corners[triangle, 0] - start[0], corners[triangle, 1] - start[1], corners[triangle, 2] - start[2])
        b = (a[0] + corners[triangle, 3], a[1] + corners[triangle, 4], a[2] + corners[triangle, 5])
        c = (a[0] + corners[triangle, 6], a[1] + corners[triangle, 7], a[2] + corners[triangle, 8])
        volume, size = dot(cross(a, b), c), max(dot(a, a), dot(b, b), dot(c, c))
        sign = 1.0 if volume >= 0.0 else -1.0
        outside = -SLACK * size if abs(volume) > SLACK * size * math.sqrt(size) else -math.inf
        one, two, three, inside = cross(a, b), cross(b, c), cross(c, a), 0
        for index in range(len(x)):
            way = (x[index], y[index], z[index])
            depth = min(sign * dot(way, one), sign * dot(way, two), sign * dot(way, three))
            inside |= (depth >= outside) << index  # no branch, so that several rays are computed at once
        for index in range(len(x) if inside else 0):
            if inside >> index & 1:
                distance = _triangle(corners, triangle, start, (x[index], y[index], z[index]))
                if distance <= bounds[index]:
                    bounds[index] = found[index] = distance
    return _lanes_farthest(lanes, first, end)


@part
def _nearest_triangle(meshes: Meshes, root: int, start: Vector, way: Vector, bound: float, bottom: int) -> float:
    """Return the distance along a ray to the first triangle of a mesh within the distance `bound`; infinity without a hit.

    The ray is given in the frame of the mesh, and tested against a node `root` and its descendants. The stack above `bottom` is
    free.
    """
    nodes, corners, stack, _ = meshes
    inverse = (over(way[0], 1.0), over(way[1], 1.0), over(way[2], 1.0))
    found = math.inf
    if _entry(nodes[root], start, inverse, bound) == math.inf:
        return found
    index, depth = root, bottom
    while index >= 0:
        node = nodes[index]
        if node.count == 0:
            near, far = node.first, node.first + 1
            entry, later = _entry(nodes[near], start, inverse, bound), _entry(nodes[far], start, inverse, bound)
            if later < entry:
                near, far, entry, later = far, near, later, entry
            if later < math.inf:
                stack[depth].entry, stack[depth].node = later, far
                depth += 1
            if entry < math.inf:
                index = near
                continue
        for row in range(node.first, node.first + node.count):
            distance = _triangle(corners, row, start, way)
            if distance <= bound:
                found = bound = distance
        index = -1
        while depth > bottom and index < 0:
            depth -= 1
            if stack[depth].entry <= bound:
                index = stack[depth].node
    return found


@part
def _entry(node: Any, start: Vector, inverse: Vector, bound: float) -> float:
    """Return the distance at which a ray enters the box of a node, 0 inside; infinity if it misses the box within `bound`."""
    one, other = (node.low_x - start[0]) * inverse[0], (node.high_x - start[0]) * inverse[0]
    entry, leave = min(one, other), max(one, other)
    one, other = (node.low_y - start[1]) * inverse[1], (node.high_y - start[1]) * inverse[1]
    entry, leave = max(entry, min(one, other)), min(leave, max(one, other))
    one, other = (node.low_z - start[2]) * inverse[2], (node.high_z - start[2]) * inverse[2]
    entry, leave = max(entry, min(one, other), 0.0), min(leave, max(one, other), bound)
    return entry if entry <= leave else math.inf


@part
def _triangle(corners: Floats, row: int, start: Vector, way: Vector) -> float:
    """Return the distance along a ray to either side of a triangle, by the method of Moller and Trumbore."""
    one = (corners[row, 3], corners[row, 4], corners[row, 5])
    other = (corners[row, 6], corners[row, 7], corners[row, 8])
    across = cross(way, other)
    volume = dot(one, across)
    if abs(volume) < TINY:
        return math.inf
    offset = (start[0] - corners[row, 0], start[1] - corners[row, 1], start[2] - corners[row, 2])
    u = dot(offset, across) / volume
    if u < -SEAM or u > 1.0 + SEAM:
        return math.inf
    turned = cross(offset, one)
    v = dot(way, turned) / volume
    if v < -SEAM or u + v > 1.0 + SEAM:
        return math.inf
    distance = dot(other, turned) / volume
    return distance if distance >= 0.0 else math.inf
