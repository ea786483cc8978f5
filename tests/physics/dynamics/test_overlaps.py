"""What is put into something."""

from __future__ import annotations

import pytest

from graphengine.devices.entity import Move
from tests.physics.dynamics.things import add, run, world
from tests.physics.harness import SCENE, Project

BLOCK = '<body name="{}" pos="{} 0 .5"><freejoint/><geom type="box" size=".5 .5 .5" mass="10"/></body>'


def test_a_body_placed_inside_another_overlaps_by_its_depth(project: Project) -> None:
    wall = '<body name="wall" pos="5 0 0"><geom type="box" size=".5 5 5"/></body>'
    simulation = world(project, wall, BLOCK.format("block", 2)).simulation
    assert simulation.entities.overlaps("block") == []
    simulation.entities.place("block", Move((4.12, 0, 0.48)))
    deepest, other = simulation.entities.overlaps("block")
    assert (deepest.other, other.other) == ("wall", "floor")
    assert (deepest.depth, other.depth) == pytest.approx((0.12, 0.02))
    assert simulation.entities.overlaps("bot") == []


def test_robots_placed_inside_each_other_overlap_mutually(project: Project) -> None:
    simulation = world(project, BLOCK.format("one", 2), BLOCK.format("two", 4)).simulation
    simulation.entities.place("one", Move((3.2, 0, 0.5)))
    for name, other in (("one", "two"), ("two", "one")):
        (found,) = simulation.entities.overlaps(name)
        assert found.other == other
        assert found.depth == pytest.approx(0.2)


def test_a_body_at_rest_does_not_overlap_with_its_support(project: Project) -> None:
    simulation = world(project, BLOCK.format("block", 2), BLOCK.format("heavy", 4).replace("10", "1000")).simulation
    run(simulation, 0.5)
    assert simulation.entities.overlaps("block") == simulation.entities.overlaps("heavy") == []


def test_a_robot_spawned_inside_a_body_overlaps_with_the_body(project: Project) -> None:
    loaded = world(project, BLOCK.format("block", -4))
    add(loaded, "late", -3.4)
    (found,) = loaded.simulation.entities.overlaps("late")
    assert found.other == "block"
    assert found.depth == pytest.approx(0.1)


def test_an_arm_that_is_bolted_to_the_world_does_not_overlap_with_itself(project: Project) -> None:
    project.robot("fixed_base: true")
    loaded = world(project, BLOCK.format("block", 2))
    loaded.simulation.entities.place("bot", Move((1.4, 0, 0.5)))
    (found,) = loaded.simulation.entities.overlaps("bot")
    assert found.other == "block"
    assert found.depth == pytest.approx(0.1)


def test_shapes_that_pass_through_each_other_do_not_overlap(project: Project) -> None:
    ghost = '<body name="ghost" pos="5 0 1"><geom type="box" size=".5 5 5" contype="0" conaffinity="0"/></body>'
    simulation = world(project, ghost, BLOCK.format("block", 2)).simulation
    simulation.entities.place("block", Move((5, 0, 0.5)))
    assert simulation.entities.overlaps("block") == []


FIXED = '<body name="{}" pos="{}"><geom type="box" size=".5 .5 .5"/></body>'


@pytest.mark.parametrize(
    ("things", "height", "touched"),
    [
        ([], 0.05, {}),
        ([], 0.03, {}),
        ([("table", "0 0 -.4")], 0.15, {}),
        ([("table", "0 0 -.4")], 0.12, {"bot": ("table", 0.03), "table": ("bot", 0.03)}),
        ([("wall", ".699 0 0")], 0.05, {"bot": ("wall", 0.001), "wall": ("bot", 0.001)}),
        ([("wall", ".8 0 0")], 0.05, {}),
        ([("crate", "0 0 .5")], 0.2, {"bot": ("crate", 0.4), "crate": ("bot", 0.4)}),
    ],
    ids=["on the floor", "in the floor", "on a table", "in a table", "leaning", "beside", "within"],
)
def test_a_robot_touches_all_bodies_but_its_support(
    project: Project, things: list[tuple[str, str]], height: float, touched: dict[str, tuple[str, float]]
) -> None:
    """The cart's box is 0.4 m long, 0.3 m wide and 0.1 m high; only its base is near anything."""
    project.write("scene.yaml", SCENE.replace("0.1]", f"{height}]"))
    simulation = world(project, *(FIXED.format(*thing) for thing in things)).simulation
    found = {name: (overlap.other, overlap.depth) for name, overlap in simulation.entities.touching().items()}
    assert {name: other for name, (other, _) in found.items()} == {n: other for n, (other, _) in touched.items()}
    for name, (_, depth) in touched.items():
        if name == "bot":
            assert found[name][1] == pytest.approx(depth, abs=0.05)


def test_robots_that_touch_each_other_both_do(project: Project) -> None:
    found = project.scene("  other: {use: bot.yaml, position: [0.3, 0, 0.1]}\n").load().simulation.entities.touching()
    assert {name: overlap.other for name, overlap in found.items()} == {"bot": "other", "other": "bot"}
