"""ROS domains of runs at the same time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.experiments.domains import free_domain

HOLD = "from graphengine.experiments.domains import free_domain\nwith free_domain() as n: print(n, flush=True); input()"


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


def test_runs_in_two_processes_get_different_domains_and_give_them_back() -> None:
    with subprocess.Popen([sys.executable, "-c", HOLD], stdin=-1, stdout=-1, text=True) as other:
        assert other.stdout is not None
        taken = int(other.stdout.readline())
        with free_domain() as own:
            assert own != taken
        other.communicate("\n", timeout=20)
    with free_domain() as own:
        assert own == taken


def test_a_folder_to_which_others_can_write_is_refused(tmp_path: Path) -> None:
    with free_domain():
        (folder,) = tmp_path.iterdir()
    folder.chmod(0o777)
    with pytest.raises(Exception, match="others can write to it"), free_domain():
        pass
