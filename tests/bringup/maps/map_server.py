"""A reader of maps by the rules of nav2's map_server (Jazzy): what a robot's navigation makes of the two files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image


@dataclass(frozen=True)
class ReadMap:
    """As nav_msgs/OccupancyGrid: `data` is (height, width), the first row at the origin; 100 occupied, 0 free, -1 unknown."""

    resolution: float
    origin: tuple[float, float, float]
    data: NDArray[np.int8]

    def cell(self, x: Any, y: Any) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column of points; the origin is the outer corner of the first cell."""
        column = np.floor((np.asarray(x) - self.origin[0]) / self.resolution).astype(np.intp)
        row = np.floor((np.asarray(y) - self.origin[1]) / self.resolution).astype(np.intp)
        return row, column


def read_map(path: Path) -> ReadMap:
    facts = yaml.safe_load(path.read_text(encoding="utf-8"))
    with Image.open(path.parent / facts["image"]) as image:
        shades, opaque = pixels(image)
    assert facts.get("mode", "trinary") == "trinary"
    p = shades / 255 if facts["negate"] else 1 - shades / 255
    data = np.full(p.shape, -1, np.int8)
    data[p >= facts["occupied_thresh"]] = 100
    data[p <= facts["free_thresh"]] = 0
    data[~opaque] = -1
    x, y, yaw = facts["origin"]
    return ReadMap(float(facts["resolution"]), (float(x), float(y), float(yaw)), data[::-1])


def pixels(image: Image.Image) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Mean of the colours, and whether a pixel is wholly opaque; one with less alpha than 255 is unknown."""
    channels = np.asarray(image, np.float64)
    if channels.ndim == 2:
        return channels, np.ones(channels.shape, np.bool_)
    colours, alpha = channels[..., :3], channels[..., 3:]
    return colours.mean(axis=-1), (alpha == 255).all(axis=-1)
