"""Draw the arm of the tests at the workbench of `worlds/table.xml`.

python -m tests.pictures.arm docs/pictures/arm.png
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import graphengine as ge
from tests import arm_robot

POSE = (-0.68, 0.5, 1.3, 1.34, 0.0, 0.6)
"""Positions of the joints at the start, rad: the gripper is above the cubes and points down."""
SCENE = """format: 1
scene: arm
world: worlds/table.xml
physics: {tick_rate: 60, substeps: 4}
robots: {arm: {use: arm.yaml, position: [0.0, 0.0, 0.75]}}
"""


def draw(path: Path, size: tuple[int, int] = (960, 540)) -> None:
    """Write the picture."""
    start = dict(zip(arm_robot.JOINTS, POSE, strict=True))
    files = {"arm.urdf": arm_robot.urdf(shapes=True), "arm.yaml": arm_robot.robot_file(start), "scene.yaml": SCENE}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        with ge.load(Path(folder) / "scene.yaml").session() as sim:
            sim.run(0.2)
            sim.picture("perspective", path, size)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
