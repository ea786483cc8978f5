"""`graphrun snapshot`: render an image of a scene at a given simulation time."""

from __future__ import annotations

import argparse
import colorsys
import math
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import add_file_arguments, clean, log_problem, open_scene, table
from graphengine.cli.progress import progress
from graphengine.format.errors import UsageError
from graphengine.format.files import near

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graphengine.api.scene import Scene
    from graphengine.devices.camera import Picture
    from graphengine.physics.pictures.rendering import Image

MILLIMETRES = 1000
"""Millimetres in a metre. 16 bit depth images of ROS are in mm."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun snapshot` to its parser."""
    from graphengine.cli.quantities import duration

    add_file_arguments(parser)
    parser.set_defaults(rays="mujoco")  # hardly a ray is cast for an image, and compiling takes seconds
    where = "view: top, perspective, the name of a camera in the world's MJCF file, or the prim of a camera (default perspective)"
    parser.add_argument("--camera", metavar="VIEW|PRIM", default="perspective", help=where)
    parser.add_argument(
        "--at",
        metavar="TIME",
        type=duration,
        default=0.0,
        help="simulation time of the image, such as 10 or 500ms (default 0)",
    )
    parser.add_argument(
        "--size", metavar="WxH", type=size, help="size in pixels (default: that of the camera's prim, else 1280x720)"
    )
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, required=True, help="PNG file to write")
    what = parser.add_mutually_exclusive_group()
    depth = "write a 16 bit depth image of a camera's prim: depth along its optical axis, mm; 0 if out of range"
    what.add_argument("--depth", action="store_true", help=depth)
    what.add_argument(
        "--segmentation", action="store_true", help="write an image with one colour per prim, and print the colours"
    )


def size(text: str) -> tuple[int, int]:
    """Parse a size such as `1280x720` to width and height."""
    from graphengine.devices.camera import LARGEST_PICTURE as LARGEST

    match = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", text)
    width, height = (int(match[1]), int(match[2])) if match else (0, 0)
    if not (1 <= width <= LARGEST and 1 <= height <= LARGEST):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size; write 1280x720, at most {LARGEST}x{LARGEST}")
    return width, height


def execute(arguments: argparse.Namespace) -> int:
    """Run the scene until the given time and write the image; return 0, or 1 if the scene has errors."""
    from graphengine.api.pictures import write_png

    output: Path = arguments.output
    if output.suffix.lower() != ".png" or output.is_dir():
        raise UsageError(f"-o {output}: write the name of a PNG file, such as snapshot.png")
    scene = open_scene(arguments)
    if scene is None:
        return 1
    picture, labels = _take(scene, arguments)
    if arguments.depth:
        write_png(_millimetres(picture.depth), output)
    elif arguments.segmentation:
        assert picture.segmentation is not None
        write_png(_colours(picture.segmentation), output)
        print(clean(_table(picture.segmentation, labels)))
    else:
        write_png(picture.rgb, output)
    height, width = picture.depth.shape
    print(
        clean(f"{near(str(output))}: {arguments.camera} at t = {arguments.at:g} s, {width} x {height}"), file=sys.stderr
    )
    return 0


def _take(scene: Scene, arguments: argparse.Namespace) -> tuple[Picture | Image, Mapping[int, str]]:
    """Run the scene without a network until the given time, and render the image.

    Returns:
        The image, and the prim path for each segmentation ID in it.

    Raises:
        UsageError: there is no scene or no such camera, or a view was chosen for a depth image.
    """
    from graphengine.api.pictures import find_camera, look, simulated
    from graphengine.api.run_options import RunOptions
    from graphengine.api.scene import loaded_of, start_runner

    loaded = loaded_of(scene)
    if loaded.world is None:
        raise UsageError(f"{loaded.path} is a graph without a scene and has nothing to draw; give a scene with --scene")
    try:
        prim = find_camera(loaded.world.simulation, arguments.camera)
    except UsageError as error:
        raise UsageError(f"--camera {error}") from None
    if arguments.depth and prim is None:
        raise UsageError(
            f"--depth: {arguments.camera} is a view, which has no depth image; give the prim of a camera to --camera"
        )
    with start_runner(scene, RunOptions(domain=0, log=log_problem)) as runner:
        with progress("simulating", lambda: runner.session.time, arguments.at):
            runner.run(arguments.at, math.inf)
        world = simulated(runner.session.services.world)
        picture = look(world, arguments.camera, arguments.size, segmentation=arguments.segmentation)
        return picture, world.studio.labels


def _millimetres(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Convert depths from m to 16 bit mm, as in ROS; depths that do not fit become 0."""
    import numpy as np

    scaled = np.rint(depth * MILLIMETRES)
    return np.where(scaled <= np.iinfo(np.uint16).max, scaled, 0).astype(np.uint16)


def _colours(numbers: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Return an RGB image with one colour per segmentation ID. Successive IDs have distant hues; the background, 0, is black."""
    import numpy as np

    return np.array([_colour(number) for number in range(int(numbers.max()) + 1)], np.uint8)[numbers]


def _colour(number: int) -> tuple[int, int, int]:
    if number == 0:
        return (0, 0, 0)
    hue = number * 0.618034 % 1.0  # the golden ratio
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.45 + 0.15 * (number % 4), 0.95 - 0.15 * (number % 3))
    return round(255 * red), round(255 * green), round(255 * blue)


def _table(numbers: NDArray[np.int32], labels: Mapping[int, str]) -> str:
    """Return a table with the colour, number of pixels and path of each prim in a segmentation image."""
    import numpy as np

    found, counts = np.unique(numbers, return_counts=True)
    return table(
        [
            ("#{:02x}{:02x}{:02x}".format(*_colour(number)), f"{count} pixels", labels.get(number, "background"))
            for number, count in zip(found.tolist(), counts.tolist(), strict=True)
        ]
    )
