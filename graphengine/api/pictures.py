"""Renders images of a session's world from a view or from a camera prim."""

from __future__ import annotations

import colorsys
import contextlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.backend import World
from graphengine.devices.stage import Prim
from graphengine.format.atomic_write import write_together
from graphengine.format.errors import PrimError, UsageError
from graphengine.format.wording import did_you_mean, listing

if TYPE_CHECKING:
    from graphengine.devices.camera import Picture
    from graphengine.physics.pictures.rendering import Image
    from graphengine.physics.simulation import Simulation

SIZE = (1280, 720)
"""Default width and height of images of a view, pixels."""
MILLIMETRES = 1000
"""Millimetres in a metre. 16 bit depth images of ROS are in mm."""


def simulated(world: World) -> Simulation:
    """Return the session's world as a Simulation, the only kind of world that has a MuJoCo model.

    Raises:
        UsageError: the session runs a graph without a scene.
    """
    from graphengine.physics.simulation import Simulation

    if not isinstance(world, Simulation):
        raise UsageError("a graph without a scene has no MuJoCo model and nothing to draw; give a scene with --scene")
    return world


def find_camera(world: Simulation, name: str) -> Prim | None:
    """Return the camera prim with this name or path; return None if a view has the name.

    Views are `top`, `perspective`, `follow` and the MuJoCo cameras. A view takes precedence over a camera prim of the same name.

    Raises:
        UsageError: neither a view nor a camera prim has the name, or several camera prims have it.
    """
    from graphengine.physics.views import views

    known, stage = views.names(world), world.stage
    if name in known:
        return None
    cameras = list(stage.prims("camera"))
    named = [prim for prim in cameras if prim.name == name]
    with contextlib.suppress(PrimError):
        named = named or [prim for prim in cameras if prim is stage.find(name)]
    if len(named) == 1:
        return named[0]
    paths = [prim.path for prim in named or cameras]
    if named:
        raise UsageError(f"{name}: {len(named)} cameras have this name\n  {listing(paths, 'write one of')}")
    near = did_you_mean(name, [*known, *paths, *(prim.name for prim in cameras)])
    raise UsageError(
        f"{name}: there is no view or camera with this name or path\n  "
        + (near or f"{listing(known, 'views')}\n  {listing(paths, 'cameras')}")
    )


def look(
    world: Simulation, name: str, size: tuple[int, int] | None = None, *, segmentation: bool = False
) -> Picture | Image:
    """Return an image of the world from a view or a camera prim; from a camera prim, it is the image that graphs receive.

    Args:
        world: world to draw, in its current state.
        name: name of a view, or name or path of a camera prim.
        size: width and height, pixels; None takes the camera's own size, or `SIZE` for a view.
        segmentation: whether to add the segmentation ID of the prim at each pixel.

    Raises:
        RenderError: OpenGL is missing or failed.
        UsageError: no view or camera has the name, or several camera prims have it.
    """
    from graphengine.physics.sensors.camera import PinholeCamera
    from graphengine.physics.views import views

    prim = find_camera(world, name)
    if prim is not None:
        return world.device(PinholeCamera, prim, size=size).picture(segmentation=segmentation)
    return views.draw(world, views.find_view(world, name, size or SIZE), segmentation=segmentation)


def write_png(pixels: NDArray[Any], path: Path) -> None:
    """Write pixels to a PNG file.

    Raises:
        OSError: the file cannot be written.
    """
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(pixels).save(content, "PNG", optimize=True)
    write_together({path: content.getvalue()})


def depth_in_millimetres(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Convert depths from m to 16 bit mm, as in ROS; depths that do not fit become 0."""
    scaled = np.rint(depth * MILLIMETRES)
    return np.where(scaled <= np.iinfo(np.uint16).max, scaled, 0).astype(np.uint16)


def segmentation_colours(numbers: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Return an RGB image with one colour per segmentation ID. Successive IDs have distant hues; the background, 0, is black."""
    return np.array([_colour(number) for number in range(int(numbers.max()) + 1)], np.uint8)[numbers]


def segmentation_legend(numbers: NDArray[np.int32], labels: Mapping[int, str]) -> list[tuple[str, int, str]]:
    """Return colour (`#rrggbb`), number of pixels and prim path of each prim in a segmentation image.

    Args:
        numbers: segmentation ID at each pixel.
        labels: prim path of each segmentation ID.
    """
    found, counts = np.unique(numbers, return_counts=True)
    return [
        ("#{:02x}{:02x}{:02x}".format(*_colour(number)), count, labels.get(number, "background"))
        for number, count in zip(found.tolist(), counts.tolist(), strict=True)
    ]


def _colour(number: int) -> tuple[int, int, int]:
    if number == 0:
        return (0, 0, 0)
    hue = number * 0.618034 % 1.0  # the golden ratio
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.45 + 0.15 * (number % 4), 0.95 - 0.15 * (number % 3))
    return round(255 * red), round(255 * green), round(255 * blue)
