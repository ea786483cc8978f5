"""Tracks of skid-steered bases with equal friction, as a table: `python -m tests.bench.skid_tracks FOLDER`.

FOLDER holds clones of the repositories by their own names. Each robot is imported as by its vendor's launch file; then friction
across the wheels is set to the friction along them. A track is that of a base of two wheels that turns as commanded, as a mean of
both directions: measured on the spot, on slow arcs by `graphrun calibrate`, and by the planar balance of Coulomb forces for the
same arcs, with the masses of the description and with the centre of mass in the middle of the wheels.
"""

from __future__ import annotations

import json
import math
import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import graphengine as ge
from graphengine.api.calibration.arc_track import ArcDrives
from graphengine.api.calibration.drive_recorder import DriveRecorder
from graphengine.api.calibration.full_speed import limits_of, slow_arc
from graphengine.api.calibration.robot_interface import find_command, inputs_named
from graphengine.api.run_options import RunOptions
from graphengine.api.runner import Runner
from graphengine.api.scene import loaded_of
from graphengine.api.session import Session
from graphengine.descriptions.engine import mujoco
from tests.bench.public_descriptions import NEVER_TUNED_TO, ROBOTS, Robot
from tests.bench.public_robots import graphrun
from tests.physics.bases import Base, Wheel
from tests.physics.dynamics.coulomb_balance import turning_track

_A200, _PANTHER = (
    next(one for one in (*ROBOTS, *NEVER_TUNED_TO) if one.name == name) for name in ("Clearpath A200", "Panther")
)


def _of_clearpath(name: str) -> Robot:
    arguments = tuple(text.replace("a200", name) for text in _A200.arguments)
    return replace(_A200, name=f"Clearpath {name.upper()}", file=_A200.file.replace("a200", name), arguments=arguments)


SKID_STEERED = {
    "clearpath_control/config/a200/control.yaml": _A200,
    "clearpath_control/config/j100/control.yaml": _of_clearpath("j100"),
    "clearpath_control/config/w200/control.yaml": _of_clearpath("w200"),
    "husarion_ugv_controller/config/WH01_controller.yaml": replace(_PANTHER, name="Husarion Panther"),
    "husarion_ugv_controller/config/WH05_controller.yaml": replace(
        _PANTHER, name="Husarion Lynx", file=_PANTHER.file.replace("panther", "lynx")
    ),
}
"""Robots by the file with the parameters of their controllers."""
HEAD = (
    "robot", "distance of wheels, m", "on the spot, m", "slow arcs, m", "Coulomb, slow arcs, m", "Coulomb, even loads, m",
    "vendor, m", "spot - vendor", "slow arcs - vendor", "even loads - vendor",
)  # fmt: skip


def row(robot: Robot, controllers: str, clones: Path, folder: Path) -> list[str]:
    """Import a robot into a folder, measure its tracks, and return the cells of its row."""
    arguments = [text.format(repository=clones / robot.folder) for text in robot.arguments]
    source = ["--from", str(clones / robot.folder / robot.file), "--package-path", str(clones)]
    made = graphrun("new", "robot", *source, *arguments, folder=folder)
    if made.returncode:
        return [robot.name, made.stderr.strip().splitlines()[-1]]
    scene, file = folder / "robot/robot.yaml", folder / "robot/robots/robot.yaml"
    text = file.read_text(encoding="utf-8")
    (friction,) = re.findall(r"dynamic_friction: (.*)\n    across", text)
    file.write_text(re.sub("across: .*", f"across: {friction}", text), encoding="utf-8")
    graphrun("calibrate", scene.name, "--write", folder=scene.parent)
    slow = json.loads(graphrun("calibrate", scene.name, "--format", "json", folder=scene.parent).stdout)["track"]
    distance, spot, exact, even = measure(scene, float(friction))
    text = (clones / robot.folder / controllers).read_text(encoding="utf-8")
    keys = "wheel_separation", "wheel_separation_multiplier"
    vendor = math.prod(float(re.findall(rf"{key}: ([\d.]+)", text)[0]) for key in keys)
    lengths = [f"{each:.3f}" for each in (distance, spot, slow, exact, even, vendor)]
    return [robot.name, *lengths, *(f"{each / vendor - 1:+.1%}" for each in (spot, slow, even))]


def measure(scene: Path, friction: float) -> tuple[float, float, float, float]:
    """The distance of the wheels and the tracks: measured on the spot, and on slow arcs by the balance, also with even loads."""
    loaded = loaded_of(ge.load(scene))
    assert loaded.world is not None
    (robot,) = loaded.world.robots.values()
    command = find_command(loaded.claims, None)
    assert command is not None
    arc = slow_arc(robot, *limits_of(loaded))
    inputs = tuple(
        f"{graph.name}/{node.id}.{port.name}" for graph, node, port, _ in inputs_named(loaded, "wheelDistance")
    )
    with Session(Runner(loaded, RunOptions(domain=0))) as sim:
        drives = DriveRecorder(sim, robot.name, command, (), None)
        base = _base(sim, [robot.urdf.pose_in_root(robot.urdf.joints[name].child)[0] for name in robot.drives])
        spins = ArcDrives(sim, drives, sim.checkpoint(), inputs)
        spot = turning_track(base, friction, 0.0, arc[1])
        for _ in range(3):
            left, right = spins.drive(0.0, arc[1], spot)
            spot /= (left.yaw - right.yaw) / 2.0 / arc[1]
    even = replace(base, centre=(0.0, 0.0))
    return 2 * abs(base.wheels[0].y), spot, turning_track(base, friction, *arc), turning_track(even, friction, *arc)


def _base(sim: Session, places: list[tuple[float, float, float]]) -> Base:
    """The look-alike of a robot at rest for the balance, whose `radius` is the height of the centre of mass."""
    world = sim._runner.session.services.world
    model, data = world.model, world.data  # type: ignore[attr-defined]
    mujoco.mj_forward(model, data)
    (root,) = np.flatnonzero((model.body_parentid == 0) & (model.body_dofnum == 6))
    centre, mass = data.subtree_com[root] - data.xpos[root], float(model.body_subtreemass[root])
    x, y, _ = data.xmat[root].reshape(3, 3).T @ centre
    wheels = tuple(Wheel(str(number), *place[:2]) for number, place in enumerate(places))
    return Base("robot", wheels, float(data.subtree_com[root][2]), 0.0, mass / 1.2, centre=(1.2 * x, 1.2 * y))


if __name__ == "__main__":
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    for path, each in SKID_STEERED.items():
        with tempfile.TemporaryDirectory() as place:
            print("| " + " | ".join(row(each, path, Path(sys.argv[1]).resolve(), Path(place))) + " |", flush=True)
