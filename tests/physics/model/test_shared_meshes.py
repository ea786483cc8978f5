"""Meshes and textures that robots have in common are there once, and nothing else knows."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from graphengine.descriptions.engine import mujoco
from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.sensors.camera import PinholeCamera
from graphengine.physics.sensors.lidar import RayLidar
from tests.physics.harness import CART, Project, steps
from tests.physics.pictures.harness import needs_opengl, segmented

PLACES = {"first": (0.0, 0.0), "second": (0.0, 1.0), "third": (1.0, 0.5)}
SENSORS = """sensors:
  eye: {type: camera, parent: base_link, position: [0, 0, .6]}
  scanner: {type: lidar, profile: lidar_360, parent: base_link, position: [0, 0, .2]}
"""
SHAPE = '<geometry><sphere radius=".05"/></geometry>'
"""What the mesh takes the place of."""


def pebble(path: Path) -> None:
    """A mesh without any symmetry."""
    ball = trimesh.creation.icosphere(2, radius=0.2)
    ball.vertices *= 1 + 0.2 * np.random.default_rng(1).random(ball.vertices.shape)
    path.write_bytes(ball.export(file_type="stl"))


def robots(project: Project, own: bool) -> LoadedWorld:
    """Three carts with a mesh each, of one file or of files of their own which hold the same."""
    entries = ""
    for name, (x, y) in PLACES.items():
        kind = name if own else "one"
        pebble(project.folder / f"{kind}.stl")
        mesh = f'<geometry><mesh filename="{kind}.stl"/></geometry>'
        project.write(f"{kind}.urdf", CART.replace(SHAPE, mesh))
        project.write(f"{kind}.yaml", f"robot: {kind}\nurdf: {kind}.urdf\n{SENSORS}")
        entries += f"  {name}: {{use: {kind}.yaml, position: [{x}, {y}, 0.3]}}\n"
    return project.write("scene.yaml", f"scene: t\nworld: world.xml\nrobots:\n{entries}").load()


def bodies_and_joints(model: mujoco.MjModel) -> dict[str, bytes]:
    """All that a model holds of these, and of what they are made of but the numbers of meshes."""
    kinds = ("body_", "geom_", "jnt_", "dof_", "exclude_", "mat_", "qpos0")
    found = {name: getattr(model, name) for name in dir(model) if name.startswith(kinds) and name != "geom_dataid"}
    return {name: array.tobytes() for name, array in found.items() if isinstance(array, np.ndarray)}


def test_lidars_and_motion_treat_a_shared_mesh_as_a_copy_to_the_last_bit(project: Project) -> None:
    shared, own = robots(project, own=False), robots(project, own=True)
    assert (shared.simulation.model.nmesh, own.simulation.model.nmesh) == (1, 3)
    expected = bodies_and_joints(own.simulation.model)
    assert {"body_mass", "body_inertia", "geom_pos", "geom_rbound"} <= expected.keys()
    assert bodies_and_joints(shared.simulation.model) == expected
    seen = []
    for world in (shared, own):
        simulation, stage = world.simulation, world.stage
        steps(simulation, 120)
        scans = [simulation.device(RayLidar, stage.find(f"/{name}/base_link/scanner/Lidar")).scan() for name in PLACES]
        assert all(np.isfinite(scan.ranges).any() for scan in scans)
        assert simulation.data.ncon
        seen.append((simulation.data.qpos.tobytes(), *(scan.ranges.tobytes() for scan in scans)))
    assert seen[0] == seen[1]
    assert [prim.path for prim in shared.stage.prims()] == [prim.path for prim in own.stage.prims()]


@needs_opengl
def test_images_of_a_shared_mesh_equal_images_of_separate_meshes(project: Project) -> None:
    pictures = []
    for own in (False, True):
        world = robots(project, own)
        camera = world.simulation.device(PinholeCamera, world.stage.find("/first/base_link/eye/Camera"))
        picture, arm = segmented(camera, "/third/Geometry/base_link/arm")
        assert arm.sum() > 100
        pictures.append((picture.rgb.tobytes(), picture.depth.tobytes(), np.array(picture.segmentation).tobytes()))
    assert pictures[0] == pictures[1]


@pytest.mark.parametrize("gone", list(PLACES))
def test_added_robots_share_meshes_and_removed_robots_leave_them(project: Project, gone: str) -> None:
    worlds = robots(project, own=False), robots(project, own=True)
    for world, kind in zip(worlds, ("one", gone), strict=True):
        world.add("fourth", RobotUse(use=f"{kind}.yaml", position=(2.0, 2.0, 0.3)))
        world.remove(gone)
        steps(world.simulation, 60)
    shared, own = (world.simulation for world in worlds)
    assert (shared.model.nmesh, own.model.nmesh) == (1, 3)
    assert bodies_and_joints(shared.model) == bodies_and_joints(own.model)
    assert shared.data.qpos.tobytes() == own.data.qpos.tobytes()


def test_meshes_of_the_same_name_in_two_folders_stay_two(project: Project) -> None:
    for folder, radius in (("a", 0.1), ("b", 0.3)):
        project.write(f"{folder}/bot.yaml", "robot: bot\nurdf: bot.urdf\n")
        project.write(f"{folder}/bot.urdf", CART.replace(SHAPE, '<geometry><mesh filename="ball.stl"/></geometry>'))
        ball = trimesh.creation.icosphere(3, radius=radius)
        (project.folder / folder / "ball.stl").write_bytes(ball.export(file_type="stl"))
    entries = "  a: {use: a/bot.yaml}\n  b: {use: b/bot.yaml, position: [3, 0, 0]}\n"
    model = project.write("scene.yaml", f"scene: t\nworld: world.xml\nrobots:\n{entries}").load().simulation.model
    reach = [float(model.geom_rbound[model.body(f"{robot}/arm").geomadr[0]]) for robot in ("a", "b")]
    assert reach == pytest.approx([0.1 * math.sqrt(3), 0.3 * math.sqrt(3)], rel=0.01)  # of the box around a ball


def test_textures_of_a_mujoco_model_are_shared_too_and_height_fields_are_found(project: Project) -> None:
    project.write(
        "can.xml",
        """<mujoco><asset><texture name="t" type="2d" file="t.png"/><material name="m" texture="t"/>
        <hfield name="h" file="t.png" size="1 1 .1 .1"/></asset><worldbody><body name="can"><freejoint/>
        <geom size=".1" material="m"/><geom type="hfield" hfield="h" mass="0" contype="0" conaffinity="0"/>
        </body></worldbody></mujoco>""",
    )
    Image.fromarray(np.random.default_rng(1).integers(0, 256, (8, 8, 3), np.uint8)).save(project.folder / "t.png")
    entries = "  can: {use: can.xml, count: 3, spacing: [3, 3], position: [0, 0, 1]}\n"
    model = project.write("scene.yaml", f"scene: t\nworld: world.xml\nrobots:\n{entries}").load().simulation.model
    assert (model.ntex, model.nmat, model.nhfield) == (1, 3, 3)
