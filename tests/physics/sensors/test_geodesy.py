"""Positions on the WGS84 ellipsoid, compared with published numbers and with the way back."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.physics.sensors.geodesy import TangentPlane, geocentric, geographic

POINT = (53 + 48 / 60 + 33.820 / 3600, 2 + 7 / 60 + 46.380 / 3600, 73.0)
"""Latitude 53°48'33.820" N, longitude 2°07'46.380" E, 73 m: the example of the IOGP's Guidance Note 373-7-2 for methods 9602 and
9837, whose topocentric origin is at latitude 55° N, longitude 5° E, 200 m."""
GEOCENTRIC = (3771793.968, 140253.342, 5124304.349)
TOPOCENTRIC = (-189013.869, -128642.040, -4220.171)
THOUSANDTH_OF_A_SECOND = 1e-3 / 3600


def test_the_published_example_of_geocentric_coordinates() -> None:
    assert geocentric(*POINT) == pytest.approx(GEOCENTRIC, abs=1e-3)
    latitude, longitude, height = geographic(*GEOCENTRIC)
    assert (latitude, longitude) == pytest.approx(POINT[:2], abs=THOUSANDTH_OF_A_SECOND)
    assert height == pytest.approx(73.0, abs=1e-3)


def test_the_published_example_of_topocentric_coordinates() -> None:
    latitude, longitude, height = TangentPlane(55.0, 5.0, 200.0, 0.0).geodetic(TOPOCENTRIC)
    assert (latitude, longitude) == pytest.approx(POINT[:2], abs=THOUSANDTH_OF_A_SECOND)
    assert height == pytest.approx(73.0, abs=1e-3)


@given(latitude=st.floats(-90.0, 90.0), longitude=st.floats(-180.0, 180.0), height=st.floats(-500.0, 20_000.0))
def test_the_way_back_meets_the_point_within_a_tenth_of_a_micrometre(
    latitude: float, longitude: float, height: float
) -> None:
    place = geocentric(latitude, longitude, height)
    assert geocentric(*geographic(*place)) == pytest.approx(place, abs=1e-7)
    assert geographic(*place)[2] == pytest.approx(height, abs=1e-7)


@pytest.mark.parametrize("latitude", [-90.0, -45.0, 0.0, 45.0, 90.0])
def test_the_origin_of_the_world_is_where_the_scene_says(latitude: float) -> None:
    found = TangentPlane(latitude, 8.54, 408.0, 30.0).geodetic((0.0, 0.0, 0.0))
    assert found[0] == pytest.approx(latitude, abs=1e-12)
    assert found[2] == pytest.approx(408.0, abs=1e-8)
    assert abs(latitude) == 90.0 or found[1] == pytest.approx(8.54, abs=1e-12)


@pytest.mark.parametrize(("heading", "east", "north"), [(0, 1, 0), (90, 0, 1), (180, -1, 0), (-90, 0, -1)])
def test_a_metre_along_x_goes_where_the_heading_says_by_the_radii_of_curvature(
    heading: float, east: float, north: float
) -> None:
    """A short way is M dphi to the north and N cos(phi) dlambda to the east, with the radii of curvature M and N."""
    phi, a, e2 = math.radians(47.38), 6378137.0, 6.69437999014e-3
    w = 1.0 - e2 * math.sin(phi) ** 2
    meridian, normal = a * (1.0 - e2) / w**1.5, a / math.sqrt(w)
    latitude, longitude, height = TangentPlane(47.38, 8.54, 0.0, heading).geodetic((1.0, 0.0, 0.0))
    assert math.radians(latitude - 47.38) * meridian == pytest.approx(north, abs=1e-6)
    assert math.radians(longitude - 8.54) * normal * math.cos(phi) == pytest.approx(east, abs=1e-6)
    assert height == pytest.approx(0.5 / a, rel=0.02)  # the ellipsoid falls away by d²/2a


def test_an_error_is_to_the_east_to_the_north_and_upwards_whatever_the_heading() -> None:
    turned, level = (TangentPlane(10.0, 20.0, 0.0, heading) for heading in (77.0, 0.0))
    assert turned.geodetic((0.0, 0.0, 0.0), (3.0, 4.0, 5.0)) == pytest.approx(level.geodetic((3.0, 4.0, 5.0)))
