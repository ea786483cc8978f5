"""Scenes with physics for the cases that need them: files by name, for `Player.scene`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

CARTER_WHEEL_RADIUS, CARTER_WHEEL_DISTANCE = 0.24, 0.56
"""m, of the Carter robot of Isaac Sim's examples."""

FLOOR = """
    <mujoco>
      <worldbody>
        <geom name="floor" type="plane" size="0 0 1" friction="1 0.005 0.0001"/>
        {body}
      </worldbody>
    </mujoco>
    """
SCENE = """
    scene: case
    world: world.xml
    physics: {tick_rate: 60, substeps: 4}
    """
ROBOT = """
    robots:
      robot: {{use: robot.yaml, position: {position}, orientation: {{rpy_deg: [0, 0, {yaw_deg}]}}}}
    graphs:
      graph: {{use: graph.yaml, at: /World/graph}}
    """


def odometry(chassis: str) -> str:
    """Nodes and wires that publish the odometry of a body."""
    wires = "".join(f"  - Compute.{port} -> Publish.{port}\n" for port in ODOMETRY)
    return f"""
nodes:
  Tick: OnPlaybackTick
  Compute: {{type: ComputeOdometry, inputs: {{chassisPrim: {chassis}}}}}
  Publish: PublishOdometry
connections:
  - Tick.tick -> Compute.execIn
  - Compute.execOut -> Publish.execIn
{wires}"""


ODOMETRY = ("position", "orientation", "linearVelocity", "angularVelocity")


def scene(
    urdf: str, robot: Mapping[str, Any], graph: str, position: Sequence[float] = (0, 0, 0), yaw: float = 0.0
) -> dict[str, str]:
    """The files of a robot on a floor, and of a graph."""
    place = ROBOT.format(position=[float(number) for number in position], yaw_deg=float(yaw))
    file = json.dumps({"robot": "robot", "urdf": "robot.urdf", **robot})
    files = {"world.xml": FLOOR.format(body=""), "scene.yaml": SCENE + place}
    return {**files, "robot.urdf": urdf, "robot.yaml": file, "graph.yaml": graph}


def cube_on_the_floor(height: float, size: float = 0.5) -> dict[str, str]:
    """A cube whose centre starts at a height, and its odometry."""
    half = size / 2
    cube = f'<body name="cube" pos="0 0 {height}"><freejoint/><geom type="box" size="{half} {half} {half}" mass="1"/></body>'
    return {
        "world.xml": FLOOR.format(body=cube),
        "scene.yaml": f"{SCENE}graphs:\n      graph: {{use: graph.yaml, at: /World/graph}}\n    ",
        "graph.yaml": f"graph: graph\n{odometry('/World/cube')}",
    }


def body(mass: float, inertia: float, size: str, origin: str = "0 0 0", collides: bool = True) -> str:
    """What a link of a URDF is made of."""
    shape = f'<origin xyz="{origin}"/><geometry>{size}</geometry>'
    collision = f"<collision>{shape}</collision>" if collides else ""
    tensor = f'<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/>'
    return f'<inertial><origin xyz="{origin}"/><mass value="{mass}"/>{tensor}</inertial>{collision}'


def arm(joints: Sequence[str], stiffness: float, damping: float, **commands: Any) -> dict[str, str]:
    """Joints about vertical axes, or along a horizontal one if called so, on a heavy base; commands as literals."""
    parts = [f'<link name="base_link">{body(200.0, 20.0, "<box size=&quot;1 1 0.2&quot;/>", "0 0 0.1")}</link>']
    above = "base_link"
    for number, name in enumerate(joints):
        slides, link = "Prismatic" in name, f"link{number}"
        kind, axis = ("prismatic", "1 0 0") if slides else ("revolute", "0 0 1")
        small = body(0.5, 0.01, "<box size=&quot;0.05 0.05 0.05&quot;/>", "0.1 0 0", collides=False)
        parts += [
            f'<link name="{link}">{small}</link>',
            f'<joint name="{name}" type="{kind}"><parent link="{above}"/><child link="{link}"/>',
            f'<origin xyz="{0.0 if number == 0 else 0.1} 0 {0.3 if number == 0 else 0.0}"/><axis xyz="{axis}"/>',
            '<limit lower="-3" upper="3" effort="1000" velocity="10"/></joint>',
        ]
        above = link
    drive = {"drive": {"stiffness": float(stiffness), "damping": float(damping)}}
    inputs = {"targetPrim": "/robot", **commands}
    graph = f"""
        graph: graph
        nodes:
          Tick: OnPlaybackTick
          Control: {{type: ArticulationController, inputs: {json.dumps(inputs)}}}
          States: {{type: PublishJointState, inputs: {{targetPrim: /robot}}}}
        connections: [Tick.tick -> Control.execIn, Tick.tick -> States.execIn]
        """
    urdf = f'<robot name="arm">{"".join(parts).replace("&quot;", chr(34))}</robot>'
    return scene(urdf, {"joints": dict.fromkeys(joints, drive)}, graph)


def carter(position: Sequence[float], yaw_deg: float, controller: dict[str, float]) -> dict[str, str]:
    """Two driven wheels and a caster that slides, driven over cmd_vel; odometry, and TF of the base below the world."""
    radius, half = CARTER_WHEEL_RADIUS, CARTER_WHEEL_DISTANCE / 2
    wheels = "".join(
        f'<link name="{side}">{body(1.0, 0.03, f"<sphere radius={chr(34)}{radius}{chr(34)}/>")}</link>'
        f'<joint name="{side}_joint" type="continuous"><parent link="base_link"/><child link="{side}"/>'
        f'<origin xyz="0 {y} {radius}"/><axis xyz="0 1 0"/></joint>'
        for side, y in (("left", half), ("right", -half))
    )
    base = body(30.0, 2.0, '<box size="0.4 0.3 0.2"/>', "-0.05 0 0.25")
    caster = body(0.5, 0.01, '<sphere radius="0.05"/>')
    mount = '<parent link="base_link"/><child link="caster"/><origin xyz="-0.3 0 0.05"/>'
    links = f'<link name="base_link">{base}</link>{wheels}<link name="caster">{caster}</link>'
    urdf = f'<robot name="carter">{links}<joint name="caster_joint" type="fixed">{mount}</joint></robot>'
    drive = {"drive": {"damping": 50.0}, "armature": 0.01}
    materials = {
        "Wheel": {"static_friction": 1.0, "dynamic_friction": 1.0, "combine": "max", "bind": ["left", "right"]},
        "Caster": {"static_friction": 0.0, "dynamic_friction": 0.0, "combine": "min", "bind": ["caster"]},
    }
    robot = {"materials": materials, "joints": {"left_joint": drive, "right_joint": drive}}
    robot["frames"] = {"place": {"parent": "base_link"}}
    graph = f"""
            graph: graph
            nodes:
              Tick: OnPlaybackTick
              Twist: SubscribeTwist
              Linear: BreakVector3
              Angular: BreakVector3
              Diff: {{type: DifferentialController, inputs: {json.dumps(controller)}}}
              Art: {{type: ArticulationController, inputs: {{targetPrim: /robot, jointNames: [left_joint, right_joint]}}}}
              Compute: {{type: ComputeOdometry, inputs: {{chassisPrim: /robot}}}}
              Odometry: PublishOdometry
              TF: {{type: PublishTransformTree, inputs: {{targetPrims: /robot/base_link/place}}}}
            connections:
              - Tick.tick -> Twist.execIn
              - Twist.execOut -> Diff.execIn
              - Twist.linearVelocity -> Linear.tuple
              - Twist.angularVelocity -> Angular.tuple
              - Linear.x -> Diff.linearVelocity
              - Angular.z -> Diff.angularVelocity
              - Diff.velocityCommand -> Art.velocityCommand
              - Tick.tick -> Art.execIn
              - Tick.tick -> Compute.execIn
              - Compute.execOut -> Odometry.execIn
              - Compute.position -> Odometry.position
              - Compute.orientation -> Odometry.orientation
              - Tick.tick -> TF.execIn
            """
    return scene(urdf, robot, graph, position, yaw_deg)


def pulled_imu(acceleration: float) -> dict[str, str]:
    """An inertial unit on a robot that falls sideways."""
    graph = """
        graph: graph
        nodes: {Tick: OnPlaybackTick, Imu: {type: ReadIMU, inputs: {imuPrim: /robot/base_link/imu, readGravity: false}}}
        connections: [Tick.tick -> Imu.execIn]
        """
    urdf = f'<robot name="box"><link name="base_link">{body(1.0, 0.1, CUBE)}</link></robot>'
    files = scene(urdf, {"sensors": {"imu": {"type": "imu", "parent": "base_link"}}}, graph, (0, 0, 1))
    return {**files, "world.xml": f'<mujoco><option gravity="{acceleration} 0 0"/></mujoco>'}


CUBE = '<box size="0.2 0.2 0.2"/>'


def forklift(controller: dict[str, Any]) -> dict[str, str]:
    """Driven wheels in front, wheels that are driven and steer behind; its base is in the middle of the front axle."""
    half, base = controller["trackWidth"] / 2, controller["wheelBase"]
    front, back = controller["frontWheelRadius"], controller["backWheelRadius"]
    chassis = body(200.0, 20.0, '<box size="1.6 0.8 0.2"/>', f"{-base / 2} 0 0.5")
    parts = [f'<link name="base_link">{chassis}</link>']
    names = ["front_left", "front_right", "back_left", "back_right"]
    for name, x, y, radius in zip(
        names, (0, 0, -base, -base), (half, -half) * 2, (front,) * 2 + (back,) * 2, strict=True
    ):
        above, place = "base_link", f"{x} {y} {radius}"
        if x:
            knuckle = body(2.0, 0.05, CUBE, collides=False)
            parts += [f'<link name="{name}_knuckle">{knuckle}</link>', _turning(f"{name}_steer", above, place, "0 0 1")]
            above, place = f"{name}_knuckle", "0 0 0"
        wheel = body(5.0, 0.2, f'<sphere radius="{radius}"/>')
        parts += [f'<link name="{name}">{wheel}</link>', _turning(name, above, place, "0 1 0")]
    steered = ["back_left_steer", "back_right_steer"]
    joints = {name: {"drive": {"damping": 100.0}} for name in names}
    joints |= {name: {"drive": {"stiffness": 5000.0, "damping": 500.0}} for name in steered}
    graph = f"""
            graph: graph
            nodes:
              Tick: OnPlaybackTick
              Ackermann: {{type: AckermannController, inputs: {json.dumps(controller)}}}
              Steer: {{type: ArticulationController, inputs: {{targetPrim: /robot, jointNames: {json.dumps(steered)}}}}}
              Drive: {{type: ArticulationController, inputs: {{targetPrim: /robot, jointNames: {json.dumps(names)}}}}}
              Compute: {{type: ComputeOdometry, inputs: {{chassisPrim: /robot}}}}
            connections:
              - Tick.tick -> Ackermann.execIn
              - Ackermann.execOut -> Steer.execIn
              - Ackermann.execOut -> Drive.execIn
              - Ackermann.wheelAngles -> Steer.positionCommand
              - Ackermann.wheelRotationVelocity -> Drive.velocityCommand
              - Tick.tick -> Compute.execIn
            """
    return scene(f'<robot name="forklift">{"".join(parts)}</robot>', {"joints": joints}, graph)


def _turning(name: str, above: str, place: str, axis: str) -> str:
    """A joint of a URDF without limits; a wheel's is called like the wheel."""
    below = name.replace("_steer", "_knuckle")
    ends = f'<parent link="{above}"/><child link="{below}"/><origin xyz="{place}"/><axis xyz="{axis}"/>'
    return f'<joint name="{name}" type="continuous">{ends}</joint>'
