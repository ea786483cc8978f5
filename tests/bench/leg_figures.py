"""How far a robot on legs sinks, moves and turns in 10 s, and after a push: `python -m tests.bench.leg_figures SCENE`.

SCENE has one robot, which stands by its graph. The push is 50 N sideways for 0.1 s, at the centre of mass. Prints JSON.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import yaml

import graphengine as ge
from graphengine.devices.rotation import rotate

STANDING = 10.0
"""Time to stand, before the push and after it, s."""
FORCE, DURATION = 50.0, 0.1
"""Of the push, N and s."""


def figures(path: Path) -> dict[str, Any]:
    """Measure the robot of a scene: change of its height since it was placed (mm), and its tilt (degrees)."""
    found: dict[str, Any] = {}
    scene = yaml.safe_load(path.read_text(encoding="utf-8"))
    (placed,) = scene["robots"].values()
    with ge.load(path).session() as sim:
        (robot,) = sim.robots.values()
        # After settling, the height is that of a robot which may lie down.
        height = placed["position"][2] if scene["settle"] else robot.pose.position[2]
        found["joints"] = len(robot.joints)
        for kind in ("standing", "pushed"):
            if kind == "pushed":
                sim.push(robot.name, (0.0, FORCE, 0.0), DURATION)
            sim.run(STANDING)
            found[kind] = 1000 * (robot.pose.position[2] - height)
            found[f"tilt_{kind}"] = math.degrees(
                math.acos(min(1.0, rotate(robot.pose.orientation, (0.0, 0.0, 1.0))[2]))
            )
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    print(json.dumps(figures(parser.parse_args().scene)))
