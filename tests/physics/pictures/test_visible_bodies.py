"""What a world tells of its bodies to programs that draw them by themselves."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

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


def test_shapes_are_those_that_pictures_show_in_the_frames_of_their_bodies() -> None:
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


def test_a_mesh_is_told_once_with_its_vertices_and_triangles() -> None:
    bodies = visible_bodies(MODEL)
    assert [shape.mesh for shape in bodies.shapes if shape.mesh] == ["wedge"]
    vertices, faces = bodies.surfaces["wedge"]
    assert (vertices.dtype, faces.dtype) == (np.dtype(np.float32), np.dtype(np.int32))
    assert (vertices.shape, faces.shape) == ((4, 3), (4, 3))
    assert faces.max() == 3


def test_poses_are_those_of_the_bodies_with_the_scalar_last() -> None:
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
