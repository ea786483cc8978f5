"""Captures the visible state of a model. The state can be rendered while the simulation continues.

A MuJoCo scene (MjvScene) contains everything that rendering needs, so only the thread that steps the simulation reads the state.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import NEITHER, PICTURES, RAYS_AND_PICTURES, Bools, Floats, mujoco
from graphengine.devices.rotation import Pose, Quaternion, rotate

SKY = 0.7
"""Distance at which MuJoCo draws the sky, divided by the distance of the far plane. The sky hides objects that are farther
away."""

SEEN = [group in (RAYS_AND_PICTURES, 1, PICTURES) for group in range(6)]
"""Whether images show the geoms of each geom group."""
_ALL_BUT_DECORATION = mujoco.mjtCatBit.mjCAT_STATIC.value | mujoco.mjtCatBit.mjCAT_DYNAMIC.value


def axes_of(turn: Quaternion) -> Floats:
    """Return the axes of a rotated frame as rows (x, y, z) in the frame in which the rotation is given."""
    return np.array([rotate(turn, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))])


@dataclass(frozen=True, slots=True)
class Lens:
    """The projection of a camera with square pixels that looks along its -z axis, with +y up.

    Attributes:
        size: width and height, pixels.
        half_height: tangent of half the vertical field of view; for a parallel projection, half the height of the image, m.
        near: distance of the near plane, m.
        far: distance of the far plane, m.
        parallel: whether the projection is parallel; plans use this projection.
    """

    size: tuple[int, int]
    half_height: float
    near: float
    far: float
    parallel: bool = False

    @classmethod
    def pinhole(cls, size: tuple[int, int], focal: float, near: float, farthest: float) -> Lens:
        """Return the lens of a pinhole camera.

        Args:
            size: width and height of the image, pixels.
            focal: focal length, pixels.
            near: distance of the near plane, m.
            farthest: distance up to which objects are visible, m; the sky is drawn beyond it.
        """
        width, height = size
        corner = math.hypot(1.0, width / 2 / focal, height / 2 / focal)  # length of a ray there for each metre of depth
        return cls(size, height / 2 / focal, near, 1.01 * farthest * corner / SKY)

    @classmethod
    def plan(cls, size: tuple[int, int], half_height: float, near: float, farthest: float) -> Lens:
        """Return the lens of a parallel projection.

        Args:
            size: width and height of the image, pixels.
            half_height: half the height of the visible area, m.
            near: distance of the near plane, m.
            farthest: distance up to which objects are visible, m. The sky is drawn beyond it, at least as far away as the
                diagonal of the visible area is long.
        """
        diagonal = 2 * half_height * math.hypot(1.0, size[0] / size[1])
        return cls(size, half_height, near, 1.01 * max(farthest, diagonal) / SKY, parallel=True)

    def misses(self, pose: Pose, centres: Floats, radii: Floats) -> Bools:
        """Return for each sphere whether it is completely outside the view of a pinhole camera.

        Args:
            pose: pose of the camera.
            centres: centres of the spheres, shape (n, 3), m.
            radii: radii of the spheres, m.
        """
        place, (right, up, back) = pose[0], axes_of(pose[1])
        high, wide = self.half_height, self.half_height * self.size[0] / self.size[1]
        # Outward normals of the planes through the camera that bound what is in sight; the last one has it before the camera.
        normals = np.array([up + high * back, high * back - up, right + wide * back, wide * back - right, back])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        missed: Bools = ((centres - place) @ normals.T > radii[:, None]).any(axis=1)
        return missed

    def aim(self, scene: mujoco.MjvScene, pose: Pose) -> None:
        """Set pose and projection of both (stereo) cameras of a MuJoCo scene to the same values, because MuJoCo averages them."""
        (x, y, z), turn = pose
        at_near = self.half_height if self.parallel else self.half_height * self.near
        for eye in scene.camera:
            eye.pos, eye.forward, eye.up = (x, y, z), rotate(turn, (0.0, 0.0, -1.0)), rotate(turn, (0.0, 1.0, 0.0))
            eye.frustum_near, eye.frustum_far = self.near, self.far
            eye.frustum_bottom, eye.frustum_top = -at_near, at_near
            eye.frustum_center = eye.frustum_width = 0.0  # the width follows from the picture's
            eye.orthographic = self.parallel


@dataclass(frozen=True, slots=True)
class Shot:
    """A captured frame that is not rendered yet."""

    model: mujoco.MjModel
    scene: mujoco.MjvScene
    lens: Lens
    numbers: NDArray[np.int32] | None
    """Segmentation ID of each MuJoCo segment of the scene, 0 for the background; None if no segmentation was requested."""


class FrameCapture:
    """Captures the state of a model.

    Args:
        model: model to draw.
        numbers: segmentation ID of each body.
    """

    def __init__(self, model: mujoco.MjModel, numbers: NDArray[np.int32]) -> None:
        self.model = model
        self._numbers = numbers
        self._idle: deque[mujoco.MjvScene] = deque()
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = SEEN
        self._option.sitegroup[:] = 0
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_USER.value  # leave the scene's as it was aimed
        self._bounded = model.geom_rbound > 0  # a plane is endless
        # A tendon has a part for each object on its path and for each stretch between two; a view may add a sky.
        self._capacity = 1 + model.ngeom + 3 * model.nwrap + model.nskin + model.nflex

    def capture(
        self, data: mujoco.MjData, pose: Pose, lens: Lens, *, segmentation: bool = False, whole: bool = False
    ) -> Shot:
        """Capture the part of a state that a camera sees.

        Args:
            data: state of the model.
            pose: pose of the camera.
            lens: lens of the camera.
            segmentation: whether a segmentation can also be rendered from the shot.
            whole: whether to include bodies outside the view. They may cast shadows into the view; capturing without them is
                faster.
        """
        scene = self._idle.pop() if self._idle else mujoco.MjvScene(self.model, self._capacity)
        lens.aim(scene, pose)
        groups = self.model.geom_group.copy()
        if not whole:
            self.model.geom_group[self._bounded & lens.misses(pose, data.geom_xpos, self.model.geom_rbound)] = NEITHER
        try:
            mujoco.mjv_updateScene(self.model, data, self._option, None, self._camera, _ALL_BUT_DECORATION, scene)
        finally:
            self.model.geom_group[:] = groups
        return Shot(self.model, scene, lens, self._segments(scene) if segmentation else None)

    def give_back(self, shot: Shot) -> None:
        """Accept the MuJoCo scene of a shot that is no longer needed, for reuse; may be called from any thread."""
        if shot.model is self.model:
            self._idle.append(shot.scene)

    def _segments(self, scene: mujoco.MjvScene) -> NDArray[np.int32]:
        numbers = np.zeros(scene.ngeom + 1, np.int32)
        for geom in scene.geoms[: scene.ngeom]:
            if geom.objtype == mujoco.mjtObj.mjOBJ_GEOM.value:
                numbers[geom.segid + 1] = self._numbers[self.model.geom_bodyid[geom.objid]]
        return numbers
