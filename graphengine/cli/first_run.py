"""Runs a new project for a short time, and reports a robot that falls, leans, hangs, sags or starts inside another body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.devices.rotation import tilt_of
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import GraphError
from graphengine.format.wording import printable

if TYPE_CHECKING:
    from graphengine.api.bodies import Pose
    from graphengine.api.session import Session
    from graphengine.physics.model.robot import RobotInstance

SECONDS = 2.0
"""Simulated time, s."""
MOST_JOINTS = 120
"""Maximum number of moving joints of a robot that is run."""
FALLEN, LEANING = 20.0, 1.0
"""Tilt (degrees) of the base link beyond which a robot has fallen, and beyond which it leans."""
SUNK = 0.05
"""Distance (m) by which the base link of a robot that has fallen, or whose legs have given way, comes down."""
CREPT = 0.01
"""Horizontal distance (m) beyond which a robot without a command rolls away."""
HANGING = 0.05
"""Distance (rad or m) from its start beyond which a joint without a drive hangs; new projects test with this tolerance."""
MOST_TOLD = 6
"""Maximum number of joints that a line names."""
SAG = 0.002
"""Distance (rad or m) from its target beyond which the drive of a joint sags; new projects test with this tolerance."""


def first_run(scene: Path, robot: str, *, holds: bool) -> list[str]:
    """Run a scene for `SECONDS` and return lines on how the robot moves without a command; empty if it stays at rest.

    Args:
        scene: path of the scene file.
        robot: name of the robot in the scene.
        holds: whether the project tests that the joints hold their start positions.
    """
    from graphengine.api.scene import loaded_of
    from graphengine.api.scene_loading import load

    try:
        opened = load(scene)
    except CheckError as error:
        errors = [found.message for found in error.findings if found.severity == "error"]
        return [f"the files of the project have errors: {message}" for message in errors]
    world = loaded_of(opened).world
    assert world is not None
    instance = world.robots[robot]
    lines = [f"at the start, {found.message}" for found in opened.findings if found.code == "W210"]
    if len(instance.moving) > MOST_JOINTS:
        return lines
    try:
        with opened.session() as sim:
            begin = sim.robots[robot].pose
            before = {name: joint.position for name, joint in sim.robots[robot].joints.items()}
            sim.run(SECONDS)
            return [*lines, *_said(sim, instance, begin, before, holds=holds)]
    except GraphError as error:
        return [*lines, f"the simulation fails: {error}"]


def _said(sim: Session, robot: RobotInstance, begin: Pose, before: dict[str, float], *, holds: bool) -> list[str]:
    """Return lines on how a robot has moved from the pose `begin` of its base link and the positions `before` of its joints."""
    now = sim.robots[robot.name]
    placed = robot.placement.pose[0][2] if robot.keyframe is None else begin.position[2]
    moved = max((abs(joint.position - before[name]) for name, joint in now.joints.items()), default=0.0)
    lines = [*_base(now.pose, begin, placed), *_joints(sim, robot)]
    if holds and moved > HANGING:
        lines.append(f"test_robot.py fails: a joint moves {moved:.2f} rad or m from its start position")
    return lines


def _base(pose: Pose, begin: Pose, placed: float) -> list[str]:
    """Return a line if the base link has fallen, leans or moves away; else an empty list.

    Args:
        pose: pose of the base link at the end.
        begin: pose of the base link at t = 0, after settling.
        placed: height of the base link in the scene file, m.
    """
    tilt = math.degrees(tilt_of(pose.orientation))
    down, crept = placed - pose.position[2], math.dist(pose.position[:2], begin.position[:2])
    if tilt > FALLEN or down > SUNK:
        lower = f" {1000 * down:.0f} mm lower and" if down > SUNK else ""
        return [f"the robot falls: after {SECONDS:g} s its base link is{lower} tilted by {tilt:.0f} degrees"]
    if tilt > LEANING:
        return [f"the robot leans by {tilt:.1f} degrees"]
    return [f"the robot moves {1000 * crept:.0f} mm in {SECONDS:g} s without a command"] if crept > CREPT else []


def _joints(sim: Session, robot: RobotInstance) -> list[str]:
    """Return a line on joints without a drive that hang, and a line on drives that sag under the weight of links.

    Joints with a velocity drive are left out, because they have no position to hold.
    """
    from graphengine.api.robots import find_robot
    from graphengine.descriptions.actuators.drives import Drive

    held = sim._runner.session.services.world.articulation(find_robot(sim._runner, robot.name))
    targets = dict(zip(held.joint_names, held.set_points()[0].tolist(), strict=True))
    hanging: list[tuple[str, float]] = []
    sagging: list[tuple[str, float]] = []
    for name, joint in sim.robots[robot.name].joints.items():
        described = robot.description.joints[name]
        bounded = described.limits is not None or robot.disabled.free_link is None
        servo = robot.drives.get(name, Drive()).servo(name, "velocity")
        if math.isfinite(targets[name]):
            sagging.append((name, joint.position - targets[name]))
        elif servo is None and described.mimic is None and bounded:
            hanging.append((name, joint.position - robot.starts.get(name, 0.0)))
    without = "joints without a drive hang, rad or m: {}; --position-drives holds joints that take efforts"
    if robot.description.mjcf is not None:
        without = "joints without a position servo move, rad or m: {}"
    return [
        *_worst(without, hanging, HANGING),
        *_worst("drives are off their targets, as under the weight in the start position, rad or m: {}", sagging, SAG),
    ]


def _worst(text: str, errors: Sequence[tuple[str, float]], bound: float) -> list[str]:
    """Return a line with the `MOST_TOLD` joints whose errors are largest and exceed the bound; an empty list without any."""
    large = sorted((each for each in errors if abs(each[1]) > bound), key=lambda each: -abs(each[1]))
    if not large:
        return []
    more = f" and {len(large) - MOST_TOLD} more" if len(large) > MOST_TOLD else ""
    return [text.format(", ".join(f"{printable(name)} {error:+.3f}" for name, error in large[:MOST_TOLD]) + more)]
