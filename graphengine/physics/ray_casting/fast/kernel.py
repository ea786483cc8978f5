"""Casts rays from a common origin against trees of geoms, and finds the nearest surface for each ray.

Neighbouring rays of a lidar hit nearly the same geoms. So rays are grouped in packets: a packet walks a tree once, with the
bounds of its rays' directions, and each ray is tested against the geoms that the packet reaches. The geom that the last ray of
the previous packet hit is tested first, because geoms behind it can then be skipped.

Packets of `WIDE` rays walk the tree of a mesh. How many of its rays reach the same triangles depends on the size and distance of
the triangles and on the angle between the rays, so the work is counted: after `TESTS` tests of boxes and triangles for each ray
of a packet, packets of `NARROW` rays continue where it stopped, and after as many tests again, single rays do.

The result for a ray is the smallest distance over all geoms, and the geom with the lowest id at that distance; it does not
depend on trees and packets. Surfaces are the same as those of `mj_ray`. Rays hit closed surfaces from outside and inside, and
planes only from their front.

Tables are arrays of records, because numba counts references to each array argument.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, Indices
from graphengine.physics.kernels.compiled import kernel, part
from graphengine.physics.ray_casting.fast.table import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HFIELD,
    MESH,
    PLANE,
    SPHERE,
    Records,
)
from graphengine.physics.ray_casting.fast.tree import Tree
from graphengine.physics.ray_casting.own_colliders import PASSED, VISIBLE

Spread = tuple[float, float, float, float, float, float]
"""Inverse bounds of the directions of several rays: 1 / the greatest x, y and z, then 1 / the least x, y and z."""

Vector = tuple[float, float, float]
Roles = NDArray[np.uint8]
Own = tuple[Roles, float]
"""Role of each geom for the rays, and the distance nearer than which they pass through visible geoms of their own robot, m."""
Meshes = tuple[Records, Floats, Records, Floats]
"""Nodes of the trees of all meshes; corners of their triangles; memory for nodes that rays have yet to visit, and for lanes.

A lane is a column for one ray of a packet: its direction in the frame of a mesh (3 rows), the distance beyond which hits do not
matter, and the distance of its first hit on the mesh; infinity if there is none.
"""

PACKET = 32
"""Number of rays that walk a tree of geoms together."""
WIDE, NARROW = 16, 4
"""Numbers of rays that walk the tree of a mesh together."""
TESTS = 6
"""Number of tests of boxes and triangles, per ray, after which a packet in the tree of a mesh is divided."""
WIDEST = 0.5
"""Rays do not walk the tree of a mesh together if a component of their unit vectors differs by this number or more."""

TINY = 1e-15
"""MuJoCo's mjMINVAL: numbers with a smaller magnitude count as zero."""
SEAM = 1e-12
"""Fraction by which triangles extend beyond their edges, so that no ray passes between two neighbours."""
SLACK = 1e-11
"""Fraction by which the cone around a triangle is wider than the triangle; it exceeds `SEAM` and the rounding errors."""

BEAM = np.dtype([("way", "f8", 3), ("distance", "f8"), ("geom", "i8")], align=True)
"""A ray: its unit vector in the world frame, and distance (m) and id of the nearest geom that it has hit so far, or -1."""


@kernel
def cast(
    distances: Floats,
    numbers: Indices,
    directions: Floats,
    origin: Floats,
    rotation: Floats,
    far: float,
    near: float,
    roles: Roles,
    geoms: Records,
    still: Tree,
    moving: Tree,
    triangles: Records,
    corners: Floats,
    stack: Records,
) -> None:
    """Find the first hit of each ray, and write its distance and geom to `distances` and `numbers`.

    Args:
        distances: output, m; -1 for no hit.
        numbers: output, ids of the geoms; -1 for no hit.
        directions: directions of the rays in the sensor's frame, shape (n, 3).
        origin: common origin in the world frame, m.
        rotation: rotation of the sensor in the world, a 3 x 3 matrix.
        far: maximum distance, m.
        near: distance nearer than which rays pass through visible geoms of their own robot, m.
        roles: role of each geom of the model; see `own_colliders`.
        geoms: all geoms of the model, in order.
        still: tree of the static geoms.
        moving: tree of the moving geoms.
        triangles: trees of all meshes, one after the other.
        corners: for each triangle one corner and the two edges from it, in the frame of the mesh, shape (triangles, 9).
        stack: memory from `new_stack`.
    """
    start = (origin[0], origin[1], origin[2])
    own, meshes = (roles, near), (triangles, corners, stack, np.empty((5, PACKET)))
    beyond = np.nextafter(far, math.inf)
    packet = np.empty(PACKET, BEAM)
    guess = -1
    for first in range(0, len(directions), PACKET):
        count = min(PACKET, len(directions) - first)
        _aim(packet, count, directions, first, rotation, beyond)
        if guess >= 0:
            _meet(guess, geoms, own, packet, count, start, meshes)
        spread = _spread(packet, count)
        _walk(still, spread, guess, geoms, own, packet, count, start, meshes)
        _walk(moving, spread, guess, geoms, own, packet, count, start, meshes)
        for index in range(count):
            beam = packet[index]
            distances[first + index] = beam.distance if beam.geom >= 0 else -1.0
            numbers[first + index] = guess = beam.geom


@part
def _aim(packet: Records, count: int, directions: Floats, first: int, rotation: Floats, beyond: float) -> None:
    """Fill a packet with the next rays, rotated to the world frame and without hits."""
    for index in range(count):
        beam = packet[index]
        x, y, z = directions[first + index, 0], directions[first + index, 1], directions[first + index, 2]
        for axis in range(3):
            beam.way[axis] = rotation[axis, 0] * x + rotation[axis, 1] * y + rotation[axis, 2] * z
        beam.distance = beyond
        beam.geom = -1


@part
def _walk(
    tree: Tree,
    spread: Spread,
    met: int,
    geoms: Records,
    own: Own,
    packet: Records,
    count: int,
    start: Vector,
    meshes: Meshes,
) -> None:
    """Test a packet against all geoms of a tree that it may reach, except for the geom `met`, which was tested before."""
    farthest = _farthest(packet, count)
    index = 0
    while index < len(tree):
        node = tree[index]
        if _reach(spread, start, node.low, node.high, farthest) == math.inf:
            index = node.skip
            continue
        if node.item >= 0 and node.item != met and own[0][node.item] != PASSED:
            _meet(node.item, geoms, own, packet, count, start, meshes)
            farthest = _farthest(packet, count)
        index += 1


@part
def _farthest(packet: Records, count: int) -> float:
    """Return the greatest distance of a packet's hits so far; geoms beyond this distance cannot change the result."""
    farthest = 0.0
    for index in range(count):
        farthest = max(farthest, packet[index].distance)
    return farthest


@part
def _spread(packet: Records, count: int) -> Spread:
    """Return the bounds of a packet's directions in the world frame."""
    x, y, z = -math.inf, -math.inf, -math.inf
    u, v, w = math.inf, math.inf, math.inf
    for index in range(count):
        way = packet[index].way
        x, y, z = max(x, way[0]), max(y, way[1]), max(z, way[2])
        u, v, w = min(u, way[0]), min(v, way[1]), min(w, way[2])
    return _over(x, 1.0), _over(y, 1.0), _over(z, 1.0), _over(u, -1.0), _over(v, -1.0), _over(w, -1.0)


@part
def _over(bound: float, outwards: float) -> float:
    """Return 1 / bound; for a bound of 0 a huge number with the sign of `outwards`, which widens the range of directions."""
    return 1.0 / bound if bound != 0.0 else outwards * 1e300


@part
def _reach(spread: Spread, origin: Vector, low: Floats | Vector, high: Floats | Vector, farthest: float) -> float:
    """Return the distance from which rays with directions within the bounds can hit a box; infinity if not within `farthest`.

    At distance t from the origin, the rays span the range from least * t to most * t along each axis. They reach the box where
    most * t >= low and least * t <= high. Each condition bounds t from below or from above, depending on the sign of its factor.
    """
    nearest = 0.0
    for axis in range(3):
        bound = (low[axis] - origin[axis]) * spread[axis]
        if spread[axis] > 0.0:
            nearest = max(nearest, bound)
        else:
            farthest = min(farthest, bound)
        bound = (high[axis] - origin[axis]) * spread[3 + axis]
        if spread[3 + axis] < 0.0:
            nearest = max(nearest, bound)
        else:
            farthest = min(farthest, bound)
    return nearest if nearest <= farthest else math.inf


@part
def _meet(number: int, geoms: Records, own: Own, packet: Records, count: int, start: Vector, meshes: Meshes) -> None:
    """Test all rays of a packet against one geom, in the geom's frame."""
    geom = geoms[number]
    turn, place = geom.rotation, geom.position
    right, up, out = (turn[0], turn[3], turn[6]), (turn[1], turn[4], turn[7]), (turn[2], turn[5], turn[8])
    offset = (start[0] - place[0], start[1] - place[1], start[2] - place[2])
    start = (_dot(right, offset), _dot(up, offset), _dot(out, offset))
    kind = geom.kind
    size = (geom.size[0], geom.size[1], geom.size[2])
    roles, near = own
    nearest = near if roles[number] == VISIBLE else 0.0
    if kind in (MESH, HFIELD):
        _enter_lanes(packet, count, right, up, out, meshes[3])
        _meet_mesh(meshes, geom.mesh, start, count)
        for index in range(count):
            _keep(packet[index], number, meshes[3][4, index], nearest)
        return
    for index in range(count):
        beam = packet[index]
        way = (beam.way[0], beam.way[1], beam.way[2])
        _keep(beam, number, _distance(kind, size, start, (_dot(right, way), _dot(up, way), _dot(out, way))), nearest)


@part
def _keep(beam: Any, number: int, distance: float, nearest: float) -> None:
    """Write a hit to a ray if it is nearer than the hit so far, or as near and on a geom with a lower id."""
    if distance >= nearest and (distance < beam.distance or (distance == beam.distance and number < beam.geom)):
        beam.distance, beam.geom = distance, number


@part
def _enter_lanes(packet: Records, count: int, right: Vector, up: Vector, out: Vector, lanes: Floats) -> None:
    """Write the rays of a packet to lanes; `right`, `up` and `out` are the axes of the mesh in the world frame."""
    for index in range(count):
        beam = packet[index]
        way = (beam.way[0], beam.way[1], beam.way[2])
        lanes[0, index], lanes[1, index], lanes[2, index] = _dot(right, way), _dot(up, way), _dot(out, way)
        lanes[3, index], lanes[4, index] = beam.distance, math.inf


@part
def _distance(kind: int, size: Vector, start: Vector, way: Vector) -> float:
    """Return the distance along a ray to the surface of a geom, in the geom's frame; infinity without a hit."""
    if kind == BOX:
        return _box(size, start, way)
    if kind == CYLINDER:
        return _cylinder(size, start, way)
    if kind == PLANE:
        return _plane(size, start, way)
    if kind == CAPSULE:
        return _capsule(size, start, way)
    if kind == SPHERE:
        return _first(*_roots(_dot(way, way), _dot(way, start), _dot(start, start) - size[0] * size[0]))
    if kind == ELLIPSOID:
        shrunk = (start[0] / size[0], start[1] / size[1], start[2] / size[2])
        along = (way[0] / size[0], way[1] / size[1], way[2] / size[2])
        return _first(*_roots(_dot(along, along), _dot(along, shrunk), _dot(shrunk, shrunk) - 1.0))
    return math.inf


@part
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@part
def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the real roots of a t^2 + 2 b t + c, the smaller one first; infinities if there are none."""
    discriminant = b * b - a * c
    if discriminant < 0.0 or a < TINY:
        return math.inf, math.inf
    root = math.sqrt(discriminant)
    return (-b - root) / a, (-b + root) / a


@part
def _first(near: float, far: float) -> float:
    """Return the smaller of two distances, at which a line enters and leaves a shape, that is not negative; else infinity."""
    if near >= 0.0:
        return near
    return far if far >= 0.0 else math.inf


@part
def _box(size: Vector, start: Vector, way: Vector) -> float:
    near, far = -math.inf, math.inf
    for axis in range(3):
        if abs(way[axis]) > TINY:
            over = 1.0 / way[axis]
            one, other = (-size[axis] - start[axis]) * over, (size[axis] - start[axis]) * over
            near = max(near, min(one, other))
            far = min(far, max(one, other))
        elif abs(start[axis]) > size[axis]:
            return math.inf
    return _first(near, far) if near <= far else math.inf


@part
def _plane(size: Vector, start: Vector, way: Vector) -> float:
    """Return the distance to the front of a plane, whose `size` limits it unless it is 0; infinity without a hit."""
    if way[2] > -TINY or start[2] < 0.0:
        return math.inf
    distance = -start[2] / way[2]
    x, y = start[0] + distance * way[0], start[1] + distance * way[1]
    if (size[0] > 0.0 and abs(x) > size[0]) or (size[1] > 0.0 and abs(y) > size[1]):
        return math.inf
    return distance


@part
def _side(size: Vector, start: Vector, way: Vector) -> float:
    """Return the distance along a ray to the round side of a cylinder whose `size` is radius and half height."""
    across = way[0] * way[0] + way[1] * way[1]
    towards = way[0] * start[0] + way[1] * start[1]
    outside = start[0] * start[0] + start[1] * start[1] - size[0] * size[0]
    distance = _first(*_roots(across, towards, outside))
    return distance if abs(start[2] + distance * way[2]) <= size[1] else math.inf


@part
def _cylinder(size: Vector, start: Vector, way: Vector) -> float:
    distance = _side(size, start, way)
    if abs(way[2]) > TINY:
        for end in (-size[1], size[1]):
            flat = (end - start[2]) / way[2]
            x, y = start[0] + flat * way[0], start[1] + flat * way[1]
            if 0.0 <= flat < distance and x * x + y * y <= size[0] * size[0]:
                distance = flat
    return distance


@part
def _capsule(size: Vector, start: Vector, way: Vector) -> float:
    distance = _side(size, start, way)
    for end in (-1.0, 1.0):
        centre = (start[0], start[1], start[2] - end * size[1])
        for cap in _roots(_dot(way, way), _dot(way, centre), _dot(centre, centre) - size[0] * size[0]):
            if 0.0 <= cap < distance and end * (start[2] + cap * way[2]) >= size[1]:
                distance = cap
    return distance


@part
def _meet_mesh(meshes: Meshes, root: int, start: Vector, count: int) -> None:
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
    return _reach(spread, start, low, high, farthest)


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
    spread = _over(x, 1.0), _over(y, 1.0), _over(z, 1.0), _over(u, -1.0), _over(v, -1.0), _over(w, -1.0)
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
        volume, size = _dot(_cross(a, b), c), max(_dot(a, a), _dot(b, b), _dot(c, c))
        sign = 1.0 if volume >= 0.0 else -1.0
        outside = -SLACK * size if abs(volume) > SLACK * size * math.sqrt(size) else -math.inf
        one, two, three, inside = _cross(a, b), _cross(b, c), _cross(c, a), 0
        for index in range(len(x)):
            way = (x[index], y[index], z[index])
            depth = min(sign * _dot(way, one), sign * _dot(way, two), sign * _dot(way, three))
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
    inverse = (_over(way[0], 1.0), _over(way[1], 1.0), _over(way[2], 1.0))
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
    across = _cross(way, other)
    volume = _dot(one, across)
    if abs(volume) < TINY:
        return math.inf
    offset = (start[0] - corners[row, 0], start[1] - corners[row, 1], start[2] - corners[row, 2])
    u = _dot(offset, across) / volume
    if u < -SEAM or u > 1.0 + SEAM:
        return math.inf
    turned = _cross(offset, one)
    v = _dot(way, turned) / volume
    if v < -SEAM or u + v > 1.0 + SEAM:
        return math.inf
    distance = _dot(other, turned) / volume
    return distance if distance >= 0.0 else math.inf


@part
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
