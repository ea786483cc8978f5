"""Draws the prints on things of a hall, so that a camera image shows something: barcodes, arrows, folds, boards and stripes.

A print darkens its material and leaves its colour, because the intensity of a lidar's returns follows the colour.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from PIL import Image

SIDE = 128
"""Side of a print, texels. It covers each side of a thing."""


def _barcode(row: int, column: int) -> bool:
    return 84 <= row < 104 and 70 <= column < 116 and (column * 2654435761 >> 7) % 5 < 2


def carton(row: int, column: int) -> float:
    """Return the brightness of cardboard with a tape, a barcode and two arrows that point up."""
    arrow = min(abs(column - 22), abs(column - 44))
    if _barcode(row, column) or (84 <= row < 94 and arrow <= row - 84) or (94 <= row < 104 and arrow <= 2):
        return 0.35
    return 0.86 if 54 <= row < 68 else 1.0


def film(row: int, column: int) -> float:
    """Return the brightness of stretch film with folds, and a label with a barcode."""
    if _barcode(row, column):
        return 0.25
    label = 78 <= row < 110 and 62 <= column < 122
    return 0.78 if label else 0.92 + 0.08 * math.sin((row + 3 * column) / 9) ** 2


def boards(row: int, column: int) -> float:
    """Return the brightness of boards with gaps."""
    return 0.45 if column % 16 < 2 else 0.88 + 0.03 * ((column // 16) * 7 % 5)


def ribs(row: int, column: int) -> float:
    """Return the brightness of plastic with a rim and ribs."""
    return 0.72 if row < 10 or column % 16 < 4 else 1.0


def stripes(row: int, column: int) -> float:
    """Return the brightness of slanted black stripes."""
    return 0.12 if (row + column) % 64 < 28 else 1.0


def panels(row: int, column: int) -> float:
    """Return the brightness of panels with joints."""
    return 0.84 if column % 8 == 0 or row % 64 == 0 else 1.0


PRINTS: Mapping[str, Callable[[int, int], float]] = {
    "carton_light": carton,
    "carton": carton,
    "carton_dark": carton,
    "wrap": film,
    "wood": boards,
    "crate": ribs,
    "yellow": stripes,
    "wall": panels,
    "wall_band": panels,
    "shutter": ribs,
}
"""Function that returns the brightness, 0 to 1, at a row and a column of the print on a material, by the material's name."""


FACES: Mapping[str, int] = {"right": 1, "left": 3, "up": 2, "down": 0, "front": 0, "back": 0}
"""Quarter turns, counter-clockwise, of a print on each face of MuJoCo's cube (+x, -x, +y, -y, +z, -z), so that it is upright."""


def faces(material: str) -> dict[str, str]:
    """Return the files of a material's print as attributes of a cube texture."""
    name = PRINTS[material].__name__
    return {f"file{face}": f"prints/{name}_{turns}.png" for face, turns in FACES.items()}


def write_prints(folder: Path) -> None:
    """Write each print into a folder, in each of its turns, as grey PNG files."""
    folder.mkdir(exist_ok=True)
    for draw in dict.fromkeys(PRINTS.values()):
        upright = np.array(
            [[round(255 * draw(row, column)) for column in range(SIDE)] for row in range(SIDE)], np.uint8
        )
        for turns in sorted(set(FACES.values())):
            Image.fromarray(np.rot90(upright, turns)).save(folder / f"{draw.__name__}_{turns}.png", optimize=True)
