"""The controller of bases with two driven wheels on one axle, and the lint that compares its inputs with the robot's geometry."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from graphengine.compiler.lint_registry import lint
from graphengine.format.errors import BadValueError
from graphengine.node import Doubles, ExecIn, In, Node, Out, State
from graphengine.nodes.checked import check_outcome
from graphengine.nodes.core.articulation import IsaacArticulationController, robot_of
from graphengine.nodes.known_inputs import LENGTHS
from graphengine.nodes.wheeled_robots.geometry_check import Effects, compare_geometry
from graphengine.nodes.wheeled_robots.limits import limited, ramped

if TYPE_CHECKING:
    from graphengine.compiler.graph import Instance
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.devices.stage import Prim


class DifferentialController(Node, type="isaacsim.robot.wheeled_robots.DifferentialController"):
    """Computes the wheel speeds of a base with two driven wheels from the twist of the base.

    The wheel speeds are (2v - w d) / 2r on the left and (2v + w d) / 2r on the right, where r is `wheelRadius`, d is
    `wheelDistance`, and v and w are `linearVelocity` and `angularVelocity` after limits and ramps. The acceleration of v is
    limited only if neither `maxAcceleration` nor `maxDeceleration` is 0. A limit of 0 means no limit. The sign of a wired
    radius, distance or limit is ignored. Changed inputs take effect at the next execution.
    """

    exec_in = ExecIn()
    wheel_radius: float = In(gt=0.0, required=True, unit="m", doc="radius r of the wheels")
    wheel_distance: float = In(gt=0.0, required=True, unit="m", doc="distance d between the wheels' contact points")
    dt: float = In(default=0.0, ge=0.0, unit="s", doc="time between two executions; needed for acceleration limits")
    max_acceleration: float = In(
        default=0.0,
        ge=0.0,
        unit="m/s2",
        doc="limit of the acceleration while the base speeds up; no limit if `maxAcceleration` or `maxDeceleration` is 0",
    )
    max_deceleration: float = In(
        default=0.0,
        ge=0.0,
        unit="m/s2",
        doc="limit of the deceleration while the base slows down; no limit if `maxAcceleration` or `maxDeceleration` is 0",
    )
    max_angular_acceleration: float = In(
        default=0.0, ge=0.0, unit="rad/s2", doc="limit of the angular acceleration; 0: none"
    )
    max_linear_speed: float = In(default=0.0, ge=0.0, unit="m/s", doc="largest speed of the base; 0: no limit")
    max_angular_speed: float = In(default=0.0, ge=0.0, unit="rad/s", doc="largest turn rate of the base; 0: no limit")
    max_wheel_speed: float = In(default=0.0, ge=0.0, unit="rad/s", doc="largest speed of a wheel; 0: no limit")
    scale_wheel_speeds: bool = In(
        default=False,
        extension=True,
        doc="true: if a wheel exceeds `maxWheelSpeed`, v and w are scaled down, so that the base keeps the radius of its turn; "
        "false: each wheel is limited, as in Isaac Sim",
    )
    linear_velocity: float = In(default=0.0, unit="m/s", doc="forward velocity of the base")
    angular_velocity: float = In(default=0.0, unit="rad/s", doc="turn rate of the base, counter-clockwise")
    velocity_command: Doubles = Out(default=[0.0, 0.0], unit="rad/s", doc="wheel speeds: [left, right]")

    previous_linear: float = State(default=0.0)
    previous_angular: float = State(default=0.0)

    def compute(self) -> None:
        """Apply limits and ramps to the twist, then compute and output the wheel speeds.

        Raises:
            BadValueError: the wheel radius or the wheel distance is 0, an acceleration limit needs `dt` but `dt` is not above 0,
                or a number is not finite.
        """
        radius, distance = abs(self.wheel_radius), abs(self.wheel_distance)
        if not (radius and distance):
            raise BadValueError("wheelDistance" if radius else "wheelRadius", 0.0, "other than 0")
        if self.dt <= 0.0 and (self.max_acceleration or self.max_deceleration or self.max_angular_acceleration):
            legal = "above 0 for acceleration limits (wire deltaSeconds of OnPlaybackTick to dt)"
            raise BadValueError(_RAMPS, self.dt, legal)
        linear = limited(self.linear_velocity, abs(self.max_linear_speed))
        angular = limited(self.angular_velocity, abs(self.max_angular_speed))
        share = self.feasible_share(linear, angular)
        linear, angular = linear * share, angular * share
        if self.max_acceleration and self.max_deceleration:
            faster = abs(linear) > abs(self.previous_linear) and linear * self.previous_linear >= 0.0
            slope = abs(self.max_acceleration if faster else self.max_deceleration)
            linear = ramped(self.previous_linear, linear, slope, self.dt)
        angular = ramped(self.previous_angular, angular, abs(self.max_angular_acceleration), self.dt)
        limit = abs(self.max_wheel_speed)
        share = self.feasible_share(linear, angular)  # v and w may change at different rates
        left = limited((2.0 * linear - angular * distance) * share / (2.0 * radius), limit)
        right = limited((2.0 * linear + angular * distance) * share / (2.0 * radius), limit)
        check_outcome(self, linear, angular, left, right)
        self.previous_linear, self.previous_angular = linear, angular
        self.velocity_command = np.array((left, right))

    def feasible_share(self, linear: float, angular: float) -> float:
        """Return the factor that scales a twist to wheel speeds of at most `maxWheelSpeed`; 1 without scaling."""
        most = abs(self.max_wheel_speed * self.wheel_radius)
        if not (self.scale_wheel_speeds and most):
            return 1.0
        return most / max(abs(linear) + abs(angular * self.wheel_distance) / 2.0, most)


LENGTHS[DifferentialController] = lambda *_: 2
_RAMPS = "dt, maxAcceleration, maxDeceleration, maxAngularAcceleration"
_EFFECTS: Effects = (
    lambda factor: f"the robot will drive at {1.0 / factor:.3g} times the commanded speed",
    lambda factor: f"the robot will turn at {factor:.3g} times the commanded turn rate",
)


@lint("W201")
def lint_wheel_geometry(context: LintContext) -> None:
    """Warn if `wheelRadius` or `wheelDistance` of a controller differs from the geometry of the robot that it drives."""
    for controller, node, robot, joints in _driven(context):
        compare_geometry(context, controller, node, robot, joints, _EFFECTS)


def _driven(context: LintContext) -> Iterator[tuple[Instance, DifferentialController, Prim, tuple[str, ...]]]:
    """Yield each controller that drives a robot through an IsaacArticulationController.

    Each item consists of the controller's instance, its node with the initial inputs, the robot, and the names of its joints.
    """
    for graph, source, node in context.nodes(DifferentialController):
        for wire in (wire for wire in graph.data_wires if wire.source == source.index):
            drives = graph.instances[wire.target].make_node()
            if not isinstance(drives, IsaacArticulationController):
                continue
            robot = robot_of(context, drives)
            if robot is not None:
                yield source, node, robot, drives.joint_names or tuple(robot.facts.get("joints", ()))
