"""Occupancy map of a scene: its obstacles, extent and free cells.

Obstacles are what stands still: robots and bodies that can move are left out. Free is what can be reached from a seed, such as
where a robot stands; what is neither an obstacle nor reached, such as the outside of a hall, is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphengine.format.errors import UsageError
from graphengine.physics.engine import Bools, Indices, body_names, collides, mujoco
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.occupancy.flood_fill import reached
from graphengine.physics.occupancy.grid import Canvas, Grid, Window
from graphengine.physics.occupancy.shapes import shapes
from graphengine.physics.sensors.rays import visible_geoms

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""As in nav_msgs/OccupancyGrid."""

MOST_CELLS = 25_000_000
"""250 m x 250 m in cells of 0.05 m, which take some seconds and 0.8 GB."""
SMALLEST_CELL = 1e-4
"""m."""
FARTHEST = 1e6
"""m: beyond, the margin by which touching is told from overlapping drowns in rounding."""

Point = tuple[float, float]
Rectangle = tuple[Point, Point]
"""The corners in the south-west and in the north-east."""


@dataclass(frozen=True, slots=True)
class OccupancyMap:
    """A floor plan; `cells` is (rows, columns), the first row in the south, of OCCUPIED, FREE and UNKNOWN."""

    grid: Grid
    window: Window
    cells: NDArray[np.int8]

    def share(self, state: int) -> float:
        """The fraction of cells in a state."""
        return float(np.mean(self.cells == state))


@dataclass(frozen=True, slots=True)
class MapRequest:
    """Parameters of a map.

    Attributes:
        window: heights between which a body is an obstacle, m.
        cell: side of a cell, m.
        bounds: what the map covers, rounded outwards to whole cells; when None, the rectangle around `select`.
        select: prims that are to be covered; all obstacles when empty.
        origin: a point at which cells have a corner.
        seeds: points that are free, with all that can be reached from them; where the first robot stands when empty.
        include: prims of robots or of bodies that can move which are obstacles all the same, where they are at the start.
        exclude: prims that are no obstacles.

    Raises:
        UsageError: they make no sense.
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
            raise UsageError(f"a map ends {FARTHEST:g} m from the world's origin, and has finite numbers only")
        if low >= high:
            raise UsageError(f"z: the lower bound {low:g} is not below the upper bound {high:g}")
        if self.cell < SMALLEST_CELL:
            raise UsageError(f"cell: {self.cell:g} is less than {SMALLEST_CELL:g}; write metres, such as 0.05")
        for name, first, last in zip("xy", *corners, strict=True):
            if first >= last:
                raise UsageError(f"bounds: the least {name}, {first:g}, is not below the greatest, {last:g}")


def make_map(world: LoadedWorld, request: MapRequest) -> OccupancyMap:
    """Return the map of a scene in its initial state.

    Raises:
        UsageError: the request makes no sense in this scene.
        PrimError: it names a prim that is not there.
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
        floor = f"a floor above z = {request.window[0]:g} m, where the heights begin that count, is an obstacle, too"
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
        raise UsageError(
            f"{grid.columns} x {grid.rows} cells are more than the {MOST_CELLS} that a map may have\n"
            f"  make cells of {fitting * 1.01:.2g} m or more, or give narrower bounds"
        )


def _obstacles(world: LoadedWorld, request: MapRequest) -> Indices:
    """Ids of the geoms that are obstacles."""
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
    """Which geoms rays see or contacts feel."""
    there = collides(model)
    there[visible_geoms(model)] = True
    return there


def _geoms(world: LoadedWorld, path: str) -> Indices:
    """Ids of the geoms at and below a prim."""
    model, prim = world.simulation.model, world.stage.find(path)
    parts = {part.body for part in prim.descendants()}
    bodies = [body for body, name in enumerate(body_names(model)) if name in parts]
    if prim.path in ("/", "/World"):  # the geoms of MuJoCo's `worldbody`, which has no prim of its own, lie there
        bodies.append(0)
    geoms: Indices = np.flatnonzero(_there(model) & np.isin(model.geom_bodyid, bodies))
    if not len(geoms):
        raise UsageError(f"{prim.path} has no geometry that an obstacle could have")
    return geoms


def _bounds(world: LoadedWorld, select: Sequence[str], obstacles: Indices) -> Rectangle:
    """The rectangle around the selected prims, else around all obstacles; infinite planes are ignored."""
    chosen = np.unique(np.concatenate([_geoms(world, path) for path in select])) if select else obstacles
    rectangles = [shape.bounds() for shape in shapes(world.simulation.model, world.simulation.data, chosen)]
    west, south = (min((float(low[axis]) for low, _ in rectangles), default=math.inf) for axis in (0, 1))
    east, north = (max((float(high[axis]) for _, high in rectangles), default=-math.inf) for axis in (0, 1))
    if not (west <= east and south <= north):
        raise UsageError("there is nothing that a map could be fitted to; give its bounds")
    return (west, south), (east, north)


def _first_robot(world: LoadedWorld) -> Point:
    """Position of the first robot; the origin in a scene without robots."""
    for robot in world.robots.values():
        (x, y, _), _ = world.simulation.body(world.stage.find(robot.prim_path)).pose()
        return x, y
    return 0.0, 0.0


def _seed(grid: Grid, occupied: Bools, x: float, y: float) -> tuple[int, int]:
    """Row and column of a point that has to be free."""
    cell = grid.locate(x, y)
    if cell is None:
        raise UsageError(
            f"the free point ({x:g}, {y:g}) lies outside of the map\n"
            f"  which covers x {grid.west:g} to {grid.east:g}, y {grid.south:g} to {grid.north:g}"
        )
    if not occupied[cell]:
        return cell
    rows, columns = np.nonzero(~occupied)
    nearest = int(np.argmin((rows - cell[0]) ** 2 + (columns - cell[1]) ** 2))
    near_x, near_y = (round(value, 6) for value in grid.centre(int(rows[nearest]), int(columns[nearest])))
    raise UsageError(
        f"the point ({x:g}, {y:g}), which is to be free, is occupied\n"
        f"  the nearest free point is ({near_x:.10g}, {near_y:.10g})"
    )
