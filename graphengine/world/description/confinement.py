"""Processes that read a stranger's files: all are bounded in time and memory, some confined to those files as well."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

from graphengine.files import Files

MAX_CPU_SECONDS = 20
MAX_MEMORY_BYTES = 1 << 30

_HARMLESS = frozenset(
    ("compile", "exec", "builtins.id", "glob.glob", "glob.glob/2", "object.__getattr__", "sys._getframe")
)
_READING = frozenset(("open", "os.listdir", "os.scandir", "os.walk"))
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class ProcessError(Exception):
    """A process that did not come to its end; says why. `answer` is what it had said by then."""

    def __init__(self, message: str, answer: bytes) -> None:
        super().__init__(message)
        self.answer = answer


class RefusedError(Exception):
    """What a file asked for and does not get; says what to do."""


def ask(module: str, request: bytes, seconds: float) -> bytes:
    """What a module writes when it is run with a request as its input; it sees no environment and gets so many seconds.

    Raises:
        ProcessError: it takes longer, or ends before it should.
    """
    command = [sys.executable, "-P", "-s", "-m", module]
    environment = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONHASHSEED": "0"}
    environment["OPENBLAS_NUM_THREADS"] = "1"  # each thread takes of the memory that the process may have
    try:
        done = subprocess.run(command, input=request, capture_output=True, timeout=seconds, env=environment)
    except subprocess.TimeoutExpired as error:
        raise ProcessError(f"takes more than {seconds:g} s", error.stdout or b"") from None
    if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        raise ProcessError("takes more time or memory than it may", done.stdout)
    if done.returncode < 0:
        raise ProcessError(f"breaks off: {signal.strsignal(-done.returncode)}", done.stdout)
    if done.returncode > 0:
        told = done.stderr.decode("utf-8", "replace").split("\n")
        raise ProcessError(next(filter(None, reversed(told)), f"ended with {done.returncode}"), done.stdout)
    return done.stdout


def bound() -> None:
    """Bound the time and memory of this process for good; it writes no file."""
    for kind, value in (
        (resource.RLIMIT_CPU, MAX_CPU_SECONDS),
        (resource.RLIMIT_AS, MAX_MEMORY_BYTES),
        (resource.RLIMIT_FSIZE, 0),
    ):
        hard = resource.getrlimit(kind)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(kind, (value, value))
    warnings.simplefilter("ignore")  # their text comes from source files


def confine(files: Files) -> None:
    """Bound this process: from here on it also reads only what `files` lets it, which notes it, and only pipes leave it.

    An audit hook is told of everything that Python does to the outside. It is a second wall: what is evaluated here should
    not get that far.
    """
    bound()
    os.environ.clear()

    def judge(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _HARMLESS:
            return
        if event not in _READING or not isinstance(arguments[0], str | os.PathLike):
            raise RefusedError(f"{event} is not allowed here")
        if event == "open" and arguments[2] & _WRITING:
            raise RefusedError(f"{str(arguments[0])!r} cannot be written from here")
        check_readable(Path(arguments[0]), files)
        if event == "open":
            files.note(Path(arguments[0]))

    sys.addaudithook(judge)


def check_readable(path: Path, files: Files) -> None:
    """Refuse a file outside of what may be read.

    Raises:
        RefusedError: it is.
    """
    if not files.may_read(path):
        remedy = f"allow it with --allow {path.resolve().parent}"
        raise RefusedError(f"{str(path)!r} lies outside the folder of the file you gave\n{remedy}")
