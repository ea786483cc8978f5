"""Sends Ctrl-C to this process when it has made as many calls as SIGINT_AFTER says, counted from the first import of `graphrun`.

Python imports this module at its start, in processes whose PYTHONPATH names its folder. SIGINT_AFTER has one number, or several
for several signals. The number of all calls is written to the file SIGINT_CALLS when the process ends.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
from types import FrameType

PENDING = [int(text) for text in os.environ.pop("SIGINT_AFTER", "").split()]
TOTAL = os.environ.pop("SIGINT_CALLS", "")
calls = 0


def wait(frame: FrameType, event: str, argument: object) -> None:
    """Wait for the end of `interrupts.begin`."""
    if event == "return" and frame.f_code.co_name == "begin" and frame.f_code.co_filename.endswith("interrupts.py"):
        sys.setprofile(count)


def count(frame: FrameType, event: str, argument: object) -> None:
    """Count a call, and send a signal after it if it is time."""
    global calls
    if event in ("call", "c_call"):
        calls += 1
        if PENDING and calls >= PENDING[0]:
            PENDING.pop(0)
            os.kill(os.getpid(), signal.SIGINT)


def write() -> None:
    """Write the number of calls to the file."""
    with open(TOTAL, "w", encoding="utf-8") as file:
        file.write(str(calls))


if TOTAL:
    atexit.register(write)  # the first function registered is the last that is called
if PENDING or TOTAL:
    sys.setprofile(wait)
