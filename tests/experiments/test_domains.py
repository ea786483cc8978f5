"""ROS domains of runs at the same time."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.api.session import Session
from graphengine.experiments.domains import LOCAL, free_domain
from graphengine.ros.domain import Domain
from tests.experiments.harness import result_of, scenario_file

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


def test_the_domain_of_the_user_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    with free_domain() as own:
        pass
    monkeypatch.setenv("ROS_DOMAIN_ID", str(own))
    with free_domain() as other:
        assert other != own


@pytest.mark.parametrize(("given", "used"), [(None, "LOCALHOST"), ("SUBNET", "SUBNET")])
def test_a_run_and_its_programs_stay_on_this_machine_unless_the_user_says_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: str | None, used: str
) -> None:
    for name in (LOCAL, "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    if given is not None:
        monkeypatch.setenv(LOCAL, given)
    (outputs := tmp_path / "outputs").mkdir()
    path = scenario_file(tmp_path, f"do: [start: [sh, -c, 'echo ${LOCAL} $ROS_DOMAIN_ID'], wait: 1s]\n")
    ranges: list[str] = []

    def watch(session: Session) -> None:
        ranges.append(Domain.from_environment(session._runner.options.environ).discovery_range)

    result = result_of(path, programs=True, outputs=outputs, watch=watch)
    assert (result.outcome, ranges, os.environ.get(LOCAL)) == ("passed", [used], given), result.report()
    assert (outputs / "1-sh.txt").read_text() == f"{used} {result.domain}\n"


def test_a_folder_to_which_others_can_write_is_refused(tmp_path: Path) -> None:
    with free_domain():
        (folder,) = tmp_path.iterdir()
    folder.chmod(0o777)
    with pytest.raises(Exception, match="others can write to it"), free_domain():
        pass
