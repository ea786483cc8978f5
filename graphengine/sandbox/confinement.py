"""Starts processes that read untrusted files, and provides functions with which these processes confine themselves."""

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
from graphengine.format.wording import allowing, quoted
from graphengine.sandbox import landlock, seccomp
from graphengine.sandbox.seccomp import Tier

MAX_CPU_SECONDS = 20
"""CPU time after which the kernel ends a confined process, s."""
MAX_MEMORY_BYTES = 1 << 30
"""Maximum address space of a confined process, bytes."""
MAX_THREADS = 4096
"""Maximum number of threads of the user (RLIMIT_NPROC); with more, a confined process cannot start a thread."""
_NOBODY = 65534
"""User ID of `nobody`; a process of root takes it as real user ID, because the kernel does not limit the threads of root."""
MAX_ANSWER_BYTES = 256_000_000
"""Maximum size of the answer of a confined process, bytes."""
MAX_REASON = 1000
"""Maximum number of characters of the last line on stderr, which becomes the message of a ProcessError."""
MAX_COMPLAINT_BYTES = 1_000_000
"""Maximum number of bytes that are read from the stderr of a process."""

_HARMLESS = frozenset(
    ("compile", "exec", "builtins.id", "glob.glob", "glob.glob/2", "object.__getattr__", "sys._getframe")
)
_READING = frozenset(("open", "os.listdir", "os.scandir", "os.walk"))
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class ProcessError(Exception):
    """A process failed or exceeded a limit.

    The message is the reason, usually without a subject, such as `takes more than 3 s`. `answer` is the output until then.
    """

    def __init__(self, message: str, answer: bytes) -> None:
        super().__init__(message)
        self.answer = answer


class AccessDeniedError(Exception):
    """A confined process attempted an access that is not allowed. The message may contain a remedy in a second line."""


def ask(module: str, request: bytes, seconds: float) -> bytes:
    """Run a Python module in a new process, write the request to its stdin, and return its stdout.

    The process gets no environment variables of this process.

    Raises:
        ProcessError: the process runs for more than `seconds`, fails, or writes more than `MAX_ANSWER_BYTES`.
    """
    command = [sys.executable, "-P", "-s", "-m", module]
    environment = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONHASHSEED": "0"}
    environment["OPENBLAS_NUM_THREADS"] = "1"  # each thread uses part of the limited memory
    environment["_ROS_WHEELS_BOOTSTRAP_COMPLETE"] = "1"  # else wheels of ROS 2 from PyPI start the process twice
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
            complaints = complaint.result().decode("utf-8", "replace").split("\n")
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        finally:  # also after KeyboardInterrupt, because Ctrl-C does not reach the new session
            timer.cancel()
            _kill(process)
        code = process.wait()
        asking.result()
    if len(answer) > MAX_ANSWER_BYTES:
        raise ProcessError(f"writes more than {MAX_ANSWER_BYTES // 1_000_000} MB of output", b"")
    if late.is_set():
        raise ProcessError(f"takes more than {seconds:g} s", answer)
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        raise ProcessError("exceeds its limit of CPU time or memory", answer)
    if code < 0:
        raise ProcessError(f"crashed: {signal.strsignal(-code)}", answer)
    if code > 0:
        reason = next(filter(None, reversed(complaints)), f"ended with exit code {code}")
        raise ProcessError(reason[:MAX_REASON], answer)
    return answer


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and all processes that it started, which form a group; `wait` must not have been called yet."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _write(stream: IO[bytes], request: bytes) -> None:
    with contextlib.suppress(BrokenPipeError), stream:  # the process may end before it has read the request
        stream.write(request)


def bound(memory: int = MAX_MEMORY_BYTES) -> None:
    """Limit the CPU time, memory (bytes) and number of threads of this process permanently, and deny it writing files."""
    for kind, value in (
        (resource.RLIMIT_CPU, MAX_CPU_SECONDS),
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_NPROC, MAX_THREADS),
    ):
        hard = resource.getrlimit(kind)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(kind, (value, value))
    warnings.simplefilter("ignore")  # a warning would quote source files, which may not be read


def confine(
    files: Files,
    tier: Tier,
    also: Collection[str] = (),
    memory: int = MAX_MEMORY_BYTES,
    libraries: Collection[Path] = (),
) -> None:
    """Limit and confine this process permanently; afterwards it can read only the files that `files` allows.

    Call this before the process reads untrusted data, while it has one thread. The kernel confines all code with Landlock and
    seccomp, if it has them. In addition, an audit hook raises AccessDeniedError with a readable message for Python code, and
    records which files are opened.

    Args:
        files: the files that may be read.
        tier: whether the process may open files and start threads.
        also: additional audit events to allow; they must not change anything outside the process.
        memory: memory limit, bytes.
        libraries: additional folders from which native libraries may read.

    Raises:
        OSError, RuntimeError: a kernel feature that is available cannot be enabled.
    """
    bound(memory)
    os.environ.clear()
    if tier.threads and sys.platform == "linux" and os.geteuid() == 0:
        with contextlib.suppress(OSError):  # a container without this user: its root is an ordinary user outside
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
        AccessDeniedError: the file may not be read.
    """
    if not files.may_read(path):
        beside = [root for root in files.roots if not path.is_absolute() and (root / path).exists()]
        start = f"relative paths begin at the folder where graphrun runs: cd {quoted(beside[0])}" if beside else ""
        remedy = start or allowing(package_folder(path))
        raise AccessDeniedError(f"{str(path)!r} lies outside the folder of the file you gave\n{remedy}")
