"""What the tests of the network share: domains of their own, and waiting for what comes in its own time."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable, Iterator

import pytest

PATIENCE = 20.0  # s; what is waited for comes within a second on an idle machine

_offsets = itertools.count()


@pytest.fixture
def domain_id() -> int:
    """A domain that no other test of this process uses, and hardly one of another."""
    return 101 + (os.getpid() * 7 + next(_offsets)) % 99


@pytest.fixture
def eventually() -> Callable[[Callable[[], object]], bool]:
    def wait(condition: Callable[[], object]) -> bool:
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline:
                return False
            time.sleep(0.005)
        return True

    return wait


@pytest.fixture(autouse=True)
def environment_is_left_alone() -> Iterator[None]:
    before = dict(os.environ)
    yield
    changed = {name for name in before | dict(os.environ) if before.get(name) != os.environ.get(name)}
    assert changed <= {"PYTEST_CURRENT_TEST"}
