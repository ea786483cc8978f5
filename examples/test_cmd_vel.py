"""Tests the graph `cmd_vel` of a robot. It needs `pip install pytest`; run it with `pytest examples/test_cmd_vel.py`."""

import pytest

from graphengine import Session
from graphengine.testing import session_fixture

SPEED = "cmd_vel/DiffController.velocityCommand"  # of the left and the right wheel, rad/s
RADIUS = 0.049  # of a wheel, m

sim = session_fixture("dd100_flat", set={"DiffController.maxLinearSpeed": 0.8})


def test_the_wheels_follow_a_twist_with_limited_acceleration(sim: Session) -> None:
    sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
    sim.run(0.2)
    assert sim.value(SPEED)[0] * RADIUS < 0.3
    sim.run(0.8)
    assert sim.value(SPEED) * RADIUS == pytest.approx([0.5, 0.5])


def test_a_speed_above_the_limit_is_cut(sim: Session) -> None:
    sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 3.0}}, every=0.1)
    sim.run(2.0)
    assert sim.robots["dd100"].velocity.linear[0] == pytest.approx(0.8, abs=0.01)


def test_silence_for_half_a_second_stops_the_robot(sim: Session) -> None:
    drive = sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
    sim.run(1.5)
    drive.close()
    assert sim.run(2.0, until=lambda s: abs(s.robots["dd100"].velocity.linear[0]) < 0.01)
