"""Finds the track and the limit of the turn rate with which a skid-steered base drives arcs as commanded, and writes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.api.scene_loading import load
from graphengine.api.session import Session
from graphengine.api.session_control import Checkpoint
from graphengine.bringup.calibration.drive_recorder import DriveRecorder, FallenError
from graphengine.bringup.calibration.figures import Calibration, Twist
from graphengine.bringup.calibration.flat_scene import flat_scene
from graphengine.bringup.calibration.full_speed import limits_of, slow_arc
from graphengine.bringup.calibration.measuring import is_steady, mean_velocity
from graphengine.bringup.calibration.robot_interface import find_command, inputs_named, limit_of
from graphengine.bringup.calibration.write_back import write_figures, write_input

EXACT = 0.005
"""Largest relative difference between the reached and the commanded turn rate with the track found."""
ACCEPTED = 0.05
"""Largest relative difference in the turn rate at which the track of the description's controller is kept."""
_RAMP = 15.0
"""Largest time to reach the speed and turn rate of an arc, s."""
_RUNS = 5
"""Largest number of tracks, or of limits, that are tried."""
AHEAD, TURNED = 0.05, 0.1
"""Largest relative differences in speed and turn rate that arcs at the limits may have."""
_LOWER = 0.8
"""Factor that lowers the limit of the turn rate until arcs are as commanded.

Much slower turns can start late, because the links of a rocker move before they push the wheels.
"""


def correct_track(robot_file: Path, name: str, lift: float, allowed: Sequence[Path], *, told: bool) -> str:
    """Drive an imported skid-steered robot on arcs, write the track that it needs into its file, and return a line on the track.

    Args:
        robot_file: robot file, whose graph has a controller for a base with left and right wheels.
        name: name of the robot.
        lift: height of the root link on the floor, m.
        allowed: folders outside of the project that the robot uses.
        told: whether the description's controller gives the track in the file; this track is kept if it is nearly right.

    Raises:
        CheckError: the robot has errors.
    """
    with _on_flat_floor(robot_file, name, lift, allowed) as scene:
        try:
            return _correct(scene, name, told=told)
        except FallenError as error:
            return f"track: not measured, because {error}"


def lower_turn(robot_file: Path, name: str, lift: float, allowed: Sequence[Path], *, guessed: bool) -> list[str]:
    """Drive an imported skid-steered robot on arcs at its limits, and return lines on arcs that are not as commanded.

    A guessed limit of the turn rate is lowered in the robot's file until the arcs are as commanded.

    Args:
        robot_file: robot file with the track that `correct_track` has written.
        name: name of the robot.
        lift: height of the root link on the floor, m.
        allowed: folders outside of the project that the robot uses.
        guessed: whether the limit of the turn rate may be lowered, because the description does not give it.

    Raises:
        CheckError: the robot has errors.
    """
    with _on_flat_floor(robot_file, name, lift, allowed) as scene:
        try:
            return _lower(scene, name, guessed=guessed)
        except FallenError as error:
            return [f"arcs at the limits: {error}"]


def _on_flat_floor(robot_file: Path, name: str, lift: float, allowed: Sequence[Path]) -> AbstractContextManager[Scene]:
    """Return a context manager that yields a scene with a robot on a flat floor."""
    place = robot_file.absolute()
    robots = {name: {"use": str(place), "position": [0.0, 0.0, lift]}}
    outside = [place.parent, *([place.parent.parent] if place.parent.name == "robots" else []), *allowed]
    allow = [each.absolute() for each in outside]
    return flat_scene("track", "track", lambda path: load(path, allow=allow, rays="mujoco"), {"robots": robots})


def _correct(scene: Scene, name: str, *, told: bool) -> str:
    inputs = {
        f"{graph.name}/{node.id}.{port}": value
        for graph, node, port, value in inputs_named(loaded_of(scene).planned, "wheelDistance")
    }
    speed, turn = slow_arc(world_of(scene).robots[name], *limits_of(scene))
    command = find_command(scene.topics, None)
    if not inputs or command is None or not 0.0 < turn < math.inf or not speed < math.inf:
        return "track: not measured, because its graph has no command topic or no limits, or its wheels no grip across them"
    before = float(next(iter(inputs.values())))
    tried: list[tuple[float, float]] = []
    with scene.session(domain=0) as sim:
        arcs = ArcDrives(sim, DriveRecorder(sim, name, command, (), None), sim.checkpoint(), tuple(inputs))
        while len(tried) < _RUNS and not (tried and _error(tried[-1]) <= EXACT):
            track = tried[-1][0] / tried[-1][1] if tried else before
            left, right = arcs.drive(speed, turn, track)
            share = (left.yaw - right.yaw) / 2.0 / turn
            if not tried and told and abs(share - 1.0) <= ACCEPTED:
                return f"track: {track:.4g} m of the controller, with which it turns at {share:.1%} of commands"
            if share < 0.1:
                return f"track: not measured, because the robot turns at {share * turn:.3g} rad/s of {turn:.3g} rad/s"
            tried.append((track, share))
    best = min(tried, key=_error)
    found = Calibration(name, command.topic, command.type, speed, turn, True, "differential", track=best[0])
    write_figures(scene, found)
    outcome = "as commanded" if _error(best) <= EXACT else f"at {best[1]:.1%} of commands"
    text = f"track: {best[0]:.4g} m, with which the robot turns {outcome} on arcs of {speed:.3g} m/s, {turn:.3g} rad/s"
    return f"{text}; with {before:.4g} m of the controller, it turns at {tried[0][1]:.1%}" if told else text


def _error(drive: tuple[float, float]) -> float:
    """Return the relative error of the turn rate in a drive, i.e. a track and the reached share of the commanded turn rate."""
    return abs(drive[1] - 1.0)


def _lower(scene: Scene, name: str, *, guessed: bool) -> list[str]:
    command, first = find_command(scene.topics, None), limit_of(scene, "maxAngularSpeed")
    if command is None or not max(limits_of(scene)) < math.inf:
        return []
    limit, failed = first, list[_Arcs]()
    with scene.session(domain=0) as sim:
        drives = ArcDrives(sim, DriveRecorder(sim, name, command, (), None), sim.checkpoint())
        for _ in range(_RUNS):
            speed, turn = limits_of(scene, limit)
            commands = (speed, turn), slow_arc(world_of(scene).robots[name], speed, turn)
            tried = (_Arcs.driven(drives, *each) for each in commands)
            bad = next((arcs for arcs in tried if not arcs.good), None)
            if bad is None:
                break
            failed.append(bad)
            if not guessed:
                break
            limit *= _LOWER
    if not failed:
        return []
    value, comment = float(f"{limit:.3g}"), f"lowered from {first:.4g}, with which arcs are not as commanded"
    if bad is None and write_input(scene, name, "maxAngularSpeed", value, comment):
        return [f"limit of the skid-steered base: turn {value:g} rad/s in place of {first:.4g} rad/s: {failed[0]}"]
    remedy = f"even {failed[-1]}" if bad is not None and guessed else "lower `turn` of its graph"
    return [f"limits too high for the skid-steered base: {failed[0]}; {remedy}"]


@dataclass(frozen=True, slots=True)
class _Arcs:
    """Test arcs to both sides: commanded speed and turn rate, and the reached share of each that is farthest from 1."""

    speed: float
    turn: float
    ahead: float
    rate: float

    @staticmethod
    def driven(drives: ArcDrives, speed: float, turn: float) -> _Arcs:
        """Drive test arcs with a speed (m/s) and turn rate (rad/s)."""
        arcs = drives.drive(speed, turn)
        ahead = max((arc.x / speed for arc in arcs), key=lambda share: abs(share - 1.0))
        rate = max((abs(arc.yaw) / turn for arc in arcs), key=lambda share: abs(share - 1.0))
        return _Arcs(speed, turn, ahead, rate)

    @property
    def good(self) -> bool:
        """Whether the arcs are as commanded."""
        return abs(self.ahead - 1.0) <= AHEAD and abs(self.rate - 1.0) <= TURNED

    def __str__(self) -> str:
        reached = f"reaches {self.ahead:.0%} of the speed and {self.rate:.0%} of the turn rate"
        return f"on arcs of {self.speed:.3g} m/s and {self.turn:.3g} rad/s, it skids and {reached}"


@dataclass(frozen=True, slots=True)
class ArcDrives:
    """Test arcs of a robot to the left and right.

    Attributes:
        sim: session with the robot.
        drives: recorder that drives the robot.
        mark: state in which each arc begins.
        inputs: addresses of the inputs that hold the track.
    """

    sim: Session
    drives: DriveRecorder
    mark: Checkpoint
    inputs: tuple[str, ...] = ()

    def drive(self, speed: float, turn: float, track: float | None = None) -> tuple[Twist, Twist]:
        """Return the mean velocities that the robot reaches on an arc to the left and on an arc to the right.

        Args:
            speed: speed to command, m/s.
            turn: turn rate to command, rad/s.
            track: track of the controller, m; None keeps the track of the robot's file.
        """
        return self._drive(Twist(x=speed, yaw=turn), track), self._drive(Twist(x=speed, yaw=-turn), track)

    def _drive(self, command: Twist, track: float | None) -> Twist:
        """Return the mean velocity that the robot reaches with a command."""
        self.sim.restore(self.mark)
        if track is not None:
            for address in self.inputs:
                self.sim.set(address, track)
        self.drives.begin()
        self.drives.drive_until(command, lambda trace: is_steady(trace, command), _RAMP)
        begin = self.drives.rows - 1
        self.drives.drive(command, 2.0)
        return mean_velocity(self.drives.trace().part(begin))
