"""Converts Gazebo cameras to sensor profiles."""

from __future__ import annotations

import math
from typing import Any

from graphengine.bringup.robots.gazebo_figures import Figures, noise, rate
from graphengine.bringup.robots.gazebo_values import Subject, UnusableError, Values
from graphengine.format.wording import printable


def camera(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a colour camera."""
    profile = _pinhole(values, sensor)
    if deviation := noise(values, sensor, ("camera", "noise"), ("noise",)):
        profile["colour_noise"] = round(min(deviation, 1.0) * 255.0, 6)  # Gazebo's colours go from 0 to 1
    return Figures("camera", "camera", profile, _resolution_told(profile))


def depth_camera(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a depth camera."""
    return _with_depth(values, sensor, "depth_camera", "depth")


def rgbd_camera(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a camera with colour and depth."""
    return _with_depth(values, sensor, "rgbd_camera", "colour and depth")


def _pinhole(values: Values, sensor: Subject) -> dict[str, Any]:
    camera: tuple[str, ...] = ("camera",)
    if values.find("camera") is None and values.find("horizontal_fov") is not None:
        camera = ()
        sensor.guessed("its values are not in <camera>, where Gazebo looks for them")
    size = [values.number(*camera, "image", side, default=d) for side, d in (("width", 320.0), ("height", 240.0))]
    for side, length in zip(("width", "height"), size, strict=True):
        if not 1.0 <= length <= 1e6:
            raise UnusableError(f"image {side} {length:g} is not a valid number of pixels", sensor.span)
    wide = values.number(*camera, "horizontal_fov", default=1.047)
    if not 0.0 < wide < math.pi:
        raise UnusableError(
            f"horizontal_fov {wide:g} rad: a pinhole camera needs a value between 0 and pi", sensor.span
        )
    width, height = (int(length) for length in size)
    tall = 2.0 * math.atan(math.tan(wide / 2.0) * height / width)
    pixels = values.text(*camera, "image", "format")
    if pixels.upper().startswith(("L8", "L16", "L_", "BAYER")):
        sensor.lost(f"image format {printable(pixels[:40])!r}; images are rgb8")
    return {
        "size": [width, height],
        "fov_deg": [round(math.degrees(angle), 6) for angle in (wide, tall)],
        "clip": [values.number(*camera, "clip", end, default=d) for end, d in (("near", 0.1), ("far", 100.0))],
        "rate": rate(values, 30.0, sensor),
    }


def _with_depth(values: Values, sensor: Subject, graph: str, images: str) -> Figures:
    profile = _pinhole(values, sensor) | {"depth": True}
    values.skip("camera", "depth_camera", "output")
    clip = [values.number("camera", "depth_camera", "clip", end) for end in ("near", "far")]
    if all(clip):
        profile["clip"] = clip
    if deviation := noise(values, sensor, ("camera", "noise"), ("noise",)):
        profile["depth_noise"] = deviation
        text = f"noise of {deviation:g} m: taken for that at 1 m, as here it grows with the square of the distance"
        sensor.guessed(text)
    return Figures("camera", graph, profile, f"{images} {_resolution_told(profile)}")


def _resolution_told(profile: dict[str, Any]) -> str:
    width, height = profile["size"]
    return f"camera of {width} x {height} pixels"
