"""`graphrun snapshot`: render a picture of a scene after a given time."""

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
"""In a metre: what a picture of distances counts in, as ROS does in depth images of 16 bits."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun snapshot` to its parser."""
    from graphengine.cli.quantities import duration

    add_file_arguments(parser)
    where = "top, perspective, a camera of the world's MJCF, or the prim of a camera (default perspective)"
    parser.add_argument("--camera", metavar="VIEW|PRIM", default="perspective", help=where)
    parser.add_argument(
        "--at", metavar="TIME", type=duration, default=0.0, help="simulation time of the picture: 10, 500ms"
    )
    parser.add_argument("--size", metavar="WxH", type=size, help="pixels (default 1280x720, or the camera's own)")
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, required=True, help="PNG file to write")
    what = parser.add_mutually_exclusive_group()
    depth = "write a depth image of a camera: depths along its optical axis, 16 bits, mm; 0: nothing in range"
    what.add_argument("--depth", action="store_true", help=depth)
    what.add_argument(
        "--segmentation", action="store_true", help="write an image with one colour per prim; print the colours"
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
    """Write the picture; return 0 on success, 1 with errors."""
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
    """Run the scene with the transport memory; return the picture, and the prim path of each number in it."""
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
    """Convert depths (m) to 16 bit millimetres as in ROS; 0 for depths out of range."""
    import numpy as np

    scaled = np.rint(depth * MILLIMETRES)
    return np.where(scaled <= np.iinfo(np.uint16).max, scaled, 0).astype(np.uint16)


def _colours(numbers: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Return the RGB colour of each prim number; successive numbers have distant hues, and 0, the background, is black."""
    import numpy as np

    return np.array([_colour(number) for number in range(int(numbers.max()) + 1)], np.uint8)[numbers]


def _colour(number: int) -> tuple[int, int, int]:
    if number == 0:
        return (0, 0, 0)
    hue = number * 0.618034 % 1.0  # the golden ratio
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.45 + 0.15 * (number % 4), 0.95 - 0.15 * (number % 3))
    return round(255 * red), round(255 * green), round(255 * blue)


def _table(numbers: NDArray[np.int32], labels: Mapping[int, str]) -> str:
    """Return a table of colour, pixel count and path of each prim in the picture."""
    import numpy as np

    found, counts = np.unique(numbers, return_counts=True)
    return table(
        [
            ("#{:02x}{:02x}{:02x}".format(*_colour(number)), f"{count} pixels", labels.get(number, "background"))
            for number, count in zip(found.tolist(), counts.tolist(), strict=True)
        ]
    )
