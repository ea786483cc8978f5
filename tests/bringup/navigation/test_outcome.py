"""Outcomes of goals as a table and as JUnit XML."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.bringup.navigation.goal_list import NavigationGoal
from graphengine.bringup.navigation.outcome import HEADER, Outcome, error_name, rows, write_junit

EAST = NavigationGoal(1.0, 2.0, 0.5, "east <&>")
WHOLE = Outcome(EAST, "reached", "", 12.34, 5.678, 0.1, 0.2, 0.1, 3, (0.01, 0.05))
NOTHING = Outcome(NavigationGoal(1.0, -2.5, 0.0), "not sent", "server lost")


def test_a_table_has_all_figures_with_their_units() -> None:
    header, whole, nothing = rows([WHOLE, NOTHING])
    assert header == HEADER
    assert whole[:5] == ("east <&>", "reached", "12.3 s", "5.68 m", "0.100 m")
    assert whole[5:] == ("0.200 m, 5.7 deg", "3", "mean 0.010 m, max 0.050 m", "")
    assert nothing == ("1 -2.5 0", "not sent", "-", "-", "-", "-", "-", "-", "server lost")


def test_error_codes_have_names() -> None:
    assert [error_name(code) for code in (0, 105, 206, 723, 4711)] == [
        "",
        "FAILED_TO_MAKE_PROGRESS (105)",
        "GOAL_OCCUPIED (206)",
        "drive on heading COLLISION_AHEAD (723)",
        "error (4711)",
    ]


def test_junit_has_a_case_for_each_goal(tmp_path: Path) -> None:
    write_junit(tmp_path / "out.xml", [WHOLE, NOTHING], "nav2 goals /a")
    suite = ElementTree.parse(tmp_path / "out.xml").getroot()
    assert suite.attrib == {"name": "nav2 goals /a", "tests": "2", "failures": "1", "time": "12.340"}
    whole, nothing = suite.findall("testcase")
    assert whole.attrib == {"classname": "nav2 goals /a", "name": "east <&>", "time": "12.340"}
    assert {one.get("name"): one.get("value") for one in whole.iter("property")} == {
        "path_m": "5.678",
        "error_m": "0.1",
        "true_error_m": "0.2",
        "true_turn_rad": "0.1",
        "recoveries": "3",
        "localization_error_mean_m": "0.01",
        "localization_error_max_m": "0.05",
    }
    assert [one.get("message") for one in nothing.iter("failure")] == ["not sent: server lost"]


@given(st.text(st.characters()))
def test_junit_with_any_text_of_a_peer_can_be_read(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    file = tmp_path_factory.mktemp("junit") / "out.xml"
    write_junit(file, [Outcome(NavigationGoal(0.0, 0.0, 0.0, text), "aborted", f"{text}\0\ud800.")], text)
    (failure,) = ElementTree.parse(file).getroot().iter("failure")
    assert failure.get("message", "").endswith("\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}.")
