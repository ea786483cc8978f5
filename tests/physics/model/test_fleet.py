"""Which robots a scene's entries stand for."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.spec import RobotUse
from graphengine.physics.model.fleet_expansion import place
from tests.physics.harness import Project

SCENE = "scene: test\nworld: world.xml\nrobots:\n"


def fleet(project: Project, entry: str) -> Project:
    return project.write("scene.yaml", f"{SCENE}  bot: {entry}\n")


def test_a_count_stands_in_rows(project: Project) -> None:
    fleet(project, "{use: bot.yaml, count: 5, per_row: 2, spacing: [2, 3], position: [1, 1, 0.1]}")
    robots = project.load().robots
    positions = [robot.placement.pose[0] for robot in robots.values()]
    assert list(robots) == ["bot_0000", "bot_0001", "bot_0002", "bot_0003", "bot_0004"]
    assert positions == [(1, 1, 0.1), (3, 1, 0.1), (1, 4, 0.1), (3, 4, 0.1), (1, 7, 0.1)]


def test_physics_has_each_robot_where_it_was_put(project: Project) -> None:
    loaded = fleet(project, "{use: bot.yaml, count: 3, spacing: [2, 2], position: [0, 0, 0.5]}").load()
    for index in range(3):
        position, _ = loaded.simulation.body(loaded.stage.find(f"/bot_{index:04}/base_link")).pose()
        assert position == pytest.approx((2.0 * index, 0.0, 0.5))


def test_places_are_relative_to_the_pose_of_the_fleet(project: Project) -> None:
    place_there = "{position: [2, 0, 0], orientation: {rpy_deg: [0, 0, 90]}}"
    entry = f"position: [1, 0, 0], orientation: {{rpy_deg: [0, 0, 90]}}, places: [{{}}, {place_there}]"
    fleet(project, f"{{use: bot.yaml, {entry}}}")
    first, second = (robot.placement.pose for robot in project.load().robots.values())
    assert first[0] == pytest.approx((1, 0, 0))
    assert second[0] == pytest.approx((1, 2, 0))
    assert second[1] == pytest.approx((0, 0, 1, 0), abs=1e-12)


def test_robots_of_a_fleet_are_namespaces_of_their_names(project: Project) -> None:
    fleet(project, "{use: bot.yaml, count: 2, spacing: [2, 2]}\n  lone: {use: bot.yaml, position: [0, 9, 0]}")
    stage = project.load().stage
    assert stage.namespaces("/bot_0001/base_link/graph") == ["bot_0001"]
    assert stage.namespaces("/lone/base_link/graph") == []


@pytest.mark.parametrize(
    ("pattern", "namespace"),
    [("{name}", "bot_0001"), ("team/{name}", "team/bot_0001"), ("r{index}", "r1"), ("r{index:04}", "r0001")],
)
def test_a_namespace_may_be_a_pattern(project: Project, pattern: str, namespace: str) -> None:
    fleet(project, f'{{use: bot.yaml, count: 2, spacing: [2, 2], namespace: "{pattern}"}}')
    assert project.load().stage.namespaces("/bot_0001/base_link") == [namespace]


def test_a_namespace_of_a_single_robot_may_be_a_pattern_too(project: Project) -> None:
    fleet(project, '{use: bot.yaml, namespace: "{name}"}')
    assert project.load().stage.namespaces("/bot/base_link") == ["bot"]


def test_notes_on_a_robot_file_are_given_once_for_all_its_robots(project: Project) -> None:
    project.robot("materials:\n  Rubber: {bind: [base_link]}")
    fleet(project, "{use: bot.yaml, count: 4, spacing: [2, 2]}")
    assert sum("Rubber" in finding.message for finding in project.try_load()[1].items) == 1


@pytest.mark.parametrize(
    ("entry", "code", "words"),
    [
        ("{use: bot.yaml, count: 2}", "G109", "needs a `spacing`"),
        ("{use: bot.yaml, spacing: [1, 1]}", "G109", "need a `count`"),
        ("{use: bot.yaml, count: 0, spacing: [1, 1]}", "G109", "count"),
        ("{use: bot.yaml, count: 1001, spacing: [1, 1]}", "G109", "count"),
        ("{use: bot.yaml, count: 2, spacing: [1, -1]}", "G109", "spacing"),
        ("{use: bot.yaml, count: 2, spacing: [1, 1], places: [{}]}", "G109", "not both"),
        ("{use: bot.yaml, count: 2, spacing: [1, 1], namespace: same}", "S105", "2 robots would share the namespace"),
        ('{use: bot.yaml, count: 2, spacing: [1, 1], namespace: "{number}"}', "G109", "has an unknown placeholder"),
        ('{use: bot.yaml, namespace: "{name.__class__}"}', "G109", "has an unknown placeholder"),
        ("{use: bot.yaml, count: 2, spacing: [1, 1]}\n  bot_0001: {use: bot.yaml}", "S105", "two robots are named"),
    ],
)
def test_a_fleet_that_cannot_be_is_an_error(project: Project, entry: str, code: str, words: str) -> None:
    error = fleet(project, entry).error()
    assert f"error {code}" in error
    assert words in error


@given(count=st.integers(1, 60), per_row=st.none() | st.integers(1, 70), dx=st.floats(0.1, 9), dy=st.floats(0.1, 9))
def test_no_two_robots_of_a_fleet_share_a_name_or_a_place(
    count: int, per_row: int | None, dx: float, dy: float
) -> None:
    found = list(place("bot", RobotUse(use="bot.yaml", count=count, per_row=per_row, spacing=(dx, dy))))
    assert len({robot.name for robot in found}) == len({robot.namespace for robot in found}) == count
    assert len({robot.pose[0] for robot in found}) == count
