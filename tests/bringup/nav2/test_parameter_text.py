"""The template of Nav2's parameters: what its comments mean, and whether it uses only known values and facts."""

from __future__ import annotations

import re

from graphengine.bringup.nav2.parameter_text import parameter_lines
from graphengine.bringup.nav2.sourced import Sourced
from graphengine.bringup.nav2.text_files import TEMPLATES
from graphengine.format.templates import filled, holds

GIVEN = {
    "speed": Sourced(0.5, "the graph"),
    "pair": [1.0, -2.0],
    "scans": {"scan": {"topic": "/a"}, "scan1": {"topic": "/b"}},
}
FACTS = {"car": True, "slam": False, "busy": False}


def lines(*template: str, busy: bool = False) -> list[str]:
    return list(parameter_lines(template, GIVEN, {**FACTS, "busy": busy}))


def test_a_value_without_a_comment_is_from_nav2() -> None:
    assert lines("a: b::C") == ["a: b::C  # Nav2's own parameter file"]


def test_given_values_have_their_source_or_that_of_the_template() -> None:
    assert lines("a: $speed", "b: -$speed", "c: $speed  # half", "d: 1  # $speed") == [
        "a: 0.5  # the graph",
        "b: -0.5  # the graph",
        "c: 0.5  # half",
        "d: 1  # the graph",
    ]
    assert lines("a: -$pair  # both") == ["a: [-1.0, 2.0]  # both"]


def test_a_condition_holds_for_all_lines_below() -> None:
    assert lines("a:  # if slam", "  b:", "    c: 1", "a:  # if car and not slam", "  b: 2  # if car; x; y") == [
        "a:",
        "  b: 2  # x; y",
    ]


def test_the_option_busy_selects_its_own_values() -> None:
    template = "a: 0.1  # if car; busy: 0.5"
    assert lines(template) == ["a: 0.1  # Nav2's own parameter file"]
    assert lines(template, busy=True) == ["a: 0.5  # to tolerate a busy machine (--busy)"]


def test_a_block_is_repeated_for_each_name() -> None:
    assert lines("$scans:", "  topic: $topic  # t") == ["scan:", "  topic: /a  # t", "scan1:", "  topic: /b  # t"]


def test_every_condition_in_a_template_is_closed() -> None:
    for slam in (False, True):
        text = filled(
            TEMPLATES / "readme.txt",
            {"slam": slam, "fleet": False, "described": True},
            robots="r",
            scene="s",
            run="run",
            goal="g",
            map="m",
        )
        assert ("slam_toolbox" in text, "AMCL" in text) == (slam, not slam)
        assert not re.search(r"# (if|end)|\$", text)


def test_each_word_of_a_condition_in_the_parameter_template_is_a_fact() -> None:
    known = {"jazzy", "kilted", "lyrical", "dwb", "mppi", "rpp", "differential", "omni", "ackermann"}
    known |= {"busy", "car", "circular", "round", "slam"}
    conditions = re.findall(r"  # if ([\w ]+)", (TEMPLATES / "nav2_params.txt").read_text())
    assert len(conditions) > 50
    assert {word.removeprefix("not ") for text in conditions for word in text.split(" and ")} <= known
    assert holds("car and not slam", FACTS)
