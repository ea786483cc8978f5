"""How a mobile base follows its commands, on the flat and on a slope: `python -m tests.bench.base_figures SCENE`.

SCENE is the scene of a new project with one robot. Commands are shares of the robot's own limits: straight drives, turns on the
spot and sideways drives at 0.3 of them, arcs at 0.3 and 1.0 of both, drives up and across a floor of 5 degrees, a turn on it, and
a stop from full speed. The limits are those of the graph's controller, reduced as the graph reduces a command that its wheels
cannot follow. Speeds are means over 3 s, after the ramp. Prints JSON: ratios of reached to commanded values, and mm/s.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

import graphengine as ge
from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.api.session import Session
from graphengine.bringup.calibration.calibrator import choose_robot
from graphengine.bringup.calibration.drive_recorder import STILL, DriveRecorder, FallenError
from graphengine.bringup.calibration.figures import Twist
from graphengine.bringup.calibration.flat_scene import on_flat_floor
from graphengine.bringup.calibration.measuring import mean_velocity
from graphengine.bringup.calibration.omni_geometry import is_oblique
from graphengine.bringup.calibration.robot_interface import find_command, inputs_named, known_wheel_base, limit_of
from graphengine.bringup.calibration.wheel_geometry import WheelMeter
from graphengine.physics.model.robot import RobotInstance

SLOPE = 5.0
"""Slope of the tilted floor, degrees."""
MEASURED = 3.0
"""Time over which a speed is measured, s."""
STOPPED = 0.01
"""Speed below which the robot has stopped, m/s."""
PARKED = 4.0
"""Time for which the robot is parked on the slope, s."""


@dataclass(frozen=True)
class Limits:
    """The limits of a robot's controller: speed (m/s), turn rate (rad/s) and deceleration (m/s2); infinite if there is none.

    `rim` is the largest speed of a wheel's rim, m/s, and `lever` the speed of the rim divided by the turn rate on the spot, m.
    """

    speed: float
    turn: float
    deceleration: float
    rim: float
    lever: float

    def scaled(self, twist: Twist) -> Twist:
        """The command that the graph makes of a command that is too fast for the wheels."""
        needed = math.hypot(twist.x, twist.y) + abs(twist.yaw) * self.lever
        share = min(1.0, self.rim / needed) if needed else 1.0
        return Twist(twist.x * share, twist.y * share, twist.yaw * share)


class Base:
    """The base of a running scene."""

    def __init__(self, sim: Session, scene: Scene, robot: str) -> None:
        command = find_command(scene.topics, None)
        if command is None:
            raise SystemExit("no graph of the robot takes velocity commands")
        instance = world_of(scene).robots[robot]
        self.sim = sim
        self.car = any(inputs_named(loaded_of(scene).planned, "maxWheelRotation"))
        self.wheel_base = known_wheel_base(scene) or WheelMeter.described_wheel_base(instance)
        self.steering = limit_of(scene, "maxWheelRotation")
        self.drives = DriveRecorder(sim, robot, command, (), self.wheel_base)
        self.limits = _limits(scene, instance)
        self._mark = sim.checkpoint()

    def reached(self, twist: Twist) -> Twist:
        """The mean velocity under a constant command; NaN if the robot falls."""
        self._begin()
        ramp = max(2.0, abs(twist.x) / min(self.limits.deceleration, 1.0) + 1.0)
        try:
            self.drives.drive(twist, ramp)
            begin = self.drives.rows - 1
            self.drives.drive(twist, MEASURED)
        except FallenError:
            return Twist(math.nan, math.nan, math.nan)
        return mean_velocity(self.drives.trace().part(begin))

    def stop(self, speed: float) -> float:
        """The way (m) from the command to stop, at a speed that the robot has reached, to the stop."""
        self._begin()
        try:
            return self._way(speed)
        except FallenError:
            return math.nan

    def _way(self, speed: float) -> float:
        self.drives.drive(Twist(x=speed), max(2.0, speed / min(self.limits.deceleration, 1.0) + 1.0))
        begin = self.drives.rows - 1
        for _ in range(200):
            self.drives.drive(STILL, 0.1)
            path = self.drives.trace().part(begin).base
            if math.dist(path[-1, :2], path[-4, :2]) < STOPPED * 3 * self.drives.dt:
                break
        return float(math.dist(path[-1, :2], path[0, :2]))

    def creep(self) -> float:
        """The speed (mm/s) of the parked robot."""
        self._begin()
        with contextlib.suppress(FallenError):
            self.drives.drive(STILL, PARKED)
        path = self.drives.trace().base
        return 1000.0 * float(math.dist(path[-1, :2], path[path.shape[0] // 2, :2])) / (PARKED / 2)

    def _begin(self) -> None:
        self.sim.restore(self._mark)
        self.drives.begin()


def _limits(scene: Scene, robot: RobotInstance) -> Limits:
    rim = limit_of(scene, "maxWheelSpeed", "maxWheelVelocity") * limit_of(scene, "wheelRadius", "backWheelRadius")
    track, brakes = limit_of(scene, "wheelDistance"), limit_of(scene, "maxDeceleration", "acceleration")
    lever = track / 2
    if any(
        inputs_named(loaded_of(scene).planned, "mecanumAngles")
    ):  # mecanum or omni wheels, whose drives have the ramps
        joints = [
            robot.description.joints[name] for name, drive in robot.drives.items() if drive.max_acceleration < math.inf
        ]
        places = [robot.description.pose_in_root(joint.child)[0] for joint in joints]
        axes = robot.description.axes_in_root()
        oblique = any(is_oblique(axes[joint.name]) for joint in joints)
        lever = max((math.hypot(x, y) if oblique else abs(x) + abs(y) for x, y, _ in places), default=0.0)
        radius = limit_of(scene, "wheelRadius")
        brakes = min((robot.drives[joint.name].max_acceleration * radius for joint in joints), default=math.inf)
    return Limits(limit_of(scene, "maxLinearSpeed"), limit_of(scene, "maxAngularSpeed"), brakes, rim, lever)


@contextmanager
def on_slope(scene: Path, across: bool) -> Iterator[Scene]:
    """The project's scene on a tilted floor, with the robot across it, or facing upwards."""
    data = yaml.safe_load(scene.read_text(encoding="utf-8"))
    (robot,) = data["robots"].values()
    tilt = [SLOPE, 0, 0] if across else [0, -SLOPE, 0]
    floor = f'<geom type="plane" size="0 0 1" euler="{tilt[0]} {tilt[1]} 0"/>'
    (scene.parent / "slope.xml").write_text(
        f"<mujoco><compiler angle='degree'/><worldbody>{floor}</worldbody></mujoco>"
    )
    robot |= {
        "position": [0, 0, robot["position"][2] / math.cos(math.radians(SLOPE))],
        "orientation": {"rpy_deg": tilt},
    }
    data |= {"world": "slope.xml", "graphs": {}}
    path = scene.parent / "slope.yaml"
    path.write_text(yaml.safe_dump(data))
    yield ge.load(path)


def figures(scene: Path) -> dict[str, Any]:
    """Measure the base of a scene."""
    opened = ge.load(scene)
    robot = choose_robot(opened, None)
    found: dict[str, Any] = {}
    with on_flat_floor(opened, robot) as flat, flat.session(domain=0) as sim:
        base = Base(sim, flat, robot.name)
        found |= _on_the_flat(base)
    for across in (False, True):
        with on_slope(scene, across) as tilted, tilted.session(domain=0) as sim:
            found |= _on_the_slope(Base(sim, tilted, robot.name), "across" if across else "up", found["speed"])
    return found


def _on_the_slope(base: Base, name: str, speed: float) -> dict[str, Any]:
    found: dict[str, Any] = {f"slope_{name}": _share(base, Twist(x=speed))[0], f"creep_{name}": base.creep()}
    if name == "across" and not base.car:
        rate = 0.3 * min(base.limits.turn, base.limits.rim / base.limits.lever, 3.0)
        found["slope_spot"] = _share(base, Twist(yaw=rate))[1]
    return found


def _on_the_flat(base: Base) -> dict[str, Any]:
    limits = base.limits
    found: dict[str, Any] = {}
    full = min(limits.speed, limits.rim, 2.0)
    turn = min(limits.turn, limits.rim / limits.lever if limits.lever else math.inf, 3.0)
    speed, rate = 0.3 * full, 0.3 * turn
    found["speed"] = speed
    found["straight"] = [_share(base, Twist(x=sign * speed))[0] for sign in (1, -1)]
    if base.car:
        assert base.wheel_base is not None
        radius = base.wheel_base / math.tan(0.8 * min(base.steering, 0.6))
        twists = {share: Twist(x=share * full, yaw=share * full / radius) for share in (0.3, 1.0)}
    else:
        found["spot"] = [_share(base, Twist(yaw=sign * rate))[1] for sign in (1, -1)]
        sideways = [base.reached(Twist(y=sign * speed)).y / (sign * speed) for sign in (1, -1)]
        if min(sideways) > 0.1:
            found["sideways"] = sideways
        twists = {share: Twist(x=share * full, yaw=share * turn) for share in (0.3, 1.0)}
    for share, twist in twists.items():
        pairs = [_share(base, replace(twist, yaw=sign * twist.yaw)) for sign in (1, -1)]
        found[f"arc_{share}"] = [pair[0] for pair in pairs]
        found[f"arc_{share}_turn"] = [pair[1] for pair in pairs]
    found["limits"] = {"speed": full, "turn": turn}
    if limits.deceleration < math.inf:
        found["stop"] = base.stop(full) / (full * full / (2 * limits.deceleration))
    return found


def _share(base: Base, twist: Twist) -> tuple[float, float]:
    """The reached speed and turn rate divided by those that the graph commands; NaN where none is commanded."""
    reached, told = base.reached(twist), base.limits.scaled(twist)
    return (reached.x / told.x if told.x else math.nan), (reached.yaw / told.yaw if told.yaw else math.nan)


BOUND = 0.05
"""Largest deviation of a speed or turn rate from the command, as a share; a skid-steered base may be faster in arcs."""
SKID_TURN = 0.1
"""Largest deviation of the turn rate of a skid-steered base."""
WAY = 1.2
"""Largest way to stop, as a multiple of v^2 / 2a."""
DRIVES = ("straight", "sideways", "arc_0.3", "arc_1.0", "slope_up", "slope_across")
"""The figures that are speeds."""


def outside(found: dict[str, Any], *, skid: bool) -> list[str]:
    """The names of the figures that are out of bounds."""
    bad = []
    for name in (name for name in DRIVES if name in found):
        most = math.inf if skid and name.startswith("arc") else 1.0 + BOUND
        if not all(1.0 - BOUND <= share <= most for share in _values(found[name])):
            bad.append(name)
    turns = [name for name in found if name == "spot" or name.endswith(("_turn", "_spot"))]
    bound = SKID_TURN if skid else BOUND
    bad += [name for name in turns if not all(abs(share - 1.0) <= bound for share in _values(found[name]))]
    return [*bad, *(["stop"] if "stop" in found and not found["stop"] <= WAY else [])]


def _values(figure: float | list[float]) -> list[float]:
    return figure if isinstance(figure, list) else [figure]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    given = parser.parse_args()
    print(json.dumps(figures(given.scene)))


if __name__ == "__main__":
    main()
