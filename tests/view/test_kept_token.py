"""The token of a page stays the same for the next run on the same port, unless others could know it."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from graphengine.view import kept_token as module
from graphengine.view.kept_token import kept_token


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    return {"XDG_RUNTIME_DIR": str(tmp_path)}


def test_a_chosen_port_keeps_its_token_in_a_file_of_the_user_alone(environment: dict[str, str], tmp_path: Path) -> None:
    token = kept_token(8080, environment)
    assert kept_token(8080, environment) == token
    assert kept_token(8081, environment) != token
    assert stat.S_IMODE((tmp_path / "graphrun/page-8080.token").stat().st_mode) == 0o600


def test_a_free_port_and_a_missing_folder_have_a_new_token_each_time(
    environment: dict[str, str], tmp_path: Path
) -> None:
    assert kept_token(0, environment) != kept_token(0, environment)
    (tmp_path / "graphrun").mkdir()
    (tmp_path / "graphrun").chmod(0o777)  # others may have written into it
    assert kept_token(8080, environment) != kept_token(8080, environment)


def test_a_folder_in_the_place_of_the_file_gives_a_new_token(environment: dict[str, str], tmp_path: Path) -> None:
    kept_token(8081, environment)
    (tmp_path / "graphrun/page-8080.token").mkdir()
    assert kept_token(8080, environment) != kept_token(8080, environment)


def _link(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))
    path.symlink_to(path.with_name("elsewhere"))


CHANGES: dict[str, Callable[[Path], object]] = {
    "readable by others": lambda path: path.chmod(0o644),
    "a link": _link,
    "a second name": lambda path: os.link(path, path.with_name("other")),
    "another text": lambda path: path.write_bytes(b"x" * 31),
    "from the future": lambda path: os.utime(path, (0.0, time.time() + 3600)),
    "too old": lambda path: os.utime(path, (0.0, time.time() - module.LONGEST_PAUSE - 60)),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_file_that_cannot_be_trusted_is_replaced(environment: dict[str, str], tmp_path: Path, change: str) -> None:
    token = kept_token(8080, environment)
    path = tmp_path / "graphrun/page-8080.token"
    CHANGES[change](path)
    new = kept_token(8080, environment)
    assert new != token
    assert path.read_text(encoding="ascii") == new == kept_token(8080, environment)
    assert not path.is_symlink()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
