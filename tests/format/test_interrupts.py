"""Ctrl-C and a lack of memory end a program without a traceback also where Python cannot raise their exceptions."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.cli.harness import ROOT, environment
from tests.waiting import PATIENCE

START = """
import os, signal, threading, time
from graphengine.format import interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)
interrupts.begin()
interrupts.work()
"""
IN_A_DESTRUCTOR = """
class Interrupted:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
try:
    Interrupted()
    threading.Event().wait()
except KeyboardInterrupt:
    print("ended")
"""
IN_A_DESTRUCTOR_BEFORE_A_WAIT = (
    """
send, sent = signal.pthread_kill, []
def early(thread, number):
    sent.append(number)
    if len(sent) > 2:
        send(thread, number)
signal.pthread_kill = early
"""
    + IN_A_DESTRUCTOR
)
"""The first signals have no effect, as if they arrived just before the thread starts to wait."""
IN_A_CONSTRUCTOR = """
class HalfMade:
    def __init__(self):
        os.kill(os.getpid(), signal.SIGINT)
        self.handle = 1
    def __del__(self):
        del self.handle
try:
    HalfMade()
except KeyboardInterrupt:
    print("ended")
"""
IN_A_DESTRUCTOR_WITHOUT_MEMORY = """
class Large:
    def __del__(self):
        raise MemoryError
print("before")
Large()
print("after")
"""
IN_A_STARTING_THREAD = """
def fail(thread):
    raise MemoryError
threading.Thread._bootstrap_inner = fail
print("before")
threading.Thread(target=print).start()
"""
IN_A_THREAD = """
def fail():
    raise MemoryError
print("before")
thread = threading.Thread(target=fail)
thread.start()
thread.join()
print("after")
"""
IN_THE_HANDLING_OF_ANOTHER_ERROR = """
print("before")
try:
    raise MemoryError
finally:
    raise ValueError
"""


def ended(code: str) -> tuple[int, str, str]:
    """Run code in a process after `interrupts.work`; return its exit code, output and errors."""
    done = subprocess.run(
        [sys.executable, "-c", START + code],
        cwd=ROOT,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    "code",
    [IN_A_DESTRUCTOR, IN_A_DESTRUCTOR_BEFORE_A_WAIT, IN_A_CONSTRUCTOR],
    ids=["destructor", "before a wait", "constructor"],
)
def test_an_interrupt_is_raised_once_and_destructors_print_nothing(code: str) -> None:
    assert ended(code) == (0, "ended\n", "")


@pytest.mark.parametrize(
    "code",
    [IN_A_DESTRUCTOR_WITHOUT_MEMORY, IN_A_STARTING_THREAD, IN_A_THREAD, IN_THE_HANDLING_OF_ANOTHER_ERROR],
    ids=["destructor", "starting thread", "thread", "handling of an error"],
)
def test_an_uncatchable_lack_of_memory_ends_the_program_with_one_line(code: str) -> None:
    assert ended(code) == (3, "before\n", "error: out of memory\n")
