"""Each limit accepts what is at its value, and refuses or cuts what is one beyond."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.limits import foundations, physics
from tests.limits.table import LIMITS, ROOT, Limit, named_limits

@pytest.mark.parametrize("one", LIMITS, ids=lambda one: one.name)
def test_a_limit_accepts_its_value_and_nothing_beyond(one: Limit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert one.try_it(tmp_path, monkeypatch) == (True, False)
