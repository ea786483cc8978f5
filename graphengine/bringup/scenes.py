"""Functions that map a scene, compute how well robots localize themselves in the map, and calibrate robots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, get_args

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.bringup.calibration.figures import Calibration
    from graphengine.bringup.maps.localizability import Localizability
    from graphengine.bringup.maps.map_files import Convention, Format
    from graphengine.physics.occupancy.occupancy_map import OccupancyMap, Point, Rectangle


def occupancy_map(
    scene: Scene,
    path: str | PathLike[str] | None = None,
    *,
    heights: tuple[float, float] = (0.2, 0.62),
    cell: float = 0.05,
    bounds: Rectangle | None = None,
    origin: Point = (0.0, 0.0),
    free: Sequence[Point] = (),
    select: Sequence[str] = (),
    include: Sequence[str] = (),
    exclude: Sequence[str] = (),
    image: Format = "png",
    convention: Convention = "ros",
) -> OccupancyMap:
    """Return an occupancy map of the scene at time 0; `graphrun map` makes the same map for Nav2's map_server.

    >>> floor = bringup.occupancy_map(scene, bounds=((-2, -1), (2, 1)), cell=0.5)
    >>> floor.cells.shape
    (4, 8)

    Args:
        scene: the scene.
        path: path, without suffix, of the image and of PATH.yaml to write; None writes no files.
        heights: lowest and highest z in the world at which bodies count as obstacles, m.
        cell: side of a cell, m.
        bounds: south-west and north-east corner (x, y), m, rounded outwards to whole cells; None fits the map to the prims
            in `select`.
        origin: point (x, y) at which corners of cells meet, m; aligns the grid.
        free: points (x, y) from which free space is flood-filled, m; empty for the position of the first robot.
        select: paths of prims whose extent the map covers if `bounds` is None; empty for all obstacles.
        include: paths of robots and movable bodies to map as obstacles.
        exclude: paths of prims that are not mapped as obstacles.
        image: file format of the image.
        convention: `ros`, or `isaac` for a map as Isaac Sim makes it: the height range is rounded outwards to cells and
            extended by half a cell at both ends, the origin is shifted by half a cell, and the image is RGBA.

    Returns:
        The map. `cells` has the shape (rows, columns), with rows from south to north and columns from west to east; 100
        is occupied, 0 free, -1 unknown.

    Raises:
        OSError: a file cannot be written.
        PrimError: there is no prim at a path in `select`, `include` or `exclude`.
        UsageError: an argument is invalid, or a graph was loaded without a scene.
    """
    from graphengine.api.scene import world_of
    from graphengine.api.values import check_choice
    from graphengine.bringup.maps.map_files import Convention, Format, isaac_window, write_map
    from graphengine.physics.occupancy.occupancy_map import MapRequest, make_map

    check_choice("image", image, get_args(Format))
    check_choice("convention", convention, get_args(Convention))
    world = world_of(scene)
    request = MapRequest(heights, cell, bounds, select, origin, free, include, exclude)
    if convention == "isaac":
        request = replace(request, window=isaac_window(heights, cell))
    made = make_map(world, request)
    if path is not None:
        write_map(made, Path(path), image, convention)
    return made


def localizability(
    scene: Scene,
    chart: OccupancyMap,
    path: str | PathLike[str] | None = None,
    *,
    robot: str | None = None,
    lidar: str | None = None,
    spacing: float = 0.5,
    scans: int = 8,
    alpha: float = 0.01,
    progress: Callable[[float], None] = lambda share: None,
) -> Localizability:
    """Compute how well AMCL could localize a robot at each place of a map, as `graphrun map --localizability` does.

    >>> floor = bringup.occupancy_map(scene, bounds=((-2, -1), (2, 1)))
    >>> result = bringup.localizability(scene, floor, spacing=1.0)
    >>> float((result.spread <= 0.1).mean())  # a floor without obstacles
    0.0

    Args:
        scene: the scene.
        chart: map of the scene.
        path: path, without suffix, of the PNG and CSV files to write; None writes no files.
        robot: name of the robot; None chooses the first robot.
        lidar: path of the lidar's prim; None chooses the robot's only lidar.
        spacing: distance between neighbouring places, m.
        scans: number of scans whose likelihoods are multiplied to compute the ambiguity.
        alpha: translation noise of the motion model, alpha3 of AMCL.
        progress: receives the completed share of the work, 0 to 1.

    Returns:
        Spread and ambiguity of each place and heading, as `graphengine.bringup.maps.localizability` defines them.

    Raises:
        OSError: a file cannot be written.
        PrimError: there is no prim at the path `lidar`.
        UsageError: the robot or lidar does not exist, the robot has several lidars and `lidar` is None, the lidar is not
            level, the map has no free place, or a graph was loaded without a scene.
    """
    from graphengine.api.scene import world_of
    from graphengine.bringup.maps.localizability import localizability
    from graphengine.bringup.maps.localizability_report import write_report
    from graphengine.bringup.maps.robot_lidar import robot_lidar

    world = world_of(scene)
    sensor, radius = robot_lidar(world.simulation, world.robots, robot, lidar)
    result = localizability(chart, sensor, radius, spacing=spacing, scans=scans, alpha=alpha, progress=progress)
    if path is not None:
        write_report(result, chart, Path(path))
    return result


def calibrate(
    scene: Scene,
    robot: str | None = None,
    *,
    command_topic: str | None = None,
    speed: float = 0.3,
    turn_speed: float = 0.6,
    seed: int = 0,
) -> Calibration:
    """Drive a robot alone on a flat floor and measure how it follows its commands, as `graphrun calibrate` does.

    The test drives use the robot file and its graphs unchanged. They do not use the scene's world and the graphs of the scene
    file. The same files and arguments give the same results.

    >>> result = bringup.calibrate(scene)
    >>> result.kinematics, f"{result.wheel_radius:.3f} m", result.outside(0.02)
    ('differential', '0.049 m', ())

    Args:
        scene: the scene with the robot.
        robot: name of the robot; None takes the only robot, or the first one if all robots have the same robot file.
        command_topic: topic to drive the robot with, of type Twist, TwistStamped or AckermannDriveStamped. The last part
            of the name is enough if it is unique. None takes the robot's only command topic.
        speed: speed to command, m/s; lowered to the limits of the robot's controllers.
        turn_speed: turn rate to command, rad/s; lowered to the limits of the robot's controllers.
        seed: seed of all random generators.

    Raises:
        CheckError: the robot or one of its graphs has errors in the scene with the flat floor.
        UsageError: an argument is invalid, or the robot or its command topic is ambiguous.
    """
    from graphengine.bringup.calibration.calibrator import calibrate

    return calibrate(scene, robot, command_topic, speed, turn_speed, seed=seed)
