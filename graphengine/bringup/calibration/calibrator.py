"""Drives a robot alone on a flat floor and measures how it follows its commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from graphengine.api.run_options import Log, log_to_logging
from graphengine.api.scene import Scene, world_of
from graphengine.api.session import Session
from graphengine.api.session_control import Checkpoint
from graphengine.bringup.calibration import diagnosis, full_speed, imu_noise
from graphengine.bringup.calibration.drive_recorder import STILL, DriveRecorder, FallenError
from graphengine.bringup.calibration.figures import Calibration, Kind, Kinematics, Motion, Slope, Square, Twist
from graphengine.bringup.calibration.flat_scene import on_flat_floor
from graphengine.bringup.calibration.measuring import (
    LEAST,
    is_steady,
    mean_velocity,
    settle_time,
    share,
    turning_centre,
    with_drift,
)
from graphengine.bringup.calibration.odometry_errors import OdometryMeter
from graphengine.bringup.calibration.robot_interface import (
    ACKERMANN,
    IMU,
    ODOMETRY,
    CommandTopic,
    find_command,
    find_robots,
    known_wheel_base,
    limit_of,
    published,
)
from graphengine.bringup.calibration.square_drive import drive_square
from graphengine.bringup.calibration.wheel_geometry import WheelMeter
from graphengine.devices.rotation import Vector3
from graphengine.format.errors import UsageError
from graphengine.format.wording import listing
from graphengine.physics.model.robot import RobotInstance

SPEED, TURN_SPEED = 0.3, 0.6
"""Default speed (m/s) and turn rate (rad/s) of the commands."""
REST, LONGEST_RAMP, LONGEST_TURN = 3.0, 15.0, 60.0
"""Time for which the robot stands at the start, maximum time to wait for a steady velocity, and maximum time of a turn, s."""
STRAIGHT = 4.0
"""Time for which a steady straight motion is measured, s."""
ARC = 1.0
"""Angle by which the robot turns in a test arc, rad."""

Progress = Callable[[float], None]


def calibrate(
    scene: Scene,
    robot: str | None = None,
    command_topic: str | None = None,
    speed: float = SPEED,
    turn_speed: float = TURN_SPEED,
    *,
    seed: int = 0,
    log: Log = log_to_logging,
    progress: Progress = lambda share: None,
) -> Calibration:
    """Calibrate a robot of a scene in test drives and return the measurements.

    Args:
        scene: scene with the robot.
        robot: name of the robot; None chooses the only robot, or the first robot if all have the same robot file.
        command_topic: topic for commands; None chooses the robot's only command topic.
        speed: speed to command, m/s; lowered to the limits of the robot's controllers.
        turn_speed: turn rate to command, rad/s; lowered to the limits of the robot's controllers.
        seed: seed of all random generators.
        log: receives severity, prim path and text of each log message of a node.
        progress: receives the completed share of the work, 0 to 1.

    Raises:
        CheckError: the robot or one of its graphs has errors.
        UsageError: the robot or the topic is unknown or ambiguous, or a speed is not above 0.
    """
    for name, value in (("speed", speed), ("turn_speed", turn_speed)):
        if not 0.0 < value < math.inf:
            raise UsageError(f"{name}: expected a number above 0, got {value!r}")
    chosen = choose_robot(scene, robot)
    with on_flat_floor(scene, chosen) as flat:
        command = find_command(flat.topics, command_topic)
        if command is None:
            reason = diagnosis.no_command(scene, flat)
            return Calibration(chosen.name, "", "", speed, turn_speed, moves=False, notes=(reason,))
        speed = min(speed, limit_of(flat, "maxLinearSpeed"), full_speed.rim_speed(flat))
        turn_speed = min(turn_speed, limit_of(flat, "maxAngularSpeed"))
        result = Calibration(chosen.name, command.topic, command.type, speed, turn_speed, moves=True)
        with flat.session(seed=seed, domain=0, log=log) as sim:
            return _Calibrator(sim, flat, command, result, progress).run()


def choose_robot(scene: Scene, name: str | None) -> RobotInstance:
    """Return the robot to calibrate: the robot `name`, or by default the first robot of the scene.

    Without a name, all robots must have the same robot file.

    Raises:
        UsageError: the scene has no robot, no robot has the name, or no name is given and the robot files differ.
    """
    robots = find_robots(scene, [name] if name is not None else [], "calibrate")
    if len({robot.placement.use.use for robot in robots}) > 1:
        names = listing((robot.name for robot in robots), "robots")
        raise UsageError(f"the scene has several robots; choose one with --robot\n  {names}")
    return robots[0]


class _Calibrator:
    """Runs the test drives of one calibration in a session, and collects their measurements."""

    def __init__(
        self, sim: Session, scene: Scene, command: CommandTopic, result: Calibration, progress: Progress
    ) -> None:
        self._sim, self._scene, self._result, self._progress = sim, scene, result, progress
        self._imus = published(scene.topics, IMU)
        instance = world_of(scene).robots[result.robot]
        self._wheel_base = known_wheel_base(scene) or WheelMeter.described_wheel_base(instance)
        self._arc_radius = _arc_radius(self._wheel_base, limit_of(scene, "maxWheelRotation"))
        odometry = published(scene.topics, ODOMETRY)
        self._drives = DriveRecorder(sim, result.robot, command, odometry, self._wheel_base)
        self._wheels = WheelMeter(instance, self._drives.articulation.joint_names)
        self._meters = {topic: OdometryMeter(topic) for topic in odometry}
        self._motions: list[Motion] = []
        self._notes = [
            f"{what}: the robot's graphs publish no {message_type.replace('/msg/', '/')}"
            for what, message_type, topics in (("odometry", ODOMETRY, odometry), ("IMU", IMU, self._imus))
            if not topics
        ]
        self._arc_rate = 0.0
        self._robot = instance
        self._at_rest = STILL
        self._mark: Checkpoint

    def run(self) -> Calibration:
        """Run the test drives, until the robot falls or does not move, and return their results."""
        try:
            return self._run()
        except FallenError as error:
            self._notes.insert(0, str(error))
            return self._finished(moves=False)

    def _run(self) -> Calibration:
        imus = imu_noise.measure(self._sim, self._imus, self._drives, REST)
        self._result = replace(self._result, imus=imus)
        self._at_rest = mean_velocity(self._drives.trace(round(1.0 / self._drives.dt)))
        self._notes += diagnosis.rolls_away(self._at_rest)
        self._mark = self._sim.checkpoint()
        load = diagnosis.floor_load(self._sim, self._result.robot)
        speed, turn = self._result.speed, Twist(yaw=self._result.turn_speed)
        forward = self._measure("forward", "straight", Twist(x=speed))
        reasons = diagnosis.held_by_stiffness(self._drives, self._wheels)
        self._notes += reasons
        if not self._follows(forward.commanded, forward.reached):
            reasons = diagnosis.stands_still(self._drives, self._wheels, load)
            if not self._responds(turn, by_wheels=False):
                self._notes = list(dict.fromkeys([*reasons, *self._notes]))
                return self._finished(moves=False)
        self._measure("backward", "straight", Twist(x=-speed))
        on_the_spot = self._result.command_type != ACKERMANN and self._responds(turn)
        if on_the_spot:
            self._measure("turn_left", "turn", turn)
            self._measure("turn_right", "turn", Twist(yaw=-self._result.turn_speed))
        steered = not on_the_spot and self._measure_arcs()
        sideways = on_the_spot and self._responds(Twist(y=speed))
        if sideways:
            self._measure("sideways_left", "sideways", Twist(y=speed))
            self._measure("sideways_right", "sideways", Twist(y=-speed))
        if all(abs(motion.share) < LEAST for motion in self._motions):
            # What moved was only the response to the first command.
            self._notes = list(dict.fromkeys([*reasons, *self._notes]))
            return self._finished(moves=False)
        if on_the_spot or steered:
            self._measure_at_limits(steered=steered)
        squares: list[Square] = []
        for sign in (1.0, -1.0) if on_the_spot or steered else ():
            self._begin()
            command = Twist(x=speed, yaw=sign * (self._arc_rate if steered else self._result.turn_speed))
            centre = turning_centre(self._motions) or (0.0, 0.0)
            squares.append(drive_square(self._drives, self._meters.values(), command, centre, steered=steered))
            self._progress(0.9)
        kinematics: Kinematics = "differential" if on_the_spot else "ackermann" if steered else ""
        if sideways:
            kinematics = "omni" if self._wheels.oblique else "mecanum"
        return replace(self._finished(kinematics), squares=tuple(squares))

    def _finished(self, kinematics: Kinematics = "", *, moves: bool = True) -> Calibration:
        """Return the result with the measurements of all completed test drives."""
        omni, wheels = kinematics in ("mecanum", "omni"), self._wheels
        skids = kinematics == "differential" and wheels.has_several_axles
        notes = self._notes + (wheels.notes() if moves else []) + diagnosis.clamped(self._sim)
        odometry = []
        for topic, meter in self._meters.items():
            odometry.append(meter.figures(self._drives.child_frames.get(topic, ""), omni=omni))
            notes += meter.notes if moves else []
        return replace(
            self._result,
            moves=moves,
            kinematics=kinematics,
            motions=tuple(replace(one, slip=wheels.slip(one, omni=omni), skids=skids) for one in self._motions),
            wheels=wheels.wheels,
            wheel_radius=wheels.radius,
            track=wheels.track,
            wheel_base=wheels.wheel_base,
            turning_centre=turning_centre(self._motions),
            odometry=tuple(odometry),
            notes=tuple(notes),
        )

    # Motions

    def _responds(self, twist: Twist, *, by_wheels: bool = True) -> bool:
        """Drive with a command for 2 s and return whether the robot follows the command.

        Args:
            twist: velocity to command.
            by_wheels: whether a robot whose wheels turn without moving it follows the command too.
        """
        self._begin()
        self._drives.drive(twist, 2.0)
        trace = self._drives.trace()
        part = trace.part(len(trace.base) // 2)
        return self._follows(twist, mean_velocity(part)) or (by_wheels and self._wheels.roll(part))

    def _follows(self, twist: Twist, reached: Twist) -> bool:
        """Return whether a command changes the velocity of the robot by at least `LEAST` times the commanded velocity."""
        return abs(share(twist, reached) - share(twist, self._at_rest)) >= LEAST

    def _begin(self, gravity: Vector3 | None = None) -> None:
        self._sim.restore(self._mark)
        if gravity is not None:
            self._sim._runner.session.services.world.set_gravity(gravity)
        self._drives.begin()

    def _measure_arcs(self) -> bool:
        """Measure an arc to the left and an arc to the right; return whether the robot turned in at least one arc."""
        self._arc_rate = min(self._result.turn_speed, self._result.speed / self._arc_radius)
        for name, sign in (("arc_left", 1.0), ("arc_right", -1.0)):
            self._measure(name, "turn", Twist(x=self._result.speed, yaw=sign * self._arc_rate))
        turned = any(abs(motion.share) >= LEAST for motion in self._motions[-2:])
        if not turned:
            self._notes.append("turn: the robot turns neither on the spot nor in an arc")
        return turned

    def _measure_at_limits(self, *, steered: bool) -> None:
        """Measure arcs at 0.3 and 1.0 of the limits, a stop from full speed, and drives and creep on a slope."""
        command, radius = self._result.command_type, self._arc_radius
        drives = list(full_speed.arcs(self._scene, self._robot, command, radius, steered=steered))
        if not drives:
            why = "the robot's graphs do not limit both speed and turn rate"
            self._notes.append(f"arcs at full speed, stop: not driven, because {why}")
        try:
            for name, twist in drives:
                self._measure(name, "turn", twist)
            self._begin()
            self._result = replace(self._result, stop=full_speed.stop(self._drives, self._scene, self._result.speed))
            for name, sign in (("uphill", -1.0), ("downhill", 1.0)):
                self._measure(name, "straight", Twist(x=self._result.speed), full_speed.tilted((sign, 0.0, 0.0)))
            creeps = []
            for direction in ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
                self._begin(full_speed.tilted(direction))
                creeps.append(full_speed.creep(self._drives))
            self._result = replace(self._result, slope=Slope(*creeps))
        except FallenError as error:
            self._notes.append(f"drives at the limits ended: {error}")

    def _measure(self, name: str, kind: Kind, twist: Twist, gravity: Vector3 | None = None) -> Motion:
        """Drive with a constant command, wait for a steady velocity, then measure and return the motion.

        Args:
            name: name of the motion.
            kind: component of the velocity that is evaluated.
            twist: velocity to command.
            gravity: gravity of a slope, m/s2; then the motion counts for no geometry and no odometry.
        """
        self._begin(gravity)
        steady = self._drives.drive_until(twist, lambda trace: is_steady(trace, twist), LONGEST_RAMP)
        begin = self._drives.rows - 1
        if kind == "turn":
            self._drive_a_turn(twist, begin)
        else:
            self._drives.drive(twist, STRAIGHT)
        trace = self._drives.trace()
        window = trace.part(begin)
        reached = mean_velocity(window)
        motion = Motion(name, kind, twist, reached, share(twist, reached))
        if steady and abs(motion.share) >= LEAST:
            axis, final = {"straight": (0, reached.x), "sideways": (1, reached.y), "turn": (2, reached.yaw)}[kind]
            motion = replace(motion, settle_time=settle_time(trace, axis, final))
        motion = with_drift(motion, window)
        if kind == "turn" and twist.x:
            x, y = turning_centre(self._motions) or (0.0, 0.0)
            ahead, aside = reached.x - reached.yaw * y, reached.y + reached.yaw * x
            motion = replace(motion, speed_share=ahead / twist.x, sideslip=math.atan2(aside, ahead))
        self._motions.append(motion)
        self._progress(min(0.05 * len(self._motions), 0.8))
        if gravity is None:
            self._wheels.take(motion, window)
        for meter in self._meters.values() if gravity is None else ():
            meter.take(motion, window)
        if not steady:
            self._notes.append(f"{name}: the velocity is not steady after {LONGEST_RAMP:g} s")
        return motion

    def _drive_a_turn(self, twist: Twist, begin: int) -> None:
        """Drive on to the end of a full turn on the spot, or of an arc of `ARC` rad.

        Stop after 2 s if the robot hardly turns and would need longer than `LONGEST_TURN`.
        """
        self._drives.drive(twist, 2.0)
        rate = abs(mean_velocity(self._drives.trace().part(begin)).yaw)
        needed = (ARC if twist.x else 1.02 * math.tau) / rate - 2.0 if rate > 0.0 else math.inf
        if 0.0 < needed <= LONGEST_TURN:
            self._drives.drive(twist, needed)


def _arc_radius(wheel_base: float | None, steering_limit: float) -> float:
    """Return the radius of the test arcs, m: the turning radius at 0.8 times the steering limit (rad), but 2 to 5 wheel bases.

    For a steering limit of 1.2 rad or more, the radius is 3 wheel bases. If the wheel base is None, the radius is 1.5 m.
    """
    if wheel_base is None:
        return 1.5
    return wheel_base * (min(max(1.0 / math.tan(0.8 * steering_limit), 2.0), 5.0) if steering_limit < 1.2 else 3.0)
