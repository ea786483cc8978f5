"""Programs that scenarios start."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from graphengine.experiments.programs import ProgramError, Programs, ending
from graphengine.format.interrupts import by_sigterm
from tests.experiments.falling import start
from tests.experiments.harness import result_of, scenario_file
from tests.waiting import eventually


@pytest.fixture
def programs(tmp_path: Path) -> Programs:
    return Programs(tmp_path, {**os.environ, "ROS_DOMAIN_ID": "7"}, tmp_path, allowed=True)


def python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


def is_running(process: int) -> bool:
    status = Path(f"/proc/{process}/stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


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
    assert not is_running(int(up.read_text()))


@pytest.mark.parametrize(
    ("name", "message"),
    [("no_such_program", "start no_such_program: No such file"), ("tr\0ue", "start .*ue: embedded null")],
)
def test_a_program_that_cannot_be_started_is_an_error(programs: Programs, name: str, message: str) -> None:
    with pytest.raises(ProgramError, match=message):
        programs.start([name])


@pytest.mark.parametrize(("code", "text"), [(3, "exit code 3"), (-6, "signal SIGABRT"), (-40, "signal 40")])
def test_the_end_of_a_program_is_named(code: int, text: str) -> None:
    assert ending(code) == text


def test_a_program_that_ends_by_a_signal_without_a_name_is_an_error(programs: Programs) -> None:
    list(programs.start(["sh", "-c", "kill -40 $$"]))
    with pytest.raises(ProgramError, match="ended with signal 40"):
        eventually(lambda: programs.check())
    programs.close()


def end_during_a_program(folder: Path, *arguments: str, by: signal.Signals, trap: str = "") -> int:
    """End `graphrun test` by a signal while its program runs, wait until the program has ended, and return the exit code."""
    text = f'transport: memory\ndo: [start: [sh, -c, "{trap}echo $$ > up; exec sleep 300"], wait: 9000s]\n'
    scenario_file(folder, f"{text}stop: {{after: 9999s}}\n")
    up = folder / "up"
    with start(folder, "--allow-programs", *arguments) as driver:
        assert eventually(lambda: up.exists() and up.read_text())
        driver.send_signal(by)
        assert eventually(lambda: not is_running(int(up.read_text())))
        driver.communicate(timeout=60)
    return driver.returncode


def test_programs_are_ended_when_graphrun_test_is_ended(tmp_path: Path) -> None:
    assert end_during_a_program(tmp_path, by=signal.SIGTERM) == 2


def test_a_program_of_another_process_ends_with_graphrun_test(tmp_path: Path) -> None:
    assert end_during_a_program(tmp_path, "-n", "2", by=signal.SIGTERM) == 2
    (tmp_path / "up").unlink()
    rows = ("--results", "rows.jsonl")
    assert end_during_a_program(tmp_path, *rows, by=signal.SIGKILL, trap="trap '' INT TERM; ") == -signal.SIGKILL


def test_a_signal_that_arrives_while_a_program_starts_does_not_lose_the_program(
    programs: Programs, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = subprocess.Popen

    def interrupted(*arguments: Any, **options: Any) -> subprocess.Popen[bytes]:
        process: subprocess.Popen[bytes] = start(*arguments, **options)
        signal.raise_signal(signal.SIGTERM)
        return process

    monkeypatch.setattr(subprocess, "Popen", interrupted)
    with by_sigterm(), pytest.raises(KeyboardInterrupt):
        programs.start(["sleep", "60"])
    ((_, _, process),) = programs._running
    programs.close()
    assert process.returncode == -signal.SIGINT


def test_no_program_is_started_unless_it_is_allowed(tmp_path: Path) -> None:
    path = scenario_file(tmp_path, 'transport: memory\ndo: [start: [sh, -c, ": > made"], wait: 1s]\n')
    result = result_of(path)
    assert (result.outcome, "only with --allow-programs" in result.reason) == ("error", True)
    assert not (tmp_path / "made").exists()
    assert eventually(lambda: result_of(path, programs=True).outcome == "passed" and (tmp_path / "made").exists())
