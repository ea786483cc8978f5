"""Each limit accepts an input at its value, and refuses or cuts one beyond; none is without a test."""

from __future__ import annotations

from itertools import chain
from pathlib import Path

import pytest

from tests.limits import foundations, isaac, network, physics, robot_files, sessions, surfaces
from tests.limits.exempt import BOUNDS_NO_INPUT, TESTED
from tests.limits.table import LIMITS, ROOT, Limit, named_limits

ENTRIES = (foundations, isaac, network, physics, robot_files, sessions, surfaces)
"""Modules that enter their functions into the table when they are imported."""


@pytest.mark.parametrize("one", LIMITS, ids=lambda one: one.name)
def test_a_limit_accepts_its_value_and_nothing_beyond(
    one: Limit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert one.try_it(tmp_path, monkeypatch) == (True, False)


def test_no_limit_is_without_a_test() -> None:
    ways = [{one.name for one in LIMITS}, {*TESTED}, {*chain.from_iterable(BOUNDS_NO_INPUT.values())}]
    known = set.union(*ways)
    found = set(named_limits())
    assert sorted(found - known) == [], "enter these limits into the table: see tests/limits/table.py"
    assert sorted(known - found) == [], "these limits are gone: remove their entries"
    assert sum(map(len, ways)) == len(known), "a limit has an entry of two kinds"


@pytest.mark.parametrize("test", sorted({*TESTED.values()}))
def test_the_test_that_covers_a_limit_is_there(test: str) -> None:
    path, _, name = test.partition("::")
    assert f"def {name}(" in (ROOT / path).read_text(encoding="utf-8")
