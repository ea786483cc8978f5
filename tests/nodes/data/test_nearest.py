"""NearestRange: the nearest range of a scan within a sector, and where it is."""

from __future__ import annotations

import math
from typing import Any

import pytest

from graphengine.nodes.data.nearest import NearestRange
from tests.nodes.data.harness import computed

INF, NAN = math.inf, math.nan
SCAN = {"ranges": [5.0, 1.0, 4.0, 2.0, 3.0], "azimuth_range": (-90.0, 90.0)}  # at -90, -45, 0, 45 and 90 degrees


def nearest(**inputs: Any) -> tuple[float, float]:
    """Distance and azimuth."""
    node = computed(NearestRange, **{**SCAN, **inputs})
    return node.distance, node.azimuth


@pytest.mark.parametrize(
    ("sector", "expected"),
    [
        ((-180.0, 180.0), (1.0, -45.0)),
        ((-10.0, 180.0), (2.0, 45.0)),
        ((45.0, 90.0), (2.0, 45.0)),  # both ends belong to it
        ((-44.0, 44.0), (4.0, 0.0)),
        ((10.0, 20.0), (INF, 0.0)),  # between two beams
        ((90.0, -90.0), (INF, 0.0)),
    ],
)
def test_ranges_outside_the_sector_are_ignored(sector: tuple[float, float], expected: tuple[float, float]) -> None:
    assert nearest(sector=sector) == expected


@pytest.mark.parametrize(
    ("ranges", "expected"),
    [
        ([], (INF, 0.0)),
        ([INF, NAN, INF], (INF, 0.0)),
        ([INF, NAN, 7.0], (7.0, 90.0)),
        ([7.0], (7.0, -90.0)),
        ([2.0, 2.0, 2.0], (2.0, -90.0)),  # of several, the first
    ],
)
def test_infinite_and_nan_ranges_are_ignored(ranges: list[float], expected: tuple[float, float]) -> None:
    assert nearest(ranges=ranges) == expected
