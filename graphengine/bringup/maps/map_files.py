"""Writes the image and the YAML file that Nav2's map_server reads.

Occupied cells are black, free cells white, and unknown cells grey: the brightness 127 gives p = 1 - 127/255 = 0.502, between
`free_thresh` and `occupied_thresh`. (The usual 205 of map savers gives p = 0.19608, only 0.00008 above a free_thresh of 0.196.
With a free_thresh of 0.25, as in newer maps, map_server would read unknown cells as free.) The image does not have an alpha
channel, because map_server would read the alpha as "unknown".

Isaac Sim's convention differs in three points. The height range is rounded outwards to cells, and then extended by half a cell on
both sides. The image has an alpha of 255. The origin is the centre of the lower left cell, although map_server takes it as the
corner of that cell, which shifts maps by half a cell.
"""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Literal

import numpy as np
import yaml
from PIL import Image

from graphengine.format.atomic_write import write_together
from graphengine.format.errors import UsageError
from graphengine.physics.occupancy.grid import Window
from graphengine.physics.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap

Convention = Literal["ros", "isaac"]
Format = Literal["png", "pgm"]

BRIGHTNESS = {OCCUPIED: 0, UNKNOWN: 127, FREE: 255}
OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.196


def isaac_window(window: Window, cell: float) -> Window:
    """Return the height range that Isaac Sim's map generator uses for a requested range, m.

    With cells of 0.05 m, it uses 0.175 to 0.675 for 0.2 to 0.62.
    """
    low, high = math.floor(window[0] / cell + 1e-9), math.ceil(window[1] / cell - 1e-9)
    return (low - 0.5) * cell, (high + 0.5) * cell


def write_map(chart: OccupancyMap, stem: Path, image: Format = "png", convention: Convention = "ros") -> None:
    """Write `stem`.png (or .pgm) and `stem`.yaml, both or neither.

    Raises:
        UsageError: a PGM is requested in Isaac Sim's convention, or `stem`.yaml exists and is not a map, such as a scene.
        OSError: a file cannot be written.
    """
    text = stem.with_name(f"{stem.name}.yaml")
    contents = map_files(chart, stem, image, convention)
    if text.is_file() and not any(line.startswith(b"image:") for line in text.read_bytes().splitlines()):
        raise UsageError(f"{text} exists and is not a map; choose another name")
    write_together(contents)


def map_files(
    chart: OccupancyMap, stem: Path, image: Format = "png", convention: Convention = "ros"
) -> dict[Path, bytes]:
    """Return a dict from the paths of the image and the YAML file of `write_map` to their contents.

    Raises:
        UsageError: a PGM is requested in Isaac Sim's convention.
    """
    if convention == "isaac" and image != "png":
        raise UsageError("Isaac Sim's convention needs a PNG image; choose the format png")
    picture, text = (stem.with_name(f"{stem.name}.{ending}") for ending in (image, "yaml"))
    describe = _isaac_yaml if convention == "isaac" else _yaml
    return {picture: _image(chart, image, convention), text: describe(chart, picture.name).encode()}


def _image(chart: OccupancyMap, image: Format, convention: Convention) -> bytes:
    """Return the encoded image of a map with north at the top."""
    pixels = np.empty(chart.cells.shape, np.uint8)
    for state, brightness in BRIGHTNESS.items():
        pixels[chart.cells == state] = brightness
    picture = Image.fromarray(pixels[::-1])
    if convention == "isaac":
        picture = picture.convert("RGBA")
    buffer = io.BytesIO()
    picture.save(buffer, {"png": "PNG", "pgm": "PPM"}[image])
    return buffer.getvalue()


def _yaml(chart: OccupancyMap, image: str) -> str:
    grid = chart.grid
    facts = {
        "image": image,
        "mode": "trinary",
        "resolution": grid.cell,
        "origin": [_short(grid.west), _short(grid.south), 0.0],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESHOLD,
        "free_thresh": FREE_THRESHOLD,
    }
    return yaml.safe_dump(facts, sort_keys=False, default_flow_style=None, allow_unicode=True, width=math.inf)


def _isaac_yaml(chart: OccupancyMap, image: str) -> str:
    """Return the YAML text of Isaac Sim's map generator, without a newline at the end."""
    grid = chart.grid
    x, y = grid.centre(0, 0)
    name = yaml.safe_dump(image, allow_unicode=True, width=math.inf).splitlines()[0]
    lines = [
        f"image: {name}",
        f"resolution: {grid.cell}",
        f"origin: [{_short(x)}, {_short(y)}, 0.0000]",
        "negate: 0",
        f"occupied_thresh: {OCCUPIED_THRESHOLD}",
        f"free_thresh: {FREE_THRESHOLD}",
    ]
    return "\n".join(lines)


def _short(value: float) -> float:
    """Return a number rounded to nine decimals, so that a multiple of a cell is 0.15 and not 0.15000000000000002."""
    return round(value, 9) + 0.0
