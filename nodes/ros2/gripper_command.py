"""A gripper controller node: an action server that moves the fingers of a robot with limited effort."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.devices.backend import joint_numbers
from graphengine.format.errors import ContextError
from graphengine.messages.actions import Goal
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Bound, Context, Fire, In, State
from graphengine.node.types import String, Token, Tokens
from graphengine.nodes.ros2.robot_action import RobotActionNode, message

_TYPES = ("GripperCommand", "ParallelGripperCommand")
_LARGEST = 1e6
"""Maximum magnitude of the position, effort and velocity of a goal."""
_APPROACH = 4.0
"""Minimum number of ticks to the target at the velocity set point, which is kept low enough if the effort is limited."""


class ROS2GripperCommand(RobotActionNode, type="graphengine.ros2.ROS2GripperCommand", gated=True):
    """Moves a gripper, like gripper_controllers and parallel_gripper_controller of ros2_controllers.

    A goal is a position of the joint `jointName`; fingers whose joints mimic this joint move with it. Wire the outputs to an
    IsaacArticulationController. If a maximum effort is set, the position set point stays so close to the finger that the drive's
    spring exerts at most this effort. In this case the node keeps commanding the joint after the goal has ended, so that the
    gripper holds an object with this effort.

    A goal succeeds when the finger's position is within `goalTolerance` of the goal. If the finger rests for `stallTimeout`
    before it reaches the goal, for example on an object, the goal ends and its result has `stalled` set: the goal succeeds if
    `allowStalling` is true, otherwise it is aborted. A new goal aborts the current goal. If a goal is canceled, the finger holds
    its position. To let a gripper press against the limit of its own joint, give its drive `overtravel` in the robot file:
    position set points can exceed the limit by this distance. Goals for another joint, and goals with numbers that are not
    finite, are rejected.
    """

    joint_name: String = In(
        default="", required=True, setup=True, doc="joint that moves the fingers; must not be a mimic joint"
    )
    action_name: String = In(default="gripper_controller/gripper_cmd", setup=True, doc="name of the gripper's action")
    action_type: Token = In(
        default="GripperCommand", setup=True, tokens=_TYPES, doc="name of the action type in the package control_msgs"
    )
    max_effort: float = In(
        default=0.0, ge=0.0, unit="N m, N", doc="maximum effort of goals without effort; 0: only the drive limits it"
    )
    goal_tolerance: float = In(default=0.01, ge=0.0, unit="rad, m", doc="position error up to which a goal succeeds")
    allow_stalling: bool = In(
        default=False,
        doc="true: a goal succeeds if the finger stalls, for example on an object; false: the goal is aborted",
    )
    stall_timeout: float = In(
        default=1.0, ge=0.0, unit="s", doc="time at rest after which the finger counts as stalled and the goal ends"
    )
    stall_velocity_threshold: float = In(
        default=0.001, ge=0.0, unit="rad/s, m/s", doc="maximum speed at which the finger counts as resting"
    )

    index: int = Bound()
    published: str = Bound()
    target: float | None = State(default=None)
    moving: Tokens = State(default=())
    effort: float = State(default=math.inf)
    speed: float = State(default=math.inf)
    set_point: float = State(default=0.0)
    moved: float = State(default=0.0)

    def setup(self, context: Context) -> None:
        """Look up the joint `jointName`, and create the action server `actionName`."""
        self.bind(context, f"control_msgs/action/{self.action_type}", self.action_name)
        robot = self.articulation
        (self.index,) = joint_numbers(robot, [self.joint_name])
        self.published = context.joint_names(self.prim())[self.index]
        if leader := robot.leaders[self.index]:
            raise ContextError(
                f"jointName is the mimic joint {self.joint_name!r}, which follows {leader!r}",
                self.joint_name,
                f"set jointName to {leader}",
            )
        self.commanded = (self.joint_name,)

    def compute(self) -> Fire:
        """Start the goals that arrived in this tick, and move the finger towards its target."""
        fired = None
        lost_goal = self.goal is not None and not self.goal.active
        if lost_goal or (self.target is not None and self.moving != self.commanded):
            fired = self.hold()  # the node was set up again
        for goal in self.server.goals():
            self.begin(goal)
        if self.goal is not None and self.goal.cancel_requested:
            self.goal.canceled(self.result(stalled=False, reached=False))
            fired = self.hold()
        elif self.target is not None:
            fired = self.move(self.target)
        self.server.update()
        return fired

    def begin(self, goal: Goal) -> None:
        """Accept a new goal and abort the current one, or reject the new goal and log the reason if it is invalid."""
        try:
            position, effort, speed = self.read(goal.message.command)
        except ValueError as error:
            self.logger.log("warning", f"{self.server.action}: {error}")
            goal.reject()
            return
        goal.accept()
        if self.goal is not None:
            self.goal.abort(self.result(stalled=False, reached=False))
        at = self.articulation.set_points()[0][self.index]
        if self.target is None:
            self.set_point = float(at if np.isfinite(at) else self.articulation.positions()[self.index])
        lowest, highest = self.articulation.target_ranges[self.index]
        # The last goal may have been beyond the joint's range.
        self.set_point = min(max(self.set_point, lowest), highest)
        self.goal, self.target, self.moved = goal, position, self.clock.time
        self.moving = self.commanded
        self.effort, self.speed = effort or self.max_effort or math.inf, speed or math.inf

    def read(self, command: Any) -> tuple[float, float, float]:
        """Return the position, effort and velocity of a goal, in SI units.

        An effort of 0 selects the default of the node; a velocity of 0 means no limit.

        Raises:
            ValueError: the goal is invalid; the message says why.
        """
        if self.action_type == _TYPES[0]:
            numbers = command.position, abs(command.max_effort), 0.0
        else:
            position, effort, velocity = command.position, command.effort, command.velocity
            if len(position) != 1 or len(velocity) > 1 or len(effort) > 1:
                legal = "one position, and at most one velocity and effort"
                raise ValueError(f"a goal has {legal}; this one has {len(position)} positions")
            if list(command.name) not in ([], [self.published]):
                raise ValueError(f"the goal is for another joint; the gripper's joint is {self.published}")
            numbers = float(position[0]), abs(next(iter(effort), 0.0)), abs(next(iter(velocity), 0.0))
        if not all(abs(number) <= _LARGEST for number in numbers):  # false for NaN
            raise ValueError(f"position, effort and velocity must be finite, with a magnitude up to {_LARGEST:g}")
        return numbers

    def move(self, target: float) -> Fire:
        """Output the next set point, and end the goal if the finger arrived or stalled; return the port to fire."""
        robot, index, now = self.articulation, self.index, self.clock.time
        position, speed = robot.positions()[index], abs(robot.velocities()[index])
        step = self.speed * self.clock.delta
        self.set_point += min(max(target - self.set_point, -step), step)
        reach = self.effort / robot.stiffness[index] if robot.stiffness[index] else math.inf
        ahead = self.set_point - position
        # The drive's damping would brake a finger that is moved with little effort, so the velocity set point follows the
        # finger's speed while the target is far away.
        most = ahead / (_APPROACH * self.clock.delta) if abs(ahead) > reach else 0.0
        follow = min(max(robot.velocities()[index], min(most, 0.0)), max(most, 0.0))
        command = position + follow * self.clock.delta + min(max(ahead, -reach), reach)
        if speed > self.stall_velocity_threshold:
            self.moved = now
        if self.goal is not None:
            if abs(target - position) <= self.goal_tolerance:
                self.goal.succeed(self.result(stalled=False, reached=True))
                self.goal = None
            elif now - self.moved > self.stall_timeout:
                end = self.goal.succeed if self.allow_stalling else self.goal.abort
                end(self.result(stalled=True, reached=False))
                self.goal = None
        if self.goal is None and math.isinf(self.effort) and self.set_point == target:
            self.target = None
        return self.command(np.array([command]), np.array([follow]))

    def hold(self) -> int:
        """Discard the goal and its target, and output the measured position as set point; return the port to fire."""
        self.goal = self.target = None
        position = self.articulation.positions()[[self.index]]
        return self.command(np.clip(position, *self.articulation.target_ranges[self.index]), np.zeros(1))

    def result(self, *, stalled: bool, reached: bool) -> Any:
        """Return a result with the finger's measured state and the flags `stalled` and `reached_goal`."""
        robot, index = self.articulation, self.index
        result = DEFINITIONS.initial(f"control_msgs/action/{self.action_type}_Result")
        state = robot.positions()[[index]], robot.velocities()[[index]], robot.efforts()[[index]]
        if self.action_type == _TYPES[0]:
            result.position, result.effort = float(state[0][0]), float(state[2][0])
        else:
            result.state = message("sensor_msgs/msg/JointState", result.state.header, [self.published], *state)
        result.stalled, result.reached_goal = stalled, reached
        return result
