"""Generates all files that Nav2 needs to drive the robots of a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.bringup.calibration.amcl_noise import amcl_alphas
from graphengine.bringup.calibration.calibrator import calibrate
from graphengine.bringup.calibration.figures import Calibration
from graphengine.bringup.calibration.robot_interface import find_robots
from graphengine.bringup.maps.map_files import map_files
from graphengine.bringup.nav2.choices import Choices
from graphengine.bringup.nav2.motion_limits import reached
from graphengine.bringup.nav2.nav2_parameters import Alphas, nav2_parameters
from graphengine.bringup.nav2.robot_facts import RobotFacts, robot_facts, unknown_covariances
from graphengine.bringup.nav2.sourced import Sourced
from graphengine.bringup.nav2.text_files import fleet_launch, readme_file, robot_launch, rviz_file
from graphengine.physics.occupancy.occupancy_map import MapRequest, NoObstaclesError, make_map

CELL = 0.05
"""Side of a cell of the map, m."""
OPEN_FLOOR = 10.0
"""Margin of the map around the robots in a world without obstacles, m."""
UNCALIBRATED = 0.01
"""Value of each of AMCL's five alphas if they were not measured by a calibration."""

DEFAULTS = Choices()

Progress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True)
class Nav2Files:
    """The contents of the generated files, and notes for the user.

    Attributes:
        contents: a dict from paths, relative to the output folder, to the contents of the files.
        robots: properties of the robots that Nav2 drives.
        notes: sentences about unknown values.
    """

    contents: dict[Path, bytes]
    robots: tuple[RobotFacts, ...]
    notes: tuple[str, ...]


def nav2_files(
    scene: Scene,
    *,
    robots: Sequence[str] = (),
    choices: Choices = DEFAULTS,
    slam: bool = False,
    calibrated: bool = True,
    progress: Progress = lambda _, __: None,
) -> Nav2Files:
    """Return the files for the robots of a scene. If there are several robots, each has a folder with its name.

    Args:
        scene: the checked scene.
        robots: names of the robots; empty for all robots.
        choices: distribution, controller, tolerances and machine.
        slam: whether slam_toolbox builds the map and localizes the robot, instead of map_server and AMCL.
        calibrated: whether to calibrate the robots, which measures AMCL's noise parameters and the speeds that they reach.
        progress: receives the name of the robot in calibration and the completed share, 0 to 1.

    Raises:
        CheckError: a robot has errors on the flat floor of its calibration.
        UsageError: a robot is unknown, the scene has no robot, or Nav2 cannot drive a robot; the message says what to add.
    """
    name, chosen = scene.name, find_robots(scene, robots, "navigate")
    facts = [robot_facts(scene, robot) for robot in chosen]
    for one in facts:
        choices.controller_for(one.limits)  # refuses a wrong choice before the calibration
    notes: list[str] = []
    measured: dict[str, Calibration | None] = {}
    for place, robot in enumerate(chosen):
        kind = robot.placement.use.use
        if kind not in measured:
            told = partial(progress, robot.name)
            measured[kind] = calibrate(scene, robot.name, progress=told) if calibrated else None
        if (result := measured[kind]) is not None:
            limits, slower = reached(facts[place].limits, result)
            facts[place] = replace(facts[place], limits=limits)
            notes += [note for note in slower if note not in notes]
    contents: dict[Path, bytes] = {}
    for robot, one in zip(chosen, facts, strict=True):
        folder = Path(one.name) if len(facts) > 1 else Path()
        alphas = None if slam else _alphas(measured[robot.placement.use.use], notes)
        texts = {
            "nav2_params.yaml": nav2_parameters(one, choices, alphas, name),
            "nav2.launch.py": robot_launch(one, name, slam=slam, in_fleet=len(facts) > 1),
            "view.rviz": rviz_file(one),
        }
        contents |= {folder / file: text.encode() for file, text in texts.items()}
    if len(facts) > 1:
        contents[Path("nav2.launch.py")] = fleet_launch(facts, name, slam=slam).encode()
    if not slam:
        contents |= _map(scene, facts, notes)
    notes += [note for one in facts for note in unknown_covariances(scene, one)]
    described = {claim.topic for claim in scene.topics}.issuperset(one.topic("robot_description") for one in facts)
    readme = readme_file(name, facts, slam=slam, robot_state=loaded_of(scene).options.robot_state, described=described)
    contents[Path("README.md")] = readme.encode()
    return Nav2Files(contents, tuple(facts), tuple(notes))


def _alphas(result: Calibration | None, notes: list[str]) -> Sourced[Alphas]:
    """Return the measured alphas of AMCL; without a calibration, or if the robot did not move, small ones for good odometry."""
    if result is None:
        return Sourced((UNCALIBRATED,) * 5, "assumes good odometry; not measured (--no-calibrate)")
    if not result.moves:
        note = f"{result.robot} did not move in its calibration: {'; '.join(result.notes)}"
        notes += [note] if note not in notes else []
        return Sourced((UNCALIBRATED,) * 5, "assumes good odometry; the robot did not move in the calibration")
    source = "calibration of the robot; at least 0.01, because the particle filter needs some noise"
    return Sourced(amcl_alphas(result), source)


def _map(scene: Scene, robots: Sequence[RobotFacts], notes: list[str]) -> dict[Path, bytes]:
    """Return the image and the YAML file of an occupancy map with obstacles up to the highest robot or scan plane."""
    scans = [scan.height for robot in robots for scan in robot.scans]
    window = scan_window(scans, [robot.height for robot in robots])
    floor = robots[0].floor
    starts = [robot.pose[:2] for robot in robots]
    request = MapRequest((floor + window[0], floor + window[1]), CELL, seeds=starts)
    try:
        made = make_map(world_of(scene), request)
    except NoObstaclesError:
        notes.append(f"the map is empty, {OPEN_FLOOR:g} m around the robots: AMCL cannot find a robot in it")
        xs, ys = zip(*starts, strict=True)
        south_west, north_east = (
            (min(xs) - OPEN_FLOOR, min(ys) - OPEN_FLOOR),
            (max(xs) + OPEN_FLOOR, max(ys) + OPEN_FLOOR),
        )
        made = make_map(world_of(scene), replace(request, bounds=(south_west, north_east)))
    return map_files(made, Path("map"), "pgm")


def scan_window(scans: Sequence[float], heights: Sequence[float]) -> tuple[float, float]:
    """Return the lowest and highest height above the floor at which the map shows obstacles, m.

    The robot can hit every obstacle that is lower than its top. AMCL compares scans with the map, so the range includes all
    scan planes.

    Args:
        scans: heights of the scan planes, m.
        heights: heights of the robots, m.
    """
    low = min(min(scans) / 2.0, 0.1)
    return low, max([*heights, *(scan + 0.05 for scan in scans)])
