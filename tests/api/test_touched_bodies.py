"""The bodies that an object touches in a tick."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import graphengine as ge

RADIUS, GAP = 0.1, 0.3  # m
BALL = '<body name="{name}" pos="{x} 0 0.3"><freejoint/><geom size="0.1" gap="{gap}"/></body>'
"""A ball 0.2 m above the floor: MuJoCo lists the contact from the beginning, because of the gap, but applies no force."""


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[ge.Session]:
    balls = "".join(BALL.format(name=f"ball_{number}", x=2 * number, gap=GAP) for number in range(60))
    floor = '<geom name="floor" type="plane" size="9 9 1"/>'
    (tmp_path / "world.xml").write_text(f"<mujoco><worldbody>{floor}{balls}</worldbody></mujoco>")
    (tmp_path / "scene.yaml").write_text("{scene: hall, world: world.xml, physics: {tick_rate: 100, substeps: 4}}")
    with ge.load(tmp_path / "scene.yaml").session() as session:
        yield session


def test_a_contact_at_a_distance_is_no_touch(sim: ge.Session) -> None:
    """Of 60 balls, which MuJoCo lists as contacts in one order, the last one falls: sqrt(2 * 0.2 m / g) = 0.202 s."""
    ball = sim.body("ball_59")
    assert len(sim.mujoco.data.contact.geom) == 60
    touched: list[tuple[str, ...]] = []
    while len(touched) < 40 and (not touched or touched[-1] == ()):
        sim.step()
        touched.append(ball.touched)
    assert touched[-1] == ("floor",)
    assert sim.time == pytest.approx(0.202, abs=0.011)
    assert ball.pose.position[2] == pytest.approx(RADIUS, abs=0.02)  # 2 m/s for 0.01 s


def test_the_contacts_of_one_tick_do_not_count_in_the_next(sim: ge.Session) -> None:
    ball = sim.body("ball_3")
    sim.run(1.0)
    assert "floor" in ball.touched
    sim.move("ball_3", position=(6.0, 0.0, 5.0))
    sim.step()
    assert not ball.touched


def test_contacts_are_observed_after_a_return_to_a_checkpoint_from_before_the_first_observation(
    sim: ge.Session,
) -> None:
    mark = sim.checkpoint()
    ball = sim.body("ball_0")
    assert not ball.touched
    sim.restore(mark)
    assert not ball.touched
    sim.run(1.0)
    assert "floor" in ball.touched


def test_all_contacts_stay_at_one_address(sim: ge.Session) -> None:
    """The observation keeps views of MuJoCo's contacts."""
    data = sim.mujoco.data
    addresses = set()
    mark = sim.checkpoint()
    for action in (sim.step, lambda: sim.restore(mark), sim.reset, lambda: sim.run(0.5)):
        action()
        addresses.add(data.contact.dist.__array_interface__["data"][0])
    assert len(addresses) == 1
