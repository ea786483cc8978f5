"""Computes the occupancy map of a scene: its obstacles, its extent and its free cells.

Obstacles are static geoms; robots and movable bodies are left out unless the request includes them. Free cells can be reached
from a seed, such as the position of a robot. All other cells that are not occupied, such as the outside of a hall, are unknown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Bools, Indices, body_names, collides, mujoco
from graphengine.format.errors import UsageError
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.occupancy.flood_fill import reached
from graphengine.physics.occupancy.grid import Canvas, Grid, Window
from graphengine.physics.occupancy.shapes import shapes
from graphengine.physics.ray_casting.casters import visible_geoms

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""The states of a cell, with the values that nav_msgs/OccupancyGrid uses."""

MOST_CELLS = 25_000_000
"""Greatest number of cells in a map, e.g. 250 m x 250 m in cells of 0.05 m; this map takes some seconds and 0.8 GB of memory."""
SMALLEST_CELL = 1e-4
"""Smallest side of a cell, m."""
FARTHEST = 1e6
"""Greatest magnitude of a coordinate, m; with greater coordinates, rounding errors exceed the margin between touching and
overlap."""

Point = tuple[float, float]
Rectangle = tuple[Point, Point]
"""The south-west and the north-east corner of a rectangle, m."""


class NoObstaclesError(UsageError):
    """A map was requested without bounds, and the scene has no obstacles from which the bounds can be computed."""


@dataclass(frozen=True, slots=True)
class OccupancyMap:
    """The occupancy map of a scene.

    Attributes:
        grid: position and number of the cells.
        window: height range in which bodies are obstacles, m.
        cells: OCCUPIED, FREE or UNKNOWN, shape (rows, columns), southernmost row first.
    """

    grid: Grid
    window: Window
    cells: NDArray[np.int8]

    def share(self, state: int) -> float:
        """Return the fraction of cells that are in the given state, 0 to 1."""
        return float(np.mean(self.cells == state))


@dataclass(frozen=True, slots=True)
class MapRequest:
    """The parameters of an occupancy map.

    Attributes:
        window: height range in which a body is an obstacle, m.
        cell: side of a cell, m.
        bounds: area of the map, rounded outwards to cells; None for the rectangle around the prims in `select`.
        select: paths of the prims that the map covers; if empty, the map covers all obstacles.
        origin: a point at which cells have a corner.
        seeds: points in free space from which the free area is filled; if empty, the position of the first robot.
        include: paths of robots or movable bodies that count as obstacles in their initial pose.
        exclude: paths of prims that do not count as obstacles.

    Raises:
        UsageError: a parameter has an illegal value.
    """

    window: Window
    cell: float
    bounds: Rectangle | None = None
    select: Sequence[str] = ()
    origin: Point = (0.0, 0.0)
    seeds: Sequence[Point] = ()
    include: Sequence[str] = ()
    exclude: Sequence[str] = ()

    def __post_init__(self) -> None:
        (low, high), corners = self.window, self.bounds or ((0.0, 0.0), (1.0, 1.0))
        points = [number for point in (*corners, self.origin, *self.seeds) for number in point]
        if not all(abs(number) <= FARTHEST for number in (*points, low, high, self.cell)):
            raise UsageError(f"coordinates of a map must be finite and at most {FARTHEST:g} m")
        if low >= high:
            raise UsageError(f"z: the lower bound {low:g} is not below the upper bound {high:g}")
        if self.cell < SMALLEST_CELL:
            text = f"cell: {self.cell:g} m is less than {SMALLEST_CELL:g} m"
            raise UsageError(f"{text}; give the size in metres, such as 0.05")
        for name, first, last in zip("xy", *corners, strict=True):
            if first >= last:
                raise UsageError(f"bounds: the smallest {name}, {first:g}, is not below the largest, {last:g}")


def make_map(world: LoadedWorld, request: MapRequest) -> OccupancyMap:
    """Return the map of a scene in its initial state.

    Raises:
        UsageError: the map cannot be made, because all cells are occupied, there are too many cells, no obstacles give the
            extent, a seed is not free, or a prim has no geometry.
        PrimError: a requested prim does not exist.
    """
    model, data = world.simulation.model, world.simulation.data
    geoms = _obstacles(world, request)
    grid = Grid.around(*(request.bounds or _bounds(world, request.select, geoms)), request.cell, request.origin)
    _check_size(grid)
    canvas = Canvas(grid)
    for shape in shapes(model, data, geoms):
        shape.draw(canvas, request.window)
    occupied = canvas.occupied()
    if occupied.all():
        floor = f"a floor above z = {request.window[0]:g} m, the lower end of the height range, counts as an obstacle"
        raise UsageError(f"every cell of the map is occupied\n  {floor}")
    seeds = [_seed(grid, occupied, *point) for point in request.seeds or [_first_robot(world)]]
    cells = np.full(occupied.shape, UNKNOWN, np.int8)
    cells[reached(~occupied, seeds)] = FREE
    cells[occupied] = OCCUPIED
    return OccupancyMap(grid, request.window, cells)


def _check_size(grid: Grid) -> None:
    cells = grid.columns * grid.rows
    if cells > MOST_CELLS:
        fitting = grid.cell * math.sqrt(cells / MOST_CELLS)
        remedy = f"use cells of at least {fitting * 1.01:.2g} m, or smaller bounds"
        text = f"{grid.columns} x {grid.rows} cells are more than the {MOST_CELLS} that a map may have"
        raise UsageError(f"{text}\n  {remedy}")


def _obstacles(world: LoadedWorld, request: MapRequest) -> Indices:
    """Return the ids of the geoms that count as obstacles for a request."""
    model = world.simulation.model
    robots = tuple(f"{robot}/" for robot in world.robots)
    still = np.array([not name.startswith(robots) for name in body_names(model)]) & (model.body_weldid == 0)
    chosen: Bools = _there(model) & still[model.geom_bodyid]
    for path in request.include:
        chosen[_geoms(world, path)] = True
    for path in request.exclude:
        chosen[_geoms(world, path)] = False
    return np.flatnonzero(chosen)


def _there(model: mujoco.MjModel) -> Bools:
    """Return for each geom whether rays can hit it or bodies can collide with it."""
    there = collides(model)
    there[visible_geoms(model)] = True
    return there


def _geoms(world: LoadedWorld, path: str) -> Indices:
    """Return the ids of the geoms of a prim and of all prims below it; raise UsageError if there are none."""
    model, prim = world.simulation.model, world.stage.find(path)
    parts = {part.body for part in prim.descendants()}
    bodies = [body for body, name in enumerate(body_names(model)) if name in parts]
    if prim.path in ("/", "/World"):  # the geoms of MuJoCo's `worldbody`, which has no prim of its own, lie there
        bodies.append(0)
    geoms: Indices = np.flatnonzero(_there(model) & np.isin(model.geom_bodyid, bodies))
    if not len(geoms):
        raise UsageError(f"{prim.path} has no geometry that can be an obstacle")
    return geoms


def _bounds(world: LoadedWorld, select: Sequence[str], obstacles: Indices) -> Rectangle:
    """Return the rectangle around the selected prims, or around all obstacles if none are selected; ignore infinite planes."""
    chosen = np.unique(np.concatenate([_geoms(world, path) for path in select])) if select else obstacles
    rectangles = [shape.bounds() for shape in shapes(world.simulation.model, world.simulation.data, chosen)]
    west, south = (min((float(low[axis]) for low, _ in rectangles), default=math.inf) for axis in (0, 1))
    east, north = (max((float(high[axis]) for _, high in rectangles), default=-math.inf) for axis in (0, 1))
    if not (west <= east and south <= north):
        raise NoObstaclesError("no obstacles determine the map; give its bounds: --bounds XMIN YMIN XMAX YMAX")
    return (west, south), (east, north)


def _first_robot(world: LoadedWorld) -> Point:
    """Return the position of the first robot; the origin in a scene without robots."""
    for robot in world.robots.values():
        (x, y, _), _ = world.simulation.body(world.stage.find(robot.prim_path)).pose()
        return x, y
    return 0.0, 0.0


def _seed(grid: Grid, occupied: Bools, x: float, y: float) -> tuple[int, int]:
    """Return row and column of the cell that contains a seed; raise UsageError if the cell is not free."""
    cell = grid.locate(x, y)
    if cell is None:
        extent = f"the map covers x {grid.west:g} to {grid.east:g}, y {grid.south:g} to {grid.north:g}"
        raise UsageError(f"the free point ({x:g}, {y:g}) lies outside of the map\n  {extent}")
    if not occupied[cell]:
        return cell
    rows, columns = np.nonzero(~occupied)
    nearest = int(np.argmin((rows - cell[0]) ** 2 + (columns - cell[1]) ** 2))
    near_x, near_y = (round(value, 6) for value in grid.centre(int(rows[nearest]), int(columns[nearest])))
    remedy = f"the nearest free point is ({near_x:.10g}, {near_y:.10g})"
    raise UsageError(f"the free point ({x:g}, {y:g}) is occupied\n  {remedy}")
