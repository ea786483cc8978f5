"""Localizability: what rooms with known symmetries make of spread and ambiguity, and how distances and scans are found."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from graphengine.bringup.maps.likelihood_field import distances, likelihood_field
from graphengine.bringup.maps.localizability import Localizability, localizability
from graphengine.bringup.maps.localizability_report import summary, write_report
from graphengine.bringup.maps.robot_lidar import robot_lidar
from graphengine.bringup.maps.scan_casting import PlanarLidar, cast
from graphengine.bringup.maps.scan_matching import FARTHEST, ScanMatcher
from graphengine.format.errors import UsageError
from graphengine.physics.occupancy.grid import Grid
from graphengine.physics.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from tests.other_process import in_another_process
from tests.physics.conftest import Ship

CELL = 0.05
ROUND = PlanarLidar(-math.pi, math.tau, 0.05, 30.0)

Box = tuple[float, float, float, float]


def room(width: float, depth: float, *boxes: Box) -> OccupancyMap:
    """A room around the origin with walls of 0.1 m, and obstacles from (x, y) to (x, y)."""
    grid = Grid.around((-width / 2 - 0.1, -depth / 2 - 0.1), (width / 2 + 0.1, depth / 2 + 0.1), CELL, (0.0, 0.0))
    cells = np.full((grid.rows, grid.columns), FREE, np.int8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:] = (OCCUPIED,) * 4
    for west, south, east, north in boxes:
        low, high = grid.locate(west, south), grid.locate(east, north)
        assert low is not None
        assert high is not None
        cells[low[0] : high[0], low[1] : high[1]] = OCCUPIED
    return OccupancyMap(grid, (0.2, 0.6), cells)


def judged(chart: OccupancyMap, lidar: PlanarLidar = ROUND, **options: float) -> Localizability:
    return localizability(chart, lidar, 0.25, **options)  # type: ignore[arg-type]


def place(result: Localizability, x: float, y: float) -> int:
    return int(np.hypot(*(result.places - (x, y)).T).argmin())


FEATURES = (
    (-2.4, 1.5, -1.2, 2.4), (0.9, -2.4, 1.4, -1.1), (1.7, 0.8, 2.4, 1.2), (-2.4, -1.3, -2.0, -0.6), (0.1, 1.9, 0.5, 2.4),
)  # fmt: skip


def test_a_long_corridor_is_blind_along_its_axis() -> None:
    result = judged(room(40.0, 2.0), PlanarLidar(-math.pi, math.tau, 0.05, 8.0))
    middle = place(result, 0.0, 0.0)
    assert result.spread[middle].min() > 0.9
    assert np.abs(np.sin(result.direction[middle])).max() < 0.1
    assert result.near[middle].min() > 0.9
    assert "blind along x: x -" in summary(result)


def test_a_corridor_along_y_is_blind_along_y() -> None:
    result = judged(room(2.0, 40.0), PlanarLidar(-math.pi, math.tau, 0.05, 8.0))
    middle = place(result, 0.0, 0.0)
    assert result.spread[middle].min() > 0.9
    assert np.abs(np.cos(result.direction[middle])).max() < 0.1


def test_a_square_room_is_ambiguous_under_rotation_and_precise() -> None:
    result = judged(room(5.0, 5.0))
    spot = place(result, 1.0, 0.5)
    x, y = result.places[spot]
    assert result.spread.max() < 0.1
    assert result.far[spot].min() > 0.9
    aliases = result.alias[spot]
    turned = np.array([(-y, x), (-x, -y), (y, -x)])
    for heading, alias in zip(result.headings, aliases, strict=True):
        which = int(np.hypot(*(turned - alias[:2]).T).argmin())
        assert alias[:2] == pytest.approx(turned[which], abs=0.11)
        assert math.cos(alias[2] - heading - (which + 1) * math.pi / 2) > 0.99


def test_a_room_with_features_is_neither() -> None:
    result = judged(room(5.0, 5.0, *FEATURES))
    assert (result.spread < 0.1).mean() > 0.95
    assert (result.ambiguity < 0.5).mean() > 0.95
    assert result.good(0.1, 0.5).mean() > 0.9


def test_more_scans_leave_less_ambiguity_and_more_noise_more_spread() -> None:
    chart = room(5.0, 5.0, *FEATURES)
    one, many, noisy = judged(chart, scans=1), judged(chart), judged(chart, alpha=0.2)
    assert one.near == pytest.approx(many.near ** (1 / 8), abs=1e-5)
    assert (one.spread == many.spread).all()
    assert (noisy.spread > many.spread).all()


def test_a_lidar_with_a_narrow_view_has_a_larger_spread() -> None:
    chart = room(5.0, 5.0, *FEATURES)
    ahead = judged(chart, PlanarLidar(-math.pi / 4, math.pi / 2, 0.05, 30.0))
    assert np.quantile(ahead.spread, 0.9) > np.quantile(judged(chart).spread, 0.9)


def test_places_keep_the_radius_of_the_robot_from_obstacles() -> None:
    chart = room(5.0, 5.0, (0.0, 0.0, 0.5, 0.5))
    result = localizability(chart, ROUND, 0.6)
    assert np.abs(result.places).max() <= 2.5 - 0.6 + CELL
    assert np.hypot(*np.maximum(np.abs(result.places - 0.25) - 0.25, 0.0).T).min() >= 0.6 - CELL
    with pytest.raises(UsageError, match=r"no free place that is 1.9 m"):
        localizability(room(2.0, 2.0), ROUND, 1.9)


@pytest.mark.parametrize("options", [{"scans": 0}, {"alpha": 0.0}, {"alpha": math.nan}])
def test_an_invalid_number_of_scans_and_zero_noise_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(UsageError, match="write numbers above 0"):
        judged(room(2.0, 2.0), ROUND, **options)


def test_a_map_of_large_cells_is_refused() -> None:
    chart = room(5.0, 5.0)
    coarse = replace(chart, grid=replace(chart.grid, cell=0.75))
    with pytest.raises(UsageError, match=r"cells of 0\.75 m are too large"):
        judged(coarse)


def test_a_map_that_is_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.bringup.maps.localizability.MOST_PLACES", 3)
    with pytest.raises(UsageError, match="use a larger spacing or smaller bounds for at most 3 places"):
        judged(room(5.0, 5.0))


@given(
    st.lists(st.tuples(st.integers(0, 19), st.integers(0, 29)), min_size=1, max_size=6, unique=True), st.integers(1, 40)
)
def test_distances_agree_with_scipy_up_to_a_limit(cells: list[tuple[int, int]], most: int) -> None:
    occupied = np.zeros((20, 30), np.bool_)
    occupied[tuple(np.array(cells).T)] = True
    exact, found = distance_transform_edt(~occupied), distances(occupied, most)
    assert found[exact <= most] == pytest.approx(exact[exact <= most])
    assert (found[exact > most] > most).all()


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_rays_end_at_the_walls_of_a_room(x: float, y: float) -> None:
    chart = room(5.0, 5.0)
    field = likelihood_field(chart, 30.0)
    cell = chart.grid.locate(x, y)
    assert cell is not None
    begin = np.array(chart.grid.centre(*cell))
    (ranges,) = cast(field, np.array([cell[0]]), np.array([cell[1]]), 64, ROUND)
    angle = np.arange(64) * math.tau / 64
    ends = begin + ranges[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.abs(ends).max(axis=1) == pytest.approx(np.full(64, 2.5), abs=1.1 * CELL)


def test_rays_have_no_return_beyond_the_range_and_outside_of_the_map() -> None:
    chart = room(5.0, 5.0)
    field = likelihood_field(chart, 30.0)
    middle = np.array([chart.grid.rows // 2]), np.array([chart.grid.columns // 2])
    assert np.isnan(cast(field, *middle, 32, PlanarLidar(0.0, math.tau, 0.05, 2.0))).all()
    empty = OccupancyMap(chart.grid, (0.2, 0.6), np.full_like(chart.cells, UNKNOWN))
    assert np.isnan(cast(likelihood_field(empty, 30.0), *middle, 32, ROUND)).all()


def test_a_wall_at_the_comparison_limit_counts_as_beyond_it() -> None:
    chart = room(12.0, 1.0, (4.65, -0.5, 4.85, 0.5))
    field = likelihood_field(chart, 30.0)
    rows, columns = np.full(3, chart.grid.rows // 2), np.array([15, 60, 100])
    ranges, window = cast(field, rows, columns, 64, ROUND), ROUND.window(64, 16)
    assert ranges[0, 0] == FARTHEST
    beyond = np.where(ranges == FARTHEST, FARTHEST + 1e-9, ranges)
    at, past = (ScanMatcher(field, rows, columns, found, window) for found in (ranges, beyond))
    for number in range(len(rows)):
        assert at.best_other(number)[0] == pytest.approx(past.best_other(number)[0])


def test_the_window_follows_the_heading_and_the_mount() -> None:
    lidar = PlanarLidar(math.radians(-45), math.radians(90), 0.1, 9.0)
    seen = lidar.window(64, 16)
    assert seen.sum(axis=0).tolist() == [17] * 16
    assert np.flatnonzero(seen[:, 0]).tolist() == [*range(9), *range(56, 64)]
    assert np.flatnonzero(seen[:, 4]).tolist() == list(range(8, 25))


def test_the_lidar_of_the_dd100_is_as_in_its_profile(ship: Ship) -> None:
    world = ship("dd100_hall_pair.yaml")
    lidar, radius = robot_lidar(world.simulation, world.robots, "dd100_0001")
    assert (lidar.first, lidar.field) == pytest.approx((math.radians(-137.5), math.radians(275)), abs=1e-6)
    assert (lidar.near, lidar.far) == (0.05, 64.0)
    assert 0.2 < radius < 0.3  # half of its width


def report_of(chart: OccupancyMap, path: Path) -> list[bytes]:
    return [written.read_bytes() for written in write_report(judged(chart), chart, path)]


def test_the_report_has_a_row_for_each_place_and_a_picture(tmp_path: Path) -> None:
    chart = room(5.0, 5.0, *FEATURES)
    result = judged(chart)
    picture, table = write_report(result, chart, tmp_path / "room")
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    assert len(rows) == len(result.places)
    assert float(rows[0]["spread"]) == pytest.approx(result.spread[0].max(), abs=1e-4)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert in_another_process(report_of, chart, tmp_path / "again") == [picture.read_bytes(), table.read_bytes()]
