"""The planar balance of forces on a base with four skidding wheels, by Coulomb's law."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import root

from tests.physics.bases import Base, Floats

GRAVITY = 9.81


def balanced(base: Base, along: float, across: float, left: float, right: float) -> Floats:
    """The steady twist (m/s, m/s, rad/s) of a base whose rims move at `left` and `right`, m/s.

    A contact that slides with (a, b) along and across its wheel bears the friction -N (along^2 a, across^2 b) / n, where n is the
    length of (along a, across b): the point of the friction ellipse that dissipates most. The forces add up to the mass times
    the centripetal acceleration, and their moments to zero. Loads N move to the outer wheels, as the centre of mass is above the
    floor by a radius. Near zero, n is rounded off; the rounding shrinks step by step.
    """
    x, y = (np.array([wheel.x for wheel in base.wheels]), np.array([wheel.y for wheel in base.wheels]))
    rims = np.where(y > 0, left, right)
    weight = 1.2 * base.mass * GRAVITY  # with the wheels, of a twentieth of the chassis each
    mass = weight / GRAVITY

    def rest(twist: Floats, rounding: float) -> Floats:
        ahead, aside, turn = twist
        forces = -mass * turn * aside, mass * turn * ahead
        loads = weight / 4 - base.radius * (forces[1] * y / np.sum(y * y) + forces[0] * x / np.sum(x * x))
        sliding = ahead - turn * y - rims, aside + turn * x
        length = np.sqrt((along * sliding[0]) ** 2 + (across * sliding[1]) ** 2 + rounding**2)
        pull, push = -loads * along**2 * sliding[0] / length, -loads * across**2 * sliding[1] / length
        return np.array([pull.sum() - forces[0], push.sum() - forces[1], np.sum(x * push - y * pull)]) / weight

    track = float(y.max() - y.min())
    twist: Floats = np.array([(left + right) / 2, 0.0, (right - left) / track])
    for rounding in np.geomspace(0.3, 1e-4, 24):
        found = root(rest, twist, args=(rounding,), options={"xtol": 1e-12})
        assert np.abs(found.fun).max() < 1e-6
        twist = found.x
    return twist


def sideslip(twist: Floats) -> float:
    """The angle from the heading of the base to its motion, rad."""
    return math.atan2(twist[1], twist[0])
