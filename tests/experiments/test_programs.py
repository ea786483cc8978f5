"""Programs that scenarios start."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from graphengine.experiments.programs import ProgramError, Programs
from tests.experiments.harness import result_of, scenario_file


@pytest.fixture
def programs(tmp_path: Path) -> Programs:
    return Programs(tmp_path, {**os.environ, "ROS_DOMAIN_ID": "7"}, tmp_path, allowed=True)


def python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


def test_a_program_runs_in_the_folder_with_the_domain_and_its_output_is_kept(
    programs: Programs, tmp_path: Path
) -> None:
    list(programs.start(python("import os; print(os.getcwd(), os.environ['ROS_DOMAIN_ID'])")))
    time.sleep(0.5)
    programs.close()
    (output,) = tmp_path.glob("1-*.txt")
    assert output.read_text() == f"{tmp_path} 7\n"


def test_a_program_that_fails_is_an_error_with_its_last_output(programs: Programs) -> None:
    list(programs.start(python("import sys; print('no map'); sys.exit(3)")))
    time.sleep(0.5)
    with pytest.raises(ProgramError, match=r"ended with exit code 3\n  no map"):
        programs.check()
    programs.close()


def test_a_program_ends_with_its_children(programs: Programs, tmp_path: Path) -> None:
    child = (
        "import os, signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); "
        "open('up', 'w').write(str(os.getpid())); time.sleep(60)"
    )
    list(programs.start(python(f"import subprocess, sys; subprocess.run([sys.executable, '-c', {child!r}])")))
    up = tmp_path / "up"
    while not up.exists() or not up.read_text():
        time.sleep(0.05)
    programs.close()
    status = Path("/proc", up.read_text(), "stat")
    assert not status.exists() or status.read_text().rpartition(")")[2].split()[0] == "Z"


def test_an_unknown_program_is_an_error(programs: Programs) -> None:
    with pytest.raises(ProgramError, match="start no_such_program: No such file"):
        programs.start(["no_such_program"])


def test_no_program_is_started_unless_it_is_allowed(tmp_path: Path) -> None:
    path = scenario_file(
        tmp_path, f'transport: memory\ndo: [start: [{sys.executable}, -c, \'open("made", "w")\'], wait: 1s]\n'
    )
    result = result_of(path)
    assert (result.outcome, "only with --allow-programs" in result.reason) == ("error", True)
    assert not (tmp_path / "made").exists()
    assert result_of(path, programs=True).outcome == "passed"
    assert (tmp_path / "made").exists()
