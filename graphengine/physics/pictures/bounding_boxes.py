"""Computes the oriented 3D bounding boxes that an ideal detector would report for the bodies of a model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.descriptions.geoms import extents
from graphengine.devices.camera import BOX_3D
from graphengine.devices.rotation import Pose, multiply
from graphengine.physics.pictures.frame_capture import SEEN, axes_of

_OPTICAL = (1.0, 0.0, 0.0, 0.0)
"""Quaternion (x, y, z, w) from a camera frame (-z forward, y up) to an optical frame (z forward, y down): half a turn about x."""


class BoundingBoxes:
    """The bounding boxes of all bodies that have their own prim and visible shapes, without infinite planes.

    Args:
        model: model with the bodies.
        numbers: segmentation ID of each body; a body without a prim has the ID of its parent body.
    """

    def __init__(self, model: mujoco.MjModel, numbers: NDArray[np.int32]) -> None:
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        seen, found = np.array(SEEN)[model.geom_group], dict[int, Floats]()
        for body in np.flatnonzero(numbers != numbers[model.body_parentid]).tolist():
            geoms = np.flatnonzero(seen & (model.geom_bodyid == body)).tolist()
            reach = extents(model, data, geoms, data.xpos[body], data.xmat[body].reshape(3, 3))
            if reach is not None:
                found[body] = np.array(reach)
        self._bodies = np.array(list(found), np.intp)
        self._boxes = np.zeros(len(found), BOX_3D)
        self._boxes["semanticId"] = numbers[self._bodies]
        self._boxes["low"], self._boxes["high"] = np.array(list(found.values())).reshape(-1, 2, 3).transpose(1, 0, 2)
        self._boxes["transform"][:, 3, 3] = 1.0

    def seen_from(self, data: mujoco.MjData, pose: Pose) -> NDArray[np.void]:
        """Return the boxes of all bodies in the optical frame of a camera, given the camera's pose in the world."""
        place, camera = pose[0], axes_of(multiply(pose[1], _OPTICAL)).T
        found = self._boxes.copy()
        axes = data.xmat[self._bodies].reshape(-1, 3, 3).transpose(0, 2, 1)
        found["transform"][:, :3, :3] = axes @ camera
        found["transform"][:, 3, :3] = (data.xpos[self._bodies] - place) @ camera
        return found
