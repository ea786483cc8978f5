"""The planar balance of forces on a base with skidding wheels, by Coulomb's law."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq, root

from tests.physics.bases import Base, Floats

GRAVITY = 9.81


def balanced(base: Base, along: float, across: float, left: float, right: float) -> Floats:
    """The steady twist (m/s, m/s, rad/s) of a base whose rims move at `left` and `right`, m/s.

    A contact that slides with (a, b) along and across its wheel bears the friction -N (along^2 a, across^2 b) / n, where n is the
    length of (along a, across b): the point of the friction ellipse that dissipates most. The forces add up to the mass times
    the centripetal acceleration, and their moments about the centre of mass to zero. Loads N balance the weight; they move to the
    outer wheels, as the centre of mass is above the floor by a radius. Near zero, n is rounded off; the rounding shrinks step by
    step.
    """
    centre = np.array(base.centre) / 1.2
    x, y = (np.array([getattr(wheel, axis) for wheel in base.wheels]) for axis in "xy")
    rims = np.where(y > 0, left, right)
    weight = 1.2 * base.mass * GRAVITY  # with the wheels, of a twentieth of the chassis each
    mass = weight / GRAVITY

    def rest(twist: Floats, rounding: float) -> Floats:
        ahead, aside, turn = twist
        forces = -mass * turn * (aside + turn * centre[0]), mass * turn * (ahead - turn * centre[1])
        moments = weight * centre - base.radius * np.array(forces)
        loads = weight / len(x) + moments[0] * x / np.sum(x * x) + moments[1] * y / np.sum(y * y)
        sliding = ahead - turn * y - rims, aside + turn * x
        length = np.sqrt((along * sliding[0]) ** 2 + (across * sliding[1]) ** 2 + rounding**2)
        pull, push = -loads * along**2 * sliding[0] / length, -loads * across**2 * sliding[1] / length
        moment = np.sum((x - centre[0]) * push - (y - centre[1]) * pull)
        return np.array([pull.sum() - forces[0], push.sum() - forces[1], moment]) / weight

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


def turning_track(base: Base, friction: float, speed: float, turn: float) -> float:
    """The track (m) with which a base with friction equal in all directions turns as commanded, as a mean of both directions."""

    def excess(track: float) -> float:
        slow, fast = speed - turn * track / 2, speed + turn * track / 2
        left, right = balanced(base, friction, friction, slow, fast), balanced(base, friction, friction, fast, slow)
        return float(left[2] - right[2]) / 2 - turn

    distance = 2 * abs(base.wheels[0].y)
    return float(brentq(excess, 0.9 * distance, 5.0 * distance, xtol=1e-4))
