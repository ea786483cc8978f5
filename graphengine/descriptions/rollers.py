"""Finds the rollers of omni and mecanum wheels in a description that models each roller as a link on a joint."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graphengine.descriptions.engine import Floats
from graphengine.descriptions.robot_description import TURNING, Joint, RobotDescription
from graphengine.devices.rotation import Vector3, rotate

_LEAST = 5
"""Minimum number of rollers of a wheel."""
_PARALLEL = 0.95
"""Smallest cosine of the angle between axle and joint axis at which the axes count as parallel; the joint carries no roller."""
_RING = 0.1
"""Maximum deviation of a roller's distance from the axle, as a fraction of the mean distance."""


@dataclass(frozen=True, slots=True)
class Rollers:
    """The rollers of a wheel.

    Attributes:
        joints: names of the joints on which the rollers turn.
        links: names of the rollers' links.
        axis: axis of a roller on the floor in the root link's frame: the direction along which the wheel grips.
    """

    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    axis: Vector3 | None = None


NO_ROLLERS = Rollers()


def rollers_of(description: RobotDescription) -> dict[str, Rollers]:
    """Return the rollers of each wheel that has some, by the name of the wheel's joint.

    Rollers turn without limits and form a ring about the axle.
    """
    axes = description.axes_in_root()
    found: dict[str, Rollers] = {}
    for joint in description.moving():
        if joint.type not in TURNING:
            continue
        axle = np.array(axes[joint.name])
        below = list(_below(description, joint.child))
        rolling = [each for each in below if abs(axle @ np.array(axes[each.name])) < _PARALLEL]
        if len(rolling) >= _LEAST and len(rolling) == len(below) and _form_a_ring(description, joint, axle, rolling):
            names, links = tuple(each.name for each in rolling), tuple(each.child for each in rolling)
            found[joint.name] = Rollers(names, links, _axis_on_floor(description, joint, axle, rolling))
    return found


def _below(description: RobotDescription, link: str) -> Iterator[Joint]:
    """Yield the nearest moving joints below a link that carry no further moving joint and turn without limits."""
    for joint in description.links[link].below:
        if not joint.moves:
            yield from _below(description, joint.child)
        elif joint.type in TURNING and joint.limits is None:
            carried = (each for above in description.depth_first(joint.child) for each in above.below)
            if not any(each.moves for each in carried):
                yield joint


def _arms(description: RobotDescription, joint: Joint, axle: Floats, rolling: list[Joint]) -> Floats:
    """Return the vector from the axle to each roller's joint, perpendicular to the axle, m; shape (number of rollers, 3)."""
    hub = np.array(description.pose_in_root(joint.child)[0])
    arms: Floats = np.array([description.pose_in_root(each.child)[0] for each in rolling]) - hub
    return arms - np.outer(arms @ axle, axle)


def _form_a_ring(description: RobotDescription, joint: Joint, axle: Floats, rolling: list[Joint]) -> bool:
    arms = _arms(description, joint, axle, rolling)
    lengths = np.linalg.norm(arms, axis=1)
    mean = float(lengths.mean())
    return (
        mean > 0
        and bool(np.all(abs(lengths - mean) < _RING * mean))
        and float(np.linalg.norm(arms.mean(axis=0))) < _RING * mean
    )


def _axis_on_floor(description: RobotDescription, joint: Joint, axle: Floats, rolling: list[Joint]) -> Vector3:
    """Return the axis of a roller in the root link's frame, after the wheel has turned the roller straight below the axle."""
    arms = _arms(description, joint, axle, rolling)
    lowest = int(arms[:, 2].argmin())
    down = -np.eye(3)[2] + axle[2] * axle
    arm = arms[lowest] / np.linalg.norm(arms[lowest])
    angle = math.atan2(float(np.cross(arm, down) @ axle), float(arm @ down))
    x, y, z = (float(part) * math.sin(angle / 2) for part in axle)
    turned = rotate((x, y, z, math.cos(angle / 2)), description.axes_in_root()[rolling[lowest].name])
    return turned if turned[0] > 0 or (turned[0] == 0 and turned[1] > 0) else (-turned[0], -turned[1], -turned[2])
