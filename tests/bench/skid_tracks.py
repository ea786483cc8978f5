"""Tracks of skid-steered bases with equal friction, as a table: `python -m tests.bench.skid_tracks FOLDER`.

FOLDER holds clones of the repositories by their own names. Each robot is imported as by its vendor's launch file; then friction
across the wheels is set to the friction along them. A track is that of a base of two wheels that turns as commanded, as a mean of
both directions: measured on the spot, on slow arcs by `graphrun calibrate`, and by the planar balance of Coulomb forces for the
same arcs, with the masses of the description and with the centre of mass in the middle of the wheels.
"""

from __future__ import annotations

import json
import operator
import re
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import graphengine as ge
from graphengine.api.scene import loaded_of, world_of
from graphengine.api.session import Session
from graphengine.bringup.calibration.arc_track import ArcDrives
from graphengine.bringup.calibration.drive_recorder import DriveRecorder
from graphengine.bringup.calibration.full_speed import limits_of, slow_arc
from graphengine.bringup.calibration.robot_interface import find_command, inputs_named
from graphengine.descriptions.engine import mujoco
from tests.bench.public_descriptions import NEVER_TUNED_TO, ROBOTS, Robot
from tests.bench.public_robots import graphrun
from tests.physics.bases import Base, Wheel
from tests.physics.dynamics.coulomb_balance import turning_track


@dataclass(frozen=True)
class SkidSteered:
    """A skid-steered robot whose vendor publishes a track.

    Attributes:
        robot: its description and the arguments of its vendor's launch file.
        figures: the vendor's file with the track, in the folder of the clones.
        keys: names of the numbers in that file.
        track: the track in m, of these numbers in their order.
    """

    robot: Robot
    figures: str
    keys: tuple[str, ...] = ("wheel_separation", "wheel_separation_multiplier")
    track: Callable[..., float] = operator.mul

    def vendor(self, clones: Path) -> float:
        """The vendor's track in m."""
        text = (clones / self.figures).read_text(encoding="utf-8")
        return self.track(*(float(re.findall(rf"\b{key}\W+([\d.]+)", text)[0]) for key in self.keys))


_A200, _PANTHER, _LEO = (
    next(one for one in (*ROBOTS, *NEVER_TUNED_TO) if one.name == name)
    for name in ("Clearpath A200", "Panther", "Leo Rover")
)


def _of_clearpath(name: str) -> SkidSteered:
    arguments = tuple(text.replace("a200", name) for text in _A200.arguments)
    robot = replace(_A200, name=f"Clearpath {name.upper()}", file=_A200.file.replace("a200", name), arguments=arguments)
    return SkidSteered(robot, f"clearpath_common/clearpath_control/config/{name}/control.yaml")


def _of_husarion(name: str, controllers: str) -> SkidSteered:
    robot = replace(_PANTHER, name=f"Husarion {name.title()}", file=_PANTHER.file.replace("panther", name))
    return SkidSteered(robot, f"husarion_ugv_ros/husarion_ugv_controller/config/{controllers}")


def _rosbot(name: str, package: str) -> SkidSteered:
    controllers = f"{package}_controller/config/diff_drive_controller.yaml"
    arguments = ("mecanum:=false", "--controllers", f"{{repository}}/{controllers}")
    robot = Robot(name, f"husarion/{package}_ros", f"{package}_description/urdf/{package}.urdf.xacro", arguments)
    return SkidSteered(robot, f"{package}_ros/{controllers}")


SKID_STEERED = (
    *(_of_clearpath(name) for name in ("a200", "j100", "w200")),
    _of_husarion("panther", "WH01_controller.yaml"),
    _of_husarion("lynx", "WH05_controller.yaml"),
    _of_clearpath("a300"),
    _rosbot("Husarion ROSbot 2R", "rosbot"),
    _rosbot("Husarion ROSbot XL", "rosbot_xl"),
    SkidSteered(
        _LEO,
        "leocore_firmware_ros2/App/Inc/app/parameters.hpp",
        ("robot_wheel_separation", "robot_angular_velocity_multiplier"),
    ),
    SkidSteered(
        Robot("Pioneer 3-AT", "MobileRobots/amr-ros-config", "description/urdf/pioneer3at.urdf"),
        "AriaCoda/params/p3at.p",
        ("DiffConvFactor",),
        lambda turn_per_speed: 2.0e-3 / turn_per_speed,
    ),
)
"""The first five were the first list, the others the second; each list was written before its first robot was measured."""
HEAD = (
    "robot", "distance of wheels, m", "on the spot, m", "slow arcs, m", "Coulomb, slow arcs, m", "Coulomb, even loads, m",
    "vendor, m", "spot - vendor", "slow arcs - vendor", "even loads - vendor",
)  # fmt: skip


def row(one: SkidSteered, clones: Path, folder: Path) -> list[str]:
    """Import a robot into a folder, measure its tracks, and return the cells of its row."""
    robot = one.robot
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
    vendor = one.vendor(clones)
    lengths = [f"{each:.3f}" for each in (distance, spot, slow, exact, even, vendor)]
    return [robot.name, *lengths, *(f"{each / vendor - 1:+.1%}" for each in (spot, slow, even))]


def measure(scene: Path, friction: float) -> tuple[float, float, float, float]:
    """The distance of the wheels and the tracks: measured on the spot, and on slow arcs by the balance, also with even loads."""
    loaded = ge.load(scene)
    (robot,) = world_of(loaded).robots.values()
    command = find_command(loaded.topics, None)
    assert command is not None
    arc = slow_arc(robot, *limits_of(loaded))
    inputs = tuple(
        f"{graph.name}/{node.id}.{port}"
        for graph, node, port, _ in inputs_named(loaded_of(loaded).planned, "wheelDistance")
    )
    with loaded.session(domain=0) as sim:
        drives = DriveRecorder(sim, robot.name, command, (), None)
        spins = ArcDrives(sim, drives, sim.checkpoint(), inputs)
        sim.step(60)
        base = _base(sim)
        spot = turning_track(base, friction, 0.0, arc[1])
        for _ in range(3):
            left, right = spins.drive(0.0, arc[1], spot)
            spot /= (left.yaw - right.yaw) / 2.0 / arc[1]
    x, y = np.mean([(wheel.x, wheel.y) for wheel in base.wheels], axis=0)
    even = replace(base, centre=(1.2 * x, 1.2 * y))
    return 2 * abs(base.wheels[0].y), spot, turning_track(base, friction, *arc), turning_track(even, friction, *arc)


def _base(sim: Session) -> Base:
    """The look-alike of a robot at rest for the balance: wheels where it touches the floor, `radius` the height of its centre."""
    world = sim._runner.session.services.world
    model, data = world.model, world.data  # type: ignore[attr-defined]
    mujoco.mj_forward(model, data)
    (root,) = np.flatnonzero((model.body_parentid == 0) & (model.body_dofnum == 6))
    place, turn = data.xpos[root], data.xmat[root].reshape(3, 3).T
    wheels = tuple(Wheel(str(number), *(turn @ (point.pos - place))[:2]) for number, point in enumerate(data.contact))
    x, y, _ = turn @ (data.subtree_com[root] - place)
    mass = float(model.body_subtreemass[root])
    return Base("robot", wheels, float(data.subtree_com[root][2]), 0.0, mass / 1.2, centre=(1.2 * x, 1.2 * y))


if __name__ == "__main__":
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    for each in SKID_STEERED:
        with tempfile.TemporaryDirectory() as place:
            print("| " + " | ".join(row(each, Path(sys.argv[1]).resolve(), Path(place))) + " |", flush=True)
