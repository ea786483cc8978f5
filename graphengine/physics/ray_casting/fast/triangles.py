"""The triangles of meshes and height fields, and a tree of bounding boxes for each mesh and height field."""

from __future__ import annotations

import numpy as np

from graphengine.descriptions.engine import Floats, Indices, mujoco
from graphengine.descriptions.geoms import triangles_of
from graphengine.physics.ray_casting.fast.mesh_tree import MESH_NODE, build_mesh_tree
from graphengine.physics.ray_casting.fast.table import HFIELD, MARGIN, MESH, Records


def count_triangles(model: mujoco.MjModel, geoms: Indices) -> int:
    """Return the number of triangles of the meshes and height fields of some geoms.

    A mesh that several geoms share counts once. The few triangles below a height field and at its sides do not count.
    """
    meshes, fields = (set(model.geom_dataid[geoms[model.geom_type[geoms] == kind]].tolist()) for kind in (MESH, HFIELD))
    cells = sum(int(model.hfield_nrow[field]) * int(model.hfield_ncol[field]) for field in fields)
    return sum(int(model.mesh_facenum[mesh]) for mesh in meshes) + 2 * cells


def triangle_trees(model: mujoco.MjModel, geoms: Indices) -> tuple[Records, Floats, Indices]:
    """Build a tree for each mesh and height field of some geoms.

    Returns:
        The trees, one after the other in one array; the corners of all triangles (see `kernel.cast`); and for each geom of
        the model the index of its tree's root.
    """
    trees: list[Records] = [np.empty(0, MESH_NODE)]
    corners: list[Floats] = [np.empty((0, 9))]
    roots = np.zeros(model.ngeom, np.int64)
    known: dict[tuple[int, int], int] = {}
    for geom in geoms.tolist():
        shape = int(model.geom_type[geom]), int(model.geom_dataid[geom])
        if shape not in known:
            own = triangles_of(model, geom)
            if own is None:
                continue
            known[shape] = sum(map(len, trees))
            tree, order = _tree(own, known[shape], sum(map(len, corners)))
            own = own[order]
            own[:, 1:] -= own[:, :1]
            trees.append(tree)
            corners.append(own.reshape(-1, 9))
        roots[geom] = known[shape]
    return np.concatenate(trees), np.concatenate(corners), roots


def _tree(triangles: Floats, root: int, row: int) -> tuple[Records, Indices]:
    """Return the tree of the triangles of one mesh, and the triangles in the order of its leaves.

    Args:
        triangles: corners, shape (n, 3, 3).
        root: index of the tree's root among the nodes of all trees.
        row: index of the first triangle among the triangles of all meshes.
    """
    tree, order = np.zeros(2 * len(triangles) - 1, MESH_NODE), np.arange(len(triangles))
    low, high = triangles.min(axis=1) - MARGIN, triangles.max(axis=1) + MARGIN
    tree = tree[: build_mesh_tree(tree, low, high, order)]
    tree["first"] += np.where(tree["count"] > 0, row, root).astype(np.int32)
    return tree, order
