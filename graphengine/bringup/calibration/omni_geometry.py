"""Computes the rolling radii of omni wheels, whose axles have several directions, from wheel angles and true motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graphengine.bringup.calibration.figures import Floats
from graphengine.devices.rotation import Vector3

PARALLEL = 0.99
"""Minimum cosine of the angle between the y axis of the base link and the axle of a wheel that rolls along the x axis."""
LEVEL = 0.3
"""Maximum cosine of the angle between the axle of a wheel and the vertical."""
_LEAST = 1e-3
"""Smallest singular value (m) of the test drives that still separates forward, sideways and turning motion."""


def is_oblique(axle: Vector3) -> bool:
    """Return whether an axle is level and points neither left nor right; its wheel does not roll along the x axis."""
    return abs(axle[1]) < PARALLEL and abs(axle[2]) < LEVEL


def rolling_directions(axles: Sequence[Vector3]) -> Floats:
    """Return the direction (x, y) in which each wheel rolls at positive joint speed, shape (number of wheels, 2)."""
    return np.array([(axle[1], -axle[0]) for axle in axles]).reshape(-1, 2)


def rolling_radii(motions: Floats, angles: Floats, directions: Floats) -> Floats | None:
    """Return the rolling radius of each wheel, m; None unless the motions include forward, sideways and turning motion.

    The angle of a wheel is linear in the motion of the base; along the rolling direction, the coefficient is 1 / radius.

    Args:
        motions: motion of the base in each test drive: forward and left (m), and turn (rad); shape (drives, 3).
        angles: angle of each wheel in each test drive, rad, shape (drives, wheels).
        directions: rolling direction of each wheel, shape (wheels, 2).
    """
    coefficients, _, _, singular = np.linalg.lstsq(motions, angles, rcond=None)
    if len(singular) < 3 or singular[-1] < _LEAST:
        return None
    along = np.einsum("dw,wd->w", coefficients[:2], directions)
    radii: Floats = 1.0 / np.where(along, along, np.nan)
    return radii


def base_motion(angles: Floats, radii: Floats, places: Floats, directions: Floats) -> Floats:
    """Return the motion of the base (forward and left, m, and turn, rad) with the best fit to the angles of its wheels.

    Args:
        angles: angle of each wheel, rad.
        radii: radius of each wheel, m.
        places: centre (x, y) of each wheel in the frame of the base link, m.
        directions: rolling direction of each wheel.
    """
    levers = places[:, 0] * directions[:, 1] - places[:, 1] * directions[:, 0]
    solution = np.linalg.lstsq(np.column_stack((directions, levers)), radii * angles, rcond=None)[0]
    return np.asarray(solution, dtype=float)
