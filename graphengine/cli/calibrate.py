"""`graphrun calibrate`: drive a robot on a flat floor and measure how well it follows its velocity commands."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import add_access_arguments, clean, fitted_table, log_problem, open_scene, table
from graphengine.cli.options import add_flag, add_repeatable, add_value
from graphengine.cli.progress import share_of
from graphengine.cli.quantities import number, whole
from graphengine.format.errors import UsageError
from graphengine.format.files import near

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.bringup.calibration.figures import Calibration, ImuNoise, Motion, Odometry

BOUND = 0.02
"""Default of `--check`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun calibrate` to its parser."""
    add_value(parser, "file", "SCENE", "a scene file, or the name of an included one, such as dd100_flat")
    drive = parser.add_argument_group("test drives")
    add_value(drive, "--robot", "NAME", "robot to calibrate (default: the only one)")
    topic = "command topic of the robot, a Twist, TwistStamped or AckermannDriveStamped (default: the only one)"
    add_value(drive, "--command-topic", "TOPIC", topic)
    limit = "reduced to the limits of the robot's controllers"
    add_value(drive, "--speed", "V", f"speed to command, m/s (default 0.3); {limit}", type=number, default=0.3)
    turn = f"turn rate to command, rad/s (default 0.6); {limit}"
    add_value(drive, "--turn-speed", "W", turn, type=number, default=0.6)
    result = parser.add_argument_group("result")
    check = "exit with code 1 if a reached speed differs from the command by more than this share (default 0.02; 1.5 "
    check += (
        "times for turns, arcs and sideways drives, 5 times for turns and arcs of a skid-steered base), if a stop is "
    )
    check += "longer than 1.2 v^2/2a, or if the parked robot creeps on a slope"
    add_value(result, "--check", "BOUND", check, type=number, nargs="?", const=BOUND)
    write = "write the measured wheel radius, track, wheel base and covariances to the files of robot and graphs"
    add_flag(result, "--write", write)
    picture = "SVG file to write, with a square path as commanded, as driven and by odometry"
    add_value(result, "--picture", "FILE", picture, type=Path)
    form = "output format (default text); json has SI units, and null for values that were not measured"
    result.add_argument("--format", choices=("text", "json"), default="text", help=form)
    files = parser.add_argument_group("files")
    inputs = "value for an input, [ROBOT/][GRAPH/]NODE.PORT=VALUE, globs allowed"
    add_repeatable(files, "--set", "NODE.PORT=VALUE", inputs)
    files.add_argument("--seed", type=whole, default=0, help="seed of all random generators (default 0)")
    add_access_arguments(parser)
    parser.set_defaults(scene=None, robot_state=False, localization=None, rays="auto")


def execute(arguments: argparse.Namespace) -> int:
    """Calibrate the robot and print the measurements.

    Returns:
        0, or 1 if the scene has errors, the robot does not move or falls over, or a speed is outside the bound of `--check`.
    """
    picture: Path | None = arguments.picture
    if picture is not None and (picture.suffix.lower() != ".svg" or picture.is_dir()):
        raise UsageError(f"--picture {picture}: write the name of an SVG file, such as square.svg")
    if arguments.check is not None and not arguments.check > 0.0:
        raise UsageError(f"--check {arguments.check:g}: write a number above 0, such as {BOUND}")
    scene = open_scene(arguments)
    result = _calibrate(scene, arguments)
    print(json.dumps(result.to_data(), indent=2) if arguments.format == "json" else clean(_report(result)))
    if not result.moves:
        return 1
    if picture is not None:
        _draw(result, picture)
    if arguments.write:
        _write(scene, result)
    return _check(result, arguments.check) if arguments.check is not None else 0


def _calibrate(scene: Scene, arguments: argparse.Namespace) -> Calibration:
    from graphengine.bringup.calibration.calibrator import calibrate

    with share_of("calibrating") as advance:
        return calibrate(
            scene,
            arguments.robot,
            arguments.command_topic,
            arguments.speed,
            arguments.turn_speed,
            seed=arguments.seed,
            log=log_problem,
            progress=advance,
        )


def _draw(result: Calibration, path: Path) -> None:
    from graphengine.bringup.calibration.square_picture import draw
    from graphengine.format.atomic_write import write_together

    if not result.squares:
        print("--picture: no file is written, because the robot drove no square", file=sys.stderr)
        return
    write_together({path: draw(result).encode()})
    print(clean(f"{near(str(path))}: the square in both directions"), file=sys.stderr)


def _write(scene: Scene, result: Calibration) -> None:
    from graphengine.bringup.calibration.write_back import write_figures

    changes, notes = write_figures(scene, result)
    written = [f"{near(str(change.path))}: {change.node}: {change.old:g} -> {change.new:g}" for change in changes]
    for line in [*written, *notes] or ["--write: the files already have the measured values"]:
        print(clean(line), file=sys.stderr)


def _check(result: Calibration, bound: float) -> int:
    """Print each motion with a speed out of bounds, a stop that is too long, and creep; return 1 if one occurs, else 0."""
    from graphengine.bringup.calibration.figures import CREEP, STOP_MARGIN

    flaws = []
    for motion in result.outside(bound):
        allowed = f"the difference may be at most {_percent(motion.margin * bound)}"
        speed = "" if motion.speed_share is None else f" turn rate, {_percent(motion.speed_share)} of the commanded"
        flaws.append(f"{motion.name}: {_percent(motion.share)} of the commanded{speed} speed; {allowed}")
    if (stop := result.stop) is not None and not stop.is_within():
        ideal = "v^2 / 2a with the limit of the deceleration"
        flaws.append(f"stop: {stop.distance:.3f} m, more than {STOP_MARGIN:g} of {ideal}")
    if result.slope is not None and not result.slope.is_within():
        creep, limit = _millimetres(max(result.slope.along, result.slope.across)), _millimetres(CREEP)
        flaws.append(f"parked on a slope of 5 degrees: creeps at {creep}/s, more than {limit}/s")
    for flaw in flaws:
        print(flaw, file=sys.stderr)
    return 1 if flaws else 0


# Text


def _report(result: Calibration) -> str:
    """Return the measurements as text: tables of motions, geometry, limits, squares, odometry, AMCL and IMUs, then the notes."""
    if not result.moves:
        return "\n".join([f"{result.robot} cannot be calibrated", *(f"  {note}" for note in result.notes)])
    kind = f", {result.kinematics}" if result.kinematics else ""
    parts = [f"{result.robot}: {result.command_topic} ({result.command_type}){kind}"]
    parts.append(fitted_table([_MOTION_HEAD, *map(_motion_row, result.motions)], 4))
    parts.append(table(list(_geometry(result))))
    parts += [table(list(_at_limits(result)))] if result.stop is not None or result.slope is not None else []
    if result.squares:
        head = f"SQUARE OF {result.squares[0].side:g} m", "TRUE END MINUS COMMANDED END"
        parts.append(table([head, *_squares(result)]))
    parts += [table(list(_odometry(one))) for one in result.odometry]
    if result.odometry:
        parts.append(table(list(_amcl(result))))
    parts += [table(list(_imu(one))) for one in result.imus]
    if result.notes:
        parts.append("\n".join(["NOTES", *(f"  {note}" for note in result.notes)]))
    return "\n\n".join(parts)


_MOTION_HEAD = ("MOTION", "COMMANDED", "REACHED", "", "SETTLED", "DRIFT", "SLIP")


def _motion_row(motion: Motion) -> Sequence[str]:
    pick = {"straight": "x", "sideways": "y", "turn": "yaw"}[motion.kind]
    unit = "rad/s" if motion.kind == "turn" else "m/s"
    drift = "-"
    if motion.lateral_drift is not None and motion.heading_drift is not None:
        drift = f"{_millimetres(motion.lateral_drift)}/m, {_degrees(motion.heading_drift)}/m"
    elif motion.position_drift is not None:
        drift = f"{_millimetres(motion.position_drift)}/turn"
    return (
        motion.name.replace("_", " "),
        f"{getattr(motion.commanded, pick):.4g} {unit}",
        f"{_rounded(getattr(motion.reached, pick), 4)} {unit}",
        _percent(motion.share),
        "-" if motion.settle_time is None else f"{motion.settle_time:.2f} s",
        drift,
        "-" if motion.slip is None else _percent(motion.slip),
    )


def _geometry(result: Calibration) -> Iterator[Sequence[str]]:
    yield "GEOMETRY", "effective values, with which wheel odometry is the true motion"
    radii = [wheel.radius for wheel in result.wheels]
    spread = f" ({min(radii):.5f} to {max(radii):.5f})" if radii and max(radii) - min(radii) > 1e-5 else ""
    if result.wheel_radius is not None:
        yield "wheel radius", f"{result.wheel_radius:.5f} m{spread}, {len(radii)} wheels"
    if result.track is not None:
        name = "track + wheel base" if result.kinematics == "mecanum" else "track"
        yield name, f"{result.track:.5f} m"
    if result.wheel_base is not None:
        yield "wheel base", f"{result.wheel_base:.5f} m"
    if result.turning_centre is not None:
        x, y = (_rounded(value, 4) for value in result.turning_centre)
        yield "turning centre", f"x {x} m, y {y} m from the base link"


def _at_limits(result: Calibration) -> Iterator[Sequence[str]]:
    yield "LIMITS", "arcs, and a stop from full speed; a slope of 5 degrees"
    for motion in result.motions:
        if motion.speed_share is not None and motion.sideslip is not None:
            shares = f"speed {_percent(motion.speed_share)}, turn rate {_percent(motion.share)}"
            yield motion.name.replace("_", " "), f"{shares}, sideslip {_degrees(motion.sideslip)}"
    if (stop := result.stop) is not None:
        ideal = "its controllers have no limit of the deceleration"
        if stop.ratio is not None:
            ideal = f"{stop.ratio:.2f} of v^2 / 2a with its limit of {stop.deceleration:g} m/s2"
        yield "stop", f"{stop.distance:.3f} m from {stop.speed:.3g} m/s: {ideal}"
    if (slope := result.slope) is not None:
        along, across = _millimetres(slope.along), _millimetres(slope.across)
        yield "parked", f"creeps at {along}/s up the slope, {across}/s across it"


def _squares(result: Calibration) -> Iterator[Sequence[str]]:
    for square in result.squares:
        yield square.direction, f"{_millimetres(square.position_error)}, {_degrees(square.heading_error)}"


def _odometry(one: Odometry) -> Iterator[Sequence[str]]:
    yield "ODOMETRY", f"{one.topic} ({one.frame}) minus the true motion"
    if one.is_true():
        yield "all errors", "0"
        return
    if one.distance_error is not None:
        yield "distance", f"{_percent(one.distance_error)}"
    if one.lateral_error is not None and one.heading_error is not None:
        yield "drift", f"{_millimetres(one.lateral_error)}/m, {_degrees(one.heading_error)}/m"
    if one.turn_error is not None:
        where = "" if one.turn_position_error is None else f", {_millimetres(one.turn_position_error)}/turn"
        yield "turn", f"{_degrees(one.turn_error)}/turn{where}"
    if one.sideways_error is not None:
        yield "sideways", f"{_percent(one.sideways_error)}"
    if one.square_position_error is not None and one.square_heading_error is not None:
        yield "square", f"{_millimetres(one.square_position_error)}, {_degrees(one.square_heading_error)} at the end"
    alphas = {f"alpha{n}": getattr(one.alphas, f"alpha{n}") for n in range(1, 6)}
    if any(value is not None for value in alphas.values()):
        known = (f"{name} {'-' if value is None else _scientific(value)}" for name, value in alphas.items())
        yield "AMCL alphas", ", ".join(known)
    variances = one.covariances
    if variances.distance_variance is not None:
        distance, heading = variances.distance_variance, variances.heading_variance_by_distance or 0.0
        straight = f"distance {_scientific(distance)} m2/m, heading {_scientific(heading)} rad2/m"
        turn = variances.heading_variance_by_turn
        yield "variances", straight + ("" if turn is None else f" and {_scientific(turn)} rad2/rad")


def _amcl(result: Calibration) -> Iterator[Sequence[str]]:
    from graphengine.bringup.calibration.amcl_noise import LEAST, amcl_alphas

    yield "AMCL", f"measured parameters for nav2_amcl, at least {LEAST[0]:g}, as a filter needs noise"
    for index, value in enumerate(amcl_alphas(result), 1):
        yield f"alpha{index}", f"{value:.2g}"


def _imu(one: ImuNoise) -> Iterator[Sequence[str]]:
    yield "IMU", f"{one.topic}, {one.rate:.4g} Hz, at rest"
    yield "gyroscope", f"noise {_scientific(one.gyro_noise)} rad/s, bias {_scientific(one.gyro_bias)} rad/s"
    yield "accelerometer", f"noise {_scientific(one.accelerometer_noise)} m/s2, gravity {one.gravity:.4f} m/s2"


def _rounded(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _scientific(value: float) -> str:
    """Return a number as text with two significant digits; numbers below 1e-9 are rounding errors and become 0."""
    return f"{value:.2g}" if abs(value) >= 1e-9 else "0"


def _percent(share: float) -> str:
    return f"{_rounded(100.0 * share, 2)} %"


def _millimetres(metres: float) -> str:
    return f"{_rounded(1000.0 * metres, 1)} mm"


def _degrees(radians: float) -> str:
    return f"{_rounded(math.degrees(radians), 2)} deg"
