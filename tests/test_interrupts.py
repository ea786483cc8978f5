"""Ctrl-C ends the suite's programs, also if a script started the suite in the background."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

IN_BACKGROUND = """trap '' INT; exec "$@\""""
CHILD = "import signal; raise SystemExit(signal.getsignal(signal.SIGINT) is not signal.default_int_handler)"


def test_ctrl_c_is_not_ignored_in_the_suite_and_its_child_processes() -> None:
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert subprocess.run([sys.executable, "-c", CHILD], check=False).returncode == 0


def test_ctrl_c_is_not_ignored_in_a_suite_that_a_script_started_in_the_background() -> None:
    here = Path(__file__)
    name = f"{here}::{test_ctrl_c_is_not_ignored_in_the_suite_and_its_child_processes.__name__}"
    suite = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", name]
    done = subprocess.run(
        ["sh", "-c", IN_BACKGROUND, "sh", *suite],
        cwd=here.parent.parent,
        env={name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
