"""Ray casting with two trees of a model's geoms: one for static and one for moving geoms.

The tree of moving geoms is rebuilt once for all sensors if a geom has moved since the last cast. This takes 0.3 us per geom.
"""

from __future__ import annotations

import functools
import logging

import numba
import numpy as np

from graphengine.descriptions.engine import Floats, Indices, mujoco
from graphengine.format.process_limits import has_address_space
from graphengine.physics.kernels.compiled import announced, kept_in
from graphengine.physics.kernels.optional_kernels import ADDRESS_SPACE
from graphengine.physics.ray_casting.casters import Integers, visible_geoms
from graphengine.physics.ray_casting.fast.kernel import cast
from graphengine.physics.ray_casting.fast.mesh_tree import new_stack
from graphengine.physics.ray_casting.fast.table import GEOM, MESH, PLANE, enclose, follow
from graphengine.physics.ray_casting.fast.tree import NODE, Tree, build
from graphengine.physics.ray_casting.fast.triangles import count_triangles, triangle_trees
from graphengine.physics.ray_casting.own_colliders import OwnColliders

ENDLESS = 1e9
"""Half the side length of the bounding box of an infinite plane, m."""

MAX_TRIANGLES = 1_000_000
"""Greatest number of triangles in a model; this many triangles take 0.2 GB of memory."""

_log = logging.getLogger(__name__)


@functools.cache
def trouble() -> str:
    """Return the reason why fast rays cannot be used in this process; empty if they can. The first call compiles all kernels."""
    if numba.config.DISABLE_JIT:
        return "the environment variable NUMBA_DISABLE_JIT keeps numba from compiling them"
    if not has_address_space(ADDRESS_SPACE):  # LLVM aborts the process where it finds no memory
        return f"numba needs {ADDRESS_SPACE // 10**6} MB of address space, and the process cannot get that much (see `ulimit -v`)"
    try:
        nothing = mujoco.MjModel.from_xml_string("<mujoco/>")
        with announced("the ray casting of lidars"):
            data = mujoco.MjData(nothing)
            rays = FastRays(nothing, data)
            rays.caster(np.zeros((1, 3)), 1.0, OwnColliders(nothing, data)).cast(np.zeros(3), np.eye(3))
    except Exception as error:  # of numba, or of reading what it kept, which a crash may have left incomplete
        found = f"{type(error).__name__}: {error}; if numba's cache is damaged, delete its files in {kept_in(cast)}"
        _log.warning("numba is installed but fails, so lidars use MuJoCo's slower rays: %s", found)
        return found
    return ""


def why_not(model: mujoco.MjModel) -> str:
    """Return a description of the geoms in a model that fast rays cannot hit; empty if they can hit all geoms."""
    visible = visible_geoms(model)
    for geom in visible[model.geom_type[visible] > MESH]:
        return f"geoms of type {mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix('mjGEOM_').lower()}"
    if count_triangles(model, visible) > MAX_TRIANGLES:
        return f"more than {MAX_TRIANGLES} triangles of meshes and height fields"
    return ""


class FastRays:
    """Ray casting by compiled kernels; implements `casters.Rays`."""

    name = "fast"

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        visible = visible_geoms(model).astype(np.int64)
        moves = model.body_weldid[model.geom_bodyid[visible]] != 0
        self.table = np.zeros(model.ngeom, GEOM)
        self.table["kind"], self.table["size"] = model.geom_type, model.geom_size
        self.table["centre"], self.table["half"] = model.geom_aabb[:, :3], model.geom_aabb[:, 3:]
        planes = self.table["kind"] == PLANE
        sides = model.geom_size[planes] * (1, 1, 0)
        self.table["centre"][planes] = 0.0
        self.table["half"][planes] = np.where(sides > 0, sides, (ENDLESS, ENDLESS, 0.0))
        self.triangles, self.corners, self.table["mesh"] = triangle_trees(model, visible)
        self._positions, self._rotations = data.geom_xpos, data.geom_xmat
        follow(self.table, visible, self._positions, self._rotations)
        self.still = self._tree(visible[~moves])
        self._moving = visible[moves]
        self.moving = self._tree(self._moving)

    def _tree(self, geoms: Indices) -> Tree:
        low, high = np.empty((len(geoms), 3)), np.empty((len(geoms), 3))
        enclose(self.table, geoms, low, high)
        tree = np.zeros(max(2 * len(geoms) - 1, 0), NODE)
        build(tree, low, high, geoms)
        return tree

    def refresh(self) -> None:
        """Update the poses of all moving geoms and, if one has moved, their tree."""
        if follow(self.table, self._moving, self._positions, self._rotations):
            self.moving = self._tree(self._moving)

    def caster(self, directions: Floats, far: float, own: OwnColliders) -> FastCaster:
        """Return a caster for the rays of a sensor; see `Rays.caster`."""
        return FastCaster(self, directions, far, own)


class FastCaster:
    """Casts the rays of one sensor by compiled kernels; implements `casters.Caster`."""

    def __init__(self, rays: FastRays, directions: Floats, far: float, own: OwnColliders) -> None:
        self._rays = rays
        self._directions = directions.copy()  # a kernel is compiled anew for an array that may not be written
        self._far = float(far)
        self._own = own
        self._stack = new_stack()
        self._distances, self._geoms = np.empty(len(directions)), np.empty(len(directions), np.int64)

    def cast(self, origin: Floats, rotation: Floats) -> tuple[Floats, Integers]:
        """Return distance (m) and geom id of the first hit of each ray; see `Caster.cast`."""
        rays = self._rays
        rays.refresh()
        self._own.start_at(origin)
        sensor = self._directions, origin, rotation, self._far, self._own.near, self._own.roles
        world = rays.table, rays.still, rays.moving, rays.triangles, rays.corners
        cast(self._distances, self._geoms, *sensor, *world, self._stack)
        return self._distances, self._geoms
