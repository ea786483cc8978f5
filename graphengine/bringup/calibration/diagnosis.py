"""Finds reasons why a robot does not follow its commands, in the robot's graphs and in the state of the physics."""

from __future__ import annotations

import math
from collections import defaultdict

import numpy as np

from graphengine.api.scene import Scene
from graphengine.api.session import Session
from graphengine.bringup.calibration.drive_recorder import DriveRecorder
from graphengine.bringup.calibration.figures import Twist
from graphengine.bringup.calibration.robot_interface import COMMAND_TYPES, claims_of
from graphengine.bringup.calibration.wheel_geometry import WheelMeter
from graphengine.format.wording import listing

SLOWEST = 1e-3
"""Smallest speed at which a robot without a command counts as moving, m/s and rad/s."""


def no_command(scene: Scene, alone: Scene) -> str:
    """Return the reason why a robot has no command topic.

    Args:
        scene: scene that the user calibrates.
        alone: scene with only this robot and the graphs of its robot file.
    """
    names = ", ".join(COMMAND_TYPES).replace("/msg/", "/")
    text = f"no command topic: no graph of the robot file subscribes to {names}"
    if claims_of(scene.topics, "subscribe", *COMMAND_TYPES):
        return f"{text}; graphs of the scene are not run: list the graph below `graphs:` of the robot file"
    if not alone.graphs:
        return f"{text}; the robot file has no graphs"
    return text


def floor_load(sim: Session, robot: str) -> dict[str, float]:
    """Return a dict from the links of a robot in contact to the vertical force that other bodies exert on them, N."""
    world = sim._runner.session.services.world
    contacts, names = world.contacts(), world.bodies().names
    loads: dict[str, float] = defaultdict(float)
    for (first, second), force in zip(contacts.bodies.tolist(), contacts.forces[:, 2].tolist(), strict=True):
        for body, sign in ((first, -1.0), (second, 1.0)):
            owner, _, link = names[body].partition("/")
            if owner == robot and not names[second if body == first else first].startswith(f"{robot}/"):
                loads[link] += sign * force
    return dict(loads)


def rolls_away(velocity: Twist) -> list[str]:
    """Return a note in a list if `velocity`, without a command, shows a moving robot; else an empty list."""
    speed = math.hypot(velocity.x, velocity.y)
    if speed < SLOWEST and abs(velocity.yaw) < SLOWEST:
        return []
    return [f"the robot moves without a command: {speed:.4f} m/s, {velocity.yaw:.4f} rad/s"]


def stands_still(drives: DriveRecorder, wheels: WheelMeter, load: dict[str, float]) -> list[str]:
    """Return reasons why the robot did not move in the last drive, although a motion was commanded.

    Args:
        drives: recorder of the drive.
        wheels: the robot's wheels.
        load: result of `floor_load`.
    """
    trace = drives.trace(drives.rows // 2)
    rates = {name: rate for name, rate in wheels.rates(trace).items() if abs(rate) > 0.05}
    if rates:
        turning = ", ".join(f"{name} ({rate:.2f} rad/s)" for name, rate in list(rates.items())[:8])
        text = f"the wheels turn, but the robot does not move: {turning}"
        if not load:
            return [f"{text}; no link of the robot touches the floor"]
        total = sum(load.values())
        shares = ", ".join(f"{link} {force:.1f} N" for link, force in sorted(load.items(), key=lambda one: -one[1])[:8])
        return [f"{text}; the floor carries {total:.1f} N: {shares}"]
    if not wheels.driven:
        return ["no joint of the robot has a drive: add a drive for each wheel below `joints:` of the robot file"]
    targets = drives.set_points()
    if not np.any(np.abs(np.nan_to_num(targets)) > 0.0):
        remedy = "check the wires from the subscriber of the command topic to the node that commands joints, and its jointNames"
        return [f"no joint gets a velocity command: {remedy}"]
    if held := held_by_stiffness(drives, wheels):
        return held
    return ["joints get commands but do not turn: check damping and max_force of their drives"]


def held_by_stiffness(drives: DriveRecorder, wheels: WheelMeter) -> list[str]:
    """Return a note in a list if joints with stiffness got velocity commands in the last drive; else an empty list."""
    commanded = dict(zip(drives.articulation.joint_names, np.nan_to_num(drives.set_points()), strict=True))
    held = [name for name in wheels.stiff if commanded[name]]
    if not held:
        return []
    remedy = "remove `stiffness` of their drives below `joints:` of the robot file"
    text = f"stiffness pulls joints with velocity commands back to their positions ({listing(held, 'joints')})"
    return [f"{text}: {remedy}"]


def clamped(sim: Session) -> list[str]:
    """Return notes on joint commands of the test drives that exceeded a limit and were clamped."""
    counts = sim._runner.session.services.world.clamped_commands
    return [f"{count} commands were clamped: {text}" for text, count in counts.items()]
