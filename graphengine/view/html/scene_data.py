"""Converts the samples of a run to the JSON values and arrays that the page's script draws."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.visible import Bodies, VisibleShape
from graphengine.view.html.payload import Payload
from graphengine.view.html.trace import SampledLidar, SampledStage, SceneTrace
from graphengine.view.scene.shape_surfaces import (
    alike,
    encoded_texture,
    is_textured,
    scale,
    simplified,
    surface,
    textured_corners,
)

MAX_TRIANGLES = 20_000
"""Maximum number of triangles of a mesh; a larger mesh is simplified and drawn without its texture."""


class SceneData:
    """Puts the scenes of a run into a payload; equal surfaces and textures are stored once.

    Attributes:
        surfaces: vertices, vertex indices and texture coordinates of each surface.
        textures: JPEG or PNG file of each texture.
    """

    def __init__(self, payload: Payload) -> None:
        self._payload = payload
        self._known: dict[bytes, int] = {}
        self.surfaces: list[Mapping[str, Any]] = []
        self.textures: list[Mapping[str, Any]] = []

    def stage(self, stage: SampledStage, trace: SceneTrace) -> Mapping[str, Any]:
        """Return one part of the run: shapes, lidars, first poses of all bodies, and poses of moving bodies in all samples."""
        poses = np.stack(stage.poses)
        moving = np.flatnonzero((poses != poses[0]).any(axis=(0, 2)))
        put = self._payload.put
        return {
            "times": put(np.array(stage.ticks) * trace.period),
            "rest": put(poses[0]),
            "moving": put(moving.astype(np.uint32)),
            "poses": put(poses[:, moving].transpose(1, 2, 0), steps=True),
            "batches": self._batches(stage.bodies),
            "robots": list(stage.robots.items()),
            "lidars": [self._lidar(lidar, trace) for lidar in stage.lidars if lidar.ticks],
        }

    def _batches(self, bodies: Bodies) -> Sequence[Mapping[str, Any]]:
        batches = []
        for group in alike(bodies.shapes, bodies):
            by_opacity: defaultdict[float, list[VisibleShape]] = defaultdict(list)
            for shape in group:
                by_opacity[shape.colour[3]].append(shape)
            batches += [self._batch(shapes, bodies) for opacity, shapes in by_opacity.items() if opacity > 0]
        return batches

    def _batch(self, shapes: Sequence[VisibleShape], bodies: Bodies) -> Mapping[str, Any]:
        """Return shapes with the same surface, texture and opacity."""
        put, first = self._payload.put, shapes[0]
        textured = is_textured(first, bodies) and len(surface(first, bodies)[1]) <= MAX_TRIANGLES
        colours = np.array([shape.colour for shape in shapes])
        return {
            "surface": self._textured(first, bodies) if textured else self._plain(first, bodies),
            "texture": self._texture(encoded_texture(bodies.textures[first.texture])) if textured else None,
            "double": first.kind in ("plane", "mesh"),
            "opacity": first.colour[3],
            "rows": put(np.array([shape.body for shape in shapes], np.uint32)),
            "poses": put(np.array([[*shape.pose[0], *shape.pose[1]] for shape in shapes], np.float32)),
            "scales": put(np.array([(1, 1, 1) if textured else scale(shape) for shape in shapes], np.float32)),
            "colours": put((colours[:, :3] * 255).clip(0, 255).round().astype(np.uint8)),
        }

    def _plain(self, shape: VisibleShape, bodies: Bodies) -> int:
        vertices, faces = simplified(*surface(shape, bodies), MAX_TRIANGLES)
        return self._surface(vertices=vertices, faces=faces.astype(np.uint32))

    def _textured(self, shape: VisibleShape, bodies: Bodies) -> int:
        corners, coordinates = textured_corners(shape, bodies)
        return self._surface(vertices=corners, coordinates=coordinates.astype(np.float32))

    def _surface(self, **arrays: NDArray[Any]) -> int:
        return self._once(b"".join(array.tobytes() for array in arrays.values()), arrays, self.surfaces)

    def _texture(self, file: bytes) -> int:
        return self._once(file, {"file": np.frombuffer(file, np.uint8)}, self.textures)

    def _once(self, content: bytes, arrays: Mapping[str, NDArray[Any]], stored: list[Mapping[str, Any]]) -> int:
        """Return the index in `stored` of an entry with this content, which is added if it is new."""
        key = hashlib.sha256(content).digest()
        if key not in self._known:
            self._known[key] = len(stored)
            stored.append({name: self._payload.put(array) for name, array in arrays.items()})
        return self._known[key]

    def _lidar(self, lidar: SampledLidar, trace: SceneTrace) -> Mapping[str, Any]:
        put = self._payload.put
        return {
            "beams": put(lidar.lidar.directions[lidar.beams].astype(np.float32)),
            "times": put(np.array(lidar.ticks) * trace.period),
            "poses": put(np.stack(lidar.poses)),
            "ranges": put(np.stack(lidar.ranges)),
        }
