"""Describes a robot's lidar as a planar lidar, and measures the inscribed radius of the robot."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from graphengine.bringup.maps.scan_casting import PlanarLidar
from graphengine.descriptions.engine import body_names, collides
from graphengine.devices.rotation import relative, tilt_of, yaw_of
from graphengine.devices.stage import Prim, Stage
from graphengine.format.errors import UsageError
from graphengine.format.wording import listing
from graphengine.physics.model.robot import RobotInstance
from graphengine.physics.simulation import Simulation

LEVEL = math.radians(10)
"""Largest angle between the floor and the beams of a lidar that counts as level, rad."""


def robot_lidar(
    world: Simulation, robots: Mapping[str, RobotInstance], robot: str | None = None, lidar: str | None = None
) -> tuple[PlanarLidar, float]:
    """Return a planar lidar that describes the mounted lidar of a robot, and the inscribed radius of the robot, m.

    Of a 3D lidar, only the ring closest to the lidar's xy plane is used.

    Args:
        world: physics of the scene.
        robots: robots of the scene by name.
        robot: name of the robot; None chooses the first robot.
        lidar: path of the lidar's prim; None chooses the robot's only lidar.

    Raises:
        PrimError: no prim is at the path `lidar`.
        UsageError: the scene does not have the robot, the robot does not have exactly one lidar, the prim is not a lidar, or its
            beams are not level.
    """
    if not robots:
        raise UsageError("the scene has no robot; add a robot with a lidar")
    name = next(iter(robots)) if robot is None else robot
    if name not in robots:
        raise UsageError(f"there is no robot {name!r}; {listing(robots)}")
    prim = _lidar(world.stage, robots[name], lidar)
    base = world.stage.find(world.stage.find(robots[name].prim_path).facts["base_link"])
    _, turn = relative(world.frame(base).pose(), world.frame(prim).pose())
    tilt, facts = tilt_of(turn), prim.facts
    elevation = min(facts["elevations"], key=abs)
    if min(tilt, math.pi - tilt) + abs(elevation) > LEVEL:
        reason = "the beams are not level, so they cannot be compared with a map"
        raise UsageError(f"{prim.path}: {reason}; choose another lidar")
    first, last, step = facts["angles"]
    begin = yaw_of(turn) + (first if tilt < math.pi / 2 else -last)  # an inverted lidar scans clockwise
    field = last - first
    near, far = facts["ranges"]
    whole = math.tau if field + step > math.tau - 1e-6 else field
    return PlanarLidar(begin, whole, near, far), _inscribed_radius(world, name, base)


def _lidar(stage: Stage, robot: RobotInstance, path: str | None) -> Prim:
    """Return the lidar at a path; if the path is None, return the robot's only lidar."""
    if path is not None:
        prim = stage.find(path)
        if prim.kind != "lidar":
            raise UsageError(f"{path} is a {prim.kind}, not a lidar")
        return prim
    root = stage.find(robot.prim_path)
    lidars = [prim for prim in root.descendants() if prim.kind == "lidar"]
    if len(lidars) == 1:
        return lidars[0]
    if not lidars:
        example = "sensors: {lidar: {type: lidar}}"
        raise UsageError(f"{robot.name} has no lidar; add one to its robot file, for example {example}")
    raise UsageError(f"{robot.name} has {len(lidars)} lidars; choose one: {', '.join(prim.path for prim in lidars)}")


def _inscribed_radius(world: Simulation, robot: str, base: Prim) -> float:
    """Return the radius (m) of the largest circle around the base link that is inside the hull of the colliders' boxes."""
    model, data = world.model, world.data
    own = np.array([name.startswith(f"{robot}/") for name in body_names(model)])
    geoms = np.flatnonzero(collides(model) & own[model.geom_bodyid])
    if not len(geoms):
        return 0.0
    signs = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
    corners = model.geom_aabb[geoms, None, :3] + signs * model.geom_aabb[geoms, None, 3:]
    turned = np.einsum("gij,gcj->gci", data.geom_xmat[geoms].reshape(-1, 3, 3), corners)
    points = (turned + data.geom_xpos[geoms, None]).reshape(-1, 3)[:, :2] - world.frame(base).pose()[0][:2]
    angle = np.arange(360) * math.tau / 360
    reach = (points @ np.stack([np.cos(angle), np.sin(angle)])).max(axis=0)
    return max(0.0, float(reach.min()))
