"""Renders views for users, with shadows and antialiasing: from above, in perspective, or through a camera of the world."""

from __future__ import annotations

import math
from collections.abc import Collection
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from graphengine.devices.rotation import Pose, Quaternion, Vector3, pose_of, rotate
from graphengine.devices.stage import Prim
from graphengine.physics.engine import Bools, Floats, mujoco
from graphengine.physics.pictures import opengl
from graphengine.physics.pictures.frame_capture import SEEN, Lens, Shot
from graphengine.physics.pictures.rendering import Image, Renderer

if TYPE_CHECKING:
    from graphengine.physics.simulation import Simulation

Size = tuple[int, int]

NAMES = ("top", "perspective")
LARGEST = 100.0
"""Largest side of a world that the view from above shows completely, m; of a larger world, it shows the area of the robots."""
AROUND = 3.0
"""Margin around the robots in the view of a world larger than `LARGEST`, m."""
FARTHEST = 100.0
"""Distance up to which each view can show an infinite floor, m; for large worlds it is greater."""
MARGIN = 1.05
SHADOWED = 20.0
"""Radius around the robot in which the perspective view has shadows, m."""
FIELD_OF_VIEW = 50.0
"""Vertical field of view of the perspective view, degrees."""
DISTANCE = 4.5
"""Distance of the perspective view's camera from the robot's centre, as a multiple of the robot's radius."""
LIFT = 0.5
"""Height of the point at which the perspective view's camera looks, above the robot's centre, in multiples of its radius."""
DIRECTIONS = [
    (azimuth, elevation) for elevation in (18.0, 40.0, 65.0) for azimuth in (35.0, -35.0, 145.0, -145.0, 90.0, -90.0)
]
"""Possible directions from the robot to the camera, best first: azimuth from the robot's x axis and elevation, degrees."""

_SEEN = np.array(SEEN, np.uint8)


@dataclass(frozen=True, slots=True)
class View:
    """The camera of a view, and the area of its shadows.

    Attributes:
        pose: pose of a camera that looks along its -z axis, with +y up, in the world frame.
        lens: lens of the camera.
        centre: centre of the visible part in the world frame, m.
        reach: radius around the centre in which shadows are cast, m.
    """

    pose: Pose
    lens: Lens
    centre: Vector3
    reach: float


def names(simulation: Simulation) -> list[str]:
    """Return the names of the available views; a camera of the world overrides a built-in view of the same name."""
    cameras = (simulation.model.camera(index).name for index in range(simulation.model.ncam))
    return list(dict.fromkeys([*NAMES, *filter(None, cameras)]))


def find_view(simulation: Simulation, name: str, size: Size) -> View:
    """Return the view with a given name, which must be one of `names`, for the current state of the simulation."""
    camera = mujoco.mj_name2id(simulation.model, mujoco.mjtObj.mjOBJ_CAMERA, name)
    if camera >= 0:
        return _through(simulation, camera, size)
    return _from_above(simulation, size) if name == "top" else _at_an_angle(simulation, size)


def draw(simulation: Simulation, view: View, *, segmentation: bool = False) -> Image:
    """Render a view and return its image.

    Raises:
        RenderError: OpenGL does not work here.
    """
    shot = simulation.studio.capture(view.pose, view.lens, segmentation=segmentation, whole=True)
    _light(shot, view)
    size, far = view.lens.size, view.lens.far
    with opengl.context(), closing(Renderer(shot.model, size, far, samples=4, shadows=view.reach)) as renderer:
        return renderer.draw(shot)


def _light(shot: Shot, view: View) -> None:
    """Move directional lights so that they cast shadows around the centre of the view, and let floors cast no shadows.

    A directional light casts shadows only around the line through its position; its position has no other effect. Floors would
    show speckles of their own shadows towards the edges of MuJoCo's shadow map.
    """
    for light in shot.scene.lights[: shot.scene.nlight]:
        if light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value and light.id >= 0:
            light.pos = np.array(view.centre) - view.lens.far / 2 * light.dir
    for geom in shot.scene.geoms[: shot.scene.ngeom]:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE.value:
            geom.castshadow = False


def _through(simulation: Simulation, camera: int, size: Size) -> View:
    model, data = simulation.model, simulation.data
    low, high = _bounds(simulation)
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, data.cam_xmat[camera])
    position = data.cam_xpos[camera]
    far = max(FARTHEST, float(np.linalg.norm(high - low) + np.linalg.norm((low + high) / 2 - position)))
    if model.cam_projection[camera] == mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC:
        lens = Lens.plan(size, float(model.cam_fovy[camera]) / 2, 0.01, far)
    else:
        focal = size[1] / 2 / math.tan(math.radians(model.cam_fovy[camera]) / 2)
        lens = Lens.pinhole(size, focal, 0.05, far)
    return View(pose_of(position, turn), lens, tuple(((low + high) / 2).tolist()), float(np.linalg.norm(high - low)))


def _from_above(simulation: Simulation, size: Size) -> View:
    """Return a view from above with the x axis up, or to the right if the scene then fills more of the image."""
    low, high = _bounds(simulation)
    robots = [_place(simulation, prim) for prim in simulation.stage.prims("robot")]
    if robots:
        lowest = np.array([centre - radius for centre, radius in robots]).min(axis=0) - AROUND
        highest = np.array([centre + radius for centre, radius in robots]).max(axis=0) + AROUND
        whole = max(high - low) <= LARGEST
        low, high = (np.minimum(low, lowest), np.maximum(high, highest)) if whole else (lowest, highest)
    (x, y, z), (along_x, along_y, height) = (low + high) / 2, high - low
    turned = (along_x > along_y) == (size[0] > size[1])
    across, up = (along_x, along_y) if turned else (along_y, along_x)
    half = MARGIN * max(up, across * size[1] / size[0]) / 2
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0) if turned else (0.0, 0.0, -math.sqrt(0.5), math.sqrt(0.5))
    lens = Lens.plan(size, half, 0.1, height + 1.0)
    return View(((x, y, high[2] + 1.0), turn), lens, (x, y, z), 2 * half * max(1.0, size[0] / size[1]))


def _at_an_angle(simulation: Simulation, size: Size) -> View:
    """Return a perspective view of the first robot from a direction in which nothing hides it.

    In a world without robots, the view shows everything.
    """
    low, high = _bounds(simulation)
    robot = next(simulation.stage.prims("robot"), None)
    if robot is None:
        centre, radius, heading = (low + high) / 2, float(np.linalg.norm(high - low)) / 2, 0.0
    else:
        centre, radius = _place(simulation, robot)
        forward = rotate(simulation.body(robot).pose()[1], (1.0, 0.0, 0.0))
        heading = math.atan2(forward[1], forward[0])
    focal = size[1] / 2 / math.tan(math.radians(FIELD_OF_VIEW) / 2)
    far = max(FARTHEST, DISTANCE * radius + float(np.linalg.norm(high - low)))
    lens = Lens.pinhole(size, focal, 0.05, far)
    target = centre + np.array([0.0, 0.0, LIFT * radius])
    eyes = [centre + DISTANCE * radius * _direction(heading + math.radians(a), math.radians(e)) for a, e in DIRECTIONS]
    roots = simulation.entities.roots(robot) if robot is not None else []
    eye = next((eye for eye in eyes if robot is None or _sees(simulation, eye, centre, roots)), eyes[-1])
    return View(_looking(eye, target), lens, tuple(centre.tolist()), SHADOWED)


def _bounds(simulation: Simulation) -> tuple[Floats, Floats]:
    """Return the lowest and highest corner of all visible geoms except planes, which may be infinite."""
    return _box(simulation, simulation.model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE, np.zeros(3))


def _place(simulation: Simulation, robot: Prim) -> tuple[Floats, float]:
    """Return the centre (m, world frame) and radius (m) of a robot's visible geoms."""
    model = simulation.model
    own = np.isin(model.body_rootid[model.geom_bodyid], simulation.entities.roots(robot))
    low, high = _box(simulation, own, np.array(simulation.body(robot).pose()[0]))
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2


def _box(simulation: Simulation, chosen: Bools, otherwise: Floats) -> tuple[Floats, Floats]:
    """Return the lowest and highest corner of the visible geoms among those in `chosen`.

    If none is visible, return the corners of a cube of 1 m around the point `otherwise`.
    """
    model, data = simulation.model, simulation.data
    geoms = np.flatnonzero(chosen & (_SEEN[model.geom_group] > 0))
    if not len(geoms):
        return otherwise - 0.5, otherwise + 0.5
    rotations = data.geom_xmat[geoms].reshape(-1, 3, 3)
    middles = data.geom_xpos[geoms] + np.einsum("gij,gj->gi", rotations, model.geom_aabb[geoms, :3])
    halves = np.einsum("gij,gj->gi", np.abs(rotations), model.geom_aabb[geoms, 3:])
    return (middles - halves).min(axis=0), (middles + halves).max(axis=0)


def _direction(azimuth: float, elevation: float) -> Floats:
    level = math.cos(elevation)
    return np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])


def _sees(simulation: Simulation, eye: Floats, target: Floats, roots: Collection[int]) -> bool:
    """Return whether a ray from `eye` to `target` first hits one of the bodies `roots` or a body below them."""
    model, geom = simulation.model, np.array([-1], np.int32)
    mujoco.mj_ray(model, simulation.data, eye, target - eye, _SEEN, True, -1, geom)
    met = int(geom[0])
    return met >= 0 and int(model.body_rootid[model.geom_bodyid[met]]) in roots


def _looking(eye: Floats, target: Floats) -> Pose:
    """Return the pose of an upright camera that is at the point `eye` and looks at the point `target`."""
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, np.stack([right, np.cross(back, right), back], axis=1).reshape(-1))
    return pose_of(eye, turn)
