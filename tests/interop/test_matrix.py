"""The interop matrix, run against the ROS 2 that is sourced: every cell works, except those that cannot."""

from __future__ import annotations

import pytest

from tests.interop.cells import COLUMNS, MAY_FAIL, ROWS
from tests.interop.matrix import missing, run_column
from tests.interop.result import Result

pytestmark = [pytest.mark.ros(missing()), pytest.mark.timeout(3600)]


@pytest.fixture(scope="module", params=COLUMNS, ids=" ".join)
def column(request: pytest.FixtureRequest) -> dict[str, Result]:
    kind, rmw = request.param
    return {result.row: result for result in run_column(kind, rmw, list(ROWS))}


def test_no_cell_is_empty(column: dict[str, Result]) -> None:
    assert list(column) == list(ROWS)
    assert all(result.text for result in column.values())


@pytest.mark.parametrize("row", ROWS)
def test_a_cell_works_unless_it_cannot(column: dict[str, Result], row: str) -> None:
    """A cell that begins to work fails here: take it out of MAY_FAIL, and write the page again."""
    result = column[row]
    may_fail = (row, result.kind, result.rmw) in MAY_FAIL
    assert result.works is not may_fail, result.text
    assert result.told is may_fail, "graphrun prints no remedy"
