"""What scans cost: `mj_multiRay` in the whole world and in a slice of it, and the rays of the extra `fast`, in one run.

`python tests/bench/rays.py [ROUNDS]` casts in the full warehouse: 2751 beams of one robot, 3D lidars, and a scan of each robot
for 1, 5, 10, 20 and 50 of them. It also casts 16 x 1024 beams against meshes of 10 000, 100 000 and 1 000 000 triangles, beside
Embree if `embreex` is installed, and a scan of a robot that sees itself. It prints medians of this thread's processor time, and
ratios; nothing is asserted.
"""

from __future__ import annotations

import importlib
import importlib.util
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.descriptions.engine import mujoco, sort_geoms
from graphengine.descriptions.geoms import mesh_faces, mesh_vertices
from graphengine.devices.lidar import beam_directions
from graphengine.format.distribution import install_command
from graphengine.physics.ray_casting.casters import Caster
from graphengine.physics.ray_casting.own_colliders import OwnColliders
from graphengine.physics.ray_casting.rays import RaysChoice, select_rays
from graphengine.physics.sensors.lidar import RayLidar
from graphengine.physics.simulation import Simulation
from tests.physics.harness import SHIPPED, load

FAR = 64.0
FLEET = """scene: fleet
world: worlds/full_warehouse.xml
robots:
  dd100: {{use: robots/dd100.yaml, count: {count}, per_row: 13, spacing: [1.2, 1.2], position: [-25.0, -12.6, 0.025]}}
"""


def interleaved(rounds: int, jobs: Mapping[str, Callable[[], float]]) -> dict[str, float]:
    """Median of what some jobs say they took, run in turns so that all meet the same weather; the first round warms up."""
    times: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(rounds + 1):
        for name, job in jobs.items():
            times[name].append(job())
    return {name: statistics.median(found[1:]) for name, found in times.items()}


def poses(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """The tutorial's two places, and others in the warehouse, all at the height of the lidar."""
    generator = np.random.default_rng(1)
    places = [(-3.0, 6.0, 1.57), (-5.0, 10.0, 2.36)]
    places += [tuple(generator.uniform((-25.0, -22.0, -3.0), (5.0, 30.0, 3.0))) for _ in range(count - len(places))]
    found = []
    for x, y, yaw in places:
        turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
        found.append((np.array([x, y, 0.165]), turn))
    return found


POSES = poses(12)


def one_lidar(ways: list[RaysChoice], rounds: int) -> None:
    """Scans of single lidars at many poses."""
    simulation = load(SHIPPED / "dd100_warehouse.yaml").simulation
    model, data = simulation.model, simulation.data
    own = OwnColliders(model, data, int(model.body_rootid[model.body("dd100/chassis_link").id]))
    flat = beam_directions((-2.4, 2.4, 4.8 / 2750), np.zeros(1))
    tilted = flat.copy()
    tilted[0, 2] = 1e-12  # a beam out of the plane: what is cast into is then the whole world
    around = np.pi * 2 / 1024
    for title, directions in (
        ("2751 beams", flat),
        *(
            (f"{n} x 1024", beam_directions((-np.pi, np.pi - around, around), np.linspace(-0.4, 0.4, n)))
            for n in (16, 64)
        ),
    ):
        casters: dict[str, Caster] = {
            rays: select_rays(rays, model, data).caster(directions, FAR, own) for rays in ways
        }
        if directions is flat:
            casters = {"multiRay": select_rays("mujoco", model, data).caster(tilted, FAR, own), **casters}
            casters["slice"] = casters.pop("mujoco")

        found = interleaved(rounds, {name: many_scans(caster) for name, caster in casters.items()})
        worst = max(found.values())
        print(f"{title}, {model.ngeom} geoms:")
        for name, seconds in found.items():
            print(f"  {name:9} {seconds * 1e3:8.3f} ms a scan   {worst / seconds:5.1f} times as fast as the slowest")


def many_scans(caster: Any, poses: list[tuple[np.ndarray, np.ndarray]] = POSES) -> Callable[[], float]:
    """A job that casts at all poses."""

    def job() -> float:
        start = time.thread_time()
        for origin, rotation in poses:
            caster.cast(origin, rotation)
        return (time.thread_time() - start) / len(poses)

    return job


def meshes(rounds: int) -> None:
    """Scans of hilly meshes from above; Embree's rays are in single precision."""
    around = np.pi * 2 / 1024
    directions = np.ascontiguousarray(beam_directions((-np.pi, np.pi - around, around), np.linspace(-0.4, 0.4, 16)))
    places = [(np.array([0.0, 0.0, 1.6]), np.eye(3)), (np.array([6.0, 5.0, 2.0]), np.eye(3))]
    for wanted in (10_000, 100_000, 1_000_000):
        model, data, triangles = hills(wanted)
        fast = select_rays("fast", model, data).caster(directions, FAR, OwnColliders(model, data))
        jobs = {"fast": many_scans(fast, places)}
        if importlib.util.find_spec("embreex") is not None:
            jobs["embreex"] = many_scans(Embree(triangles, directions), places)
        found = interleaved(rounds, jobs)
        ratio = f", x{found['fast'] / found['embreex']:.2f} of embreex" if "embreex" in found else ""
        print(f"16 x 1024 beams, {len(triangles)} triangles: {found['fast'] * 1e3:.2f} ms a scan{ratio}")


def hills(wanted: int) -> tuple[mujoco.MjModel, mujoco.MjData, np.ndarray]:
    """A mesh of 40 x 40 m with about that many triangles, and the triangles in the world frame."""
    cells = int(np.sqrt(wanted / 2))
    line = np.linspace(-20, 20, cells + 1)
    x, y = np.meshgrid(line, line)
    z = 1.2 * np.sin(x) * np.cos(0.7 * y) + np.random.default_rng(0).normal(0, 0.03, x.shape)
    z[cells // 2 - 2 : cells // 2 + 2, cells // 2 - 2 : cells // 2 + 2] = -1.5
    corner = np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)
    quads = [(corner, corner + 1, corner + cells + 2), (corner, corner + cells + 2, corner + cells + 1)]
    faces = np.concatenate([np.stack(quad, axis=-1).reshape(-1, 3) for quad in quads])
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    spec, shell = mujoco.MjSpec(), mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.add_mesh(name="hills", uservert=points.ravel(), userface=faces.ravel(), inertia=shell)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hills")
    model = spec.compile()
    sort_geoms(model)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    placed = mesh_vertices(model, 0) @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    return model, data, placed[mesh_faces(model, 0)]


class Embree:
    """Casts rays by Embree, from the package `embreex`."""

    def __init__(self, triangles: np.ndarray, directions: np.ndarray) -> None:
        scenes, shapes = (importlib.import_module(f"embreex.{name}") for name in ("rtcore_scene", "mesh_construction"))
        self._scene, self._directions = scenes.EmbreeScene(), directions
        self._mesh = shapes.TriangleMesh(self._scene, triangles.astype(np.float32))

    def cast(self, origin: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Distances of all rays."""
        rays = (self._directions @ rotation.T).astype(np.float32)
        origins = np.tile(origin.astype(np.float32), (len(rays), 1))
        found: np.ndarray = self._scene.run(origins, rays, query="DISTANCE")
        return found


def own_robot(ways: list[RaysChoice], rounds: int) -> None:
    """Scans of the Dingo's lidar among the warehouse's geoms, which sees its own robot or not."""
    simulation = load(SHIPPED / "dd100_warehouse.yaml").simulation
    model, data = simulation.model, simulation.data
    carrier = model.body("dd100/chassis_link").id
    directions = beam_directions((-2.4, 2.4, 4.8 / 2750), np.zeros(1))
    origin, rotation = data.xpos[carrier] + (0.0, 0.0, 0.15), data.xmat[carrier].reshape(3, 3).copy()
    tree, jobs = int(model.body_rootid[carrier]), {}
    for rays in ways:
        blind = OwnColliders(model, data, tree)
        seeing = OwnColliders(model, data, tree, body=carrier, passed=np.array([carrier]), near=0.05)
        for name, own in (("sees all but its robot", blind), ("sees its robot", seeing)):
            caster = select_rays(rays, model, data).caster(directions, FAR, own)
            jobs[f"{rays:6} {name}"] = many_scans(caster, [(origin, rotation)] * 12)
    print("2751 beams of a robot:")
    for name, seconds in interleaved(rounds, jobs).items():
        print(f"  {name:30} {seconds * 1e3:8.3f} ms a scan")


def fleets(ways: list[RaysChoice], rounds: int) -> None:
    """A scan of every robot in the same tick."""
    print("A scan of every robot's 2751 beams:")
    alone: dict[str, float] = {}
    for count in (1, 5, 10, 20, 50):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "fleet.yaml"
            path.write_text(FLEET.format(count=count), encoding="utf-8")
            world = load(path)
        model, stage = world.simulation.model, world.stage
        simulations = {rays: Simulation(model, stage, Fraction(60), 4, rays=rays) for rays in ways}
        found = interleaved(rounds, {rays: every_scan(simulation) for rays, simulation in simulations.items()})
        for name, seconds in found.items():
            each = seconds / count
            ratio = each / alone.setdefault(name, each)
            print(
                f"  {name:9} {count:2} robots {seconds * 1e3:8.2f} ms   {each * 1e3:6.3f} ms a robot, x{ratio:4.2f} of one"
            )


def every_scan(simulation: Simulation) -> Callable[[], float]:
    """A job in which all robots move, and then all lidars have a sample."""
    lidars = [simulation.device(RayLidar, prim) for prim in simulation.stage.prims("lidar")]

    def job() -> float:
        simulation.step()
        simulation.begin_tick(simulation.tick + 3)
        start = time.thread_time()
        for lidar in lidars:
            lidar.scan()
        return time.thread_time() - start

    return job


def main() -> None:
    """Print everything."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    ways: list[RaysChoice] = ["mujoco"]
    if importlib.util.find_spec("numba") is None:
        print(f"numba is not installed: {install_command('fast')}")
    else:
        ways.append("fast")
    one_lidar(ways, rounds)
    own_robot(ways, rounds)
    if "fast" in ways:
        meshes(rounds)
    fleets(ways, rounds)


if __name__ == "__main__":
    main()
