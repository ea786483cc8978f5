"""Robots that Nav2 can drive, with a lidar, by the graphs in graphs/base."""

from __future__ import annotations

from pathlib import Path

from tests.bringup.calibration.bases import Base, joint, link, wheel

LIDAR = "sensors:\n  lidar: {type: lidar, profile: lidar_360, parent: base_link, position: [0.0, 0.0, 0.1]}\n"
SCAN = "{use: graphs/publishers/scan.yaml, parameters: {lidar: base_link/lidar/Lidar, topic: scan, frame: lidar}}"
FRAME = "{use: graphs/publishers/frame.yaml, parameters: {parent: base_link, child: lidar, position: [0, 0, 0.1]}}"

LEFT, RIGHT = 0.2, -0.2


def mecanum(folder: Path) -> Base:
    """Four mecanum wheels."""
    places = {
        "front_left": (0.2, LEFT),
        "front_right": (0.2, RIGHT),
        "rear_left": (-0.2, LEFT),
        "rear_right": (-0.2, RIGHT),
    }
    base = Base(folder, [(f"{name}_wheel", x, y) for name, (x, y) in places.items()])
    return _on_graph(base, "mecanum", "speed: 0.6")


def car(folder: Path) -> Base:
    """Two driven wheels behind, two steered ones in front."""
    knuckles = "".join(
        link(f"{side}_knuckle", 0.2)
        + joint(f"{side}_steering_joint", "base_link", f"{side}_knuckle", f"0.3 {y} 0", "0 0 1")
        + wheel(f"front_{side}_wheel", 0.0, 0.0, f"{side}_knuckle")
        for side, y in (("left", LEFT), ("right", RIGHT))
    )
    base = Base(folder, [("rear_left_wheel", -0.2, LEFT), ("rear_right_wheel", -0.2, RIGHT)], knuckles)
    base.wheels += ["front_left_wheel", "front_right_wheel"]
    base.drives |= {
        f"{side}_steering_joint": "{drive: {stiffness: 500.0, damping: 20.0}}" for side in ("left", "right")
    }
    return _on_graph(base, "ackermann", "steering_limit: 0.5")


def _on_graph(base: Base, kinematics: str, parameters: str) -> Base:
    base.keys = LIDAR
    base.graphs = {
        "base": f"{{use: graphs/base/{kinematics}.yaml, parameters: {{{parameters}}}}}",
        "scan": SCAN,
        "frame": FRAME,
    }
    return base
