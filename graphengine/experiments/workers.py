"""Workers: processes that make runs, within limits of time and memory. A run that ends its worker has a row with the reason."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from graphengine.api.scene_files import UnpackedScene
from graphengine.experiments.programs import children, ending, proc_fields, signal_groups
from graphengine.experiments.result_rows import WALL, Row, start_row
from graphengine.experiments.runs import Run
from graphengine.experiments.statistics import rerun_text
from graphengine.experiments.worker_process import GRACE, RunSettings

LOOK = 0.1
"""Time between two looks at the limits of a run, s."""
TRIES = 2
"""Number of workers that a run may end before this is its result: one may have been ended from outside."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a run.

    Attributes:
        seconds: wall time, s.
        memory: resident memory of its worker, bytes; observed on Linux only.
        reruns: number of all runs with the same seed after one has failed; 1 for no more.
    """

    seconds: float = math.inf
    memory: float = math.inf
    reruns: int = 1


class Worker:
    """A process that executes one run at a time. It is started for its first run, and again after a run has ended it.

    Args:
        settings: settings common to all runs.
        limits: limits of each run.
    """

    def __init__(self, settings: RunSettings, limits: Limits) -> None:
        self._settings = settings
        self._limits = limits
        self._process: subprocess.Popen[bytes] | None = None
        self.pipe: Any = None
        """Becomes ready to be read when a run has ended."""
        self._known: set[str] = set()
        self._programs: list[int] = []
        """Programs that the process was running at the last look; they can no longer be found when the process has ended."""

    @property
    def memory(self) -> int:
        """Resident memory of the process, bytes; 0 without a process or without /proc."""
        words = proc_fields(self._process.pid, "statm") if self._process is not None else []
        return int(words[1]) * os.sysconf("SC_PAGE_SIZE") if words else 0

    def begin(self, run: Run, place: UnpackedScene | None = None) -> None:
        """Begin a run; `place` is that of its unpacked scene."""
        self._run, self._place = run, place
        self._tries = self._runs = self._failures = 0
        self._first: Row | None = None
        self._send()

    def look(self) -> Row | None:
        """Return the row of the run if it has ended, or has been ended because of a limit; else None."""
        try:
            row = self.pipe.recv() if self.pipe.poll() else self._limited()
        except (EOFError, OSError):
            row = self._crashed()
        return self._counted(row) if row is not None else None

    def part(self) -> None:
        """Let the process end, without waiting."""
        if self._process is not None:
            self.pipe.close()

    def close(self) -> None:
        """End the process, after a run that goes on has closed its session and its programs."""
        self.part()
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(GRACE + 1.0)
            self._kill()

    def _send(self) -> None:
        if self._process is None:
            self._start()
        bundle = self._run.bundle
        key = f"{bundle.scenario.path} {bundle.inputs}"
        new = None if key in self._known else (bundle, self._place)
        self._known.add(key)
        self._begin = self._looked = time.monotonic()
        with contextlib.suppress(OSError):  # `look` finds that the process has ended
            self.pipe.send((key, new, self._run.case, self._run.number))

    def _start(self) -> None:
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-P", "-m", "graphengine.experiments.worker_process", str(theirs.fileno())]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
            start_new_session=True,  # Ctrl-C interrupts only the driver
        )
        theirs.close()
        self.pipe = Connection(ours.detach())
        self._known.clear()
        self.pipe.send(sys.path)
        self.pipe.send(self._settings)

    def _limited(self) -> Row | None:
        now = time.monotonic()
        if now - self._looked < LOOK or self._process is None:
            return None
        self._looked, self._programs = now, children(self._process.pid)
        if now - self._begin > self._limits.seconds:
            reason = f"no result after {self._limits.seconds:g} s of wall time (--time-limit)"
        elif self.memory > self._limits.memory:
            reason = f"its process used more than {self._limits.memory / 1e6:.0f} MB of memory (--memory-limit)"
        else:
            return None
        self._kill()
        return self._error(reason)

    def _crashed(self) -> Row | None:
        """Try again, or return the row of a run that ended its process."""
        code = self._kill(5.0)
        self._tries += 1
        if self._tries < TRIES:
            self._send()
            return None
        return self._error(f"its process ended with {ending(code)}, {TRIES} times")

    def _error(self, reason: str) -> Row:
        return start_row(self._run) | {"reason": reason, WALL: round(time.monotonic() - self._begin, 3)}

    def _counted(self, row: Row) -> Row | None:
        """Return the row, or begin the run again if it has failed and is to be repeated."""
        if self._first is None:
            if row["outcome"] != "failed" or self._limits.reruns < 2:
                return row
            self._first = row
        self._runs += 1
        self._failures += row["outcome"] != "passed"
        if self._runs < self._limits.reruns:
            self._tries = 0
            self._send()
            return None
        return self._first | {"rerun": rerun_text(self._failures, self._runs)}

    def _kill(self, patience: float = 0.0) -> int:
        """End the process and the programs that it has started; return its exit code."""
        process, self._process = self._process, None
        assert process is not None
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(patience)
        programs, self._programs = children(process.pid) or self._programs, []
        process.kill()
        signal_groups(programs, signal.SIGKILL)
        self.pipe.close()
        return process.wait()


class ProcessPool:
    """Makes runs in several processes of this machine.

    Args:
        number: number of processes.
        settings: settings common to all runs.
        limits: limits of each run.
    """

    def __init__(self, number: int, settings: RunSettings, limits: Limits) -> None:
        self.workers = [Worker(settings, limits) for _ in range(number)]

    def rows(self, runs: Iterable[Run]) -> Iterator[Row]:
        """Execute runs; yield the row of each run when the run ends."""
        waiting, idle, busy = iter(runs), list(self.workers), list[Worker]()
        while True:
            while idle and (run := next(waiting, None)) is not None:
                busy.append(idle.pop())
                busy[-1].begin(run)
            if not busy:
                return
            wait([worker.pipe for worker in busy], LOOK)
            for worker in tuple(busy):
                if (row := worker.look()) is not None:
                    busy.remove(worker)
                    idle.append(worker)
                    yield row

    def close(self) -> None:
        """End the processes, all at the same time."""
        for worker in self.workers:
            worker.part()
        for worker in self.workers:
            worker.close()
