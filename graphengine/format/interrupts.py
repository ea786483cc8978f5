"""Ctrl-C in the program `graphrun`: it ends the program without a traceback, at any moment from its first import to its exit.

Python raises KeyboardInterrupt in whatever code is running. Inside the initialization of a C module it becomes an ImportError,
and in a destructor it is printed and lost. So the handler waits until the current import has ended, and sends a lost interrupt
again.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from types import FrameType, TracebackType

CODE = 130
"""Exit code of a program that Ctrl-C ends, as shells report it."""
_POLL = 0.01
"""Time between two checks whether the import has ended, s."""


def is_program() -> bool:
    """Return whether this process is `graphrun` or `python -m graphengine.cli`, not another program that imports the package."""
    return os.path.basename(sys.argv[0]).startswith("graphrun") or "graphengine.cli" in sys.orig_argv


def begin() -> None:
    """End the process at Ctrl-C, as long as it only imports modules; SIGINT stays ignored if it was."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _exit)


def work() -> None:
    """Raise KeyboardInterrupt at Ctrl-C from now on, but never inside an import; call it after `begin`."""
    if signal.getsignal(signal.SIGINT) is _exit:
        signal.signal(signal.SIGINT, interrupt)
        sys.unraisablehook, sys.excepthook = _raise_again, _report


def finish() -> None:
    """End the process at Ctrl-C while the interpreter closes; call it when the work is done and the output is flushed."""
    if signal.getsignal(signal.SIGINT) is interrupt:
        signal.signal(signal.SIGINT, _exit)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, as a signal handler; if the main thread is importing a module, raise it after the import."""
    if not _imports(frame):
        raise KeyboardInterrupt
    _thread.start_new_thread(_wait, (number, _thread.get_ident()))


def _imports(frame: FrameType | None) -> bool:
    """Return whether a frame or one of its callers executes an import."""
    while frame is not None:
        if frame.f_code.co_filename == "<frozen importlib._bootstrap>":
            return True
        frame = frame.f_back
    return False


def _wait(number: int, thread: int) -> None:
    """Send the signal again when a thread has ended its import."""
    while _imports(sys._current_frames().get(thread)):
        time.sleep(_POLL)
    _thread.interrupt_main(signal.Signals(number))


def _raise_again(lost: sys.UnraisableHookArgs) -> None:
    """Report an exception that Python cannot raise where it occurred; an interrupt is sent again instead."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        _thread.interrupt_main()
    else:
        sys.__unraisablehook__(lost)


def _report(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
    """Print the traceback of an uncaught exception, unless it is a second Ctrl-C while the first ends the program."""
    if not is_cause_of(error):
        sys.__excepthook__(kind, error, traceback)


def _exit(number: int, frame: FrameType | None) -> None:
    os._exit(CODE)


def is_cause_of(error: BaseException) -> bool:
    """Return whether an exception is a KeyboardInterrupt or was raised while one was handled."""
    while not isinstance(error, KeyboardInterrupt):
        if error.__context__ is None:
            return False
        error = error.__context__
    return True
