"""The layer of contacts: contact points, and arrows for contact forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.view.layer_data import CONTACTS, FrameLayers, SceneLayers
from graphengine.view.scene.layer import Layer, Poses

PER_NEWTON = 0.01
"""Length of an arrow per force, m/N."""
LONGEST = 2.0
"""Maximum length of an arrow, m."""
COLOUR = (214, 51, 132)


class ContactArrows(Layer):
    """A point and an arrow for each contact. The arrow shows the force on the movable body, 1 m for 100 N."""

    name = needs = CONTACTS
    title = "Contacts"
    hint = "Contact points between bodies, and their forces: 1 m for 100 N"

    def _draw(self, layers: SceneLayers) -> None:
        self._movable = [row for entity in layers.entities for row in entity.bodies]
        self._points: Any = self._scene.add_point_cloud(
            f"{self.path}/points", np.zeros((1, 3), np.float32), COLOUR, point_size=0.03, point_shape="circle"
        )
        self._arrows: Any = self._scene.add_arrows(
            f"{self.path}/forces",
            np.zeros((1, 2, 3), np.float32),
            COLOUR,
            shaft_radius=0.008,
            head_radius=0.02,
            head_length=0.05,
        )

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Show the contacts of a frame."""
        if not self.shown:
            return
        contacts = frame.contacts
        self._points.visible = len(contacts.points) > 0
        if len(contacts.points):
            self._points.points = contacts.points
        on_second = np.isin(contacts.bodies[:, 1], self._movable)
        forces = np.where(on_second[:, None], contacts.forces, -contacts.forces)
        sizes = np.linalg.norm(forces, axis=1)
        felt = sizes > 0.0
        lengths = np.minimum(PER_NEWTON * sizes[felt], LONGEST)
        ends = contacts.points[felt] + forces[felt] * (lengths / sizes[felt])[:, None]
        self._arrows.visible = bool(felt.any())
        if felt.any():
            self._arrows.points = np.stack([contacts.points[felt], ends], axis=1).astype(np.float32)
