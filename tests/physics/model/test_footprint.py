"""The outline of a robot on the floor, against shapes whose outline is known."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.physics.model.footprint import circle_radius, collider_points, convex_hull, radii, simplified

SHAPES = {
    "box": '<geom type="box" size="0.3 0.2 0.1"/>',
    "lying cylinder": '<geom type="cylinder" size="0.2 0.3" euler="0 90 0"/>',
    "standing cylinder": '<geom type="cylinder" size="0.2 0.3"/>',
    "capsule": '<geom type="capsule" size="0.1 0.2" euler="0 90 0"/>',
    "ellipsoid": '<geom type="ellipsoid" size="0.3 0.2 0.1"/>',
    "sphere": '<geom type="sphere" size="0.2"/>',
}
EXTENTS = {
    "box": (0.3, 0.2),
    "lying cylinder": (0.3, 0.2),
    "standing cylinder": (0.2, 0.2),
    "capsule": (0.3, 0.1),
    "ellipsoid": (0.3, 0.2),
    "sphere": (0.2, 0.2),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_each_shape_reaches_as_far_as_its_colliders(shape: str) -> None:
    outline = np.array(convex_hull(_points(SHAPES[shape])[:, :2]))
    assert np.abs(outline).max(axis=0) == pytest.approx(EXTENTS[shape], abs=1e-6)


@pytest.mark.parametrize(
    ("shape", "radius"), [("standing cylinder", 0.2), ("sphere", 0.2), ("box", None), ("capsule", None)]
)
def test_only_the_outline_of_a_round_shape_is_a_circle(shape: str, radius: float | None) -> None:
    assert circle_radius(convex_hull(_points(SHAPES[shape])[:, :2])) == pytest.approx(radius, abs=1e-5)


def test_visuals_and_other_robots_are_no_part_of_the_outline() -> None:
    points = _points('<geom type="box" size="0.1 0.1 0.1"/><geom type="box" size="1 1 1" contype="0" conaffinity="0"/>')
    assert np.abs(points).max() == pytest.approx(0.1)


Coordinates = st.floats(-2.0, 2.0)
Clouds = st.lists(st.tuples(Coordinates, Coordinates), min_size=3, max_size=40)


@given(Clouds)
def test_no_point_lies_outside_of_its_hull(cloud: list[tuple[float, float]]) -> None:
    hull = convex_hull(np.array(cloud))
    for (ax, ay), (bx, by) in zip(hull, [*hull[1:], hull[0]], strict=True):
        length = math.hypot(bx - ax, by - ay)
        if len(hull) > 2:
            assert all((bx - ax) * (y - ay) - (by - ay) * (x - ax) >= -1e-5 * length - 1e-9 for x, y in cloud)


def test_simplifying_a_circle_keeps_its_radius_within_the_tolerance() -> None:
    angles = np.arange(64) * (math.tau / 64)
    circle = [(math.cos(angle), math.sin(angle)) for angle in angles]
    kept = simplified(circle, 0.01)
    inner, outer = radii(kept)
    assert len(kept) < 40
    assert outer == pytest.approx(1.0)
    assert inner > 1.0 - 2.0 * 0.01


def test_a_base_outside_of_the_outline_has_no_inner_circle() -> None:
    assert radii([(1.0, -1.0), (2.0, 0.0), (1.0, 1.0)]) == (0.0, 2.0)


def _points(geoms: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    text = f"""<mujoco><worldbody>
      <body name="robot/base"><freejoint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>{geoms}</body>
      <body name="robot2/base"><geom type="sphere" size="5"/></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return collider_points(model, data, "robot")
