"""Look-alikes of wheeled bases: folders with a scene, a robot file, a description and graphs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

RADIUS, TRACK = 0.05, 0.3

_SPEEDS = (
    "maxLinearSpeed: 1.0, maxAngularSpeed: 2.0, maxAcceleration: 1.0, maxDeceleration: 1.0, maxAngularAcceleration: 2.0"
)
_SUBSCRIBER = """  Tick: OnPlaybackTick
  Command: {type: ROS2SubscribeTwist, inputs: {topicName: cmd_vel, timeout: 0.5}}
  Linear: BreakVector3
  Angular: BreakVector3
"""
_TWIST = """  - Tick.tick -> Command.execIn
  - Command.linearVelocity -> Linear.tuple
  - Command.angularVelocity -> Angular.tuple
"""


def link(name: str, mass: float, shape: str = "", at: str = "0 0 0", turned: str = "0 0 0") -> str:
    """A link with the inertia of a ball of 0.1 m, and a collider."""
    inertia = 0.004 * mass
    collider = (
        f'<collision><origin xyz="{at}" rpy="{turned}"/><geometry>{shape}</geometry></collision>' if shape else ""
    )
    moments = f'ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"'
    return f'<link name="{name}"><inertial><mass value="{mass}"/><inertia {moments}/></inertial>{collider}</link>'


def joint(name: str, parent: str, child: str, at: str, axis: str, kind: str = "continuous") -> str:
    """A joint at a place in its parent link."""
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{at}"/><axis xyz="{axis}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}</joint>'


def wheel(name: str, x: float, y: float, above: str = "base_link") -> str:
    """A wheel about the y axis."""
    cylinder = f'<cylinder radius="{RADIUS}" length="0.02"/>'
    shape = link(name, 0.2, cylinder, turned="1.5707963267948966 0 0")
    return shape + joint(f"{name}_joint", above, name, f"{x} {y} 0", "0 1 0")


class Base:
    """A folder with a robot `bot` of a few wheels, alone in a scene."""

    def __init__(self, folder: Path, wheels: Sequence[tuple[str, float, float]], links: str = "") -> None:
        self.folder = folder
        self.wheels = [name for name, _, _ in wheels]
        self.scene = folder / "scene.yaml"
        self.drives = {f"{name}_joint": "{drive: {damping: 50.0}}" for name in self.wheels}
        self.graphs: dict[str, str] = {}
        self.keys = ""
        chassis = link("base_link", 5.0, '<box size="0.2 0.2 0.06"/>', at="0 0 0.02")
        self.urdf = chassis + "".join(wheel(*one) for one in wheels) + links

    def write(self) -> Base:
        """Write all files."""
        self.folder.mkdir(parents=True, exist_ok=True)
        drives = "".join(f"  {name}: {drive}\n" for name, drive in self.drives.items())
        uses = "".join(f"  {name}: {use}\n" for name, use in self.graphs.items())
        colliders = ", ".join(f"{name}: ellipsoid" for name in self.wheels)
        parts = [
            f"# A base of a test.\nrobot: bot\nurdf: bot.urdf\nwheel_colliders: {{{colliders}}}",
            f"joints:\n{drives}".rstrip() if drives else "",
            self.keys.rstrip(),
            f"graphs:\n{uses}".rstrip() if uses else "",
        ]
        self.put("bot.yaml", "\n".join(filter(None, parts)) + "\n")
        self.put("bot.urdf", f'<robot name="bot">{self.urdf}</robot>')
        self.put(
            "scene.yaml",
            "scene: s\nworld: worlds/flat_grid.xml\nrobots: {bot: {use: bot.yaml, position: [0, 0, 0.06]}}\n",
        )
        return self

    def graph(self, name: str, nodes: str, connections: str) -> None:
        """Write a graph of the robot and use it."""
        robot = "parameters: {robot: {type: target, default: /bot}}\nat: $(robot)/base_link/" + name
        text = f"graph: {name}\n{robot}\nnodes:\n{nodes}connections:\n{connections}"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.put(f"{name}.yaml", text)
        self.graphs[name] = f"{{use: {name}.yaml}}"

    def odometry(self, scale: float = 1.0, topic: str = "odom") -> None:
        """Publish the true odometry with all distances multiplied."""
        nodes = (
            "  Tick: OnPlaybackTick\n"
            "  Odometry: {type: IsaacComputeOdometry, inputs: {chassisPrim: $(robot)}}\n"
            f"  Scaled: {{type: Multiply, inputs: {{b: {{type: double, value: {scale}}}}}}}\n"
            f"  Publish: {{type: ROS2PublishOdometry, inputs: {{topicName: {topic}, chassisFrameId: base_link}}}}\n"
        )
        wires = (
            "  - Tick.tick -> Odometry.execIn\n"
            "  - Odometry.execOut -> Publish.execIn\n"
            "  - Odometry.position -> Scaled.a\n"
            "  - Scaled.product -> Publish.position\n"
            "  - Odometry.orientation -> Publish.orientation\n"
        )
        self.graph(topic, nodes, wires)

    def put(self, name: str, text: str) -> None:
        """Write one file."""
        (self.folder / name).write_text(text, encoding="utf-8")


def joints_node(name: str, joints: str) -> str:
    """A node that commands joints of the robot."""
    inputs = f"{{targetPrim: $(robot), jointNames: [{joints}]}}"
    return f"  {name}: {{type: IsaacArticulationController, inputs: {inputs}}}\n"


DRIVE = f"""graph: drive
at: $(robot)/base_link/drive
parameters:
  robot: {{type: target, default: /bot}}
  wheels: {{type: "token[]", default: [left_joint, right_joint]}}
  radius: {{type: double, default: {RADIUS}}}
  distance: {{type: double, default: {TRACK}}}
  topic: {{type: string, default: cmd_vel}}
nodes:
{_SUBSCRIBER.replace("topicName: cmd_vel", "topicName: $(topic)")}  DiffController:
    type: DifferentialController
    inputs: {{wheelRadius: $(radius), wheelDistance: $(distance), {_SPEEDS}}}
  Wheels: {{type: IsaacArticulationController, inputs: {{targetPrim: $(robot), jointNames: $(wheels)}}}}
connections:
{_TWIST}  - Tick.tick -> DiffController.execIn
  - Tick.deltaSeconds -> DiffController.dt
  - Linear.x -> DiffController.linearVelocity
  - Angular.z -> DiffController.angularVelocity
  - Tick.tick -> Wheels.execIn
  - DiffController.velocityCommand -> Wheels.velocityCommand
"""


def differential(folder: Path, *, radius: float = RADIUS, track: float = TRACK) -> Base:
    """Two wheels and a frictionless ball behind, driven by `DRIVE` with a radius and a track."""
    ball = link("ball", 0.1, '<sphere radius="0.03"/>') + joint(
        "ball_joint", "base_link", "ball", "-0.08 0 -0.02", "0 0 1", "fixed"
    )
    base = Base(folder, [("left", 0.0, TRACK / 2), ("right", 0.0, -TRACK / 2)], ball)
    base.keys = "materials:\n  Ball: {dynamic_friction: 0.0, combine: min, bind: [ball]}\n"
    parameters = f"wheels: [left_joint, right_joint], radius: {radius}, distance: {track}"
    base.folder.mkdir(parents=True, exist_ok=True)
    base.put("drive.yaml", DRIVE)
    base.graphs["drive"] = f"{{use: drive.yaml, parameters: {{{parameters}}}}}"
    return base


FOUR = (
    ("front_left", 0.15, 0.15),
    ("front_right", 0.15, -0.15),
    ("back_left", -0.15, 0.15),
    ("back_right", -0.15, -0.15),
)


def skid_steered(folder: Path) -> Base:
    """Four wheels that do not steer, with stiff drives, told their geometric track."""
    base = Base(folder, FOUR)
    base.drives = dict.fromkeys(base.drives, "{drive: {damping: 2000.0}}")
    nodes = _SUBSCRIBER + (
        "  Drive:\n"
        "    type: DifferentialController\n"
        "    inputs:\n"
        f"      wheelRadius: {RADIUS}     # of the description\n"
        f"      wheelDistance: {TRACK}\n"
    )
    nodes += joints_node("Front", "front_left_joint, front_right_joint")
    nodes += joints_node("Back", "back_left_joint, back_right_joint")
    wires = _TWIST + (
        "  - Tick.tick -> Drive.execIn\n"
        "  - Linear.x -> Drive.linearVelocity\n"
        "  - Angular.z -> Drive.angularVelocity\n"
        "  - Tick.tick -> Front.execIn\n"
        "  - Tick.tick -> Back.execIn\n"
        "  - Drive.velocityCommand -> Front.velocityCommand\n"
        "  - Drive.velocityCommand -> Back.velocityCommand\n"
    )
    base.graph("drive", nodes, wires)
    return base


def ackermann(folder: Path) -> Base:
    """Two steered wheels in front, two driven ones behind, commanded by AckermannDriveStamped."""
    knuckles = "".join(
        link(f"{side}_knuckle", 0.2)
        + joint(f"{side}_steering", "base_link", f"{side}_knuckle", f"0.15 {y} 0", "0 0 1")
        + wheel(f"front_{side}", 0.0, 0.0, f"{side}_knuckle")
        for side, y in (("left", 0.15), ("right", -0.15))
    )
    base = Base(folder, FOUR[2:], knuckles)
    base.wheels += ["front_left", "front_right"]
    base.drives |= {f"{side}_steering": "{drive: {stiffness: 500.0, damping: 20.0}}" for side in ("left", "right")}
    nodes = (
        "  Tick: OnPlaybackTick\n"
        "  Command: {type: ROS2SubscribeAckermannDrive, inputs: {topicName: ackermann_cmd}}\n"
        "  Car:\n"
        "    type: AckermannController\n"
        f"    inputs: {{wheelBase: 0.3, trackWidth: 0.3, backWheelRadius: {RADIUS}, maxWheelRotation: 0.6}}\n"
        "  Rear: {type: ArraySlice, inputs: {start: 2, end: 4, useLength: false}}\n"
    )
    nodes += joints_node("Steer", "left_steering, right_steering")
    nodes += joints_node("Drive", "back_left_joint, back_right_joint")
    wires = (
        "  - Tick.tick -> Command.execIn\n"
        "  - Tick.tick -> Car.execIn\n"
        "  - Command.speed -> Car.speed\n"
        "  - Command.steeringAngle -> Car.steeringAngle\n"
        "  - Car.wheelRotationVelocity -> Rear.array\n"
        "  - Car.execOut -> Steer.execIn\n"
        "  - Car.wheelAngles -> Steer.positionCommand\n"
        "  - Car.execOut -> Drive.execIn\n"
        "  - Rear.array -> Drive.velocityCommand\n"
    )
    base.graph("car", nodes, wires)
    return base


def mecanum(folder: Path) -> Base:
    """Four wheels that grip along the axes of their rollers, at 45 degrees, driven by graphs/base/mecanum.yaml."""
    base = Base(folder, FOUR)
    rollers = (("Left", -1.0, "front_left, back_right"), ("Right", 1.0, "front_right, back_left"))
    base.keys = "materials:\n" + "".join(
        f"  {name}: {{dynamic_friction: 0.8, across: 0.0, direction: [1.0, {y}, 0.0], bind: [{bound}]}}\n"
        for name, y, bound in rollers
    )
    wheels = ", ".join(f"{name}_joint" for name, _, _ in FOUR)
    positions = ", ".join(f"[{x}, {y}, 0.0]" for _, x, y in FOUR)
    geometry = f"wheels: [{wheels}], positions: [{positions}], rollers: [45.0, -45.0, -45.0, 45.0], radius: {RADIUS}"
    sides = "left: [front_left_joint, back_left_joint], right: [front_right_joint, back_right_joint]"
    odometry = f"{sides}, track: {TRACK}, wheelbase: {TRACK}, ticks: 0.0, slip: 0.0"
    base.graphs["base"] = f"{{use: graphs/base/mecanum.yaml, parameters: {{{geometry}, {odometry}}}}}"
    return base
