"""`ros2 run graphengine_ros graphrun`: becomes the `graphrun` of the Python that graphengine is installed in."""

from __future__ import annotations

import os
import sys

from graphengine_ros.engine import EngineNotFoundError, graphrun_command


def main() -> None:
    """Replace this process by graphrun with the same arguments; exit with code 1 if there is none."""
    try:
        command = graphrun_command()
    except EngineNotFoundError as error:
        sys.exit(f"error: {error}")
    os.execv(command[0], [*command, *sys.argv[1:]])
