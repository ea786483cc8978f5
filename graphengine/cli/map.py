"""`graphrun map`: make an occupancy map of a scene for nav2's map_server."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import add_allow_argument, clean, open_file, reading_options
from graphengine.cli.options import add_flag, add_repeatable, add_value
from graphengine.cli.progress import progress, share_of
from graphengine.cli.quantities import number, whole
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import PrimError, UsageError
from graphengine.format.files import find_file, near

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.physics.occupancy.occupancy_map import OccupancyMap

HEIGHTS = (0.2, 0.62)
"""Default height range of obstacles, m; equal to that of NVIDIA's tutorial "ROS 2 Putting It All Together"."""

ENDINGS = (".png", ".pgm", ".yaml", ".yml")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun map` to its parser."""
    add_value(parser, "scene", "SCENE", "a scene file, or the name of an included one, such as dd100_warehouse")
    add_value(
        parser,
        "--output",
        "NAME",
        "name of the files to write, NAME.png and NAME.yaml (default: SCENE_map)",
        short="-o",
    )
    where = parser.add_argument_group("map contents")

    def numbers(option: str, *names: str, help: str, **more: Any) -> None:
        where.add_argument(option, metavar=names, nargs=len(names), type=number, help=help, **more)

    def prims(option: str, help: str) -> None:
        add_repeatable(where, option, "PRIM", help)

    numbers("--z", "LOW", "HIGH", default=HEIGHTS, help="height range of obstacles, m (default 0.2 0.62)")
    add_value(where, "--cell", "SIZE", "side of a cell, m (default 0.05)", type=number, default=0.05)
    area = "area of the map, m, rounded outwards to cells (default: all obstacles)"
    numbers("--bounds", "XMIN", "YMIN", "XMAX", "YMAX", help=area)
    prims("--select", "prim whose extent is the area of the map, unless --bounds is given (default: all obstacles)")
    corner = "point at which corners of cells meet, m; aligns the grid (default 0 0)"
    numbers("--origin", "X", "Y", default=(0.0, 0.0), help=corner)
    seed = "point in free space, m: space connected to it is free, the rest unknown (default: the first robot); may be repeated"
    numbers("--from", "X", "Y", dest="seeds", action="append", default=[], help=seed)
    prims("--include", "prim of a robot or movable body to map as an obstacle")
    prims("--exclude", "prim that is not an obstacle")
    local = parser.add_argument_group("localizability")
    written = "also write NAME_localizability.png and .csv: how well AMCL could localize the robot at each place"
    add_flag(local, "--localizability", written)
    add_value(local, "--robot", "NAME", "robot whose lidar is used (default: the first one)")
    add_value(local, "--lidar", "PRIM", "lidar to use; required if the robot has several")
    scans = "number of scans, 0.25 m apart, whose likelihoods are multiplied to find ambiguous poses (default 8)"
    add_value(local, "--scans", "N", scans, type=whole, default=8)
    noise = "AMCL's parameter alpha3: a larger value widens the spread of the estimated position (default 0.01)"
    add_value(local, "--alpha", "A", noise, type=number, default=0.01)
    files = parser.add_argument_group("output")
    files.add_argument("--format", choices=("png", "pgm"), default="png", help="format of the image (default png)")
    isaac = "isaac: like maps of Isaac Sim, with a height range half a cell wider at both ends, an origin shifted by "
    isaac += "half a cell, and RGBA pixels (default ros)"
    files.add_argument("--convention", choices=("ros", "isaac"), default="ros", help=isaac)
    add_allow_argument(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Write the map, and with `--localizability` also the localizability; return 0, or 1 if the scene has errors."""
    path = find_file(arguments.scene)
    stem = _stem(arguments.output, path)
    _refuse_others(path)
    scene = open_file(path, reading_options(arguments), graphs=False)
    try:
        _map(scene, stem, arguments)
    except PrimError as error:
        raise UsageError("\n  ".join([error.message, *filter(None, error.help)])) from None
    return 0


def _map(scene: Scene, stem: Path, arguments: argparse.Namespace) -> None:
    """Write the files, and print their names and a summary.

    Raises:
        PrimError: there is no prim at a path that the arguments contain.
        UsageError: an argument is invalid, or the localizability cannot be measured with this lidar or map.
    """
    from graphengine.bringup import occupancy_map

    begin, bounds = time.perf_counter(), arguments.bounds
    with progress("mapping"):
        made = occupancy_map(
            scene,
            stem,
            heights=tuple(arguments.z),
            cell=arguments.cell,
            bounds=(tuple(bounds[:2]), tuple(bounds[2:])) if bounds else None,
            origin=tuple(arguments.origin),
            free=[tuple(point) for point in arguments.seeds],
            select=arguments.select,
            include=arguments.include,
            exclude=arguments.exclude,
            image=arguments.format,
            convention=arguments.convention,
        )
    seconds = time.perf_counter() - begin
    image, text = (near(f"{stem}.{ending}") for ending in (arguments.format, "yaml"))
    print(clean(f"{image} and {text}, in {seconds:.2f} s"))
    print(_summary(made))
    if arguments.localizability:
        _localizability(scene, made, stem, arguments)


def _localizability(scene: Scene, made: OccupancyMap, stem: Path, arguments: argparse.Namespace) -> None:
    """Write the image and the table of localizability, and print a summary.

    Raises:
        PrimError: there is no prim at the path of the lidar.
        UsageError: there is no such robot or lidar, or the localizability cannot be measured with this lidar or map.
    """
    from graphengine.bringup import localizability
    from graphengine.bringup.maps.localizability_report import summary

    begin = time.perf_counter()
    target = stem.with_name(f"{stem.name}_localizability")
    with share_of("localizability") as advance:
        result = localizability(
            scene,
            made,
            target,
            robot=arguments.robot,
            lidar=arguments.lidar,
            scans=arguments.scans,
            alpha=arguments.alpha,
            progress=advance,
        )
    seconds = time.perf_counter() - begin
    image, text = (near(f"{target}.{ending}") for ending in ("png", "csv"))
    print(clean(f"{image} and {text}, in {seconds:.1f} s"))
    print(summary(result))


def _stem(output: str | None, scene: Path) -> Path:
    """Return the path of the output files without suffix: the value of `-o`, or `SCENE_map` in the working directory.

    Raises:
        UsageError: the path is a folder.
    """
    if output is None:
        return Path(f"{scene.stem}_map")
    ending = next((ending for ending in ENDINGS if output.endswith(ending)), "")
    stem = Path(output.removesuffix(ending))
    if output.endswith("/") or not stem.name or stem.is_dir():
        raise UsageError(f"-o {output}: this is a folder; write a file name such as {stem / scene.stem}")
    return stem


def _refuse_others(path: Path) -> None:
    """Check that a file is not a graph or robot file, because only scenes have maps.

    Raises:
        UsageError: the file is a graph or robot file.
    """
    from graphengine.format import document, spec_reader

    found = document.load(path, Findings())
    kind = spec_reader.kind_of(found) if found is not None else None
    if kind in ("graph", "robot"):
        raise UsageError(f"{path}: this is a {kind} file; give a scene file")


def _summary(chart: OccupancyMap) -> str:
    from graphengine.physics.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN

    grid, (low, high) = chart.grid, chart.window
    states = {"occupied": OCCUPIED, "free": FREE, "unknown": UNKNOWN}
    shares = ", ".join(f"{name} {100 * chart.share(state):.1f} %" for name, state in states.items())
    west, south = round(grid.west, 6), round(grid.south, 6)
    size = f"{grid.columns} x {grid.rows} cells of {grid.cell:g} m, origin ({west:.10g}, {south:.10g}) m"
    return f"{size}, z {low:g} to {high:g} m\n{shares}"
