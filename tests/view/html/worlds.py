"""A scene with a shape of each kind, a ball that falls, and a robot with a lidar before a wall."""

from __future__ import annotations

WORLD = """<mujoco>
  <asset>
    <texture name="chess" type="2d" builtin="checker" rgb1=".8 .8 .8" rgb2=".6 .6 .6" width="64" height="64"/>
    <material name="chess" texture="chess" texrepeat="1 1" texuniform="true"/>
    <mesh name="wedge" vertex="0 0 0  .5 0 0  0 .5 0  0 0 .5"/>
  </asset>
  <worldbody>
    <geom type="plane" size="0 0 .1" material="chess"/>
    <geom type="box" pos="3 0 .5" size=".1 2 .5" rgba=".2 .4 .7 1"/>
    <geom type="sphere" pos="1 -2.5 .3" size=".3" rgba=".8 .3 .2 1"/>
    <geom type="capsule" pos="0 -2.5 .5" size=".2 .3" rgba=".3 .7 .3 1"/>
    <geom type="cylinder" pos="-1 -2.5 .4" size=".3 .4" rgba=".8 .7 .2 1"/>
    <geom type="ellipsoid" pos="-2 -2.5 .3" size=".4 .2 .3" rgba=".6 .3 .7 1"/>
    <geom type="mesh" mesh="wedge" pos="2 -2.5 .2" rgba=".3 .7 .7 1"/>
    <geom type="box" pos="0 2.5 .5" size=".5 .05 .5" rgba=".4 .6 .9 .3"/>
    <body name="ball" pos="1 1.5 2"><freejoint/><geom type="sphere" size=".1" mass="1"/></body>
  </worldbody>
</mujoco>
"""
SCENE = """scene: shapes
world: world.xml
robots:
  dd100: {use: robots/dd100.yaml, position: [0.0, 0.0, 0.025], namespace: dd100_0000}
"""
