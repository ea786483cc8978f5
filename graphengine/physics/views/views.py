"""Renders views for users, with shadows and antialiasing: from above, of the robots, or through a camera of the world."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.rotation import Pose, Quaternion, Vector3, pose_of
from graphengine.physics.pictures.frame_capture import SKY, Lens, Shot, axes_of
from graphengine.physics.pictures.rendering import SHADOW_MAP, Image, RendererCache
from graphengine.physics.views import framing
from graphengine.physics.views.tracking import RobotCamera

if TYPE_CHECKING:
    from graphengine.physics.simulation import Simulation

Size = tuple[int, int]

NAMES = ("top", "perspective", "follow")
LARGEST = 100.0
"""Largest side of a world that the view from above shows completely, m; of a larger world, it shows the area of the robots."""
AROUND = 3.0
"""Margin around the robots in the view of a world larger than `LARGEST`, m."""
FARTHEST = 100.0
"""Distance up to which each view can show an infinite floor, m; for large worlds it is greater."""
MARGIN = 1.05
SHADOWED = 15.0
"""Radius around the robots in which views of them have shadows, m; greater if the camera is farther away."""
FIELD_OF_VIEW = 50.0
"""Vertical field of view of views of the robots, degrees."""
SKY_COLOUR = (0.58, 0.63, 0.69, 1.0)
"""Colour of the sky of a world without one; lights make it brighter."""
SUN = (-0.4, 0.25, -0.88)
"""Direction of the light of a world without lights."""


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


class ViewCamera:
    """The camera of a view for successive images; views of the robots move smoothly with them.

    Args:
        simulation: world to show.
        name: name of the view, one of `names`.
        size: width and height of the images, pixels.
    """

    def __init__(self, simulation: Simulation, name: str, size: Size) -> None:
        self._simulation, self._name, self._size = simulation, name, size
        half = math.tan(math.radians(FIELD_OF_VIEW) / 2)
        self._robots = RobotCamera(simulation, (half * size[0] / size[1], half), follows=name == "follow")

    def view(self, time: float = 0.0) -> View:
        """Return the view of the current state.

        Args:
            time: time of the image, s; only differences between calls count, and only for views of the robots.
        """
        simulation = self._simulation
        camera = mujoco.mj_name2id(simulation.model, mujoco.mjtObj.mjOBJ_CAMERA, self._name)
        if camera >= 0:
            return _through(simulation, camera, self._size)
        return _from_above(simulation, self._size) if self._name == "top" else self._of_robots(time)

    def _of_robots(self, time: float) -> View:
        pose, centre, distance = self._robots.aim(time)
        points = framing.world_points(self._simulation)
        focal = self._size[1] / 2 / math.tan(math.radians(FIELD_OF_VIEW) / 2)
        far = max(FARTHEST, 2 * distance + float(np.linalg.norm(np.ptp(points, axis=0))))
        x, y, z = centre.tolist()
        return View(pose, Lens.pinhole(self._size, focal, 0.05, far), (x, y, z), max(SHADOWED, 2 * distance))


def find_view(simulation: Simulation, name: str, size: Size) -> View:
    """Return the view with a given name for the current state of the simulation; the name must be one of `names`."""
    return ViewCamera(simulation, name, size).view()


class ViewRenderer:
    """Renders one image after another, in the thread in which it was created; `close` releases OpenGL.

    Args:
        simulation: world to show.
        shadow_map: side of the shadow map, texels; a map with half the side takes half the time.
    """

    def __init__(self, simulation: Simulation, shadow_map: int = SHADOW_MAP) -> None:
        self._simulation, self._shadow_map = simulation, shadow_map
        self._renderers = RendererCache()

    def draw(self, view: View, *, segmentation: bool = False) -> Image:
        """Render a view of the current state.

        Raises:
            RenderError: OpenGL does not work here.
        """
        shot = self._simulation.studio.capture(view.pose, view.lens, segmentation=segmentation, whole=True)
        _light(shot, view)
        if not segmentation:  # it would be drawn as a body
            _add_sky(shot, view)
        settings = {"samples": 4, "shadows": view.reach, "shadow_map": self._shadow_map}
        return self._renderers.draw(shot, view.lens.size, view.lens.far, **settings)

    def close(self) -> None:
        """Release OpenGL; a later image creates it again."""
        self._renderers.close()


def draw(simulation: Simulation, view: View, *, segmentation: bool = False) -> Image:
    """Render a view and return its image.

    Raises:
        RenderError: OpenGL does not work here.
    """
    with closing(ViewRenderer(simulation)) as renderer:
        return renderer.draw(view, segmentation=segmentation)


def _light(shot: Shot, view: View) -> None:
    """Move directional lights so that they cast shadows around the centre of the view, and let floors cast no shadows.

    A world without lights gets one.

    A directional light casts shadows only around the line through its position; its position has no other effect. Floors would
    show speckles of their own shadows towards the edges of MuJoCo's shadow map.
    """
    scene = shot.scene
    if shot.model.nlight == 0:
        sun, scene.nlight = scene.lights[scene.nlight], scene.nlight + 1
        sun.type, sun.id, sun.headlight, sun.castshadow = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value, 0, False, True
        sun.dir, sun.attenuation = np.array(SUN) / np.linalg.norm(SUN), (1.0, 0.0, 0.0)
        sun.ambient, sun.diffuse, sun.specular = (0.25,) * 3, (0.6,) * 3, (0.1,) * 3
    for light in scene.lights[: scene.nlight]:
        if light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value and light.id >= 0:
            light.pos = np.array(view.centre) - view.lens.far / 2 * light.dir
    for geom in scene.geoms[: scene.ngeom]:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE.value:
            geom.castshadow = False


def _add_sky(shot: Shot, view: View) -> None:
    """Put a wall of the sky's colour behind all bodies if the model has no sky; MuJoCo would draw a black background."""
    if mujoco.mjtTexture.mjTEXTURE_SKYBOX in shot.model.tex_type:
        return
    (place, turn), lens, scene = view.pose, view.lens, shot.scene
    wall, distance = scene.geoms[scene.ngeom], SKY * lens.far
    scene.ngeom += 1
    half = 1.1 * lens.half_height * max(1.0, lens.size[0] / lens.size[1]) * (1.0 if lens.parallel else distance)
    axes = axes_of(turn)
    shape, size = mujoco.mjtGeom.mjGEOM_PLANE.value, np.array([half, half, 1.0])
    mujoco.mjv_initGeom(
        wall, shape, size, place - distance * axes[2], axes.T.reshape(-1), np.array(SKY_COLOUR, np.float32)
    )
    wall.emission, wall.specular, wall.castshadow = 0.3, 0.0, False


def _through(simulation: Simulation, camera: int, size: Size) -> View:
    model, data = simulation.model, simulation.data
    low, high = _box(framing.world_points(simulation))
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
    low, high = _box(framing.world_points(simulation))
    robots = [framing.robot_points(simulation, prim) for prim in simulation.stage.prims("robot")]
    if robots:
        lowest, highest = _box(np.concatenate(robots))
        lowest, highest = lowest - AROUND, highest + AROUND
        whole = max(high - low) <= LARGEST
        low, high = (np.minimum(low, lowest), np.maximum(high, highest)) if whole else (lowest, highest)
    (x, y, z), (along_x, along_y, height) = (low + high) / 2, high - low
    turned = (along_x > along_y) == (size[0] > size[1])
    across, up = (along_x, along_y) if turned else (along_y, along_x)
    half = MARGIN * max(up, across * size[1] / size[0]) / 2
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0) if turned else (0.0, 0.0, -math.sqrt(0.5), math.sqrt(0.5))
    lens = Lens.plan(size, half, 0.1, height + 1.0)
    return View(((x, y, high[2] + 1.0), turn), lens, (x, y, z), 2 * half * max(1.0, size[0] / size[1]))


def _box(points: Floats) -> tuple[Floats, Floats]:
    return points.min(axis=0), points.max(axis=0)
