"""Look-alikes of robots as MuJoCo models, some of them as URDF, too."""

from __future__ import annotations

from pathlib import Path

DIFFERENTIAL = """<mujoco model="diff">
  <compiler autolimits="true"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <default>
    <default class="wheel">
      <geom type="cylinder" size="0.05 0.015" euler="90 0 0"/>
      <joint axis="0 1 0"/>
      <velocity kv="50"/>
    </default>
    <default class="ball"><geom size="0.02"/></default>
  </default>
  <worldbody>
    <body name="base_link">
      <freejoint/>
      <inertial pos="0 0 0" mass="5" diaginertia="0.0166667 0.0166667 0.025"/>
      <geom class="ball" name="front_ball" pos="0.12 0 -0.03" mass="0.0335"/>
      <geom class="ball" name="rear_ball" pos="-0.12 0 -0.03" mass="0.0335"/>
      <body name="left" pos="0 0.15 0" childclass="wheel">
        <inertial pos="0 0 0" mass="0.25" diaginertia="0.000175 0.0003125 0.000175"/>
        <joint name="left_joint"/><geom/>
      </body>
      <body name="right" pos="0 -0.15 0" childclass="wheel">
        <inertial pos="0 0 0" mass="0.25" diaginertia="0.000175 0.0003125 0.000175"/>
        <joint name="right_joint"/><geom/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity class="wheel" name="left_motor" joint="left_joint"/>
    <velocity class="wheel" name="right_motor" joint="right_joint"/>
  </actuator>
</mujoco>
"""
"""The base of two wheels and two balls of `imported_bases`."""

ARM = """<mujoco model="arm">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <joint damping="20" armature="0.1"/>
    <general biastype="affine" gainprm="2000" biasprm="0 -2000 -100" ctrlrange="-2 2"/>
  </default>
  <worldbody>
    <body name="base">
      <inertial pos="0 0 0" mass="4" diaginertia="0.01 0.01 0.01"/>
      <body name="upper" pos="0 0 0.2">
        <inertial pos="0 0 0.15" mass="2" diaginertia="0.02 0.02 0.005"/>
        <joint name="shoulder" axis="0 1 0" range="-2 2"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0 0 0.3"/>
        <body name="lower" pos="0 0 0.3">
          <inertial pos="0 0 0.1" mass="1" diaginertia="0.008 0.008 0.002"/>
          <joint name="elbow" axis="0 1 0" range="-2 2"/>
          <geom type="capsule" size="0.03" fromto="0 0 0 0 0 0.2"/>
          <site name="flange" pos="0 0 0.25" euler="0 1.5707963267948966 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <general name="shoulder_servo" joint="shoulder"/>
    <general name="elbow_servo" joint="elbow"/>
  </actuator>
  <keyframe><key name="home" qpos="0.5 -1" ctrl="0.5 -1"/></keyframe>
</mujoco>
"""
ARM_URDF = """<robot name="arm">
  <link name="base">{base}</link><link name="upper">{upper}</link><link name="lower">{lower}</link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="0" velocity="0"/><dynamics damping="20"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="0" velocity="0"/><dynamics damping="20"/></joint>
</robot>
""".format(
    **{
        link: f'<inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/><inertia ixx="{x}" iyy="{x}" izz="{y}" ixy="0" '
        'ixz="0" iyz="0"/></inertial>'
        for link, z, mass, x, y in (
            ("base", 0, 4, 0.01, 0.01),
            ("upper", 0.15, 2, 0.02, 0.005),
            ("lower", 0.1, 1, 0.008, 0.002),
        )
    }
)
"""The same arm; the robot file has its drives, armatures and start."""
ARM_KEYS = """fixed_base: true
base_link: base
joints:
  shoulder: {armature: 0.1, start: 0.5, drive: {stiffness: 2000, damping: 100}}
  elbow: {armature: 0.1, start: -1.0, drive: {stiffness: 2000, damping: 100}}
"""

QUADRUPED = """<mujoco model="pup">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <joint axis="0 1 0" damping="0.1" armature="0.01" range="-3 3"/>
    <geom friction="0.6"/>
    <motor ctrlrange="-24 24"/>
  </default>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="trunk" pos="0 0 0.4">
      <freejoint/>
      <geom type="box" size="0.2 0.05 0.05" mass="7"/>
      <site name="imu" pos="-0.02 0 0.04"/>
      {legs}
    </body>
  </worldbody>
  <actuator>
    {motors}
  </actuator>
  <sensor><accelerometer site="imu"/><gyro site="imu"/><framequat objtype="site" objname="imu"/></sensor>
  <keyframe><key name="home" qpos="0 0 0.27 1 0 0 0 {pose}"/></keyframe>
</mujoco>
"""
_LEG = """<body name="{leg}_hip" pos="{x} {y} 0">
        <joint name="{leg}_hip_joint" axis="1 0 0" range="-1 1"/><geom size="0.04" mass="0.7" contype="0" conaffinity="0"/>
        <body name="{leg}_thigh">
          <joint name="{leg}_thigh_joint"/><geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.2" mass="1"/>
          <body name="{leg}_calf" pos="0 0 -0.213">
            <joint name="{leg}_calf_joint" range="-2.7 -0.8"/>
            <geom type="capsule" size="0.008" fromto="0 0 0 0 0 -0.2" mass="0.2"/>
            <geom name="{leg}" size="0.022" pos="0 0 -0.213" mass="0.05" condim="6" priority="1" friction="0.8 0.02 0.01"/>
          </body>
        </body>
      </body>"""
_LEGS = {"FL": (0.19, 0.14), "FR": (0.19, -0.14), "RL": (-0.19, 0.14), "RR": (-0.19, -0.14)}
QUADRUPED = QUADRUPED.format(
    legs="\n      ".join(_LEG.format(leg=leg, x=x, y=y) for leg, (x, y) in _LEGS.items()),
    motors="\n    ".join(
        f'<motor name="{leg}_{part}" joint="{leg}_{part}_joint"/>' for leg in _LEGS for part in ("hip", "thigh", "calf")
    ),
    pose=" ".join(["0 0.9 -1.8"] * 4),
)
"""A robot on four legs with motors, of the size of a Go2."""

KITCHEN_SINK = """<mujoco model="sink">
  <compiler angle="radian" autolimits="true" meshdir="." texturedir="."/>
  <option timestep="0.001" integrator="implicitfast" cone="elliptic" impratio="10"><flag warmstart="enable"/></option>
  <size nuserdata="2" njmax="500"/>
  <visual><headlight ambient="0.3 0.3 0.3"/><map znear="0.01"/></visual>
  <statistic extent="1" center="0 0 0"/>
  <default>
    <geom density="500" solref="0.01 1"/>
    <default class="arm">
      <joint axis="0 1 0" damping="1" armature="0.01" frictionloss="0.1" range="-2 2"/>
      <position kp="100" kv="5" ctrlrange="-2 2" forcerange="-50 50"/>
      <default class="visual"><geom contype="0" conaffinity="0" group="2"/></default>
    </default>
  </default>
  <custom><numeric name="number" data="1 2 3"/><text name="word" data="hello"/></custom>
  <asset>
    <mesh name="cone" vertex="0 0 0  .1 0 0  0 .1 0  0 0 .1" scale="1 1 2"/>
    <texture name="check" type="2d" builtin="checker" width="16" height="16" rgb1="0 0 0" rgb2="1 1 1"/>
    <material name="checked" texture="check" texrepeat="2 2" rgba="1 0 0 1"/>
    <hfield name="bumps" nrow="3" ncol="3" size="1 1 .1 .1" elevation="0 0 0 0 1 0 0 0 0"/>
  </asset>
  <worldbody>
    <light name="lamp" pos="0 0 3" dir="0 0 -1"/>
    <camera name="outside" pos="2 0 1" xyaxes="0 1 0 -1 0 2"/>
    <body name="trunk" pos="0 0 0.5" quat="1 0 0 0.2">
      <freejoint name="float"/>
      <geom type="box" size="0.2 0.1 0.05" material="checked"/>
      <camera name="eye" pos="0.2 0 0" euler="1.5708 -1.5708 0" fovy="60" resolution="64 48"/>
      <site name="imu" pos="0 0 0.05" size="0.01"/>
      <body name="shoulder" pos="0.1 0 0.1" childclass="arm">
        <joint name="pan" axis="0 0 1" ref="0.1"/>
        <joint name="lift" pos="0 0 0.02" springref="0.2" stiffness="1"/>
        <inertial pos="0 0 0.1" mass="0.5" fullinertia="0.002 0.002 0.001 0 0 0.0001"/>
        <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.02"/>
        <geom class="visual" type="mesh" mesh="cone"/>
        <body name="forearm" pos="0 0 0.2">
          <joint name="elbow"/>
          <geom type="ellipsoid" size="0.02 0.02 0.1" pos="0 0 0.1"/>
          <site name="tip" pos="0 0 0.2"/>
          <body name="left_finger" pos="0 0.02 0.2"><joint name="left_slide" type="slide" axis="0 1 0" range="0 0.04"/>
            <geom type="box" size="0.005 0.005 0.02" mass="0.02"/></body>
          <body name="right_finger" pos="0 -0.02 0.2"><joint name="right_slide" type="slide" axis="0 -1 0" range="0 0.04"/>
            <geom type="box" size="0.005 0.005 0.02" mass="0.02"/></body>
        </body>
      </body>
      <body name="head" pos="-0.1 0 0.1"><joint name="neck" type="ball" range="0 1" damping="0.1"/>
        <geom type="sphere" size="0.05" mass="0.2"/></body>
      <body pos="0 0 -0.1"><joint axis="0 1 0"/><geom type="cylinder" size="0.05 0.02" euler="1.5708 0 0" mass="0.3"/>
        <site name="rim" pos="0 0 -0.05"/></body>
      <frame pos="0 0.2 0"><body name="pod"><geom type="sphere" size="0.03" mass="0.1"/></body></frame>
      <replicate count="2" offset="0.1 0 0"><geom type="sphere" size="0.01" pos="0 -0.1 0" mass="0.01"/></replicate>
    </body>
  </worldbody>
  <contact><exclude body1="trunk" body2="shoulder"/><pair geom1="a" geom2="b"/></contact>
  <tendon>
    <fixed name="grip"><joint joint="left_slide" coef="0.5"/><joint joint="right_slide" coef="0.5"/></fixed>
    <spatial name="rope" limited="true" range="0 2" width="0.002"><site site="imu"/><site site="tip"/></spatial>
  </tendon>
  <equality><joint joint1="right_slide" joint2="left_slide" polycoef="0 1 0 0 0"/></equality>
  <actuator>
    <position class="arm" name="pan" joint="pan"/>
    <motor name="lift_motor" joint="lift" gear="10" ctrlrange="-1 1"/>
    <velocity name="elbow_velocity" joint="elbow" kv="10"/>
    <general name="gripper" tendon="grip" gainprm="0.0157" biastype="affine" biasprm="0 -100 -10" ctrlrange="0 255"/>
    <intvelocity name="wheel" joint="body_7_joint" kp="10" actrange="-10 10"/>
    <muscle name="muscle" tendon="rope"/>
    <damper name="damper" joint="neck" kv="1" ctrlrange="0 1"/>
    <cylinder name="cylinder" joint="elbow" area="0.001" timeconst="0.1"/>
    <adhesion name="sticky" body="pod" ctrlrange="0 1" gain="10"/>
  </actuator>
  <sensor>
    <accelerometer site="imu"/><gyro site="imu"/><jointpos joint="pan"/><touch site="tip"/><rangefinder site="tip"/>
    <framepos objtype="site" objname="tip"/><actuatorfrc actuator="lift_motor"/><subtreecom body="trunk"/>
  </sensor>
  <keyframe>
    <key name="home" qpos="0 0 0.5 1 0 0 0 0.1 0.2 0.3 0.01 0.01 1 0 0 0 0" ctrl="0.1 0 0 0 0 0 0 0 0"/>
    <key name="flat" time="1"/>
  </keyframe>
</mujoco>
""".replace('<pair geom1="a" geom2="b"/>', "")
"""A robot with one of each thing that a model can have."""


def write_model(folder: Path, name: str, text: str) -> Path:
    """Write a model to a file in a folder."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
