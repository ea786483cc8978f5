"""Runs a fleet of robots with a user-defined node, records the run, and replays the recording."""

import argparse
import sys
from pathlib import Path

import graphengine as ge
from graphengine.cli import main as graphrun

HERE = Path(__file__).parent


def main(recording: str) -> dict[str, float]:
    """Record and replay a run; return the x coordinate of each robot at its end, m, by robot name.

    The replay is compared with the recording byte by byte.
    """
    sys.path.append(str(HERE))  # the folder with patrol.py, the module of the node
    scene = ge.load(HERE / "scene.yaml", modules=["patrol"])
    with scene.session(record=recording, force=True) as sim:
        sim.run(1.0)
        sim.set("guard_0001/*/Patrol.speed", 0.2)
        sim.set("guard_0002/*/Patrol.leg", 1.0)
        sim.push("guard_0000", impulse=(0, 10, 0))
        sim.run(2.0)
        print(sim.values("*/cmd_vel/Patrol.velocity"))
        places = {name: robot.pose.position[0] for name, robot in sim.robots.items()}
    assert graphrun(["replay", recording, "--import", "patrol"]) == 0
    return places


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", nargs="?", default="fleet.mcap", help="file to write (default fleet.mcap)")
    main(parser.parse_args().recording)
