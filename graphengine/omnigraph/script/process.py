"""The process in which a script is run: one request on standard input, one answer on standard output.

The script meets stand-ins in the place of Omniverse, the modules of Python that are loaded by then, and modules beside it. It is
confined: it reads its own folder, writes nothing, reaches no network, starts no process, and ends in time.
"""

from __future__ import annotations

import builtins
import contextlib
import ctypes
import importlib
import importlib.util
import io
import itertools
import json
import linecache
import math
import os
import random
import resource
import signal
import sys
import time
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy.random  # scripts use it, and numpy reads it only then

from graphengine.diagnostics import Span
from graphengine.files import Files
from graphengine.omnigraph.omniverse.modules import ROOTS, make_modules
from graphengine.omnigraph.omniverse.og_edit import OPENED
from graphengine.omnigraph.omniverse.recorder import Recorder
from graphengine.omnigraph.omniverse.spellings import NotThereError, OmniGraphError
from graphengine.omnigraph.omniverse.stand_in import EndlessError, idle
from graphengine.omnigraph.omniverse.waiting import asyncio_stand_in
from graphengine.omnigraph.script.answers import write_answer
from graphengine.omnigraph.script.finder import OFFERED, PACKAGE, Finder
from graphengine.omnigraph.script.places import Script
from graphengine.world.files.confinement import MAX_MEMORY_BYTES, RefusedError, confine

HARMLESS = frozenset(
    ("object.__setattr__", "object.__delattr__", "os.putenv", "os.unsetenv", "pathlib.Path.glob", "pathlib.Path.rglob")
)
"""Audit events of what changes only the process; files are judged one by one, also those that a pattern finds."""

ENVIRONMENT = {"ISAAC_PATH": "/isaac-sim", "EXP_PATH": "/isaac-sim/apps", "CARB_APP_PATH": "/isaac-sim/kit"}
ENVIRONMENT |= {"ROS_DISTRO": "jazzy", "ROS_DOMAIN_ID": "0"}
"""What scripts find of Isaac Sim's and ROS's environment; of the user's nothing."""

MAX_LINE = 200
"""Characters of what a script prints that are told."""

ENDING_SECONDS = 3.0
"""Of computing that a script gets to end after its time is up, before it is killed."""
_NEW_USER, _NEW_NETWORK = 0x10000000, 0x40000000
"""CLONE_NEWUSER and CLONE_NEWNET of unshare(2)."""


class TimeIsUpError(BaseException):
    """The script runs too long."""


class Run:
    """One run of a script."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.path: str = request["path"]
        self.arguments: list[str] = request["arguments"]
        self.scripts: dict[str, Script | None] = {}
        self.script = Script(self.path, request["text"])
        self.scripts[self.path] = self.script
        self.folder = str(Path(self.path).absolute().parent)
        self.recorder = Recorder(self._where, frozenset(request["types"]), assumed=request["assumed"])
        self.modules: dict[str, Any] = dict(make_modules(self.recorder))
        self.modules["asyncio"] = asyncio_stand_in(self.recorder)
        self.may_differ = True
        """Whether the script may do better on another stage."""
        self.stopped = False
        """Whether the script failed after it had built graphs."""
        self.ended_by: BaseException | None = None
        """What the script was ended by, if it was."""

    def _where(self, text: str) -> Span | None:
        """The place of the call that the script makes."""
        frame: types.FrameType | None = sys._getframe(1)
        while frame is not None:
            script = self._script(frame.f_code.co_filename)
            if script is not None:
                return script.span(*_position(frame.f_code, frame.f_lasti, frame.f_lineno), text)
            frame = frame.f_back
        return None

    def _script(self, path: str) -> Script | None:
        """The script itself, or a module that lies beside it."""
        if path not in self.scripts:
            self.scripts[path] = None
            if path.startswith(self.folder + os.sep) and path.endswith(".py"):
                with contextlib.suppress(OSError, SyntaxError, ValueError, RecursionError):
                    self.scripts[path] = Script(path, importlib.util.decode_source(Path(path).read_bytes()))
        return self.scripts[path]

    def run(self) -> None:
        """To its end; what fails, and what it went on without, goes to the findings."""
        sys.argv[:] = [self.path, *self.arguments]
        module = types.ModuleType("__main__")
        vars(module).update(__file__=self.path, __package__=PACKAGE, __builtins__=builtins)
        sys.modules["__main__"] = sys.modules[f"{PACKAGE}.{Path(self.path).stem}"] = module
        self._run(vars(module))
        findings = self.recorder.findings
        for refused, message, place in self.recorder.refused:
            if refused is not self.ended_by:
                findings.add("N302", f"{message}; the script goes on without it", place)
        if not self.recorder.graphs and not findings.errors and self.recorder.said:
            findings.add("W302", "the script builds nothing", None, *self._said())

    def _run(self, namespace: dict[str, Any]) -> None:
        try:
            exec(compile(self.script.tree, self.path, "exec"), namespace)
        except EndlessError as error:
            place = self._place(error)
            what = "the script goes on without end, as one that steps a simulation does; it was stopped here"
            self.recorder.findings.add("N302", what, place, "what it would have built later is not in the graphs")
        except SystemExit as error:
            if error.code not in (None, 0):
                self._stop(error, f"the script ends itself: exit({error.code!r})", *_hint_for_exit(error))
        except TimeIsUpError as error:
            self.may_differ = False
            self._fail(error, "the script takes too long")
        except MemoryError as error:
            self.may_differ = False
            self._fail(error, f"the script takes more than {MAX_MEMORY_BYTES >> 20} MiB")
        except RecursionError as error:
            self._fail(error, "the script calls itself without end")
        except RefusedError as error:
            first, *more = str(error).splitlines()
            self._fail(error, f"the script may not do this: {first}", *more)
        except OmniGraphError as error:
            hints = (OPENED,) if isinstance(error, NotThereError) else ()
            self._fail(error, f"{OmniGraphError.__name__}: {error}", *hints)
        except BaseException as error:  # whatever a script raises
            self._stop(error, f"{type(error).__name__}: {str(error)[:1000] or 'no more is told'}")

    def _stop(self, error: BaseException, message: str, *help: str) -> None:
        """Keep what was built before a script failed, as one does that goes on with what only Omniverse knows."""
        if not self.recorder.graphs:
            self._fail(error, message, *help)
            return
        self.stopped = True
        what = "the script goes no further; what it would have built later is not in the graphs"
        self.recorder.findings.add("W302", message, self._place(error), what, *help)

    def _fail(self, error: BaseException, message: str, *help: str) -> None:
        self.ended_by = error
        self.recorder.findings.add("G401", message, self._place(error), *help, *self._said())

    def _said(self) -> Sequence[str]:
        """What the script printed last, as one does of an error that it catches."""
        return [f"it printed: {line}" for line in self.recorder.said]

    def _place(self, error: BaseException) -> Span | None:
        """The innermost line of the script that an error came through."""
        trace, found = error.__traceback__, None
        while trace is not None:
            script = self._script(trace.tb_frame.f_code.co_filename)
            if script is not None:
                found = script.span(*_position(trace.tb_frame.f_code, trace.tb_lasti, trace.tb_lineno))
            trace = trace.tb_next
        return found


def _position(code: types.CodeType, instruction: int, near: int) -> tuple[int, int | None, int]:
    """Line, last line and column of an instruction, which is near a line."""
    found = next(itertools.islice(code.co_positions(), instruction // 2, None), (near, None, 0, None))
    return found[0] or near, found[1], found[2] or 0


def _hint_for_exit(error: SystemExit) -> tuple[str, ...]:
    return ("give it arguments behind `--`: graphrun import FILE.py -- ARGUMENT …",) if error.code == 2 else ()


def _time_is_up(*_: Any) -> None:
    raise TimeIsUpError


def main() -> None:
    """Answer one request."""
    request = json.load(sys.stdin)
    for name in OFFERED.split():
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    run = Run(request)
    for name in list(sys.modules):
        if name.partition(".")[0] in ROOTS or name == "asyncio":
            del sys.modules[name]
    answer, complaint = sys.stdout, sys.stderr
    sys.dont_write_bytecode = True
    vars(sys.implementation)["cache_tag"] = None  # no compiled code of a stranger is loaded
    linecache.updatecache = lambda *_: []  # tracebacks show lines of files that may not be read
    sys.meta_path[:] = [Finder(run.recorder, run.modules, run.folder)]
    builtins.__import__ = importlib.__import__  # the C one asks the audit hook first
    time.sleep = lambda _: idle(run.recorder)
    random.seed(0)
    numpy.random.seed(0)
    sys.path[:] = [run.folder]
    for name in ("stdout", "stderr", "__stdout__", "__stderr__"):
        setattr(sys, name, _Printed(run.recorder))
    builtins.open = io.open = _without_writing(run.recorder)
    os.mkdir = lambda path, *_, **__: run.recorder.pass_over(f"the folder {str(path)!r}")
    signal.signal(signal.SIGALRM, _time_is_up)
    signal.setitimer(signal.ITIMER_REAL, request["seconds"])
    most = math.ceil(time.process_time() + request["seconds"] + ENDING_SECONDS)
    resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    _leave_network()
    confine(Files((Path(run.folder).resolve(), *map(Path, request["allowed"]))), also=HARMLESS)
    os.environ.update(ENVIRONMENT)
    try:
        run.run()
        signal.setitimer(signal.ITIMER_REAL, 0)
        text = write_answer(run.recorder, may_differ=run.may_differ, stopped=run.stopped)
    except BaseException as error:  # the time may be up at any moment
        complaint.write(f"the script left nothing that can be told: {type(error).__name__}")
        complaint.flush()
        os._exit(1)
    answer.write(text)
    answer.flush()
    os._exit(0)  # an interpreter that shuts down does what the hook refuses


def _leave_network() -> None:
    """Go where there is no network, as far as the kernel lets: what the audit hook is not told of reaches nobody either."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).unshare(_NEW_USER | _NEW_NETWORK)
    for name in [name for name in sys.modules if name.partition(".")[0] in ("ctypes", "_ctypes")]:
        del sys.modules[name]


def _without_writing(recorder: Recorder) -> Any:
    """An `open` for scripts that keep a log: what they write goes nowhere, and that is told."""
    real = builtins.open

    def opened(file: Any, mode: str = "r", *arguments: Any, **named: Any) -> Any:
        if not isinstance(mode, str) or not set(mode) & set("wax+"):
            return real(file, mode, *arguments, **named)
        recorder.pass_over(f"the file {str(file)!r}, which the script writes,")
        return io.BytesIO() if "b" in mode else _Nowhere()

    return opened


class _Nowhere(io.TextIOBase):
    """Where what a script prints goes."""

    def write(self, text: str) -> int:
        return len(text)

    def writable(self) -> bool:
        return True


class _Printed(_Nowhere):
    """Where what a script prints goes; the last lines are kept."""

    def __init__(self, recorder: Recorder) -> None:
        self.recorder, self.begun = recorder, ""

    def write(self, text: str) -> int:
        *lines, self.begun = (self.begun + text[-MAX_LINE:])[-2 * MAX_LINE :].split("\n")
        self.recorder.said.extend(line[:MAX_LINE] for line in lines if line.strip())
        return len(text)


if __name__ == "__main__":
    main()
