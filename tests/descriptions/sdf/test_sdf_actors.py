"""Actors of SDF worlds, which become movers."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.descriptions.sdf.test_sdf_world import rejected, world
from tests.physics.harness import ticks

WALK = ((0, "0 2 0 0 0 0"), (2, "0 4 0 0 0 0"), (5, "3 4 0 0 0 0"))


def actor(more: str = "", waypoints: tuple[tuple[float, str], ...] = WALK, *, script: str = "") -> str:
    points = "".join(f"<waypoint><time>{time}</time><pose>{pose}</pose></waypoint>" for time, pose in waypoints)
    return (
        f'<actor name="walker"><pose>1 0 1 0 0 0</pose>{more}'
        f'<script>{script}<trajectory id="0" type="walk">{points}</trajectory></script></actor>'
    )


@pytest.mark.parametrize(
    ("script", "seconds", "expected"),
    [
        ("", 1.0, (1.0, 3.0, 0.0)),
        ("", 3.5, (2.5, 4.0, 0.0)),
        ("", 6.0, (1.0, 3.0, 0.0)),  # after its last time an actor jumps to its first point
        ("<loop>false</loop>", 9.0, (4.0, 4.0, 0.0)),
        ("<delay_start>2</delay_start>", 3.0, (1.0, 3.0, 0.0)),
        ("<auto_start>false</auto_start>", 3.0, (1.0, 2.0, 0.0)),
    ],
)
def test_an_actor_is_at_its_waypoints_at_their_times(
    tmp_path: Path, script: str, seconds: float, expected: tuple[float, float, float]
) -> None:
    simulation = world(tmp_path, actor(script=script))[0].simulation
    ticks(simulation, round(60 * seconds))
    assert simulation.entities.state("walker").position == pytest.approx(expected, abs=1e-9)
    assert [entity.kind for entity in simulation.entities.all()] == ["mover"]


def test_unused_parts_of_an_actor_are_reported(tmp_path: Path) -> None:
    skin = "<skin><filename>walk.dae</filename></skin>"
    _, findings = world(tmp_path, actor(skin), '<actor name="idle"><pose>5 5 1 0 0 0</pose></actor>')
    assert [(finding.code, finding.message) for finding in findings.items] == [
        ("N103", "actor 'walker' is drawn as a plain person that faces the way it walks"),
        ("W302", "actor 'idle' is left out: it has no name or no <trajectory> with waypoints"),
    ]


def test_times_that_do_not_ascend_are_an_error(tmp_path: Path) -> None:
    backwards = ((0, "0 2 0 0 0 0"), (2, "0 4 0 0 0 0"), (1, "3 4 0 0 0 0"))
    assert rejected(tmp_path, actor(waypoints=backwards)) == ["3: the times of waypoints must ascend: 1 s follows 2 s"]
