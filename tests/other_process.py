"""Calls of a function in another process, for results that must not depend on what a process did before, or on hash seeds."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

ROOT = Path(__file__).parents[1]
CALL = """
import pickle, sys
from importlib import import_module
module, name, given, named = pickle.load(sys.stdin.buffer)
sys.stdout.buffer.write(pickle.dumps(getattr(import_module(module), name)(*given, **named)))
"""


def in_another_process(function: Callable[P, R], *given: P.args, **named: P.kwargs) -> R:
    """Return the result of a function of a test module; the process has another hash seed, so another order of sets."""
    done = subprocess.run(
        [sys.executable, "-c", CALL],
        input=pickle.dumps((function.__module__, function.__qualname__, given, named)),
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": "4242" if os.environ.get("PYTHONHASHSEED") != "4242" else "1"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    result: R = pickle.loads(done.stdout)
    return result
