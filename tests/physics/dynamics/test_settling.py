"""Coming to rest before the start."""

from __future__ import annotations

import math

import mujoco
import pytest

from graphengine.physics.dynamics.settling import SETTLE_LIMIT, SETTLED_FOR, SETTLED_SPEED, settle

SPRING = f"""
<mujoco>
  <option timestep="0.005" gravity="0 0 0"/>
  <worldbody>
    <body><joint type="slide" stiffness="{4 * math.pi**2}"/><geom size=".1" mass="1"/></body>
  </worldbody>
</mujoco>
"""


def settled_after(fastest: float) -> float | None:
    """The time that a mass takes which swings once a second without an end, by its greatest speed, m/s."""
    model = mujoco.MjModel.from_xml_string(SPRING)
    data = mujoco.MjData(model)
    data.qpos[0] = fastest / (2 * math.pi)
    return settle(model, data, lambda: mujoco.mj_step(model, data))


def test_what_swings_faster_than_the_bound_is_not_at_rest_though_it_often_turns_around() -> None:
    at_turns = 2 * SETTLE_LIMIT * math.asin(0.1) / math.pi
    assert at_turns > 3 * SETTLED_FOR
    assert settled_after(10 * SETTLED_SPEED) is None


def test_what_swings_slower_than_the_bound_is_at_rest() -> None:
    assert settled_after(0.9 * SETTLED_SPEED) == pytest.approx(SETTLED_FOR, abs=0.006)
