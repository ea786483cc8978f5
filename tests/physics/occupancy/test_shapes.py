"""The cells in which a body stands, held against MuJoCo's own distance between the body and the prism of each cell."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.descriptions.engine import sort_geoms
from graphengine.physics.occupancy.grid import Canvas, Grid, Window
from graphengine.physics.occupancy.shapes import shapes

TOUCHING = 1e-6
"""m: nearer to touching than this, the two may differ."""
WINDOW = (0.2, 0.62)
SEEN_ONLY = 'contype="0" conaffinity="0"'
TETRAHEDRON = "0.4 0 0  -0.3 0.35 0.05  -0.2 -0.3 -0.1  0.1 0.1 0.5"
ANGLE = "0 0 0  .6 0 0  .6 .2 0  .2 .2 0  .2 .6 0  0 .6 0  0 0 1  .6 0 1  .6 .2 1  .2 .2 1  .2 .6 1  0 .6 1"
ANGLE_FACES = (
    "0 3 1  1 3 2  0 5 3  3 5 4  6 7 9  7 8 9  6 9 11  9 10 11  "
    "0 1 7  0 7 6  1 2 8  1 8 7  2 3 9  2 9 8  3 4 10  3 10 9  4 5 11  4 11 10  5 0 6  5 6 11"
)
MESHES = (
    f'<asset><mesh name="tetrahedron" vertex="{TETRAHEDRON}"/>'
    f'<mesh name="angle" vertex="{ANGLE}" face="{ANGLE_FACES}"/></asset>'
)


def made(*geoms: str, assets: str = MESHES) -> tuple[mujoco.MjModel, mujoco.MjData]:
    # An exact oracle: by default MuJoCo stops at 1e-6 m.
    option = '<option ccd_tolerance="1e-10" ccd_iterations="200"/>'
    world = "".join(f"<geom {geom}/>" for geom in geoms)
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{option}{assets}<worldbody>{world}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    sort_geoms(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def draw(model: mujoco.MjModel, data: mujoco.MjData, grid: Grid, window: Window = WINDOW) -> NDArray[np.bool_]:
    canvas = Canvas(grid)
    for shape in shapes(model, data, np.arange(model.ngeom)):
        shape.draw(canvas, window)
    return canvas.occupied()


def drawn(geom: str, grid: Grid, window: Window = WINDOW) -> NDArray[np.bool_]:
    return draw(*made(geom), grid, window)


def around(model: mujoco.MjModel, data: mujoco.MjData, cell: float) -> Grid:
    """The grid of a geom's bounding rectangle, and a cell more on each side."""
    (shape, *more) = [shape.bounds() for shape in shapes(model, data, np.arange(model.ngeom))]
    low = np.min([shape[0], *(low for low, _ in more)], axis=0) - cell
    high = np.max([shape[1], *(high for _, high in more)], axis=0) + cell
    return Grid.around((low[0], low[1]), (high[0], high[1]), cell, (0.0, 0.0))


def numbers(values: Sequence[float]) -> str:
    return " ".join(map(repr, values))


lengths = st.floats(0.0625, 0.75, width=16)
places = st.floats(-0.5, 0.5, width=16)
upright = st.just((1.0, 0.0, 0.0, 0.0))
lying = st.sampled_from([(1.0, 1.0, 0.0, 0.0), (1.0, 0.0, 1.0, 0.0), (1.0, 1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 1.0)])
turned = st.floats(-3.0, 3.0, width=16).map(lambda yaw: (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))
nearly_upright = st.tuples(st.just(1.0), *[st.floats(-1e-7, 1e-7)] * 3)
tilted = st.tuples(*[st.integers(-5, 5).map(float)] * 4).filter(any)
orientations = st.one_of(upright, lying, turned, nearly_upright, tilted)


@pytest.mark.parametrize("kind", ["box", "sphere", "ellipsoid", "capsule", "cylinder", "mesh"])
@settings(max_examples=40)
@given(data=st.data())
def test_a_cell_is_occupied_exactly_when_its_prism_overlaps_the_body(kind: str, data: st.DataObject) -> None:
    size = data.draw(st.tuples(lengths, lengths, lengths), "size")
    place, turn = data.draw(st.tuples(places, places, places), "pos"), data.draw(orientations, "quat")
    cell = data.draw(st.sampled_from([0.05, 0.125, 0.3]), "cell")
    low, height = data.draw(places, "low"), data.draw(lengths, "height")
    what = 'mesh="tetrahedron"' if kind == "mesh" else f'size="{numbers(size)}"'
    body = f'type="{kind}" {what} pos="{numbers(place)}" quat="{numbers(turn)}"'
    model, state = made(body, f'type="box" size="{cell / 2} {cell / 2} {height / 2}"')
    alone = made(body)
    grid = around(*alone, cell)
    occupied = draw(*alone, grid, (low, low + height))
    for row, column in np.ndindex(occupied.shape):
        state.geom_xpos[1] = *grid.centre(row, column), low + height / 2
        distance = mujoco.mj_geomDistance(model, state, 0, 1, 0.01, None)
        if abs(distance) > TOUCHING:
            assert occupied[row, column] == (distance < 0), (row, column, distance)


@pytest.mark.parametrize("noise", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize(
    "geom",
    [
        'type="box" size="0.1 0.1 0.5" pos="{0} {0} 0.5"',
        'type="box" size="0.1 0.5 0.1" pos="{0} {0} 0.5" quat="1 1 0 0"',
        'type="cylinder" size="0.1 0.5" pos="{0} {0} 0.5"',
        'type="cylinder" size="0.1 0.1" pos="{0} {0} 0.4" quat="1 0 1 0"',
        'type="sphere" size="0.1" pos="{0} {0} 0.4"',
        'type="ellipsoid" size="0.1 0.1 0.3" pos="{0} {0} 0.4"',
        'type="capsule" size="0.1 0.3" pos="{0} {0} 0.5"',
    ],
)
def test_a_shape_that_ends_at_the_border_of_a_cell_is_not_in_the_next(geom: str, noise: float) -> None:
    occupied = drawn(geom.format(0.3 + noise), Grid(0.1, 0.0, 0.0, 6, 6))
    expected = np.zeros((6, 6), np.bool_)
    expected[2:4, 2:4] = True
    assert (occupied == expected).all()


@pytest.mark.parametrize("noise", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize(("height", "there"), [(0.1, False), (0.41, True), (0.72, False)])
@pytest.mark.parametrize("geom", ['type="box" size="0.1 0.1 0.1"', 'type="cylinder" size="0.1 0.1"'])
def test_a_shape_that_ends_at_the_window_is_not_in_it(geom: str, height: float, there: bool, noise: float) -> None:
    assert drawn(f'{geom} pos="0.5 0.5 {height + noise}"', Grid(0.1, 0, 0, 10, 10)).any() == there


def test_an_upright_cylinder_fills_the_cells_that_its_disc_overlaps() -> None:
    grid = Grid(0.05, -1.0, -1.0, 40, 40)
    x, y, radius = 0.013, -0.207, 0.61
    edges = -1.0 + 0.05 * np.arange(40)
    nearest_x, nearest_y = np.clip(x, edges, edges + 0.05), np.clip(y, edges, edges + 0.05)
    distance = np.hypot(*np.meshgrid(nearest_x - x, nearest_y - y))
    assert (drawn(f'type="cylinder" size="{radius} 1" pos="{x} {y} 0"', grid) == (distance < radius)).all()


def test_only_shapes_within_the_window_count() -> None:
    """A cone of a roof: a box on edge, wider the lower the window is."""
    roof = 'type="box" size="0.5 0.5 0.5" pos="0 0 0" euler="0 45 0"'
    grid = Grid(0.01, -1.0, -0.005, 200, 1)
    for low in (0.0, 0.2, 0.4):
        half = math.sqrt(0.5) - low
        assert drawn(roof, grid, (low, 1.0)).sum() == 2 * math.ceil(100 * half)


# Planes


@pytest.mark.parametrize(
    ("geom", "columns"),
    [
        ('size="0 0 1"', []),
        ('size="0 0 1" pos="0 0 0.2"', []),
        ('size="0 0 1" pos="0 0 0.3"', list(range(10))),
        ('size="0 0 1" pos="0 0 0.7"', list(range(10))),
        ('size="0 0 1" pos="0.7 0 0" zaxis="-1 0 0"', [7, 8, 9]),
        ('size="0.1 0.1 1" pos="0.3 0 0" zaxis="1 0 0"', [0, 1, 2]),
        ('size="0 0 1" pos="0.52 0 0" zaxis="-1 0 1"', [7, 8, 9]),  # at the window's lower end it is at x = 0.72
    ],
    ids=["floor", "at the window", "raised", "over the window", "wall", "small wall", "ramp"],
)
def test_everything_behind_a_plane_is_solid(geom: str, columns: list[int]) -> None:
    occupied = drawn(f'type="plane" {geom}', Grid(0.1, 0.0, 0.0, 10, 4))
    assert np.flatnonzero(occupied.all(axis=0)).tolist() == columns
    assert np.flatnonzero(occupied.any(axis=0)).tolist() == columns


def test_behind_an_endless_plane_that_rays_alone_see_is_nothing_to_be_seen() -> None:
    backdrop = f'type="plane" {SEEN_ONLY} size="0 0.2 1" pos="0.7 0.35 0.4" zaxis="-1 0 0"'
    assert np.flatnonzero(drawn(backdrop, Grid(0.1, 0.0, 0.0, 10, 4)).all(axis=0)).tolist() == [7, 8, 9]


def test_of_a_plane_that_rays_alone_see_the_rectangle_counts() -> None:
    sign = f'type="plane" {SEEN_ONLY} size="0.2 0.2 1" pos="0.55 0.35 0.4" quat="1 0 1 0"'  # it faces +x
    rows, columns = drawn(sign, Grid(0.1, 0.0, 0.0, 10, 10)).nonzero()
    assert list(zip(rows.tolist(), columns.tolist(), strict=True)) == [(row, 5) for row in range(1, 6)]


# Meshes


def test_a_mesh_that_collides_is_its_convex_hull_as_contacts_have_it() -> None:
    mesh = 'type="mesh" mesh="angle"'
    model, data = made(mesh, 'type="box" size="0.05 0.05 0.21"')
    grid = Grid(0.1, -0.1, -0.1, 8, 8)
    inside = []
    for cell in np.ndindex(8, 8):
        data.geom_xpos[1] = *grid.centre(*cell), 0.41
        inside.append(mujoco.mj_geomDistance(model, data, 0, 1, 1, None) < -TOUCHING)
    occupied = drawn(mesh, grid)
    assert occupied.ravel().tolist() == inside
    assert occupied[4, 4]  # which is within the hull, and not within the angle


def test_of_a_mesh_that_rays_alone_see_the_triangles_count_each_on_its_inner_side() -> None:
    plan = [
        "############.",
        "#..........#.",
        "#..........#.",
        "#...########.",
        *["#..#........."] * 8,
        ".............",
    ]
    plan[11] = "####........."
    occupied = drawn(f'type="mesh" mesh="angle" {SEEN_ONLY}', Grid(0.05, 0.0, 0.0, 13, 13))
    assert ["".join(".#"[cell] for cell in row) for row in occupied.astype(int)] == plan


# Height fields


def test_a_height_field_is_as_high_as_rays_find_it() -> None:
    heights = np.random.default_rng(3).uniform(size=(5, 4))
    field = (
        f'<hfield name="h" nrow="5" ncol="4" size="0.6 0.8 0.5 0.1" elevation="{numbers(heights.ravel().tolist())}"/>'
    )
    geom = 'type="hfield" hfield="h" pos="0.03 0.02 0.25"'
    model, data = made(geom, assets=f"<asset>{field}</asset>")
    grid, low, fine = Grid(0.1, -0.7, -0.9, 15, 19), 0.5, 12
    occupied = draw(model, data, grid, (low, 1.0))
    steepest = (
        2.5  # m/m, the greatest difference of neighbours (0.5 m) over the least distance (0.4 m), in both directions
    )
    offsets = (np.arange(fine) + 0.5) / fine
    for row, column in np.ndindex(occupied.shape):
        x, y = grid.west + 0.1 * (column + offsets), grid.south + 0.1 * (row + offsets)
        highest = max(height_at(model, data, a, b) for a in x for b in y)
        if occupied[row, column]:
            assert highest > low - steepest * 0.1 / fine
        else:
            assert highest <= low
    assert 20 < occupied.sum() < 200


def height_at(model: mujoco.MjModel, data: mujoco.MjData, x: float, y: float) -> float:
    distance = mujoco.mj_ray(
        model, data, np.array([x, y, 2.0]), np.array([0.0, 0.0, -1.0]), None, 1, -1, np.zeros(1, np.int32)
    )
    return 2.0 - distance if distance >= 0 else -math.inf


# Laws


@given(st.tuples(st.integers(-8, 8), st.integers(-8, 8)))
@settings(max_examples=20)
def test_a_shape_moved_by_whole_cells_moves_on_the_map(shift: tuple[int, int]) -> None:
    columns, rows = shift
    geom = 'type="cylinder" size="0.3 0.2" pos="{} {} 0.4" quat="1 0.3 0.2 0.1"'
    grid = Grid(0.05, -1.0, -1.0, 40, 40)
    moved = drawn(geom.format(0.05 * columns, 0.05 * rows), grid)
    assert (moved == np.roll(drawn(geom.format(0, 0), grid), (rows, columns), axis=(0, 1))).all()


def test_a_body_larger_than_the_grid_fills_it() -> None:
    grid = Grid(0.5, -1.0, -1.0, 4, 4)
    for geom in ('type="box" size="9 9 9"', 'type="sphere" size="9"', 'type="cylinder" size="9 9" quat="3 2 1 0"'):
        assert drawn(geom, grid).all()


def test_a_body_beside_the_grid_leaves_it_empty() -> None:
    grid = Grid(0.5, -1.0, -1.0, 4, 4)
    for where in ("3 0 0.4", "-3 0 0.4", "0 3 0.4", "0 -3 0.4"):
        for geom in ('type="box" size="1 1 1"', 'type="sphere" size="1"', 'type="cylinder" size="1 0.5"'):
            assert not drawn(f'{geom} pos="{where}"', grid).any()
