"""A joint trajectory controller node. It receives trajectories as action goals and as topic messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.compiler.lint_registry import lint
from graphengine.format.errors import ContextError
from graphengine.format.wording import listing
from graphengine.messages import messages
from graphengine.messages.actions import Goal
from graphengine.messages.endpoints import Subscription
from graphengine.node import Bound, Context, Fire, In, State
from graphengine.node.types import Doubles, String, Tokens, read_only
from graphengine.nodes.core.articulation import robot_of
from graphengine.nodes.ros2 import joint_trajectory as codes
from graphengine.nodes.ros2.joint_spline import Floats, JointPoint, JointSpline
from graphengine.nodes.ros2.joint_trajectory import ControlledJoints, TrajectoryError, excess_speed, read_trajectory
from graphengine.nodes.ros2.publisher import header
from graphengine.nodes.ros2.robot_action import RobotActionNode, duration, message
from graphengine.nodes.ros2.trajectory_tolerances import Tolerances

if TYPE_CHECKING:
    from graphengine.compiler.lint_registry import LintContext

ACTION = "control_msgs/action/FollowJointTrajectory"
_ROUNDING = 1e-9
_NONE = read_only(np.zeros(0))


class ROS2FollowJointTrajectory(RobotActionNode, type="graphengine.ros2.ROS2FollowJointTrajectory", gated=True):
    """Moves a robot's joints along trajectories, like joint_trajectory_controller of ros2_controllers.

    Trajectories are goals of the action `<controllerName>/follow_joint_trajectory`, or messages on the topic
    `<controllerName>/joint_trajectory`. The joints follow a spline that starts at once from the current set points. The spline is
    linear between trajectory points that have only positions, cubic between trajectory points with velocities, and quintic
    between trajectory points with velocities and accelerations. The times of the trajectory points are relative to the header's
    stamp, or to the current time if the stamp is 0; trajectory points in the past are skipped. Wire the outputs to an
    IsaacArticulationController. The outputs are the set points for the end of the tick: drives with `interpolate: true` then
    follow the spline with the smallest error.

    A new trajectory replaces the current one and aborts its goal. The joints hold their measured positions if a goal is
    canceled, if a tolerance is violated, or if a trajectory has no points. A goal succeeds when the time of its last trajectory
    point has passed and all joints are within the goal tolerances.

    An invalid goal is accepted and aborted at once: the client gets an error code and the reason. The current trajectory
    continues (joint_trajectory_controller rejects such goals without a reason). The error codes are INVALID_JOINTS for unknown,
    missing and mimic joints, OLD_HEADER_TIMESTAMP for a trajectory that ends in the past, and INVALID_GOAL for wrong lengths,
    times that do not increase, numbers that are not finite, positions beyond the limits of a joint, and a last trajectory
    point with nonzero velocity. A trajectory that exceeds a joint's velocity limit is followed, but a warning is logged.
    """

    joint_names: Tokens = In(
        default=(), setup=True, doc="joints to command; if empty, all driven joints that are not mimic joints"
    )
    controller_name: String = In(
        default="joint_trajectory_controller", setup=True, doc="name of the controller: prefix of action and topic"
    )
    allow_partial_joints_goal: bool = In(
        default=False, doc="true: joints missing in a trajectory keep their set points; false: this is an error"
    )
    path_tolerances: Doubles = In(
        default=_NONE,
        ge=0.0,
        setup=True,
        unit="rad, m",
        doc="maximum position error during a trajectory: one number for all joints, or one for each joint; empty or 0: no limit",
    )
    goal_tolerances: Doubles = In(
        default=_NONE,
        ge=0.0,
        setup=True,
        unit="rad, m",
        doc="maximum position error at the end of a trajectory: one number, or one for each joint; empty or 0: no limit",
    )
    stopped_velocity_tolerance: float = In(
        default=0.01, ge=0.0, setup=True, unit="rad/s, m/s", doc="maximum joint speed at the end; 0: no limit"
    )
    goal_time: float = In(
        default=0.0, ge=0.0, setup=True, unit="s", doc="time to reach the goal after the trajectory's end; 0: no limit"
    )
    feedback_rate: float = In(default=20.0, ge=0.0, unit="Hz", doc="maximum rate of the feedback; 0: no feedback")

    joints: ControlledJoints = Bound()
    subscription: Subscription = Bound()
    defaults: Tolerances = Bound()
    spline: JointSpline | None = State(default=None)
    tolerances: Tolerances | None = State(default=None)
    followed: Tokens = State(default=())
    started: float = State(default=0.0)
    reported: float = State(default=-np.inf)

    def setup(self, context: Context) -> None:
        """Look up the robot and its joints, and create the action server and the subscription on the trajectory topic."""
        controller = self.controller_name.rstrip("/")
        self.bind(context, ACTION, f"{controller}/follow_joint_trajectory")
        topic = f"{controller}/joint_trajectory"
        self.subscription = context.subscription("trajectory_msgs/msg/JointTrajectory", topic, **self.endpoint())
        robot = self.articulation
        driven = ~np.isnan(robot.set_points()[0])
        commanded = zip(robot.joint_names, driven, robot.leaders, strict=True)
        names = self.joint_names or [name for name, has_drive, leader in commanded if has_drive and not leader]
        published = context.joint_names(self.prim())
        self.joints = ControlledJoints.of(robot, names, published)
        joints = len(names)
        for port, given in (("pathTolerances", self.path_tolerances), ("goalTolerances", self.goal_tolerances)):
            if len(given) not in (0, 1, joints) or not (given >= 0.0).all():
                raise ContextError(
                    f"{port} must be one number for all joints or {joints} numbers, and no number may be negative",
                    given.tolist(),
                )
        self.defaults = Tolerances.by_default(
            joints, self.path_tolerances, self.goal_tolerances, self.stopped_velocity_tolerance, self.goal_time
        )
        self.commanded = tuple(names)

    def compute(self) -> Fire:
        """Start the trajectories that arrived in this tick, and follow the current trajectory."""
        fired = self.drop()
        newest = self.subscription.newest()
        if newest is not None:
            fired = self.begin(newest, None) or fired
        for goal in self.server.goals():
            goal.accept()
            fired = self.begin(goal.message.trajectory, goal) or fired
        if self.spline is not None and self.tolerances is not None:
            fired = self.follow(self.spline, self.tolerances)
        self.server.update()
        return fired

    def drop(self) -> Fire:
        """End the goal and hold the joints if the goal's server was closed, or if `setup` has chosen other joints to command.

        Return the port to fire, or None if the joints are not held.
        """
        if self.goal is not None and not self.goal.active:  # its server was closed
            self.goal = None
        elif self.spline is None or self.followed == self.commanded:
            return None
        return self.hold(codes.INVALID_GOAL, "the controller was set up again", "abort")

    def begin(self, trajectory: Any, goal: Goal | None) -> Fire:
        """Replace the current trajectory by a new trajectory, and abort the current goal.

        If the new trajectory is invalid, log the reason and abort the new goal instead.

        Args:
            trajectory: the new trajectory_msgs/JointTrajectory.
            goal: goal to which the trajectory belongs; None if it arrived on the topic.
        """
        try:
            if goal is not None and len(goal.message.multi_dof_trajectory.joint_names):
                raise TrajectoryError(codes.INVALID_GOAL, "joints with several degrees of freedom are not supported")
            tolerances = self.defaults if goal is None else self.defaults.of_goal(goal.message, self.joints)
            start, spline = self.set_point(), None
            if len(trajectory.points):
                spline = read_trajectory(trajectory, self.joints, start, partial=self.allow_partial_joints_goal)
        except TrajectoryError as error:
            self.logger.log("warning", f"{self.server.action}: {error}")
            if goal is not None:
                goal.abort(self.result(error.code, str(error)))
            return None
        if self.goal is not None:
            by = "a new goal" if goal is not None else "a trajectory from the topic"
            self.goal.abort(self.result(codes.INVALID_GOAL, f"preempted by {by}"))
        self.goal, self.spline, self.tolerances, self.followed = goal, spline, tolerances, self.commanded
        if spline is None:
            return self.hold(codes.SUCCESSFUL, "the trajectory has no points: joints hold their positions", "succeed")
        self.started = messages.seconds(trajectory.header.stamp) or start.time
        self.reported = -np.inf
        if warning := excess_speed(spline, self.joints):
            self.logger.log("warning", f"{self.server.action}: {warning}")
        return None

    def set_point(self) -> JointPoint:
        """Return the current set point of the trajectory; without a trajectory, the set point of the joints' drives."""
        now, zeros = self.clock.time, np.zeros(len(self.joints.names))
        if self.spline is not None:
            return JointPoint(now, *self.spline.sample(now), zeros)
        indices = list(self.joints.indices)
        positions, velocities = (targets[indices] for targets in self.articulation.set_points())
        measured = self.articulation.positions()[indices]
        positions = np.where(np.isnan(positions), measured, positions)
        return JointPoint(now, positions, np.nan_to_num(velocities), zeros)

    def follow(self, spline: JointSpline, tolerances: Tolerances) -> Fire:
        """Send feedback and output the next set points; return the port to fire.

        End the trajectory and its goal if the goal is canceled, if a tolerance is violated, or when the motion is complete.
        """
        if self.goal is not None and self.goal.cancel_requested:
            return self.hold(codes.SUCCESSFUL, "canceled: joints hold their positions", "canceled")
        now, rate = self.clock.time, self.feedback_rate
        overdue = now - spline.end
        due = self.goal is not None and rate and now - self.reported >= 1.0 / rate - _ROUNDING
        if overdue < -_ROUNDING and not due and not tolerances.limits_path:  # nothing depends on the errors
            return self.command(*spline.sample(now + self.clock.delta))
        desired, indices = spline.sample(now), list(self.joints.indices)
        actual = self.articulation.positions()[indices], self.articulation.velocities()[indices]
        errors = desired[0] - actual[0], desired[1] - actual[1]
        if self.goal is not None and due:
            self.reported = now
            self.report(self.goal, desired, actual, errors)
        if overdue < -_ROUNDING:
            if violation := tolerances.path.violation(self.joints, *errors):
                return self.hold(codes.PATH_TOLERANCE_VIOLATED, violation, "abort")
        else:
            violation = tolerances.goal.violation(self.joints, *errors)
            if self.goal is None or not violation:
                self.end(codes.SUCCESSFUL, "goal reached", "succeed")
            elif overdue > tolerances.goal_time:
                text = f"{violation}, {overdue:.4g} s after the end of the trajectory"
                return self.hold(codes.GOAL_TOLERANCE_VIOLATED, text, "abort")
        return self.command(*spline.sample(now + self.clock.delta))

    def hold(self, code: int, text: str, ending: str) -> int:
        """End the current goal and trajectory, and output the measured positions as set points; return the port to fire.

        Args:
            code: error code for the result of the goal; if it is not 0, `text` is logged as a warning.
            text: reason, for the result and the log.
            ending: name of the method of `Goal` that ends the goal, such as `abort`.
        """
        if code:
            self.logger.log("warning", f"{self.server.action}: {text}")
        self.end(code, text, ending)
        robot, indices = self.articulation, list(self.joints.indices)
        # A joint that rests on its limit is slightly beyond the limit.
        positions = np.clip(robot.positions()[indices], *np.array(robot.target_ranges)[indices].T)
        return self.command(positions, np.zeros_like(positions))

    def end(self, code: int, text: str, ending: str) -> None:
        """End the current trajectory and its goal; `ending` names the method of `Goal` that ends the goal, such as `abort`."""
        if self.goal is not None:
            getattr(self.goal, ending)(self.result(code, text))
        self.goal = self.spline = self.tolerances = None

    def result(self, code: int, text: str) -> Any:
        """Return a FollowJointTrajectory result with an error code and its reason."""
        return message(f"{ACTION}_Result", code, text)

    def report(self, goal: Goal, *states: tuple[Floats, Floats]) -> None:
        """Send feedback on a goal, if the feedback topic has subscribers.

        Args:
            goal: the goal.
            states: positions and velocities of the joints: desired, measured, and desired minus measured.
        """
        if not self.server.endpoints.feedback.wanted:
            return
        elapsed, none = self.clock.time - self.started, np.zeros(0)
        time = duration(elapsed)
        points = [message("trajectory_msgs/msg/JointTrajectoryPoint", *state, none, none, time) for state in states]
        feedback = self.server.definitions.initial(f"{ACTION}_Feedback")
        feedback.header, feedback.joint_names = header(self.clock.time, ""), list(self.joints.names)
        feedback.desired, feedback.actual, feedback.error = points
        if hasattr(feedback, "index"):  # since Kilted
            due = (messages.seconds(point.time_from_start) for point in goal.message.trajectory.points)
            feedback.index = max(sum(time <= elapsed for time in due) - 1, 0)
        goal.feedback(feedback)


@lint("W209")
def lint_trajectories_without_drive(context: LintContext) -> None:
    """Warn about trajectory controllers that command joints without a position drive: these joints do not move."""
    for _, instance, node in context.nodes(ROS2FollowJointTrajectory):
        robot = robot_of(context, node)
        if robot is None:
            continue
        drives = {prim.facts["joint"]: prim.facts["drive"] for prim in robot.descendants() if prim.kind == "joint"}
        idle = [name for name in node.joint_names or drives if not getattr(drives.get(name), "stiffness", 0.0)]
        if not idle or (not node.joint_names and len(idle) < len(drives)):
            continue
        message = f"{instance.id} commands joints of {robot.path} that have no position drive: nothing moves"
        remedy = f"write `{idle[0]}: {{drive: {{stiffness: 1000, damping: 50}}}}` below `joints:` of the robot file"
        helps = listing(idle, "joints"), remedy
        context.findings.add("W209", message, instance.span, *helps, related=instance.entry.via)
