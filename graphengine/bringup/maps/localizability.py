"""Computes how well AMCL can localise a robot at each place of a map: how precisely, and whether other poses fit as well.

At each free place, a scan is cast in the map for each heading, and scored at other poses by the likelihood field of nav2_amcl
(`likelihood_field`). One scan separates poses weakly: AMCL adds the beams of a scan, so a scan is seldom more than ten times as
likely at the true pose as at another pose. But the filter multiplies the likelihoods of successive scans. Resampling keeps that
product, because it duplicates particles with large weights; only the noise of the motion model reduces it. For simplicity, all
scans along a path are assumed to equal the scan at the judged pose, so the product is a power of one scan's likelihood ratio.

- Spread: the standard deviation of the position, along its worst direction, at which the filter settles. A scan gives the
  information I = 1 / sigma^2. It is computed from the second differences of the logarithms of likelihood ratios at poses 0.1 m or
  0.025 rad away; the heading is treated as unknown. Each update adds the variance q = alpha (0.25 m)^2 of the motion model and
  then the information of the scan, so the filter settles at P = 1 / (1 / (P + q) + I). The spread is limited to REACH; a spread
  of REACH means that scans give no information.
- Near ambiguity: the largest likelihood ratio of a nearby pose to the true pose. A nearby pose is at most REACH and 0.1 rad, and
  at least 0.3 m or 0.1 rad away. The ratio is that of SCANS scans: by default, AMCL uses so many in 2 m of travel, one per 0.25
  m. With `scans=1`, it is that of a single scan.
- Far ambiguity: the largest likelihood ratio of any other pose of the map (`scan_matching`), for the same number of scans.

Positions are those of the lidar. Positions closer to an obstacle than the inscribed radius of the robot are left out, because the
robot cannot get there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from graphengine.bringup.maps.likelihood_field import MAX_DISTANCE, LikelihoodField, likelihood_field
from graphengine.bringup.maps.scan_casting import PlanarLidar, cast
from graphengine.bringup.maps.scan_matching import ScanMatcher
from graphengine.descriptions.engine import Floats
from graphengine.format.errors import UsageError
from graphengine.physics.occupancy.occupancy_map import FREE, OccupancyMap

BEAMS, SCANS, HEADINGS = 60, 8, 16
ALPHA, UPDATE = 0.01, 0.25
"""Variance of the motion model per squared distance (AMCL's alpha3), and distance travelled between updates of AMCL, m."""
LARGEST_CELL = 0.5
"""Largest side of a cell, m; with larger cells, poses that are close to each other cannot be compared."""
REACH, STEP = 1.0, 0.1
"""Largest distance of a nearby pose from the true pose, and spacing of the nearby poses that are compared, m."""
OFF, TURNED = 0.3, 0.1
"""Minimum distance (m) or angle (rad) between the true pose and another nearby pose."""
_TURNS = (0.0, -0.025, 0.025, -0.05, 0.05, -TURNED, TURNED)
MOST_PLACES = 20_000
"""Maximum number of places at which `graphrun map --localizability` tests the localization."""


@dataclass(frozen=True, slots=True)
class Localizability:
    """How well a robot can be localised at each place and heading; arrays have the shape (places, headings).

    Places are in rows from south to north.

    Attributes:
        spacing: distance between neighbouring places, m.
        places: x and y, shape (places, 2), m.
        headings: headings of the robot, rad.
        spread: standard deviation of the position along its worst direction, m.
        direction: the worst direction, rad from the x axis, 0 to pi.
        near: largest likelihood ratio of a nearby pose to the true pose.
        far: largest likelihood ratio of a pose farther away to the true pose.
        alias: pose with the ratio `far`: x, y (m) and heading (rad), shape (places, headings, 3); NaN if no pose was found.
    """

    spacing: float
    places: Floats
    headings: Floats
    spread: Floats
    direction: Floats
    near: Floats
    far: Floats
    alias: Floats

    @property
    def ambiguity(self) -> Floats:
        """The larger value of `near` and `far`, for each place and heading."""
        return np.maximum(self.near, self.far)

    def good(self, spread: float, ambiguity: float) -> Floats:
        """Return, for each place, the fraction of headings with at most the given spread (m) and ambiguity."""
        fine = (self.spread <= spread) & (self.ambiguity <= ambiguity)
        return np.asarray(fine.mean(axis=1))


def localizability(
    chart: OccupancyMap,
    lidar: PlanarLidar,
    radius: float,
    *,
    spacing: float = 0.5,
    scans: int = SCANS,
    alpha: float = ALPHA,
    progress: Callable[[float], None] = lambda share: None,
) -> Localizability:
    """Return how well a robot can be localised at the free places of a map.

    Args:
        chart: the map.
        lidar: the lidar; the scans have about BEAMS of its beams, as in AMCL.
        radius: smallest distance of the lidar from obstacles, m; closer places are left out.
        spacing: distance between places, m; it is rounded to a multiple of the cell size.
        scans: number of scans whose likelihoods are multiplied for the ambiguity.
        alpha: noise of the motion model, alpha3 of AMCL.
        progress: called with the completed share, 0 to 1.

    Raises:
        UsageError: there is no free place or there are too many of them, cells are larger than `LARGEST_CELL`, or `scans` or
            `alpha` is not greater than 0.
    """
    if scans < 1 or not 0.0 < alpha < math.inf:
        raise UsageError(f"scans is {scans} and alpha is {alpha:g}: write numbers above 0")
    if chart.grid.cell > LARGEST_CELL:
        advice = f"use cells of at most {LARGEST_CELL} m"
        raise UsageError(f"cells of {chart.grid.cell:g} m are too large to compare poses; {advice}")
    field = likelihood_field(chart, lidar.far)
    stride = max(1, round(spacing / chart.grid.cell))
    inner = slice(field.pad, -field.pad)
    roomy = field.distance[inner, inner] - chart.grid.cell / 2 >= min(radius, MAX_DISTANCE - chart.grid.cell)
    first = stride // 2
    rows, columns = np.nonzero(((chart.cells == FREE) & roomy)[first::stride, first::stride])
    rows, columns = rows * stride + first, columns * stride + first
    if not len(rows):
        raise UsageError(f"the map has no free place that is {radius:.2g} m from all obstacles")
    if len(rows) > MOST_PLACES:
        advice = f"use a larger spacing or smaller bounds for at most {MOST_PLACES} places"
        raise UsageError(f"{len(rows)} places are too many; {advice}")
    rays = lidar.rays(BEAMS, HEADINGS)
    window = lidar.window(rays, HEADINGS)
    ranges = cast(field, rows, columns, rays, lidar)
    matcher = ScanMatcher(field, rows, columns, ranges, window)
    nearby = _Nearby(field, scans, alpha)
    results: list[tuple[Floats, ...]] = []
    for place in range(len(rows)):
        spread, direction, near = nearby.judge(int(rows[place]), int(columns[place]), ranges[place], window)
        far, alias = matcher.best_other(place)
        results.append((spread, direction, near, far**scans, alias))
        progress((place + 1) / len(rows))
    spread, direction, near, far, alias = (np.array(column) for column in zip(*results, strict=True))
    grid = chart.grid
    corner = np.array([grid.west + grid.cell / 2, grid.south + grid.cell / 2])
    alias[..., :2] = alias[..., :2] * grid.cell + corner
    places = np.stack([columns, rows], axis=1) * grid.cell + corner
    headings = np.arange(HEADINGS) * math.tau / HEADINGS
    return Localizability(stride * grid.cell, places, headings, spread, direction, near, far, alias)


class _Nearby:
    """Scores scans at poses near their true pose, for the spread and the near ambiguity."""

    def __init__(self, field: LikelihoodField, scans: int, alpha: float) -> None:
        self._field, self._scans, self._motion = field, scans, alpha * UPDATE**2
        step = max(1, round(STEP / field.cell))
        count = math.floor(REACH / (step * field.cell) + 1e-9)
        axis = step * np.arange(-count, count + 1)
        grid_columns, grid_rows = (values.ravel() for values in np.meshgrid(axis, axis))
        distance = np.hypot(grid_columns, grid_rows) * field.cell
        inside = distance <= REACH + 1e-9
        columns, rows, away = grid_columns[inside], grid_rows[inside], distance[inside]
        self._shift = field.shift(rows, columns)
        self._true = int(np.argmin(away))
        turns = np.array(_TURNS)[:, None]
        self._other = (np.abs(turns) >= TURNED - 1e-9) | (away >= OFF - 1e-9)
        self._steps = step * field.cell, _TURNS[2]
        block = [(one * step, other * step) for one in (-1, 0, 1) for other in (-1, 0, 1)]
        self._block = [int(np.flatnonzero((rows == down) & (columns == right))[0]) for down, right in block]

    def judge(self, row: int, column: int, ranges: Floats, window: Floats) -> tuple[Floats, Floats, Floats]:
        """Return spread (m), worst direction (rad) and near ambiguity for each heading at a cell.

        Args:
            row: row of the cell.
            column: column of the cell.
            ranges: ranges of the rays of a full circle at the cell, m; NaN for no return.
            window: 1 for each ray in the field of view at a heading, else 0, shape (rays, headings).
        """
        field, rays = self._field, len(ranges)
        met = np.isfinite(ranges)
        along = np.where(met, ranges, 0.0) / field.cell
        angle = np.arange(rays) * math.tau / rays + np.array(_TURNS)[:, None]
        ends_row = np.rint(row + along * np.sin(angle)).astype(np.intp)
        ends_column = np.rint(column + along * np.cos(angle)).astype(np.intp)
        ends = field.index(ends_row, ends_column)[:, met]
        scores = field.score.ravel().take(ends[:, None, :] + self._shift[:, None])
        likelihood = 1.0 + scores @ window[met].astype(np.float32)  # (turns, offsets, headings)
        ratio = likelihood / likelihood[0, self._true]
        spread, direction = self._precision(ratio[[1, 0, 2]][:, self._block])
        return spread, direction, ratio[self._other].max(axis=0) ** self._scans

    def _precision(self, ratio: Floats) -> tuple[Floats, Floats]:
        """Return spread (m) and worst direction (rad) for each heading.

        Args:
            ratio: likelihood ratios of poses at most one step and one turn away, shape (3 turns, 9 positions, headings).
        """
        drop = -np.log(ratio.reshape(3, 3, 3, -1))
        step, turn = self._steps
        xx, yy = (drop[1, 1, 0] + drop[1, 1, 2]) / step**2, (drop[1, 0, 1] + drop[1, 2, 1]) / step**2
        tt = (drop[0, 1, 1] + drop[2, 1, 1]) / turn**2
        xy = (drop[1, 2, 2] - drop[1, 2, 0] - drop[1, 0, 2] + drop[1, 0, 0]) / (4 * step**2)
        xt = (drop[2, 1, 2] - drop[2, 1, 0] - drop[0, 1, 2] + drop[0, 1, 0]) / (4 * step * turn)
        yt = (drop[2, 2, 1] - drop[2, 0, 1] - drop[0, 2, 1] + drop[0, 0, 1]) / (4 * step * turn)
        turning = np.maximum(tt, 1e-9)  # marginalize the heading, which is unknown, too
        xx, yy, xy = xx - xt * xt / turning, yy - yt * yt / turning, xy - xt * yt / turning
        half, mean = np.hypot((xx - yy) / 2, xy), (xx + yy) / 2
        direction = (np.arctan2(2 * xy, xx - yy) / 2 + math.pi / 2) % math.pi
        information = np.maximum(mean - half, 1e-9)
        settled = (np.sqrt(self._motion**2 + 4 * self._motion / information) - self._motion) / 2
        return np.minimum(np.sqrt(settled), REACH), direction
