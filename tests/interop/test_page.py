"""The page on interoperability that is committed: it has each cell, and only what cannot work does not."""

from __future__ import annotations

import pytest

from tests.interop.cells import COLUMNS, HINT, MAY_FAIL, ROWS
from tests.interop.page import DISTROS_TITLE, PAGE, distros_section, render
from tests.interop.result import Result

ALL = [(row, *column) for row in ROWS for column in COLUMNS]


@pytest.fixture(scope="module")
def page() -> str:
    return PAGE.read_text("utf-8")


def test_each_cell_works_or_is_one_of_those_that_cannot(page: str) -> None:
    for row in ROWS:
        cells = ["no" if (row, *column) in MAY_FAIL else "yes" for column in COLUMNS]
        assert f"\n| {row} | {' | '.join(cells)} |\n" in page


def test_each_cell_has_figures(page: str) -> None:
    for row in ROWS:
        (section,) = [part for part in page.split("\n### ") if part.startswith(f"{row}\n")]
        lines = [
            line for line in section.partition("\n## ")[0].splitlines() if "rmw_" in line and line.startswith("| ")
        ]
        assert len(lines) == len(COLUMNS)
        assert all(any(letter.isdigit() for letter in line) or "| no: " in line for line in lines)


def test_the_page_says_what_to_do_instead(page: str) -> None:
    assert HINT in page
    assert "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp" in page


def test_the_differences_between_distributions_are_up_to_date(page: str) -> None:
    assert page[page.index(DISTROS_TITLE) :] == distros_section().lstrip("\n")


def test_the_page_names_no_place_of_a_machine(page: str) -> None:
    assert "/tmp" not in page
    assert "/home" not in page


def test_no_page_is_made_when_a_cell_has_no_result() -> None:
    results = [Result(*cell, works=True, text="1/1") for cell in ALL[1:]]
    with pytest.raises(ValueError, match="without a result"):
        render(results)


def test_only_services_actions_and_parameters_between_embedded_dds_and_fast_dds_may_fail() -> None:
    assert {column[1:] for column in MAY_FAIL} == {("dds", "rmw_fastrtps_cpp")}
    assert {row for row, *_ in MAY_FAIL} == {
        "service server",
        "service client",
        "action server",
        "action client",
        "parameters",
    }
