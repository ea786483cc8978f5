"""Processes that read untrusted files: all are limited in time and memory, and some are confined to reading those files."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any

from graphengine.format.files import Files
from graphengine.format.ros_packages import package_folder
from graphengine.sandbox import landlock, seccomp
from graphengine.sandbox.seccomp import Tier

MAX_CPU_SECONDS = 20
MAX_MEMORY_BYTES = 1 << 30
MAX_THREADS = 4096
"""Threads of the user, beyond which a confined process starts no more."""
_NOBODY = 65534
"""A user whose threads the kernel counts, as it does not count root's."""
MAX_ANSWER_BYTES = 256_000_000
MAX_REASON = 1000
"""Characters of what it complains of last."""
MAX_COMPLAINT_BYTES = 1_000_000
"""Of what a process tells on its two outputs; who reads it has not more memory than it."""

_HARMLESS = frozenset(
    ("compile", "exec", "builtins.id", "glob.glob", "glob.glob/2", "object.__getattr__", "sys._getframe")
)
_READING = frozenset(("open", "os.listdir", "os.scandir", "os.walk"))
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class ProcessError(Exception):
    """A process did not complete; the message gives the reason, and `answer` holds its output until then."""

    def __init__(self, message: str, answer: bytes) -> None:
        super().__init__(message)
        self.answer = answer


class AccessDeniedError(Exception):
    """An untrusted file requested access that is not allowed; the message contains the remedy."""


def ask(module: str, request: bytes, seconds: float) -> bytes:
    """Run a module with a request as its input, without environment variables, for at most `seconds`; return its output.

    Raises:
        ProcessError: the process takes longer, or fails.
    """
    command = [sys.executable, "-P", "-s", "-m", module]
    environment = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONHASHSEED": "0"}
    environment["OPENBLAS_NUM_THREADS"] = "1"  # each thread takes of the memory that the process may have
    pipe = subprocess.PIPE
    with (
        subprocess.Popen(
            command, env=environment, stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True
        ) as process,
        ThreadPoolExecutor(2) as pool,
    ):
        assert process.stdin
        assert process.stdout
        assert process.stderr
        late = threading.Event()

        def stop() -> None:
            late.set()
            _kill(process)

        timer = threading.Timer(seconds, stop)
        timer.start()
        try:
            complaint = pool.submit(process.stderr.read, MAX_COMPLAINT_BYTES)
            asking = pool.submit(_write, process.stdin, request)
            answer = process.stdout.read(MAX_ANSWER_BYTES + 1)
            if len(answer) > MAX_ANSWER_BYTES:
                _kill(process)
            told = complaint.result().decode("utf-8", "replace").split("\n")
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        finally:  # also what the user interrupts, as the terminal does not reach it
            timer.cancel()
            _kill(process)
        code = process.wait()
        asking.result()
    if len(answer) > MAX_ANSWER_BYTES:
        raise ProcessError(f"writes more than {MAX_ANSWER_BYTES // 1_000_000} MB", b"")
    if late.is_set():
        raise ProcessError(f"takes more than {seconds:g} s", answer)
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        raise ProcessError("exceeds its limit of CPU time or memory", answer)
    if code < 0:
        raise ProcessError(f"crashed: {signal.strsignal(-code)}", answer)
    if code > 0:
        raise ProcessError(next(filter(None, reversed(told)), f"ended with {code}")[:MAX_REASON], answer)
    return answer


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process that was not waited for yet, and all processes that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _write(stream: IO[bytes], request: bytes) -> None:
    with contextlib.suppress(BrokenPipeError), stream:  # the process may end before it read what it was asked
        stream.write(request)


def bound(memory: int = MAX_MEMORY_BYTES) -> None:
    """Limit time and memory (bytes) of this process permanently; it can write no files afterwards."""
    for kind, value in (
        (resource.RLIMIT_CPU, MAX_CPU_SECONDS),
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_NPROC, MAX_THREADS),
    ):
        hard = resource.getrlimit(kind)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(kind, (value, value))
    warnings.simplefilter("ignore")  # their text comes from source files


def confine(
    files: Files,
    tier: Tier,
    also: Collection[str] = (),
    memory: int = MAX_MEMORY_BYTES,
    libraries: Collection[Path] = (),
) -> None:
    """Limit this process and enable the kernel's confinement: from here on it can only read what `files` allows.

    Call this before reading anything untrusted, while one thread runs. The kernel's confinement holds for any code; an audit
    hook only gives a readable error for what it denies, and records which files are read.

    Args:
        files: files that may be read.
        tier: additional permissions.
        also: additional audit events to allow, which must not change anything outside the process.
        memory: limit, bytes.
        libraries: folders that native libraries read themselves.

    Raises:
        OSError, RuntimeError: a kernel feature that is available cannot be enabled.
    """
    bound(memory)
    os.environ.clear()
    if tier.threads and sys.platform == "linux" and os.geteuid() == 0:
        with contextlib.suppress(OSError):  # in a container that has no such user root is one whose threads are counted
            os.setresuid(_NOBODY, -1, -1)
    if landlock.available():
        landlock.restrict((*libraries, *files.roots, *files.links()) if tier.files else ())
    if seccomp.available():
        seccomp.restrict(tier)

    def judge(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _HARMLESS or event in also:
            return
        if event not in _READING or not isinstance(arguments[0], str | os.PathLike):
            raise AccessDeniedError(f"{event} is not allowed here")
        if event == "open" and arguments[2] & _WRITING:
            raise AccessDeniedError(f"{str(arguments[0])!r} may not be written")
        check_readable(Path(arguments[0]), files)
        if event == "open":
            files.note(Path(arguments[0]))

    sys.addaudithook(judge)


def check_readable(path: Path, files: Files) -> None:
    """Check that a file may be read.

    Raises:
        AccessDeniedError: it may not be read.
    """
    if not files.may_read(path):
        beside = [root for root in files.roots if not path.is_absolute() and (root / path).exists()]
        allow = f"allow it with --allow {package_folder(path)}"
        remedy = f"relative paths begin at the folder where graphrun runs: cd {beside[0]}" if beside else allow
        raise AccessDeniedError(f"{str(path)!r} lies outside the folder of the file you gave\n{remedy}")
