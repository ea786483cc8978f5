"""Workers: crashes, hangs, memory and kills are rows or leave no trace."""

from __future__ import annotations

import os
import signal
import time
from functools import partial
from pathlib import Path

from tests.experiments.falling import (
    ABORTS,
    HANGS,
    HOGS,
    PASSES,
    finish,
    processes,
    rows,
    run,
    start,
    without_wall,
    write_scenario,
)
from tests.waiting import eventually


def children(process: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def test_a_run_that_crashes_hangs_or_eats_memory_is_one_row_with_its_reason(tmp_path: Path) -> None:
    write_scenario(tmp_path, [0], [PASSES, ABORTS, HANGS, HOGS])
    limits = ("--time-limit", "5", "--memory-limit", "900")
    assert "4 runs: 3 error, 1 passed" in run(tmp_path, "--results", "rows.jsonl", *limits, code=1)
    assert [row["reason"] for row in rows(tmp_path / "rows.jsonl")] == [
        "",
        "its process ended with signal SIGABRT, 2 times",
        "no result after 5 s of wall time (--time-limit)",
        "its process used more than 900 MB of memory (--memory-limit)",
    ]


def test_killed_workers_and_drivers_leave_the_same_rows_in_the_end(tmp_path: Path) -> None:
    folders = tmp_path / "whole", tmp_path / "killed"
    for folder in folders:
        folder.mkdir()
        write_scenario(folder, range(60), [PASSES])
    run(folders[0], "--results", "rows.jsonl", "-n", "2")
    path = folders[1] / "rows.jsonl"
    with start(folders[1], "--results", "rows.jsonl", "-n", "2") as driver:
        assert eventually(lambda: lines(path) >= 5)
        os.kill(children(driver.pid)[0], signal.SIGKILL)
        before = lines(path)
        assert eventually(lambda: lines(path) >= before + 5)
        workers = children(driver.pid)
        driver.kill()
    assert lines(path) < 60
    assert eventually(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers))
    finish(start(folders[1], "--results", "rows.jsonl", "--resume"), 0)
    assert without_wall(path) == without_wall(folders[0] / "rows.jsonl")


def test_an_interrupt_ends_the_workers_and_keeps_whole_rows(tmp_path: Path) -> None:
    write_scenario(tmp_path, range(200), [PASSES])
    path = tmp_path / "rows.jsonl"
    with start(tmp_path, "--results", "rows.jsonl", "-n", "2") as driver:
        assert eventually(lambda: lines(path) >= 3)
        workers = children(driver.pid)
        driver.send_signal(signal.SIGINT)
        begin = time.monotonic()
        assert driver.wait(timeout=30) == 2
        assert time.monotonic() - begin < 10
    assert not any(Path(f"/proc/{worker}").exists() for worker in workers)
    assert path.read_bytes().endswith(b"\n")


PROGRAM = """
transport: memory
do:
  - start: [sleep, "SECONDS"]
  - set: {address: Script.harm, value: HANGS}
"""


def test_the_programs_of_a_run_that_hangs_end_with_it(tmp_path: Path) -> None:
    seconds = f"1000.{os.getpid()}"  # no other program sleeps as long
    write_scenario(tmp_path, [0], [PASSES], PROGRAM.replace("SECONDS", seconds).replace("HANGS", str(HANGS)))

    command = f"sleep\0{seconds}\0".encode()
    with start(tmp_path, "--results", "rows.jsonl", "--allow-programs", "--time-limit", "8") as driver:
        assert eventually(lambda: processes(command))
        assert driver.wait(timeout=60) == 1
    assert not processes(command)
    assert "--time-limit" in rows(tmp_path / "rows.jsonl")[0]["reason"]


def have_ended(numbers: list[int]) -> bool:
    return not any(Path(f"/proc/{number}").exists() for number in numbers)


def test_the_programs_of_a_worker_that_is_killed_end_with_it(tmp_path: Path) -> None:
    """The first worker and the second one, which repeats the run, are killed while a program of theirs runs."""
    seconds = f"1001.{os.getpid()}"
    write_scenario(tmp_path, [0], [PASSES], PROGRAM.replace("SECONDS", seconds).replace("HANGS", str(HANGS)))

    command = f"sleep\0{seconds}\0".encode()
    with start(tmp_path, "--results", "rows.jsonl", "--allow-programs") as driver:
        for _ in range(2):
            assert eventually(lambda: processes(command))
            running = processes(command)
            time.sleep(0.5)  # several looks at the worker
            os.kill(children(driver.pid)[0], signal.SIGKILL)
            assert eventually(partial(have_ended, running))
        assert driver.wait(timeout=60) == 1
    assert not processes(command)
    assert rows(tmp_path / "rows.jsonl")[0]["reason"] == "its process ended with signal SIGKILL, 2 times"
