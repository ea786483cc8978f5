"""Bodies of sensors, seen by cameras and by the rays of other robots: without mass, and nothing collides with them."""

from __future__ import annotations

from graphengine.diagnostics import Findings
from graphengine.stage import Stage
from graphengine.world.engine import RAYS_AND_PICTURES, mujoco
from graphengine.world.poses import carrier
from graphengine.world.prims import add_robot
from graphengine.world.robot import Robot
from graphengine.world.sensors.profiles import ShapeSpec


def add_housings(model: mujoco.MjSpec, robot: Robot) -> None:
    """Give each sensor that has an appearance a body of its own, on the one that carries its mount.

    Args:
        model: of the robot.
        robot: whose mounts are found as its prims will be.
    """
    stage, bodies = Stage(), {f"{robot.name}/{body.name}" for body in model.bodies}
    add_robot(stage, robot, bodies, Findings())  # what is wrong is told when the robot's prims are made
    for mount in stage.prims("sensor"):
        profile = robot.profiles.get(mount.name)
        body, (position, (x, y, z, w)) = carrier(mount)
        if profile is None or body is None or not profile.appearance:
            continue
        housing = model.body(body.partition("/")[2]).add_body(
            name=f"{mount.name}.housing", pos=position, quat=(w, x, y, z)
        )
        for shape in profile.appearance:
            _add_shape(housing, shape)


def _add_shape(body: mujoco.MjsBody, shape: ShapeSpec) -> None:
    length, width, height = shape.size
    box = shape.shape == "box"
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX if box else mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[length / 2, width / 2, height / 2] if box else [length / 2, height / 2, 0.0],
        pos=shape.position,
        rgba=[*shape.colour, 1.0],
        mass=0.0,
        contype=0,
        conaffinity=0,
        group=RAYS_AND_PICTURES,
    )
