"""What a process that reads a stranger's files may do: bounded work, and no file, program or network but those files."""

from __future__ import annotations

import os
import resource
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


class RefusedError(Exception):
    """What a file asked for and does not get; says what to do."""


def confine(files: Files) -> None:
    """Bound this process for good: from here on it reads what `files` lets it, and nothing else leaves it but pipes.

    An audit hook is told of everything that Python does to the outside. It is a second wall: what is evaluated here should
    not get that far.
    """
    _limit(resource.RLIMIT_CPU, MAX_CPU_SECONDS)
    _limit(resource.RLIMIT_AS, MAX_MEMORY_BYTES)
    _limit(resource.RLIMIT_FSIZE, 0)
    os.environ.clear()
    warnings.simplefilter("ignore")  # their text comes from source files

    def judge(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _HARMLESS:
            return
        if event not in _READING or not isinstance(arguments[0], str | os.PathLike):
            raise RefusedError(f"{event} is not allowed here")
        if event == "open" and arguments[2] & _WRITING:
            raise RefusedError(f"{str(arguments[0])!r} cannot be written from here")
        check_readable(Path(arguments[0]), files)

    sys.addaudithook(judge)


def _limit(kind: int, value: int) -> None:
    """Bound a resource, no looser than it is."""
    hard = resource.getrlimit(kind)[1]
    bound = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(kind, (bound, bound))


def check_readable(path: Path, files: Files) -> None:
    """Refuse a file outside of what may be read.

    Raises:
        RefusedError: it is.
    """
    if not files.may_read(path):
        remedy = f"allow it with --allow {path.resolve().parent}"
        raise RefusedError(f"{str(path)!r} lies outside the folder of the file you gave\n{remedy}")
