"""The node that reads the wheel geometry of a base with omnidirectional or mecanum wheels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graphengine.devices.holonomic_wheels import HolonomicWheel
from graphengine.devices.rotation import Pose, Quaternion, Vector3, relative, rotate
from graphengine.node import Bound, Context, ContextError, Double3, Double3s, Double4s, Doubles, In, Node, Out
from graphengine.node.types import Target, Token, Tokens, read_only

_AXLE = (0.0, 1.0, 0.0)
"""Direction of the axle in the wheel's frame, the same for all wheels."""


class HolonomicRobotUsdSetup(Node, type="isaacsim.robot.wheeled_robots.HolonomicRobotUsdSetup"):
    """Outputs the wheel geometry of a base with omnidirectional or mecanum wheels.

    Wire the outputs to the inputs of the same names of a HolonomicController with `rolling: true`. The outputs describe all
    wheels that have rollers. A wheel has rollers if its material in the robot file has different friction in two directions; the
    axis of the roller on the floor is the direction of the greater friction. The radius of a wheel is the radius of its collider.
    Positions and orientations are those of the wheel joints with all joints at zero. Isaac Sim instead reads radii and roller
    angles from the attributes `isaacmecanumwheel:radius` and `isaacmecanumwheel:angle` of wheel joints.

    Positions are relative to `comPrim`, with components along the axes of `comPrim`; Isaac Sim uses the axes of the world frame.
    `wheelAxis` is always the y axis, and the orientation of a wheel rotates the y axis to the axle of the wheel.
    """

    robot_prim: Target = In(setup=True, doc="the robot's prim, base link or articulation root")
    com_prim: Target = In(setup=True, doc="prim at the base's centre, frame of the outputs; if empty, the base link")
    use_path: bool = In(
        default=False,
        setup=True,
        doc="true: `robotPrimPath` and `comPrimPath` select the prims; false: `robotPrim` and `comPrim` select them",
    )
    robot_prim_path: Token = In(default="", setup=True, doc="path of the robot's prim; used if `usePath` is true")
    com_prim_path: Token = In(
        default="",
        setup=True,
        doc="path of the prim at the base's centre, used if `usePath` is true; if empty, the base link",
    )
    wheel_radius: Doubles = Out(unit="m", doc="radius of each wheel")
    wheel_positions: Double3s = Out(unit="m", doc="position of each wheel in the frame of `comPrim`")
    wheel_orientations: Double4s = Out(doc="orientation (w, x, y, z) of each wheel in the frame of `comPrim`")
    mecanum_angles: Doubles = Out(
        unit="deg", doc="for each wheel, angle from the axle to the roller axis about `upAxis`, above -90 and up to 90"
    )
    wheel_axis: Double3 = Out(doc="direction of the axle in the wheel's frame: the y axis for all wheels")
    up_axis: Double3 = Out(doc="up direction of the base in the frame of `comPrim`")
    wheel_dof_names: Tokens = Out(doc="names of the wheels' joints, for IsaacArticulationController")

    wheels: Sequence[HolonomicWheel] = Bound()
    base: Pose = Bound()

    def setup(self, context: Context) -> None:
        """Look up the wheels of the robot, and the pose of its base link relative to the prim at the centre of the base.

        Raises:
            ContextError: no robot is selected, or no wheel of the robot has rollers.
        """
        robot = self.robot_prim_path if self.use_path else next(iter(self.robot_prim), "")
        centre = self.com_prim_path if self.use_path else next(iter(self.com_prim), "")
        if not robot:
            name = "robotPrimPath" if self.use_path else "robotPrim"
            raise ContextError(f"{name} is empty", "", f"set {name}, because usePath is {str(self.use_path).lower()}")
        self.wheels = context.holonomic_wheels(robot)
        if not self.wheels:
            raise ContextError(
                f"no wheel of {robot} has rollers",
                robot,
                "give the materials of mecanum wheels `direction` and `across` in the robot file",
                "or write the geometry as literals into the inputs of HolonomicController",
            )
        link = context.base_link(robot)
        self.base = relative((context.frame(centre) if centre else link).pose(), link.pose())

    def compute(self) -> None:
        """Transform the wheels into the frame of the centre of the base and output their geometry."""
        wheels, (origin, turn) = self.wheels, self.base
        places = [np.add(origin, rotate(turn, wheel.position)) for wheel in wheels]
        turns = [_from_axle(rotate(turn, wheel.axle)) for wheel in wheels]
        self.wheel_radius = read_only(np.array([wheel.radius for wheel in wheels]))
        self.wheel_positions = read_only(np.array(places))
        self.wheel_orientations = read_only(np.array([(w, x, y, z) for x, y, z, w in turns]))
        self.mecanum_angles = read_only(np.array([wheel.roller_angle for wheel in wheels]))
        self.wheel_axis, self.up_axis = _AXLE, rotate(turn, (0.0, 0.0, 1.0))
        self.wheel_dof_names = tuple(wheel.joint for wheel in wheels)


def _from_axle(axle: Vector3) -> Quaternion:
    """Return the shortest rotation from the y axis to a unit vector; for -y, a half turn about the z axis."""
    x, y, z = axle
    across = math.hypot(x, z)
    half = math.atan2(across, y) / 2.0
    i, k = (z / across, -x / across) if across else (0.0, 1.0)
    return i * math.sin(half), 0.0, k * math.sin(half), math.cos(half)
