"""The node that computes ground-truth odometry from the state of the simulation (`isaacsim.core.nodes`)."""

from __future__ import annotations

import math
from collections.abc import Iterable

from graphengine.devices import rotation
from graphengine.devices.motion import Body
from graphengine.devices.rotation import Pose
from graphengine.format.prim_paths import at_or_below
from graphengine.node import Bound, Clock, Context, ExecIn, ExecOut, In, Node, Out, Quaterniond, State, Target, Vector3d
from graphengine.nodes.touched import reading_poses


class IsaacComputeOdometry(Node, type="isaacsim.core.nodes.IsaacComputeOdometry"):
    """Computes the ground-truth odometry of a body: its pose relative to its start pose, its velocities and its accelerations.

    The start pose is the body's pose at the first execution after play. When a command moves the robot, the start pose moves with
    the robot: the output pose does not jump (REP 105). If the command says that odometry jumps, the start pose stays.
    Accelerations are differences between the velocities at this execution and at the previous execution, divided by the
    simulation time between the two executions.
    """

    exec_in = ExecIn()
    chassis_prim: Target = In(required=True, setup=True, doc="prim of a rigid body, or prim that is fixed to one")
    exec_out = ExecOut()
    position: Vector3d = Out(unit="m", doc="position of the body in the frame of its start pose")
    orientation: Quaterniond = Out(default=(0.0, 0.0, 0.0, 1.0), doc="rotation (x, y, z, w) from the start pose")
    linear_velocity: Vector3d = Out(unit="m/s", doc="velocity in the body's frame")
    angular_velocity: Vector3d = Out(unit="rad/s", doc="angular velocity in the world frame")
    linear_acceleration: Vector3d = Out(
        unit="m/s2",
        doc="time derivative of the components of `linearVelocity`; it lacks the term ω x v, so it is 0 on a circle at "
        "constant speed",
    )
    angular_acceleration: Vector3d = Out(unit="rad/s2", doc="time derivative of `angularVelocity`, in the world frame")
    global_linear_velocity: Vector3d = Out(unit="m/s", doc="velocity in the world frame")
    global_linear_acceleration: Vector3d = Out(unit="m/s2", doc="time derivative of `globalLinearVelocity`")

    body: Body = Bound()
    clock: Clock = Bound()
    start: tuple[Vector3d, Quaterniond] | None = State(default=None)
    last_time: float = State(default=math.nan)

    def setup(self, context: Context) -> None:
        """Look up the body of `chassisPrim`. The pose of the body at the next execution becomes the start pose."""
        self.body, self.clock = context.body(self.chassis_prim[0]), context.clock
        self.start, self.last_time = None, math.nan

    def compute(self) -> None:
        """Output the current pose, velocities and accelerations of the body."""
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

    def carry(self, entity: str, before: Pose, after: Pose) -> None:
        """Move the start pose along with an entity that a command has moved, if the body belongs to the entity.

        Args:
            entity: prim path of the entity.
            before: pose of the entity in the world frame before the command.
            after: pose of the entity in the world frame after the command.
        """
        if self.start is not None and at_or_below(self.chassis_prim[0], entity):
            self.start = rotation.compose(after, rotation.relative(before, self.start))

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the body's pose."""
        return reading_poses(self.chassis_prim)


def _slope(now: Vector3d, before: Vector3d, elapsed: float) -> Vector3d:
    return (now[0] - before[0]) / elapsed, (now[1] - before[1]) / elapsed, (now[2] - before[2]) / elapsed
