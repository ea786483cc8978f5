"""The confined process that runs one script: it reads a request from stdin and writes the result to stdout.

The script can import stubs of Omniverse's modules, Python modules that are already loaded, and modules in its own folder. It can
read this folder, but cannot write files, use the network or start processes, and its time is limited.
"""

from __future__ import annotations

import builtins
import contextlib
import importlib
import io
import json
import linecache
import math
import os
import random
import re
import resource
import signal
import sys
import threading
import time
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import numpy.random  # scripts use it, but numpy would load it only when it is used

from graphengine.format.files import Files
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.modules import ROOTS
from graphengine.isaac.script.import_finder import OFFERED, ImportFinder
from graphengine.isaac.script.script_answer import ScriptAnswer
from graphengine.isaac.script.script_run import ScriptRun
from graphengine.sandbox.confinement import confine
from graphengine.sandbox.seccomp import TIERS
from graphengine.sandbox.untrusted import answer, reply

HARMLESS = frozenset(
    ("object.__setattr__", "object.__delattr__", "os.putenv", "os.unsetenv", "pathlib.Path.glob", "pathlib.Path.rglob")
)
"""Additional audit events that are allowed: they affect only this process, or list files whose access is checked later."""

NUMPY = ("char", "fft", "ma", "matlib", "polynomial", "rec", "testing", "typing")
"""Submodules that numpy loads when they are used; they are loaded before the script runs if its text contains their names."""

ENVIRONMENT = {"ISAAC_PATH": "/isaac-sim", "EXP_PATH": "/isaac-sim/apps", "CARB_APP_PATH": "/isaac-sim/kit"}
ENVIRONMENT |= {"ROS_DISTRO": "jazzy", "ROS_DOMAIN_ID": "0", "HOME": "/root"}
"""Environment variables that a script sees, with values as in Isaac Sim and ROS; the user's variables are not passed on."""

OURS, PYTHON = str(Path(__file__).parents[2]), os.path.dirname(os.__file__)
"""Folders of graphengine and of Python's library, to find out whether a file query comes from the script."""

MAX_LINE = 200
"""Maximum number of characters of a printed line that a finding quotes."""

ENDING_SECONDS = 3.0
"""CPU time after the time limit, s, in which a script can still end before the kernel kills the process."""


def main() -> None:
    """Read a request from stdin, confine this process, run the script, and write a `ScriptAnswer` to stdout."""
    request = json.load(sys.stdin)
    used = (f"numpy.{name}" for name in NUMPY if re.search(rf"\b{name}\b", request["text"]))
    for name in (*OFFERED.split(), *used):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    run = ScriptRun(request)
    for name in list(sys.modules):
        if name.partition(".")[0] in ROOTS or name == "asyncio":
            del sys.modules[name]
    stream = reply()
    sys.dont_write_bytecode = True
    vars(sys.implementation)["cache_tag"] = None  # no untrusted .pyc files are loaded
    linecache.updatecache = lambda *_: []  # otherwise tracebacks would read source files that may not be read
    sys.meta_path[:] = [ImportFinder(run.recorder, run.modules, run.folders)]
    compiled = SourceFileLoader.source_to_code

    def compile_own(self: Any, data: Any, path: Any, **named: Any) -> Any:
        return run.compiled(data, path) or compiled(self, data, path, **named)

    SourceFileLoader.source_to_code = compile_own  # type: ignore[method-assign]
    builtins.__import__ = importlib.__import__  # C's `__import__` calls the audit hook first
    time.sleep = lambda _: run.recorder.draw()
    threading.excepthook = lambda failed: run.losses.note(failed.exc_value, -1)

    class Suppress(contextlib.suppress):
        def __exit__(self, kind: Any, error: Any, trace: Any) -> bool:
            run.losses.note(error, sys._getframe(1).f_lineno)
            return super().__exit__(kind, error, trace)

    contextlib.suppress = Suppress  # type: ignore[misc]
    random.seed(0)
    numpy.random.seed(0)
    sys.path[:] = run.folders
    for name in ("stdout", "stderr", "__stdout__", "__stderr__"):
        setattr(sys, name, _Printed(run.recorder))
    builtins.open = io.open = _without_writing(run.recorder)
    os.mkdir = lambda path, *_, **__: run.recorder.pass_over(f"the folder {str(path)!r}")
    signal.signal(signal.SIGALRM, run.end)
    most = math.ceil(time.process_time() + request["seconds"] + ENDING_SECONDS)
    resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    files = Files((Path(run.folders[0]).resolve(), *map(Path, request["allowed"])))
    confine(files, TIERS["script"], also=HARMLESS)
    for name in [name for name in sys.modules if name.partition(".")[0] in ("ctypes", "_ctypes")]:
        del sys.modules[name]
    os.environ.update({**ENVIRONMENT, **request["environment"]})
    os.stat = _with_stages(run)

    def find() -> ScriptAnswer:
        signal.setitimer(signal.ITIMER_REAL, request["seconds"])
        run.run()
        signal.setitimer(signal.ITIMER_REAL, 0)
        return run.answer()

    answer(stream, find)


def _without_writing(recorder: GraphRecorder) -> Any:
    """Return a replacement for `open` that reports files opened for writing and discards what is written to them."""
    real = builtins.open

    def opened(file: Any, mode: str = "r", *arguments: Any, **named: Any) -> Any:
        if not isinstance(mode, str) or not set(mode) & set("wax+"):
            return real(file, mode, *arguments, **named)
        recorder.pass_over(f"the file {str(file)!r}, which the script writes,")
        return io.BytesIO() if "b" in mode else io.StringIO()

    return opened


def _with_stages(run: ScriptRun) -> Any:
    """Return a replacement for `os.stat` that also finds the files and folders that are assumed to exist."""
    real = os.stat

    def stat(path: Any, *arguments: Any, **named: Any) -> os.stat_result:
        try:
            return real(path, *arguments, **named)
        except OSError:
            codes = [sys._getframe(depth).f_code for depth in (2, 3, 4)]  # 1: this function
            folder = not {"is_dir", "isdir"}.isdisjoint(code.co_name for code in codes[:2])
            files = (code.co_filename for code in codes)
            asker = next((file for file in files if not file.startswith((PYTHON, "<frozen"))), "")
            asks = isinstance(path, str | os.PathLike) and not asker.startswith(OURS)
            found = asks and run.assumed(os.fsdecode(path), folder=folder)
            if not found:
                raise
            return real(found)

    return stat


class _Printed(io.TextIOBase):
    """Replacement for the script's stdout and stderr that keeps the last lines in the recorder."""

    def __init__(self, recorder: GraphRecorder) -> None:
        self.recorder, self.begun = recorder, ""

    def write(self, text: str) -> int:
        *lines, self.begun = (self.begun + text[-MAX_LINE:])[-2 * MAX_LINE :].split("\n")
        self.recorder.said.extend(line[:MAX_LINE] for line in lines if line.strip())
        return len(text)

    def writable(self) -> bool:
        return True


if __name__ == "__main__":
    main()
