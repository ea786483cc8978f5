"""`ros2 run graphengine_ros graphrun`: runs the `graphrun` of the Python environment that has graphengine."""

from __future__ import annotations

import os
import sys

from graphengine_ros.engine import EngineNotFoundError, graphrun_command


def main() -> None:
    """Replace this process by graphrun with the same arguments; exit with code 1 if graphengine is not found."""
    try:
        command = graphrun_command()
    except EngineNotFoundError as error:
        sys.exit(f"error: {error}")
    os.execv(command[0], [*command, *sys.argv[1:]])
