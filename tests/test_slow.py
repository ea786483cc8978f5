"""The list of tests that take long."""

from __future__ import annotations

import pytest

from tests.cli.harness import ROOT
from tests.conftest import SLOW


@pytest.mark.parametrize("line", SLOW)
def test_each_line_of_the_list_is_a_test_or_a_folder_of_tests(line: str) -> None:
    place, _, name = line.partition("::")
    assert (ROOT / place).exists()
    assert not name or f"def {name}(" in (ROOT / place).read_text(encoding="utf-8")
