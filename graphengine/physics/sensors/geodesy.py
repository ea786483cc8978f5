"""Converts positions in a world to WGS84 coordinates. The world's xy plane is parallel to the ellipsoid below its origin.

The conversion is exact: from topocentric to geocentric coordinates (EPSG method 9836), then to geographic ones (EPSG method 9602,
with two rounds of Bowring's formula of 1976). Its error is below 0.1 µm up to a height of 20 km.
"""

from __future__ import annotations

import math

from graphengine.devices.rotation import Vector3

_A = 6378137.0
"""Equatorial radius of the ellipsoid, m."""
_F = 1.0 / 298.257223563
"""Flattening of the ellipsoid."""
_B = _A * (1.0 - _F)
_E2 = _F * (2.0 - _F)
"""Square of the first eccentricity."""
_EP2 = _E2 / (1.0 - _E2)
"""Square of the second eccentricity."""


class TangentPlane:
    """The frame of a world on Earth: z points up, and x points east if the heading is 0.

    Args:
        latitude: geodetic latitude of the world's origin, degrees.
        longitude: longitude of the world's origin, degrees.
        elevation: height of the world's origin above the ellipsoid, m.
        heading: angle from east to the world's x axis, counter-clockwise seen from above, degrees.
    """

    def __init__(self, latitude: float, longitude: float, elevation: float, heading: float) -> None:
        self._origin = geocentric(latitude, longitude, elevation)
        phi, lam, turn = math.radians(latitude), math.radians(longitude), math.radians(heading)
        sin, cos = math.sin(phi), math.cos(phi)
        self._heading = math.cos(turn), math.sin(turn)
        east, north = (-math.sin(lam), math.cos(lam), 0.0), (-sin * math.cos(lam), -sin * math.sin(lam), cos)
        up = (cos * math.cos(lam), cos * math.sin(lam), sin)
        self._axes = tuple(zip(east, north, up, strict=True))

    def geodetic(self, position: Vector3, error: Vector3 = (0.0, 0.0, 0.0)) -> Vector3:
        """Return latitude, longitude (degrees) and height above the ellipsoid (m) of a position.

        Args:
            position: position in the world frame, m.
            error: displacement to the east, to the north and upwards that is added to the position, m.
        """
        (x, y, z), (cos, sin) = position, self._heading
        local = x * cos - y * sin + error[0], x * sin + y * cos + error[1], z + error[2]
        u, v, w = (
            start + sum(axis * part for axis, part in zip(row, local, strict=True))
            for start, row in zip(self._origin, self._axes, strict=True)
        )
        return geographic(u, v, w)


def geocentric(latitude: float, longitude: float, height: float) -> Vector3:
    """Return the Cartesian coordinates (m) about the Earth's centre, z along its axis, for degrees and a height in m."""
    phi, lam = math.radians(latitude), math.radians(longitude)
    normal = _A / math.sqrt(1.0 - _E2 * math.sin(phi) ** 2)
    level = (normal + height) * math.cos(phi)
    return level * math.cos(lam), level * math.sin(lam), ((1.0 - _E2) * normal + height) * math.sin(phi)


def geographic(x: float, y: float, z: float) -> Vector3:
    """Return latitude, longitude (degrees) and height above the ellipsoid (m) for coordinates about the Earth's centre, m."""
    level = math.hypot(x, y)
    reduced = math.atan2(_A * z, _B * level)
    for _ in range(2):
        north, axial = z + _EP2 * _B * math.sin(reduced) ** 3, level - _E2 * _A * math.cos(reduced) ** 3
        reduced = math.atan2(_B * north, _A * axial)
    phi = math.atan2(north, axial)
    sin, cos = math.sin(phi), math.cos(phi)
    height = level * cos + z * sin - _A * math.sqrt(1.0 - _E2 * sin**2)
    return math.degrees(phi), math.degrees(math.atan2(y, x)), height
