"""Finds the mecanum and omni wheels of a robot by the friction of their materials."""

from __future__ import annotations

import math
from collections.abc import Iterator

from graphengine.devices.holonomic_wheels import HolonomicWheel
from graphengine.devices.rotation import Vector3, rotate
from graphengine.format.robot_spec import MaterialSpec
from graphengine.physics.model.robot import RobotInstance


def holonomic_wheels(robot: RobotInstance) -> Iterator[HolonomicWheel]:
    """Yield the wheels whose material has different friction in two directions, in the order of the robot's joints.

    The direction with the greater friction is the axis of the roller that touches the floor.
    """
    description, radii = robot.description, robot.wheel_radii
    materials = {link: material for material in robot.spec.materials.values() for link in material.bind}
    for joint in robot.moving:
        material = materials.get(joint.child)
        if joint.name not in radii or material is None or material.across in (None, material.dynamic_friction):
            continue
        turn = description.pose_in_root(material.expressed_in or description.turns_in(joint.child))[1]
        grip = _grip(material, rotate(turn, material.direction or (1.0, 0.0, 0.0)))
        position, orientation = description.pose_in_root(joint.child)
        axle = rotate(orientation, joint.axis)
        angle = math.degrees(_heading(grip) - _heading(axle))
        angle = (angle + 90.0 - 1e-9) % 180.0 - 90.0 + 1e-9  # an axis has no sign
        yield HolonomicWheel(joint.name, radii[joint.name], position, axle, angle)


def _grip(material: MaterialSpec, along: Vector3) -> Vector3:
    """Return the horizontal direction of a material's greater friction; `along` is the direction of `dynamic_friction`."""
    x, y, _ = along
    return along if material.dynamic_friction > (material.across or 0.0) else (-y, x, 0.0)


def _heading(direction: Vector3) -> float:
    """Return the angle of a direction about the z axis, rad."""
    return math.atan2(direction[1], direction[0])
