"""Bounds of a filter: boxes that only touch them are inside, boxes at any distance are not."""

from __future__ import annotations

from itertools import pairwise

import pytest

from graphengine.control.simulation_interfaces.filters import BOX, SPHERE, overlap
from graphengine.devices.entity import Box
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS

CRATE = Box((0.0, 0.0, 0.0), (1.0, 2.0, 4.0))


def overlaps(kind: int, *points: tuple[float, float, float]) -> bool:
    bounds = DEFINITIONS.initial("simulation_interfaces/msg/Bounds")
    bounds.type, bounds.points = kind, [messages.Vector3(*point) for point in points]
    test = overlap(bounds)
    assert test is not None
    return test(CRATE)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1, 1])
def test_a_box_that_touches_the_bounds_is_inside(axis: int, side: int) -> None:
    low, high = [0.25, 0.25, 0.25], [0.75, 0.75, 0.75]
    face = CRATE.low[axis] if side < 0 else CRATE.high[axis]
    for distance, inside in ((0.0, True), (0.125, False)):
        near, far = sorted((face + side * distance, face + side * (distance + 1.0)))
        low[axis], high[axis] = near, far
        for one, other in pairwise([low, high, low]):
            assert overlaps(BOX, (*one,), (*other,)) == inside  # type: ignore[arg-type]
        centre = [0.5, 0.5, 0.5]
        centre[axis] = face + side * (1.0 + distance)
        assert overlaps(SPHERE, (*centre,), (1.0, 0.0, 0.0)) == inside  # type: ignore[arg-type]
