"""What tests of pictures share: whether there is OpenGL, and a small simulation with one camera."""

from __future__ import annotations

import ctypes
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.devices.camera import Picture
from graphengine.devices.rotation import Pose, rotate
from graphengine.devices.stage import Stage
from graphengine.format.errors import RenderError
from graphengine.physics.pictures import opengl
from graphengine.physics.sensors.camera import PinholeCamera
from graphengine.physics.simulation import Simulation

FORWARD = (0.5, -0.5, -0.5, 0.5)  # looks along +x, z up
EYE = (0.0, 0.0, 1.0)
ROOM = """
  <geom type="plane" size="0 0 1"/>
  <body name="crate" pos="3 .6 .5"><geom type="box" size=".5 .4 .5" euler="0 0 20" rgba="1 0 0 1"/></body>
  <body name="ball" pos="2.5 -.8 .6"><geom type="sphere" size=".4" rgba="0 1 0 1"/></body>
  <body name="shelf" pos="8 0 1"><geom type="box" size=".2 5 2"/></body>
"""


def why_not() -> str:
    try:
        with opengl.context():
            return ""
    except RenderError as error:
        return str(error)


def take_opengl_away(patch: pytest.MonkeyPatch) -> None:
    """What a machine without the libraries answers; `opengl._platform.cache_clear()` afterwards."""
    load = ctypes.CDLL

    def refuse(name: str, *arguments: Any, **more: Any) -> ctypes.CDLL:
        if "EGL" in name or "OSMesa" in name:
            raise OSError(f"{name}: cannot open shared object file: No such file or directory")
        return load(name, *arguments, **more)

    patch.setattr(ctypes, "CDLL", refuse)
    opengl._platform.cache_clear()


needs_opengl = pytest.mark.skipif(bool(why_not()), reason=why_not())


def simulation_of(
    parts: str, *, pose: Pose = (EYE, FORWARD), tick_rate: int = 60, seed: int = 0, extent: float = 2.0, **facts: object
) -> Simulation:
    """A world of some bodies, and a camera that looks along x from (0, 0, 1)."""
    stage = Stage()
    stage.add("/World", "scope")
    known = {"size": (64, 48), "fov_deg": (90.0, 75.0), "clip": (0.05, 50.0), "rate": 30.0, "latency": 0.05}
    stage.add("/Camera", "camera", position=pose[0], orientation=pose[1], facts=known | facts)
    world = f'<mujoco><statistic extent="{extent}"/><worldbody>{parts}</worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(world)
    for body in range(1, model.nbody):
        name = model.body(body).name
        stage.add(f"/World/{name}", "body", body=name)
    return Simulation(model, stage, Fraction(tick_rate), 1, seed=seed)


def camera_of(simulation: Simulation, size: tuple[int, int] | None = None) -> PinholeCamera:
    return simulation.device(PinholeCamera, simulation.stage.find("/Camera"), size=size)


def filming(parts: str, **facts: Any) -> tuple[Simulation, PinholeCamera]:
    """A small simulation and its camera."""
    simulation = simulation_of(parts, **facts)
    return simulation, camera_of(simulation)


def segmented(camera: PinholeCamera, path: str) -> tuple[Picture, NDArray[np.bool_]]:
    """A picture of a camera, and where it shows a prim."""
    picture = camera.picture(segmentation=True)
    assert picture.segmentation is not None
    numbers = {path: number for number, path in camera.labels.items()}
    return picture, picture.segmentation == numbers[path]


def directions(camera: PinholeCamera, pose: Pose = (EYE, FORWARD)) -> NDArray[np.float64]:
    """For each pixel the ray through its centre, in the world frame and a metre deep, shape (height, width, 3)."""
    (width, height), (fx, fy, cx, cy) = camera.size, camera.intrinsics
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    axes = np.array([rotate(pose[1], axis) for axis in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))])
    rays: NDArray[np.float64] = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(u.shape)], axis=-1) @ axes
    return rays
