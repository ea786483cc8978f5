"""Casts rays from a common origin against trees of geoms, and finds the nearest surface for each ray.

Neighbouring rays of a lidar hit nearly the same geoms. So rays are grouped in packets: a packet walks a tree once, with the
bounds of its rays' directions, and each ray is tested against the geoms that the packet reaches. The geom that the last ray of
the previous packet hit is tested first, because geoms behind it can then be skipped.

The result for a ray is the smallest distance over all geoms, and the geom with the lowest id at that distance; it does not
depend on trees and packets. Rays hit closed surfaces from outside and inside, and planes only from their front.

Tables are arrays of records, because numba counts references to each array argument.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, Indices
from graphengine.physics.kernels.compiled import kernel_of, part
from graphengine.physics.ray_casting import own_colliders
from graphengine.physics.ray_casting.fast import directions, mesh_walk, shapes, table
from graphengine.physics.ray_casting.fast.directions import Spread, Vector, dot, over, reach
from graphengine.physics.ray_casting.fast.mesh_walk import Meshes, meet_mesh
from graphengine.physics.ray_casting.fast.shapes import distance_to
from graphengine.physics.ray_casting.fast.table import HFIELD, MESH, Records
from graphengine.physics.ray_casting.fast.tree import Tree
from graphengine.physics.ray_casting.own_colliders import PASSED, VISIBLE

Roles = NDArray[np.uint8]
Own = tuple[Roles, float]
"""Role of each geom for the rays, and the distance nearer than which they pass through visible geoms of their own robot, m."""

PACKET = 32
"""Number of rays that walk a tree of geoms together."""

BEAM = np.dtype([("way", "f8", 3), ("distance", "f8"), ("geom", "i8")], align=True)
"""A ray: its unit vector in the world frame, and distance (m) and id of the nearest geom that it has hit so far, or -1."""


@kernel_of(directions, mesh_walk, own_colliders, shapes, table)
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
        if reach(spread, start, node.low, node.high, farthest) == math.inf:
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
    return over(x, 1.0), over(y, 1.0), over(z, 1.0), over(u, -1.0), over(v, -1.0), over(w, -1.0)


@part
def _meet(number: int, geoms: Records, own: Own, packet: Records, count: int, start: Vector, meshes: Meshes) -> None:
    """Test all rays of a packet against one geom, in the geom's frame."""
    geom = geoms[number]
    turn, place = geom.rotation, geom.position
    right, up, out = (turn[0], turn[3], turn[6]), (turn[1], turn[4], turn[7]), (turn[2], turn[5], turn[8])
    offset = (start[0] - place[0], start[1] - place[1], start[2] - place[2])
    start = (dot(right, offset), dot(up, offset), dot(out, offset))
    kind = geom.kind
    size = (geom.size[0], geom.size[1], geom.size[2])
    roles, near = own
    nearest = near if roles[number] == VISIBLE else 0.0
    if kind in (MESH, HFIELD):
        _enter_lanes(packet, count, right, up, out, meshes[3])
        meet_mesh(meshes, geom.mesh, start, count)
        for index in range(count):
            _keep(packet[index], number, meshes[3][4, index], nearest)
        return
    for index in range(count):
        beam = packet[index]
        way = (beam.way[0], beam.way[1], beam.way[2])
        _keep(beam, number, distance_to(kind, size, start, (dot(right, way), dot(up, way), dot(out, way))), nearest)


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
        lanes[0, index], lanes[1, index], lanes[2, index] = dot(right, way), dot(up, way), dot(out, way)
        lanes[3, index], lanes[4, index] = beam.distance, math.inf
