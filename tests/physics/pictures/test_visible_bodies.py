"""What a world tells of its bodies to programs that draw them by themselves."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image

from graphengine.physics.pictures.visible_bodies import visible_bodies
from graphengine.testing import session

MODEL = mujoco.MjModel.from_xml_string("""
<mujoco>
  <asset>
    <material name="steel" rgba="0.5 0.6 0.7 1"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
  </asset>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body name="crate" pos="1 2 3">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3" pos="0 0 0.5" quat="0 0 0 1" material="steel"/>
      <geom type="mesh" mesh="wedge" rgba="1 0 0 0.5"/>
      <geom type="sphere" size="1" group="3"/>
      <geom type="sphere" size="1" rgba="1 1 1 0"/>
    </body>
    <body name="pillar"><geom type="cylinder" size="0.2 1"/></body>
    <body name="held" mocap="true"><geom type="capsule" size="0.1 0.4"/></body>
  </worldbody>
</mujoco>
""")


def test_visible_shapes_equal_the_shapes_in_images_in_the_frames_of_their_bodies() -> None:
    bodies = visible_bodies(MODEL)
    assert bodies.names == ["world", "crate", "pillar", "held"]
    assert bodies.moving == [False, True, False, True]
    assert [(shape.kind, bodies.names[shape.body]) for shape in bodies.shapes] == [
        ("plane", "world"),
        ("box", "crate"),
        ("mesh", "crate"),
        ("cylinder", "pillar"),
        ("capsule", "held"),
    ]
    box = bodies.shapes[1]
    assert (box.size, box.pose) == ((0.1, 0.2, 0.3), ((0.0, 0.0, 0.5), (0.0, 0.0, 1.0, 0.0)))
    assert box.colour == pytest.approx((0.5, 0.6, 0.7, 1.0))


def test_a_shared_mesh_is_returned_once_with_its_vertices_and_triangles() -> None:
    bodies = visible_bodies(MODEL)
    assert [shape.mesh for shape in bodies.shapes if shape.mesh] == ["wedge"]
    vertices, faces = bodies.surfaces["wedge"]
    assert (vertices.dtype, faces.dtype) == (np.dtype(np.float32), np.dtype(np.int32))
    assert (vertices.shape, faces.shape) == ((4, 3), (4, 3))
    assert faces.max() == 3


def test_a_height_field_is_a_mesh_with_its_terrain_and_its_sides() -> None:
    model = mujoco.MjModel.from_xml_string("""
<mujoco>
  <asset><hfield name="hill" nrow="3" ncol="4" elevation="0 0 0 0  0 1 1 0  0 0 0 0" size="2 1 0.5 0.2"/></asset>
  <worldbody><geom type="hfield" hfield="hill" pos="5 0 0"/></worldbody>
</mujoco>
""")
    bodies = visible_bodies(model)
    (shape,) = bodies.shapes
    vertices, faces = bodies.surfaces[shape.mesh]
    assert (shape.kind, shape.pose[0], shape.texture) == ("mesh", (5.0, 0.0, 0.0), "")
    assert faces.max() == len(vertices) - 1
    assert vertices.min(axis=0).tolist() == pytest.approx([-2.0, -1.0, -0.2])
    assert vertices.max(axis=0).tolist() == pytest.approx([2.0, 1.0, 0.5])


def test_poses_have_position_and_quaternion_with_the_scalar_last() -> None:
    with session("dd100_flat") as sim:
        sim.move("dd100", position=(1.0, 2.0), orientation=(0.0, 0.0, math.sin(0.25), math.cos(0.25)))
        sim.step()
        world = sim._runner.session.services.world
        poses, names = world.poses(), world.bodies().names
        pose = sim.robots["dd100"].pose
        row = poses[names.index("dd100/base_link")]
        assert row.tolist() == pytest.approx([*pose.position, *pose.orientation])
        poses[:] = 0.0
        assert world.poses().any()


def textured(shapes: str, folder: Path) -> mujoco.MjModel:
    """A model with a picture of 4 x 2 pixels, of which the upper left one is red, and a cube texture."""
    pixels = np.full((2, 4, 3), 100, np.uint8)
    pixels[0, 0] = 255, 0, 0
    Image.fromarray(pixels).save(folder / "picture.png")
    return mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <asset>
    <texture name="picture" type="2d" file="{folder / "picture.png"}"/>
    <texture name="cube" type="cube" builtin="flat" rgb1="0.5 0.5 0.5" width="8" height="8"/>
    <material name="tiled" texture="picture" texrepeat="4 3" texuniform="true"/>
    <material name="stretched" texture="picture" texrepeat="4 3"/>
    <material name="cubic" texture="cube" rgba="1 0.5 0 1"/>
    <mesh name="sheet" vertex="0 0 0  1 0 0  0 1 0  0 0 1" texcoord="0 0  1 0  0 1  1 1"
      face="0 2 1  0 1 3  0 3 2  1 2 3"/>
  </asset>
  <worldbody>{shapes}</worldbody>
</mujoco>""")


def test_a_shared_texture_is_returned_once_with_its_upper_row_first(tmp_path: Path) -> None:
    plane = '<geom type="plane" size="3 2 1" material="{}"/>'
    bodies = visible_bodies(textured(plane.format("tiled") + plane.format("stretched"), tmp_path))
    (texture,) = bodies.textures.values()
    assert texture.shape == (2, 4, 3)
    assert texture[0, 0].tolist() == [255, 0, 0]
    assert {shape.texture for shape in bodies.shapes} == set(bodies.textures)


def test_a_texture_repeats_by_the_metre_or_by_the_size_of_its_shape(tmp_path: Path) -> None:
    shapes = [
        '<geom type="plane" size="3 2 1" material="tiled"/>',
        '<geom type="box" size="2 0.5 1" material="stretched"/>',
        '<geom type="cylinder" size="0.5 7" material="stretched"/>',
    ]
    found = [shape.repeats for shape in visible_bodies(textured("".join(shapes), tmp_path)).shapes]
    assert found == [(2.0, 1.5), (1.0, 3.0), (4.0, 3.0)]


def test_a_mesh_with_texture_coordinates_tells_them_for_each_corner(tmp_path: Path) -> None:
    bodies = visible_bodies(textured('<geom type="mesh" mesh="sheet" material="stretched"/>', tmp_path))
    (shape,) = bodies.shapes
    assert shape.repeats == (0.0, 0.0)
    assert bodies.coordinates["sheet"].shape == (len(bodies.surfaces["sheet"][1]), 3, 2)


def test_a_cube_texture_colours_a_shape_by_its_mean(tmp_path: Path) -> None:
    (shape,) = visible_bodies(textured('<geom size="1" material="cubic"/>', tmp_path)).shapes
    assert shape.texture == ""
    assert shape.colour == pytest.approx((0.5, 0.25, 0.0, 1.0), abs=0.01)
