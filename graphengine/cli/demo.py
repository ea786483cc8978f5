"""`graphrun demo`: run a demo in which a robot drives through a warehouse, and print commands to try."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from graphengine.cli import run
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.quantities import duration, whole
from graphengine.format.distribution import install_command
from graphengine.format.files import near, shipped
from graphengine.format.wording import quoted

SCENE, GRAPH = Path("scenes/demo.yaml"), Path("graphs/demo/round.yaml")
INTRODUCTION = """\
A Dingo robot drives through a warehouse and follows the obstacles on its left,
which its lidar sees. Ctrl-C ends the run. Try in another terminal:
  graphrun teleop
  graphrun topic echo /dd100_0000/odom
  graphrun ctl push dd100 --impulse 0,40,0
  graphrun ctl move pallet_01 -9.2 5
To change its graph, copy it, change a number, and run your copy:
  cp {graph} .
  graphrun run round.yaml --view
"""
OVER_ROS = ("  graphrun teleop", "  graphrun topic")
"""Beginnings of the lines with commands that reach the demo over ROS 2; with the transport `memory`, they are left out."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun demo` to its parser."""
    from graphengine.cli.common import add_transport_argument

    simulated = "simulation time to run, such as 10, 10s, 500ms or 2min (default: until Ctrl-C)"
    add_value(parser, "--for", "TIME", simulated, dest="duration", type=duration)
    add_flag(parser, "--no-view", "do not serve the web page that shows the run")
    parser.add_argument("--seed", type=whole, default=0, help="seed of the lidar's noise (default 0)")
    add_transport_argument(parser, reaching_others=False)
    parser.epilog = "`graphrun run demo` runs the same scene with all options of `graphrun run`."


def execute(arguments: argparse.Namespace) -> int:
    """Print an introduction with commands to try, and run the scene; return the exit code of `graphrun run`."""
    from graphengine.api.viewing import missing_packages

    folder = shipped()
    parser = argparse.ArgumentParser()
    run.add_arguments(parser)
    given = parser.parse_args([near(str(folder / SCENE))], arguments)  # the defaults of `run` for what is not given
    missing = missing_packages()
    given.view = not (arguments.no_view or missing)
    lines = INTRODUCTION.format(graph=quoted(near(str(folder / GRAPH)))).splitlines(keepends=True)
    introduction = "".join(line for line in lines if arguments.transport != "memory" or not line.startswith(OVER_ROS))
    if missing and not arguments.no_view:
        introduction += f"To see it in a browser: {install_command('view')}\n"
    print(introduction, end="", file=sys.stderr, flush=True)
    return run.execute(given)
