"""Programs that a scenario starts, such as a controller under test."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from graphengine.format.errors import GraphError, UsageError
from graphengine.format.interrupts import deferred
from graphengine.format.wording import printable

GRACE = 5.0
"""Time that a program gets to end after SIGINT and again after SIGTERM, s, before it is killed."""
LAST = 2000
"""Number of characters of a program's output in an error."""


class ProgramError(GraphError):
    """A program of a scenario could not be started, or ended with an error during the run."""


def ending(code: int) -> str:
    """Return how a process with this return code has ended, such as `exit code 1` or `signal SIGKILL`."""
    names = {known.value: known.name for known in signal.Signals}
    return f"exit code {code}" if code >= 0 else f"signal {names.get(-code, -code)}"


def proc_fields(process: int, name: str) -> list[str]:
    """Return the fields of the file `/proc/PROCESS/NAME` of Linux; an empty list without this file."""
    try:
        return Path(f"/proc/{process}/{name}").read_text(encoding="ascii").split()
    except OSError:
        return []


def children(process: int) -> list[int]:
    """Return the processes that a process has started; an empty list without /proc."""
    return [int(child) for child in proc_fields(process, f"task/{process}/children")]


def signal_groups(leaders: Iterable[int], number: signal.Signals) -> None:
    """Send a signal to process groups; those that have ended are left out."""
    for leader in leaders:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, number)


class Programs:
    """The programs of one run. Each program leads its own process group; `close` ends the group.

    Args:
        folder: working folder of the programs.
        environ: their environment variables.
        outputs: folder for their outputs, `1-NAME.txt` and so on.
        allowed: whether programs may be started.
    """

    def __init__(self, folder: Path, environ: Mapping[str, str], outputs: Path, allowed: bool) -> None:
        self._folder = folder
        self._environ = environ
        self._outputs = outputs
        self._allowed = allowed
        self._running: list[tuple[str, Path, subprocess.Popen[bytes]]] = []

    def start(self, command: Sequence[str]) -> Iterator[None]:
        """Start a program; the next step begins at once.

        Raises:
            ProgramError: the program cannot be started.
            UsageError: programs are not allowed.
        """
        if not self._allowed:
            raise UsageError(f"start {command[0]}: a scenario may start programs only with --allow-programs")
        output = self._outputs / f"{len(self._running) + 1}-{Path(command[0]).name}.txt"
        try:
            # An interrupt within Popen would leave a program that nothing ends.
            with output.open("wb") as file, deferred():
                process = subprocess.Popen(
                    list(command),
                    cwd=self._folder,
                    env=dict(self._environ),
                    stdin=subprocess.DEVNULL,
                    stdout=file,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
                self._running.append((" ".join(command), output, process))
        except (OSError, ValueError) as error:  # ValueError: a null character
            reason = error.strerror if isinstance(error, OSError) else error
            raise ProgramError(f"start {printable(' '.join(command))}: {reason}") from None
        return iter(())

    def check(self) -> None:
        """Raise ProgramError if a program has ended with another exit code than 0."""
        for command, output, process in self._running:
            if process.poll():
                text = output.read_text(encoding="utf-8", errors="replace").strip()[-LAST:]
                how = ending(process.returncode)
                raise ProgramError(f"{command}: ended with {how}\n  " + "\n  ".join(text.splitlines() or ["no output"]))

    def close(self) -> None:
        """End all programs with their children: by SIGINT, then SIGTERM, then SIGKILL, which an interrupt sends at once."""
        processes = [process for _, _, process in self._running]
        try:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal_groups([process.pid for process in processes if process.poll() is None], number)
                for process in processes:
                    with contextlib.suppress(subprocess.TimeoutExpired):
                        process.wait(GRACE)
        finally:
            signal_groups([process.pid for process in processes], signal.SIGKILL)
            for process in processes:
                process.wait()
            self._running.clear()
