"""Ends the program `graphrun` without a traceback after Ctrl-C or a lack of memory, from the first import to the exit.

Python raises KeyboardInterrupt at any place in the running code. Inside the initialization of a C module, the exception becomes
an ImportError; in a destructor, it is printed and lost. So the handler waits until the current import has ended, and sends a lost
interrupt again. A lost MemoryError ends the process: if a thread runs out of memory at its start, its starter waits forever.
"""

from __future__ import annotations

import _thread
import contextlib
import os
import signal
import sys
import time
from collections.abc import Iterator
from types import FrameType, TracebackType

CODE = 130
"""Exit code of a program that Ctrl-C ends, as shells report it."""
OUT_OF_MEMORY = 3
"""Exit code of `graphrun` when memory runs out."""
_POLL = 0.01
"""Time between two checks whether the import has ended, s."""
_raised: list[int] = []
"""Signals that have raised KeyboardInterrupt."""


def is_program() -> bool:
    """Return whether this process is `graphrun` or `python -m graphengine.cli`; False for a program that imports the package."""
    return os.path.basename(sys.argv[0]).startswith("graphrun") or "graphengine.cli" in sys.orig_argv


def begin() -> None:
    """Let Ctrl-C end the process while it imports modules; an ignored SIGINT stays ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _exit)


def work() -> None:
    """Let Ctrl-C raise KeyboardInterrupt from now on, but never inside an import. Call this function after `begin`."""
    if signal.getsignal(signal.SIGINT) is _exit:
        signal.signal(signal.SIGINT, interrupt)
    import threading  # not at the top, because before `begin` Ctrl-C prints a traceback

    sys.unraisablehook, sys.excepthook = _raise_again, _report
    threading.excepthook = lambda lost: _report(lost.exc_type, lost.exc_value or lost.exc_type(), lost.exc_traceback)


def finish() -> None:
    """Let Ctrl-C end the process at once during interpreter shutdown. Call this function after the output is flushed."""
    if signal.getsignal(signal.SIGINT) is interrupt:
        signal.signal(signal.SIGINT, _exit)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Handle a signal: raise KeyboardInterrupt, or raise it later if it would be lost now, as in an import."""
    if not _loses(frame):
        _raised.append(number)
        raise KeyboardInterrupt
    _thread.start_new_thread(_wait, (number, _thread.get_ident()))


@contextlib.contextmanager
def by_sigterm() -> Iterator[None]:
    """Return a context in which SIGTERM raises KeyboardInterrupt; without effect outside of the main thread."""
    try:
        before = signal.signal(signal.SIGTERM, interrupt)
    except ValueError:
        before = None
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGTERM, before)


@contextlib.contextmanager
def deferred() -> Iterator[None]:
    """Return a context at whose end SIGINT and SIGTERM take effect; without effect outside of the main thread."""
    import threading

    held: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    handled = {number: handler for number, handler in before.items() if callable(handler)}
    if threading.current_thread() is not threading.main_thread():
        handled = {}
    for number in handled:
        signal.signal(number, lambda number, _: held.append(number))
    try:
        yield
    finally:
        for number, handler in handled.items():
            signal.signal(number, handler)
        for late in held:
            signal.raise_signal(late)


def _loses(frame: FrameType | None) -> bool:
    """Return whether a frame or one of its callers executes an import, or reports a lost exception."""
    while frame is not None:
        if frame.f_code.co_filename == "<frozen importlib._bootstrap>" or frame.f_code is _raise_again.__code__:
            return True
        frame = frame.f_back
    return False


def _wait(number: int, thread: int) -> None:
    """Send the signal again when a thread can raise the interrupt; a signal ends a wait for a lock, unlike `interrupt_main`.

    A signal just before the beginning of a wait does not end the wait. So the signal is sent until the thread raises.
    """
    raised, sent = len(_raised), False
    while not sent or (len(_raised) == raised and signal.getsignal(number) is interrupt):
        if not _loses(sys._current_frames().get(thread)):
            signal.pthread_kill(thread, number)
            sent = True
        time.sleep(_POLL)


def _raise_again(lost: sys.UnraisableHookArgs) -> None:
    """Report an exception that Python cannot raise at the place of its origin; send an interrupt again instead."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        _thread.start_new_thread(_wait, (signal.SIGINT, _thread.get_ident()))
    elif issubclass(lost.exc_type, MemoryError):
        end_without_memory()
    elif not _raised:  # destructors of objects that an interrupt left half made fail
        sys.__unraisablehook__(lost)


def _report(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
    """Print the traceback of an uncaught exception, except for a second Ctrl-C while the first one ends the program."""
    if has_cause(error, MemoryError):
        end_without_memory()
    if not has_cause(error, KeyboardInterrupt):
        sys.__excepthook__(kind, error, traceback)


def _exit(number: int, frame: FrameType | None) -> None:
    os._exit(CODE)


def end_without_memory() -> None:
    """Print that memory ran out, and end the process."""
    try:
        os.write(2, b"error: out of memory\n")
    finally:
        end(OUT_OF_MEMORY)


def end(code: int) -> None:
    """Write the buffered output, and end the process immediately."""
    try:
        sys.stdout.flush()
    finally:
        os._exit(code)


def has_cause(error: BaseException, kind: type[BaseException]) -> bool:
    """Return whether an exception is of a class, or was raised while an exception of the class was handled."""
    found: BaseException | None = error
    while found is not None and not isinstance(found, kind):
        found = found.__context__
    return found is not None
