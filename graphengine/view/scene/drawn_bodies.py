"""Draws the bodies of a world: sends their surfaces to browsers once, and then only poses of bodies that move."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.devices.visible import Bodies, VisibleShape
from graphengine.view.scene.carried import Carried
from graphengine.view.scene.layer import Poses
from graphengine.view.scene.shape_surfaces import alike, is_textured, scale, surface, textured_surface

if TYPE_CHECKING:
    import viser


@dataclass(frozen=True, slots=True)
class Batch:
    """Shapes with the same surface; `handle` is a viser handle with one instance for each shape."""

    handle: Any
    shapes: Carried

    def place(self, poses: Poses) -> None:
        """Move the shapes with their bodies; `poses` are the poses of all bodies."""
        self.handle.batched_positions, self.handle.batched_wxyzs = self.shapes.at(poses)


class DrawnBodies:
    """A group of bodies that viewers show or hide as a whole.

    Args:
        scene: viser scene to draw in.
        path: path of the parent node in the viser scene.

    Attributes:
        batches: batches of the drawn shapes.
    """

    def __init__(self, scene: viser.SceneApi, path: str) -> None:
        self._scene = scene
        self._path = path
        self._last: Poses | None = None
        self.batches: Sequence[Batch] = ()

    def draw(self, bodies: Bodies, chosen: Collection[int]) -> None:
        """Draw the bodies in the rows `chosen`; called after a reset of the viser scene."""
        self._scene.add_frame(self._path, show_axes=False)
        groups = alike((shape for shape in bodies.shapes if shape.body in chosen), bodies)
        self.batches = [self._draw(f"{self._path}/{number}", shapes, bodies) for number, shapes in enumerate(groups)]
        self._last = None

    def update(self, poses: Poses) -> None:
        """Update the poses of bodies that have moved."""
        last, self._last = self._last, poses
        changed = (poses != last).any(axis=1) if last is not None and last.shape == poses.shape else None
        for batch in self.batches:
            if changed is None or changed[batch.shapes.rows].any():
                batch.place(poses)

    def _draw(self, name: str, shapes: Sequence[VisibleShape], bodies: Bodies) -> Batch:
        carried = Carried.of([(shape.body, shape.pose) for shape in shapes])
        if is_textured(shapes[0], bodies):
            glb = textured_surface(shapes[0], bodies)
            handle: Any = self._scene.add_batched_glb(name, glb, carried.rotations, carried.positions, lod="off")
            return Batch(handle, carried)
        vertices, faces = surface(shapes[0], bodies)
        colours = np.array([shape.colour for shape in shapes])
        handle = self._scene.add_batched_meshes_simple(
            name,
            vertices,
            faces,
            batched_wxyzs=carried.rotations,
            batched_positions=carried.positions,
            batched_scales=np.array([scale(shape) for shape in shapes], np.float32),
            batched_colors=(colours[:, :3] * 255).round().astype(np.uint8),
            batched_opacities=colours[:, 3].astype(np.float32) if (colours[:, 3] < 1.0).any() else None,
            flat_shading=True,
            side="double" if shapes[0].kind in ("plane", "mesh") else "front",
            lod="off",
        )
        return Batch(handle, carried)
