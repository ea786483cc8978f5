"""Maps of scenes: what is an obstacle, how far a map extends, what is free, and what is refused."""

from __future__ import annotations

from collections import deque
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.format.errors import PrimError, UsageError
from graphengine.physics.occupancy.flood_fill import reached
from graphengine.physics.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, MapRequest, OccupancyMap, make_map
from tests.physics.conftest import Ship
from tests.physics.harness import SHIPPED, Project

WORLD = """<mujoco>
  <asset><material name="glass" rgba="1 1 1 0"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="room">
      <geom type="box" size="0.1 1 1" pos="-1.1 0 1"/>
      <geom type="box" size="0.1 1 1" pos="1.1 0 1"/>
      <geom type="box" size="1.2 0.1 1" pos="0 -1.1 1"/>
      <geom type="box" size="1.2 0.1 1" pos="0 1.1 1"/>
    </body>
    <body name="table" pos="0.5 0.5 0"><geom type="box" size="0.2 0.2 0.5" pos="0 0 0.5"/></body>
    <body name="crate" pos="-0.5 0.5 0.2"><freejoint/><geom type="box" size="0.2 0.2 0.2"/></body>
    <body name="cart" pos="-0.5 -0.5 0.4" mocap="true"><geom type="box" size="0.2 0.2 0.2"/></body>
    <body name="paint" pos="0.5 -0.5 0"><geom type="box" size="0.2 0.2 0.001" contype="0" conaffinity="0"/></body>
    <body name="poster" pos="0 0.9 0.4"><geom type="box" size="0.2 0.05 0.2" contype="0" conaffinity="0"/></body>
    <body name="nothing" pos="0 -0.9 0.4">
      <geom type="box" size="0.2 0.05 0.2" material="glass" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>
"""


def mapped(project: Project, world: str = WORLD, **request: Any) -> OccupancyMap:
    loaded = project.write("world.xml", world).load()
    return make_map(loaded, MapRequest(**{"window": (0.2, 0.6), "cell": 0.1, **request}))


def state(chart: OccupancyMap, x: float, y: float) -> int:
    cell = chart.grid.locate(x, y)
    assert cell is not None
    return int(chart.cells[cell])


def refused(project: Project, world: str = WORLD, **request: Any) -> str:
    with pytest.raises(UsageError) as caught:
        mapped(project, world, **request)
    return str(caught.value)


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((0.5, 0.5), OCCUPIED),
        ((1.05, 0.0), OCCUPIED),
        ((0.0, 0.9), OCCUPIED),
        ((0.0, 0.0), FREE),
        ((-0.5, 0.5), FREE),
        ((-0.5, -0.5), FREE),
        ((0.5, -0.5), FREE),
        ((0.0, -0.9), FREE),
    ],
    ids=["table", "wall", "poster", "robot", "crate", "cart", "paint", "what nothing sees"],
)
def test_fixed_bodies_are_obstacles(project: Project, place: tuple[float, float], expected: int) -> None:
    assert state(mapped(project), *place) == expected


def test_the_map_covers_all_obstacles_in_whole_cells(project: Project) -> None:
    grid = mapped(project, cell=0.25).grid
    assert (grid.west, grid.south, grid.east, grid.north) == (-1.25, -1.25, 1.25, 1.25)
    exact = mapped(project, cell=0.1).grid
    assert (exact.columns, exact.rows) == (24, 24)
    assert (exact.west, exact.south) == pytest.approx((-1.2, -1.2), abs=1e-12)


def test_bounds_grow_to_whole_cells_from_the_origin(project: Project) -> None:
    grid = mapped(project, bounds=((-0.32, -0.3), (0.3, 0.71)), origin=(0.05, 0.0), seeds=[(0.0, 0.0)]).grid
    assert (grid.west, grid.south, grid.east, grid.north) == pytest.approx((-0.35, -0.3, 0.35, 0.8), abs=1e-12)


def test_a_selection_is_covered_and_no_more(project: Project) -> None:
    grid = mapped(project, select=["/World/table", "/World/crate"], seeds=[(0.0, 0.5)]).grid
    assert (grid.west, grid.south, grid.east, grid.north) == pytest.approx((-0.7, 0.3, 0.7, 0.7), abs=1e-12)


def test_unreachable_cells_are_unknown(project: Project) -> None:
    chart = mapped(project, bounds=((-2.0, -2.0), (2.0, 2.0)))
    inside = np.zeros((40, 40), np.bool_)
    inside[10:30, 10:30] = True
    assert ((chart.cells == FREE) == (inside & (chart.cells != OCCUPIED))).all()
    outside = mapped(project, bounds=((-2.0, -2.0), (2.0, 2.0)), seeds=[(-1.9, -1.9)])
    assert state(outside, 0.0, 0.0) == UNKNOWN
    both = mapped(project, bounds=((-2.0, -2.0), (2.0, 2.0)), seeds=[(-1.9, -1.9), (0.0, 0.0)])
    assert both.share(UNKNOWN) == 0.0
    assert sum(both.share(value) for value in (FREE, OCCUPIED, UNKNOWN)) == pytest.approx(1.0)


def test_free_begins_where_the_first_robot_stands(project: Project) -> None:
    scene = "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.yaml, position: [-1.9, 0, 0.1]}\n"
    chart = mapped(project.write("scene.yaml", scene), bounds=((-2.0, -2.0), (2.0, 2.0)))
    assert (state(chart, -1.9, 1.9), state(chart, 0.0, 0.0)) == (FREE, UNKNOWN)
    without = mapped(project.write("scene.yaml", "scene: test\nworld: world.xml\n"), bounds=((-2.0, -2.0), (2.0, 2.0)))
    assert (state(without, -1.9, 1.9), state(without, 0.0, 0.0)) == (UNKNOWN, FREE)


def test_robots_and_movable_bodies_are_obstacles_on_request(project: Project) -> None:
    chart = mapped(project, include=["/bot", "/World/crate"], seeds=[(0.0, -0.9)], window=(0.1, 0.3))
    assert [state(chart, *place) for place in ((0.0, 0.0), (-0.5, 0.5), (-0.5, -0.5))] == [OCCUPIED, OCCUPIED, FREE]
    chart = mapped(project, exclude=["/World/table"])
    assert state(chart, 0.5, 0.5) == FREE
    floor_alone = mapped(project, exclude=["/World"], include=["/World/table"], bounds=((-1, -1), (1, 1)))
    assert floor_alone.share(OCCUPIED) == 0.0  # what is excluded is excluded last


def test_a_robot_that_stands_fast_is_left_out_as_well(project: Project) -> None:
    project.robot("fixed_base: true")
    window = (0.1, 0.3)
    assert state(mapped(project, window=window), 0.0, 0.0) == FREE
    assert state(mapped(project, window=window, include=["/bot"], seeds=[(0.0, 0.5)]), 0.0, 0.0) == OCCUPIED


def test_the_map_of_the_warehouse_agrees_with_mujocos_contacts_in_each_cell(ship: Ship) -> None:
    world = ship("dd100_warehouse.yaml")
    chart = make_map(world, MapRequest(window=(0.2, 0.62), cell=0.05))
    occupied = np.pad(chart.cells == OCCUPIED, 1)
    border = (occupied != np.roll(occupied, 1, axis=0)) | (occupied != np.roll(occupied, 1, axis=1))
    cells = np.argwhere(border[1:-1, 1:-1])
    spec = mujoco.MjSpec.from_file(str(SHIPPED / "worlds/full_warehouse.xml"))
    spec.worldbody.add_geom(name="prism", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.025, 0.025, 0.21])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    prism = model.geom("prism").id
    still = (model.body_weldid[model.geom_bodyid] == 0) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE)
    others = [geom for geom in np.flatnonzero(still).tolist() if geom != prism]
    compared = 0
    for row, column in cells[np.random.default_rng(4).choice(len(cells), 300, replace=False)].tolist():
        data.geom_xpos[prism] = *chart.grid.centre(row, column), 0.41
        distance = min(mujoco.mj_geomDistance(model, data, prism, geom, 0.1, None) for geom in others)
        if abs(distance) > 1e-6:
            assert (distance < 0) == (chart.cells[row, column] == OCCUPIED)
            compared += 1
    assert compared > 50  # most racks begin and end at the border of a cell


# Mistakes


def test_an_occupied_seed_comes_with_the_nearest_free_point(project: Project) -> None:
    text = refused(project, seeds=[(0.62, 0.5)])
    assert text.splitlines() == [
        "the free point (0.62, 0.5) is occupied",
        "  the nearest free point is (0.75, 0.55)",
    ]
    mapped(project, seeds=[(0.75, 0.55)])


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ({"seeds": [(5.0, 0.0)]}, "the free point (5, 0) lies outside of the map\n  the map covers x -1.2 to 1.2"),
        ({"window": (0.6, 0.2)}, "z: the lower bound 0.6 is not below the upper bound 0.2"),
        ({"window": (0.2, 0.2)}, "z: the lower bound 0.2 is not below"),
        ({"cell": 0.0}, "cell: 0 m is less than 0.0001 m"),
        ({"cell": -0.05}, "cell: -0.05 m is less than 0.0001 m"),
        ({"cell": float("nan")}, "must be finite and at most 1e+06 m"),
        ({"window": (0.2, float("inf"))}, "must be finite and at most 1e+06 m"),
        ({"bounds": ((0.0, 0.0), (0.0, 1.0))}, "bounds: the smallest x, 0, is not below the largest, 0"),
        ({"bounds": ((0.0, 2.0), (1.0, 1.0))}, "bounds: the smallest y, 2, is not below the largest, 1"),
        (
            {"cell": 1e-4},
            "24000 x 24000 cells are more than the 25000000 that a map may have\n  use cells of at least 0.00048 m",
        ),
        ({"origin": (1e7, 0.0)}, "coordinates of a map must be finite and at most 1e+06 m"),
        ({"select": ["/World/nothing"]}, "/World/nothing has no geometry that can be an obstacle"),
        ({"exclude": ["/bot/Geometry/base_link/arm/plate"]}, "plate has no geometry"),
        ({"bounds": ((-0.1, 0.4), (0.8, 0.6)), "seeds": [(0.5, 0.5)], "include": ["/World"]}, "(0.5, 0.5)"),
        ({"bounds": ((0.4, 0.4), (0.6, 0.6)), "seeds": [(0.5, 0.5)]}, "every cell of the map is occupied"),
    ],
)
def test_a_request_that_makes_no_sense_is_refused(project: Project, request_: dict[str, Any], message: str) -> None:
    assert message in refused(project, **request_)


def test_a_world_without_obstacles_needs_bounds(project: Project) -> None:
    world = '<mujoco><worldbody><geom type="plane" size="0 0 1"/></worldbody></mujoco>'
    assert "give its bounds" in refused(project, world)
    chart = mapped(project, world, bounds=((-1.0, -1.0), (1.0, 1.0)))
    assert chart.share(FREE) == 1.0


def test_a_prim_that_is_not_there_is_refused_with_its_nearest(project: Project) -> None:
    with pytest.raises(PrimError, match="did you mean 'table'"):
        mapped(project, exclude=["/World/tabel"])


# Reach


def flooded(free: NDArray[np.bool_], seed: tuple[int, int]) -> NDArray[np.bool_]:
    """The same cell by cell."""
    found = np.zeros_like(free)
    pending = deque([seed] if free[seed] else [])
    while pending:
        row, column = pending.popleft()
        if 0 <= row < free.shape[0] and 0 <= column < free.shape[1] and free[row, column] and not found[row, column]:
            found[row, column] = True
            pending.extend([(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)])
    return found


@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 2**32 - 1), st.floats(0.2, 0.9))
def test_reach_is_that_of_a_flood_from_side_to_side(rows: int, columns: int, seed: int, share: float) -> None:
    dice = np.random.default_rng(seed)
    free = dice.random((rows, columns)) < share
    one, other = [(int(dice.integers(rows)), int(dice.integers(columns))) for _ in range(2)]
    assert (reached(free, [one]) == flooded(free, one)).all()
    assert (reached(free, [one, other]) == flooded(free, one) | flooded(free, other)).all()
