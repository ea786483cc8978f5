"""Finds the Python that graphengine is installed in: colcon's scripts run in the system's Python, which usually lacks it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

VARIABLE = "GRAPHENGINE_PYTHON"
_HAS_ENGINE = "import importlib.util, sys; sys.exit(importlib.util.find_spec('graphengine') is None)"
_TIMEOUT = 30.0
"""Maximum time in which a Python interpreter has to answer, s."""
REMEDY = f"""install graphengine in a virtual environment, and name that:
  python3 -m venv ~/graphengine && ~/graphengine/bin/pip install .    # in a checkout of graphengine
  export {VARIABLE}=~/graphengine/bin/python        or the launch argument python:=~/graphengine/bin/python"""


class EngineNotFoundError(Exception):
    """No Python with graphengine was found. The message lists the searched places and a remedy."""


def graphrun_command(python: str = "", environ: Mapping[str, str] = os.environ) -> list[str]:
    """Return the first arguments of a command line that runs `graphrun`.

    The first of these is used: the given Python, the one in GRAPHENGINE_PYTHON, the one of the active virtual environment,
    `graphrun` on the PATH, and the Python that runs this function. The first two must have graphengine, if they are given.

    Args:
        python: path of a Python interpreter; empty if none is given.
        environ: environment variables.

    Raises:
        EngineNotFoundError: none of them has graphengine, or one of the first two is given without it.
    """
    for given, origin in ((python, "python:="), (environ.get(VARIABLE, ""), f"{VARIABLE}=")):
        if given:
            path = os.path.expanduser(given)
            if not has_engine(path):
                raise EngineNotFoundError(f"{origin}{given} is not a Python that has graphengine\n{REMEDY}")
            return _command(path)
    active = environ.get("VIRTUAL_ENV", "")
    if active and has_engine(path := str(Path(active, "bin", "python"))):
        return _command(path)
    script = shutil.which("graphrun", path=environ.get("PATH"))
    if script and "graphengine_ros" not in Path(script).parts:  # this package has a graphrun too
        return [script]
    if has_engine(sys.executable):
        return _command(sys.executable)
    searched = f"{VARIABLE}, VIRTUAL_ENV, graphrun on the PATH, and {sys.executable}"
    raise EngineNotFoundError(f"graphengine is not found; looked in {searched}\n{REMEDY}")


def has_engine(python: str) -> bool:
    """Return whether a Python interpreter can import graphengine."""
    try:
        asked = subprocess.run([python, "-P", "-c", _HAS_ENGINE], capture_output=True, timeout=_TIMEOUT, check=False)
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return False
    return asked.returncode == 0


def _command(python: str) -> list[str]:
    # -P: untrusted modules in the working directory cannot shadow others.
    return [python, "-P", "-m", "graphengine.cli"]
