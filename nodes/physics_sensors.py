"""Nodes that read IMUs, contact sensors, joint efforts and joint states (`isaacsim.sensors.physics`)."""

from __future__ import annotations

import numpy as np

from graphengine.devices.contact import ContactSensor
from graphengine.devices.imu import Imu
from graphengine.devices.motion import Articulation
from graphengine.node import Bound, Clock, Context, ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.node.types import Doubles, Float, Quaterniond, Target, Tokens, UChars, Vector3d


class IsaacReadIMU(Node, type="isaacsim.sensors.physics.IsaacReadIMU", gated=True):
    """Outputs the newest sample of an IMU. Fires only if the IMU has a new sample since the last execution.

    `linAcc` and `angVel` are means over the time since the previous sample; `orientation` is the orientation at the time of the
    sample. To get every sample of an IMU whose rate is above the tick rate, use a graph with `runs: physics_step`.
    """

    exec_in = ExecIn()
    imu_prim: Target = In(required=True, setup=True, doc="prim of the IMU")
    use_latest_data: bool = In(default=False, doc="no effect; Isaac Sim ignores this input too")
    read_gravity: bool = In(default=True, doc="true: `linAcc` includes gravity, as an accelerometer measures it")
    exec_out = ExecOut()
    sensor_time: Float = Out(unit="s", doc="simulation time of the sample")
    lin_acc: Vector3d = Out(
        unit="m/s2", doc="acceleration in the sensor's frame; upright at rest (0, 0, 9.81), or 0 without gravity"
    )
    ang_vel: Vector3d = Out(unit="rad/s", doc="angular velocity in the sensor's frame")
    orientation: Quaterniond = Out(default=(0.0, 0.0, 0.0, 1.0), doc="orientation (x, y, z, w) in the world frame")

    imu: Imu = Bound()
    last: int = State(default=-1)

    def setup(self, context: Context) -> None:
        """Look up the IMU at `imuPrim` and keep its handle."""
        self.imu = context.device(Imu, self.imu_prim[0])

    def compute(self) -> Fire:
        """If the IMU has a new sample, output it and fire."""
        sample = self.imu.sample()
        if sample.index == self.last:
            return None
        self.last = sample.index
        x, y, z = sample.linear_acceleration
        u, v, w = sample.gravity if self.read_gravity else (0.0, 0.0, 0.0)
        self.lin_acc = (x + u, y + v, z + w)
        self.sensor_time, self.ang_vel, self.orientation = sample.time, sample.angular_velocity, sample.orientation
        return self.exec_out


class IsaacReadContactSensor(Node, type="isaacsim.sensors.physics.IsaacReadContactSensor"):
    """Reads the mean contact force over the tick, or over the physics step in a graph with `runs: physics_step`."""

    exec_in = ExecIn()
    cs_prim: Target = In(required=True, setup=True, doc="prim of the contact sensor")
    use_latest_data: bool = In(default=False, doc="no effect; Isaac Sim ignores this input too")
    exec_out = ExecOut()
    sensor_time: Float = Out(default=0.0, unit="s", doc="simulation time of the reading")
    in_contact: bool = Out(default=False, doc="whether the contact force reaches the sensor's threshold")
    value: Float = Out(default=0.0, unit="N", doc="magnitude of the sum of contact forces; 0 below the threshold")

    sensor: ContactSensor = Bound()

    def setup(self, context: Context) -> None:
        """Look up the contact sensor at `csPrim` and keep its handle."""
        self.sensor = context.device(ContactSensor, self.cs_prim[0])

    def compute(self) -> None:
        """Output the reading of the contact sensor."""
        reading = self.sensor.reading()
        self.sensor_time, self.in_contact, self.value = reading.time, reading.in_contact, reading.force


class IsaacReadEffortSensor(Node, type="isaacsim.sensors.physics.IsaacReadEffortSensor"):
    """Reads the effort of a joint: the effort of its drive plus the commanded effort. IsaacReadJointState outputs the same value.

    In Isaac Sim, the effort also includes the efforts of the joint's limits, friction and springs.
    """

    exec_in = ExecIn()
    prim: Target = In(required=True, setup=True, doc="prim of the joint, such as `/robot/Physics/elbow`")
    use_latest_data: bool = In(default=False, doc="no effect; Isaac Sim ignores this input too")
    enabled: bool = In(default=True, doc="no effect; Isaac Sim ignores this input too")
    sensor_period: Float = In(default=0.0, unit="s", doc="no effect; Isaac Sim ignores this input too")
    exec_out = ExecOut()
    sensor_time: Float = Out(default=0.0, unit="s", doc="simulation time of the reading")
    value: Float = Out(default=0.0, unit="N m, N", doc="effort of the joint's drive plus commanded effort")

    articulation: Articulation = Bound()
    index: int = Bound()
    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Look up the joint at `prim`, and keep its robot and its index among the robot's joints."""
        self.articulation, self.index = context.joint(self.prim[0])
        self.clock = context.clock

    def compute(self) -> None:
        """Output the current effort of the joint and the simulation time."""
        self.sensor_time = self.clock.time
        self.value = float(self.articulation.efforts()[self.index])


class IsaacReadJointState(Node, type="isaacsim.sensors.physics.IsaacReadJointState"):
    """Reads the state of all movable joints of a robot, for ROS2PublishJointState.

    `jointNames` are the names in the robot description, also for joints with an `isaac:nameOverride`.
    """

    exec_in = ExecIn()
    prim: Target = In(required=True, setup=True, doc="prim of the robot")
    exec_out = ExecOut()
    sensor_time: Float = Out(unit="s", doc="simulation time of the reading")
    joint_names: Tokens = Out(doc="names of the joints in the robot description, in the order of the other arrays")
    joint_positions: Doubles = Out(unit="rad, m")
    joint_velocities: Doubles = Out(unit="rad/s, m/s")
    joint_efforts: Doubles = Out(unit="N m, N", doc="for each joint, effort of its drive plus commanded effort")
    joint_dof_types: UChars = Out(doc="type of each joint: 0 for revolute, 1 for prismatic")
    stage_meters_per_unit: Float = Out(
        default=0.0, unit="m", doc="length of a stage unit: 1 m; the output is 0 before the first execution"
    )

    articulation: Articulation = Bound()
    clock: Clock = Bound()
    dof_types: UChars = Bound()

    def setup(self, context: Context) -> None:
        """Look up the robot at `prim` and keep a handle to its joints."""
        self.articulation, self.clock = context.articulation(self.prim[0]), context.clock
        self.dof_types = np.array(self.articulation.prismatic, np.uint8)

    def compute(self) -> None:
        """Output the current state of the joints and the simulation time."""
        robot = self.articulation
        self.sensor_time = self.clock.time
        self.joint_names, self.joint_dof_types = robot.joint_names, self.dof_types
        self.joint_positions, self.joint_velocities = robot.positions(), robot.velocities()
        self.joint_efforts = robot.efforts()
        self.stage_meters_per_unit = 1.0
