"""The program as its users have it: in this process where speed counts, as a process of its own where signals and streams do."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.waiting import PATIENCE

ROOT = Path(__file__).resolve().parents[2]

SCENES = ["dd100_flat", "dd100_warehouse", "tutorial/flat_grid", "tutorial/navigation", "tutorial/simple_warehouse"]
GRAPHS = sorted(str(path.relative_to(ROOT / "graphs").with_suffix("")) for path in (ROOT / "graphs").rglob("*.yaml"))


@dataclass(frozen=True)
class Result:
    """What a command left behind."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """Lines of the standard output."""
        return self.out.splitlines()


Graphrun = Callable[..., Result]


def checked(result: Result, code: int | None = None, out: str | None = None, err: str | None = None) -> Result:
    """A command's result, which must have the exit code, and exactly the texts, that are given."""
    for told, wanted in ((result.code, code), (result.out, out), (result.err, err)):
        assert wanted is None or told == wanted, result
    return result


def environment(changes: Mapping[str, str] | None = None) -> dict[str, str]:
    """One in which the program is found, and which neither ROS 2 nor a CI system around it disturbs."""
    others = ("ROS_", "RMW_", "CYCLONE", "NO_COLOR", "FORCE_COLOR", "GITHUB_")
    inherited = {name: value for name, value in os.environ.items() if not name.startswith(others)}
    return {**inherited, "PYTHONPATH": str(ROOT), "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", **(changes or {})}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "graphengine.cli", *arguments]


def process(*arguments: str, cwd: Path = ROOT, env: Mapping[str, str] | None = None, **ended: Any) -> Result:
    """Run the program to its end in a process of its own; `ended` is what `checked` takes."""
    done = subprocess.run(
        command(*arguments),
        cwd=cwd,
        env=environment(env),
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE,
        check=False,
    )
    return checked(Result(done.returncode, done.stdout, done.stderr), **ended)


class Live:
    """A run that goes on until it is told to stop; what it says, and with `out` what it prints, arrives in `said`."""

    def __init__(
        self,
        *arguments: str,
        cwd: Path = ROOT,
        env: Mapping[str, str] | None = None,
        columns: int = 0,
        out: bool = False,
    ):
        self.said = ""
        if arguments[0] == "run" and "--rays" not in arguments:
            arguments += ("--rays", "mujoco")  # numba starts slowly; which rays a run takes is tested in this process
        if columns:
            self._reading, writing = pty.openpty()
            fcntl.ioctl(writing, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        else:
            self._reading, writing = os.pipe()
        self.process = subprocess.Popen(
            command(*arguments),
            cwd=cwd,
            env=environment(env),
            stdin=subprocess.DEVNULL,
            stdout=writing if out else None,
            stderr=writing,
            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),  # which a suite under nohup ignores
        )
        os.close(writing)

    def hear(self, wanted: Callable[[str], bool]) -> bool:
        """Read on until what was said is as wanted; False when the run ended before, or nothing comes."""
        deadline = time.monotonic() + PATIENCE
        while not wanted(self.said):
            ready, _, _ = select.select([self._reading], [], [], max(0.0, deadline - time.monotonic()))
            try:
                heard = os.read(self._reading, 65536) if ready else b""
            except OSError:  # a terminal whose other end was closed
                heard = b""
            if not heard:
                return wanted(self.said)
            self.said += heard.decode()
        return True

    def stop(self, number: signal.Signals) -> int:
        """Send a signal; the exit code when all was heard."""
        self.process.send_signal(number)
        self.hear(lambda said: False)
        return self.process.wait(PATIENCE)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._reading)


def live(*arguments: str, **options: Any) -> contextlib.closing[Live]:
    """A run for a `with` statement."""
    return contextlib.closing(Live(*arguments, **options))
