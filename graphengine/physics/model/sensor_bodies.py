"""Adds sensors to the model of their robot: visible bodies, and parts that devices need, such as welds.

The bodies are visible to cameras and to rays of other robots; they have neither mass nor collisions.
"""

from __future__ import annotations

from graphengine.descriptions.engine import RAYS_AND_PICTURES, mujoco
from graphengine.devices.stage import Stage, housing_of
from graphengine.format.diagnostics import Findings
from graphengine.physics.implementations import IMPLEMENTATIONS
from graphengine.physics.model.profiles import ShapeSpec
from graphengine.physics.model.robot import RobotInstance
from graphengine.physics.model.robot_prims import add_robot


def add_sensors(model: mujoco.MjSpec, robot: RobotInstance) -> None:
    """Add a body for each sensor with an appearance to the body that carries the sensor, and the parts that devices need.

    Args:
        model: editable model of the robot.
        robot: robot with the sensors.
    """
    stage, bodies = Stage(), {f"{robot.name}/{body.name}" for body in model.bodies}
    add_robot(stage, robot, bodies, Findings())  # errors are reported when the robot's prims are defined in the scene
    for name, path in stage.find(robot.prim_path).facts["mounts"].items():
        profile = robot.profiles.get(name)
        if not path or profile is None:
            continue
        mount = stage.find(path)
        for prim in mount.descendants():
            kind = IMPLEMENTATIONS.all.get(prim.kind)
            if kind is not None and kind.build is not None:
                kind.build(model, (prim.carrier()[0] or "world").removeprefix(f"{robot.name}/"), prim)
        if not profile.appearance:
            continue
        body, (position, (x, y, z, w)) = mount.carrier()
        if body is None:
            continue
        carrier, name = (path.removeprefix(f"{robot.name}/") for path in (body, housing_of(mount)))
        housing = model.body(carrier).add_body(name=name, pos=position, quat=(w, x, y, z))
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
