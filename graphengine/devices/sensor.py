"""Quantities that devices, bodies and materials share. Units are SI; quaternions are (x, y, z, w)."""

from __future__ import annotations

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

Friction = tuple[float, float]
"""Static and dynamic friction."""

Light = tuple[float, Vector3]
"""Intensity, in times of what it is at the start, and colour (red, green, blue)."""
