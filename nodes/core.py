"""Time, odometry, transforms, joints and sensors' plumbing (`isaacsim.core.nodes`)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graphengine import rotation
from graphengine.context import Articulation, Body, Clock, Context, FrameLink, JointSelection
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.types import (
    Double3s,
    Double4s,
    Doubles,
    Ints,
    Quaterniond,
    String,
    Target,
    Token,
    Tokens,
    UInt,
    UInt64,
    Vector3d,
)


class IsaacReadSimulationTime(Node, type="isaacsim.core.nodes.IsaacReadSimulationTime", volatile=True):
    """Simulation time; the same for everything that reads it in one tick."""

    reset_on_stop: bool = In(default=True, doc="seconds since play; else since the session began, over stop and play")
    reference_time_numerator: int = In(default=0, doc="if set, the time is this fraction")
    reference_time_denominator: UInt64 = In(default=0, doc="denominator of the reference time")
    simulation_time: float = Out(unit="s")

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock

    def compute(self) -> None:
        """Read the clock, or divide the reference time."""
        if self.reference_time_denominator > 0:
            self.simulation_time = self.reference_time_numerator / self.reference_time_denominator
        elif self.reset_on_stop:
            self.simulation_time = self.clock.time
        else:
            self.simulation_time = self.clock.monotonic_time


class OgnIsaacRunOneSimulationFrame(Node, type="isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame", gated=True):
    """Fires the first time it runs after play, and then no more."""

    exec_in = ExecIn()
    step = ExecOut(doc="fires once after play")

    done: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire once."""
        if self.done:
            return None
        self.done = True
        return self.step


class IsaacCreateRenderProduct(Node, type="isaacsim.core.nodes.IsaacCreateRenderProduct", gated=True):
    """Binds a camera or lidar prim to a path that helpers take."""

    exec_in = ExecIn()
    width: UInt = In(default=1280, setup=True, unit="pixel")
    height: UInt = In(default=720, setup=True, unit="pixel")
    camera_prim: Target = In(required=True, setup=True, doc="prim of the camera or lidar")
    enabled: bool = In(default=True, doc="when false, nothing fires")
    render_product_prim: Target = In(setup=True, doc="a render product to use as it is")
    render_product_path: Token = Out(doc="what helpers take")
    exec_out = ExecOut()

    path: str = State()

    def setup(self, context: Context) -> None:
        """Make the path, so that helpers know it before the first tick."""
        if self.render_product_prim:
            self.path = self.render_product_prim[0]
        else:
            self.path = context.render_product(self.camera_prim[0], self.width, self.height)
        self.render_product_path = self.path

    def compute(self) -> Fire:
        """Hand the path on."""
        if not self.enabled:
            return None
        self.render_product_path = self.path
        return self.exec_out


class IsaacComputeOdometry(Node, type="isaacsim.core.nodes.IsaacComputeOdometry"):
    """Pose since play and velocities of a body: ground truth, without noise.

    Position and orientation are those of the body in the frame it had at the first compute after play. Linear velocity is in
    the body's frame, angular velocity in the world's; accelerations are differences of the velocities over simulation time.
    """

    exec_in = ExecIn()
    chassis_prim: Target = In(required=True, setup=True, doc="rigid body, or a prim that one carries")
    exec_out = ExecOut()
    position: Vector3d = Out(unit="m", doc="in the start frame")
    orientation: Quaterniond = Out(default=(0.0, 0.0, 0.0, 1.0), doc="(x, y, z, w), relative to the start")
    linear_velocity: Vector3d = Out(unit="m/s", doc="in the body's frame")
    angular_velocity: Vector3d = Out(unit="rad/s", doc="in the world frame")
    linear_acceleration: Vector3d = Out(unit="m/s2", doc="of the linear velocity in the body's frame")
    angular_acceleration: Vector3d = Out(unit="rad/s2", doc="of the angular velocity in the world frame")
    global_linear_velocity: Vector3d = Out(unit="m/s", doc="in the world frame")
    global_linear_acceleration: Vector3d = Out(unit="m/s2", doc="in the world frame")

    body: Body = State()
    clock: Clock = State()
    start: tuple[Vector3d, Quaterniond] | None = State(default=None)
    last_time: float = State(default=math.nan)

    def setup(self, context: Context) -> None:
        """Bind the body."""
        self.body = context.body(self.chassis_prim[0])
        self.clock = context.clock

    def compute(self) -> None:
        """Read the body's state and put it into its frames."""
        position, orientation = self.body.pose()
        velocity, angular = self.body.velocity()
        if self.start is None:
            self.start = (position, orientation)
        (x0, y0, z0), start = self.start
        x, y, z = position
        self.position = rotation.unrotate(start, (x - x0, y - y0, z - z0))
        self.orientation = rotation.multiply(rotation.conjugate(start), orientation)
        local = rotation.unrotate(orientation, velocity)
        elapsed = self.clock.time - self.last_time
        if elapsed > 0.0:
            self.linear_acceleration = _slope(local, self.linear_velocity, elapsed)
            self.global_linear_acceleration = _slope(velocity, self.global_linear_velocity, elapsed)
            self.angular_acceleration = _slope(angular, self.angular_velocity, elapsed)
        self.last_time = self.clock.time
        self.linear_velocity, self.global_linear_velocity, self.angular_velocity = local, velocity, angular


def _slope(now: Vector3d, before: Vector3d, elapsed: float) -> Vector3d:
    return (now[0] - before[0]) / elapsed, (now[1] - before[1]) / elapsed, (now[2] - before[2]) / elapsed


_HALF_TURN_ABOUT_X = (1.0, 0.0, 0.0, 0.0)


class IsaacComputeTransformTree(Node, type="isaacsim.core.nodes.IsaacComputeTransformTree"):
    """Poses of prims relative to a parent prim; a robot gives all of its links."""

    exec_in = ExecIn()
    parent_prim: Target = In(setup=True, doc="prim of the parent frame; empty for the world")
    target_prims: Target = In(required=True, setup=True, doc="robots, links, sensors, frames")
    exec_out = ExecOut()
    parent_frames: Tokens = Out(doc="names of the parent frames")
    child_frames: Tokens = Out(doc="names of the child frames")
    translations: Double3s = Out(unit="m")
    orientations: Double4s = Out(doc="(x, y, z, w)")

    links: Sequence[FrameLink] = State()
    names: tuple[tuple[str, ...], tuple[str, ...]] = State()
    constant: tuple[Double3s, Double4s] | None = State()

    def setup(self, context: Context) -> None:
        """Expand the targets; the names are known before the first tick."""
        self.links = context.transform_tree(self.target_prims, self.parent_prim[0] if self.parent_prim else "")
        self.names = tuple(link.parent_name for link in self.links), tuple(link.child_name for link in self.links)
        self.parent_frames, self.child_frames = self.names
        self.constant = self.read_poses() if all(link.fixed is not None for link in self.links) else None

    def compute(self) -> None:
        """Read all poses."""
        self.parent_frames, self.child_frames = self.names
        self.translations, self.orientations = self.constant or self.read_poses()

    def read_poses(self) -> tuple[Double3s, Double4s]:
        """Translations and orientations of all edges, now."""
        poses = [pose_of(link) for link in self.links]
        translations = np.array([position for position, _ in poses]).reshape(-1, 3)
        return translations, np.array([orientation for _, orientation in poses]).reshape(-1, 4)


def pose_of(link: FrameLink) -> rotation.Pose:
    """Pose of an edge's child in its parent's frame, now."""
    if link.fixed is not None:
        position, orientation = link.fixed
    else:
        position, orientation = link.child.pose()
        if link.parent is not None:
            position, orientation = rotation.relative(link.parent.pose(), (position, orientation))
    return position, rotation.multiply(orientation, _HALF_TURN_ABOUT_X) if link.optical else orientation


class IsaacArticulationController(Node, type="isaacsim.core.nodes.IsaacArticulationController"):
    """Joint targets from arrays; they act from the next physics step on, and hold until the next command."""

    exec_in = ExecIn()
    target_prim: Target = In(required="robot", setup=True, doc="prim that stands for the robot")
    robot_path: String = In(default="", required="robot", setup=True, doc="the same as text; wins over targetPrim")
    joint_names: Tokens = In(doc="joints that the arrays are for; empty for all, or by index")
    joint_indices: Ints = In(doc="joints by number, where no names are given")
    position_command: Doubles = In(unit="rad, m", doc="one a joint; NaN leaves a joint alone")
    velocity_command: Doubles = In(unit="rad/s, m/s", doc="one a joint; NaN leaves a joint alone")
    effort_command: Doubles = In(unit="N m, N", doc="one a joint; NaN leaves a joint alone")

    articulation: Articulation = State()
    selection: JointSelection | None = State(default=None)
    selected: tuple[object, object] = State(default=((), ()))

    def setup(self, context: Context) -> None:
        """Bind the robot, and the joints that are known by now."""
        self.articulation = context.articulation(self.robot_path or self.target_prim[0])
        self.select()

    def select(self) -> JointSelection:
        """Bind the joints."""
        self.selected = (self.joint_names, self.joint_indices)
        self.selection = self.articulation.select(self.joint_names, self.joint_indices.tolist())
        return self.selection

    def compute(self) -> None:
        """Apply the commands, all or none."""
        selection = self.selection
        if selection is None or self.selected[0] is not self.joint_names or self.selected[1] is not self.joint_indices:
            selection = self.select()
        position, velocity, effort = self.position_command, self.velocity_command, self.effort_command
        joints = len(selection.names)
        for name, command in (("positionCommand", position), ("velocityCommand", velocity), ("effortCommand", effort)):
            if len(command) not in (0, joints):
                path = self.articulation.prim_path
                raise ValueError(f"{name} has {len(command)} values for {joints} joints of {path}; nothing was applied")
        selection.command(position.tolist() or None, velocity.tolist() or None, effort.tolist() or None)
