"""Encodes camera images for browsers; distances become colours from near to far."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

NEAR_TO_FAR = ((220, 40, 40), (250, 190, 40), (120, 200, 60), (40, 180, 160), (40, 90, 220))
"""Colours of distances, the nearest first."""
QUALITY = 85


def encoded_image(pixels: NDArray[Any]) -> Mapping[str, str]:
    """Return `source`, a data URL of an image, and `range`, the distances in it; the range of a colour image is empty.

    Args:
        pixels: colours, shape (height, width, 3), or distances, m, shape (height, width).
    """
    shown = ""
    if pixels.ndim == 2:
        pixels, shown = coloured(pixels)
    encoded = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(encoded, "JPEG", quality=QUALITY)
    text = base64.b64encode(encoded.getvalue()).decode()
    return {"source": f"data:image/jpeg;base64,{text}", "range": shown}


def coloured(depths: NDArray[Any]) -> tuple[NDArray[np.uint8], str]:
    """Return an image of distances, in which pixels without a surface are black, and the text of their range."""
    hit = np.isfinite(depths)
    if not hit.any():
        return np.zeros((*depths.shape, 3), np.uint8), "no surface in range"
    near, far = float(depths[hit].min()), float(depths[hit].max())
    share = np.where(hit, (depths - near) / max(far - near, 1e-9), 0.0)
    image = mixed(NEAR_TO_FAR, share)
    image[~hit] = 0
    return image, f"{near:.2f} m (red) to {far:.2f} m (blue)"


def mixed(steps: tuple[tuple[int, int, int], ...], where: NDArray[Any]) -> NDArray[np.uint8]:
    """Return a colour for each value in `where`: 0 gives the first of `steps`, 1 the last, values between interpolate."""
    columns = np.array(steps, float).T
    parts = [np.interp(where, np.linspace(0.0, 1.0, len(steps)), column) for column in columns]
    return np.stack(parts, axis=-1).astype(np.uint8)
