"""Makes triangle surfaces of shapes, with or without a texture."""

from __future__ import annotations

import io
from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from graphengine.devices.visible import Bodies, Surface, VisibleShape

FLOOR = 200.0
"""Side length of the square that represents an infinite plane, m."""
MANY_TRIANGLES = 200_000
"""Maximum number of triangles; a larger surface is simplified and drawn without its texture."""
LARGEST_TEXTURE = 1024
"""Maximum width and height of a texture, pixels; a larger texture is downsampled."""

Scale = tuple[float, float, float]


def scale(shape: VisibleShape) -> Scale:
    """Return the factors along x, y and z by which the result of `surface` must be scaled to the size of the shape."""
    x, y, z = shape.size
    if shape.kind == "sphere":
        return x, x, x
    if shape.kind == "cylinder":
        return x, x, y
    if shape.kind == "plane":
        return x or FLOOR / 2, y or FLOOR / 2, 1.0
    return (1.0, 1.0, 1.0) if shape.kind in ("capsule", "mesh") else (x, y, z)


def surface(shape: VisibleShape, bodies: Bodies) -> Surface:
    """Return the triangle surface of a shape: a capsule or mesh in its actual size, other kinds as a unit shape."""
    if shape.kind == "mesh":
        vertices, faces = bodies.surfaces[shape.mesh]
        return simplified(vertices, faces, MANY_TRIANGLES)
    if shape.kind == "capsule":
        made = trimesh.creation.capsule(height=2 * shape.size[1], radius=shape.size[0], count=(24, 24))
    elif shape.kind == "cylinder":
        made = trimesh.creation.cylinder(radius=1.0, height=2.0, sections=32)
    elif shape.kind in ("sphere", "ellipsoid"):
        made = trimesh.creation.icosphere(subdivisions=3)
    elif shape.kind == "plane":
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
        return corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    else:
        made = trimesh.creation.box(extents=(2.0, 2.0, 2.0))
    return np.asarray(made.vertices, np.float32), np.asarray(made.faces, np.int32)


def simplified(vertices: NDArray[np.float32], faces: NDArray[np.int32], most: int) -> Surface:
    """Return a surface with at most `most` triangles: if it has more, vertices in the same cell of a grid become one."""
    cells = int(most**0.5)
    low, side = vertices.min(axis=0), np.ptp(vertices, axis=0).max() or 1.0
    kept_vertices, kept = vertices, faces
    while len(kept) > most:
        grid = ((vertices - low) / side * cells).astype(np.int32)
        _, first, cell = np.unique(grid, axis=0, return_index=True, return_inverse=True)
        kept_vertices, kept = vertices[first], cell.reshape(-1)[faces].astype(np.int32)
        kept = kept[(kept != np.roll(kept, 1, axis=1)).all(axis=1)]
        cells = cells * 3 // 4
    return kept_vertices, kept


def alike(shapes: Iterable[VisibleShape], bodies: Bodies) -> Sequence[Sequence[VisibleShape]]:
    """Return the shapes in groups with equal surfaces."""
    groups: defaultdict[tuple[object, ...], list[VisibleShape]] = defaultdict(list)
    for shape in shapes:
        form: tuple[object, ...]
        if is_textured(shape, bodies):
            form = (shape.kind, shape.mesh, shape.size, shape.texture, shape.repeats, shape.colour)
        else:
            # A box, sphere, ellipsoid or cylinder is a scaled unit shape; a capsule is not.
            form = (shape.kind, shape.mesh, shape.size if shape.kind == "capsule" else ())
        groups[form].append(shape)
    return [*groups.values()]


def is_textured(shape: VisibleShape, bodies: Bodies) -> bool:
    """Return whether a shape is drawn with its texture."""
    return bool(shape.texture) and (not shape.mesh or len(bodies.surfaces[shape.mesh][1]) <= MANY_TRIANGLES)


def textured_corners(shape: VisibleShape, bodies: Bodies) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the corners of the triangles of a textured shape, in order.

    Returns:
        Positions in the shape's actual size, m, shape (n, 3), and texture coordinates from the upper left corner, shape (n, 2).
    """
    vertices, faces = surface(shape, bodies)
    corners = (vertices * np.array(scale(shape), np.float32))[faces.ravel()]
    if shape.mesh in bodies.coordinates:
        across, down = bodies.coordinates[shape.mesh].reshape(-1, 2).T
    else:
        left, upper = shape.size[0], shape.size[0 if shape.kind in ("sphere", "cylinder", "capsule") else 1]
        across, down = (corners[:, 0] + left) * shape.repeats[0], (upper - corners[:, 1]) * shape.repeats[1]
    return corners, np.stack([across, down], axis=1)


def textured_surface(shape: VisibleShape, bodies: Bodies) -> bytes:
    """Return the textured surface of a shape in its actual size, as a binary glTF file."""
    corners, coordinates = textured_corners(shape, bodies)
    red, green, blue, opacity = shape.colour
    material = PBRMaterial(  # type: ignore[no-untyped-call]
        baseColorTexture=Image.open(io.BytesIO(encoded_texture(bodies.textures[shape.texture]))),
        baseColorFactor=[*(np.array((red, green, blue)) ** 2.2).tolist(), opacity],  # glTF colours are linear
        metallicFactor=0.0,
        roughnessFactor=1.0,
        doubleSided=shape.kind in ("plane", "mesh"),
        alphaMode="BLEND" if opacity < 1.0 else "OPAQUE",
    )
    coordinates[:, 1] = 1.0 - coordinates[:, 1]  # trimesh has its origin at the lower left
    made = trimesh.Trimesh(
        corners,
        np.arange(len(corners)).reshape(-1, 3),
        visual=TextureVisuals(uv=coordinates, material=material),  # type: ignore[no-untyped-call]
        process=False,
    )
    exported = made.export(file_type="glb")
    assert isinstance(exported, bytes)
    return exported


def encoded_texture(pixels: NDArray[np.uint8]) -> bytes:
    """Return a texture as a PNG or JPEG file, at most `LARGEST_TEXTURE` pixels wide and high."""
    image = Image.fromarray(pixels[..., 0] if pixels.shape[2] == 1 else pixels)
    if image.mode == "L":
        image = image.convert("RGB")
    image.thumbnail((LARGEST_TEXTURE, LARGEST_TEXTURE))
    encoded = io.BytesIO()
    image.save(encoded, "PNG" if image.mode == "RGBA" else "JPEG", quality=90)
    return encoded.getvalue()
