"""Converts Gazebo sensors to sensor profiles; `READERS` has a function for each sensor type."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from graphengine.bringup.robots.gazebo_values import GAZEBO_NAMES, Figures, Subject, UnusableError, Values, noise, rate
from graphengine.descriptions.files.xml import numbers
from graphengine.format.wording import printable

_AXES = ("x", "y", "z")
_FRAMES = ("child", "parent", "sensor")
_DIRECTIONS = ("child_to_parent", "parent_to_child")


class _Triad(NamedTuple):
    """The accelerometers or gyroscopes of the three axes of an IMU.

    Attributes:
        section: name in SDF.
        classic: name in Gazebo classic.
        name: prefix of keys in a profile.
        device: section of a profile.
        instability: key of the bias instability in that section.
        units: units of the bias instability per SI unit.
    """

    section: str
    classic: str
    name: str
    device: str
    instability: str
    units: float


_TRIADS = (
    _Triad("linear_acceleration", "accel", "acceleration", "accelerometer", "bias_instability_ug", 1e6 / 9.80665),
    _Triad("angular_velocity", "rate", "angular_velocity", "gyroscope", "bias_instability_dph", math.degrees(3600.0)),
)
_SPREADS = ("stddev", "dynamic_bias_stddev", "dynamic_bias_correlation_time")
"""Quantities of an IMU's noise for which a profile has one value for all axes."""
_COARSEST = 0.1
"""Largest range resolution (m) that is used; larger values, such as 1 m in many descriptions, are placeholders."""


def ray(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a ray sensor.

    A sensor with a single ray, or with a plugin that publishes sensor_msgs/Range, becomes a range sensor; else a lidar.
    """
    wide, tall = _Arc.of(values, sensor, "horizontal", 640), _Arc.of(values, sensor, "vertical", 1)
    near = values.number("lidar|ray", "range", "min", default=0.08)
    far = values.number("lidar|ray", "range", "max", default=10.0)
    profile: dict[str, Any] = {"rate": rate(values, 10.0, sensor)}
    deviation = noise(values, sensor, ("lidar|ray", "noise"), ("noise",))
    extra = _given(noise_std=deviation, resolution=_resolution(values, far, sensor))
    single = wide.count == 1 and tall.count == 1
    output = values.text("plugin", "output_type").rpartition("/")[2]
    if single or output == "Range" or "range" in (plugin := _plugin(values)) or "sonar" in plugin:
        if single and output != "Range":
            sensor.guessed("one ray: a range sensor, published as sensor_msgs/Range")
        radiation = values.text("plugin", "radiation_type|radiation").lower()
        width = max(wide.width, tall.width) or math.radians(1.0)
        profile |= {
            "radiation_type": radiation if radiation in ("ultrasound", "infrared") else "infrared",
            "field_of_view": round(min(width, math.pi), 6),
            "min_range": near,
            "max_range": far,
        }
        return Figures("range", "range", profile | extra, f"range sensor to {far:g} m")
    if wide.count == 1:
        raise UnusableError("a lidar needs at least two beams in a ring", sensor.span)
    first, last = sorted((wide.first, wide.last))
    if last - first > 360.0:
        if last - first > 360.1:
            sensor.lost(f"its beams go {last - first:g} degrees around; the profile has 360")
        last = first + 360.0
    profile["beams"] = {"first_deg": first, "last_deg": last, "count": wide.count}
    told = f"lidar of {wide.count} beams"
    if tall.count > 1 and tall.width:
        low, high = sorted((tall.first, tall.last))
        profile["rings"] = {"first_deg": low, "last_deg": high, "count": tall.count}
        told = f"lidar of {tall.count} rings with {wide.count} beams each"
    elif tall.first:
        profile["rings"] = {"each_deg": [tall.first]}
    several = (tall.count > 1 and tall.width > 0.0) or output.startswith("PointCloud") or "velodyne" in _plugin(values)
    return Figures("lidar", "points" if several else "scan", profile | {"near": near, "far": far} | extra, told)


def sonar(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a sonar, whose field of view follows from SDF's radius at maximum range."""
    near, far = values.number("sonar", "min"), values.number("sonar", "max", default=5.0)
    radius = values.number("sonar", "radius", default=0.5)
    values.skip("sonar", "geometry")
    if far <= 0.0:
        raise UnusableError("the maximum range must be greater than 0 m", sensor.span)
    profile = {
        "radiation_type": "ultrasound",
        "rate": rate(values, 10.0, sensor),
        "field_of_view": round(2.0 * math.atan(abs(radius) / far), 6),
        "min_range": near,
        "max_range": far,
    }
    return Figures("range", "range", profile, f"range sensor to {far:g} m")


def imu(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of an IMU; the profile has the largest noise of the three axes for all axes."""
    profile: dict[str, Any] = {"rate": rate(values, 100.0, sensor)}
    for triad in _TRIADS:
        names = ("mean", "bias_mean", *_SPREADS)
        quantities = {name: [_of_axis(values, triad, axis, name) for axis in _AXES] for name in names}
        for name in _SPREADS:
            if len(set(quantities[name])) > 1:
                sensor.guessed(f"{name} of {triad.section}: the profile has one for all axes, the greatest")
        deviation, drift, time = (max(quantities[name]) for name in _SPREADS)
        deviation = deviation or _of_plugin(values, triad)
        bias = [mean + offset for mean, offset in zip(quantities["mean"], quantities["bias_mean"], strict=True)]
        profile |= _given(**{f"{triad.name}_noise": deviation})
        profile |= {f"{triad.name}_bias": bias} if any(bias) else {}
        if drift and time > 0.0:
            # In Gazebo, the deviation per root of a second drives the bias; a profile has the resulting deviation of the bias.
            instability = drift * math.sqrt(time / 2.0) * triad.units
            profile[triad.device] = {triad.instability: float(f"{instability:.6g}"), "bias_correlation_time": time}
    values.text("imu", "noise", "type")
    return Figures("imu", "imu", profile, "imu")


def contact(values: Values, sensor: Subject) -> Figures:
    """Return the type and graph of a contact sensor, which detects contacts of all colliders of its link."""
    values.skip("contact", "collision")
    values.skip("update_rate")
    sensor.guessed("published each tick as std_msgs/Bool, without the positions of contacts")
    return Figures("contact", "contact", {}, "contact sensor")


def camera(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a colour camera."""
    profile = _pinhole(values, sensor)
    if deviation := noise(values, sensor, ("camera", "noise"), ("noise",)):
        profile["colour_noise"] = round(min(deviation, 1.0) * 255.0, 6)  # Gazebo's colours go from 0 to 1
    return Figures("camera", "camera", profile, _resolution_told(profile))


def depth_camera(values: Values, sensor: Subject, graph: str, images: str) -> Figures:
    """Return the type, graph and profile of a camera with depth; `images` names the images that the graph publishes."""
    profile = _pinhole(values, sensor) | {"depth": True}
    values.skip("camera", "depth_camera", "output")
    clip = [values.number("camera", "depth_camera", "clip", end) for end in ("near", "far")]
    if all(clip):
        profile["clip"] = clip
    if deviation := noise(values, sensor, ("camera", "noise"), ("noise",)):
        profile["depth_noise"] = deviation
        reason = "taken for that at 1 m, as here it grows with the square of the distance"
        sensor.guessed(f"noise of {deviation:g} m: {reason}")
    return Figures("camera", graph, profile, f"{images} {_resolution_told(profile)}")


def navsat(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a receiver for satellite navigation."""
    profile: dict[str, Any] = {"rate": rate(values, 5.0, sensor)}
    for axis in ("horizontal", "vertical"):
        if deviation := noise(values, sensor, ("navsat|gps", "position_sensing", axis, "noise")):
            profile[f"{axis}_noise"] = deviation
    return Figures("navsat", "navsat", profile, "navsat receiver")


def force_torque(values: Values, sensor: Subject) -> Figures:
    """Return the type, graph and profile of a force-torque sensor; all axes have the largest noise of Gazebo's values.

    In Gazebo, values have the axes of the child link by default; the sensor then has the orientation of this link.
    """
    profile: dict[str, Any] = {"rate": rate(values, 60.0, sensor)}
    frame = _word(values, "frame", _FRAMES)
    if (direction := _word(values, "measure_direction", _DIRECTIONS)) != _DIRECTIONS[0]:
        profile["measure_direction"] = direction
    if frame == "parent":
        profile["axes"] = "parent"
        sensor.guessed("force and torque have the axes of the parent link; the torque is about the sensor")
    for quantity in ("force", "torque"):
        deviations = [noise(values, sensor, ("force_torque", quantity, axis, "noise")) for axis in _AXES]
        if len(set(deviations)) > 1:
            sensor.guessed(f"noise of {quantity}: the profile has one for all axes, the greatest")
        if deviation := max(deviations):
            profile[f"{quantity}_noise"] = deviation
    return Figures("force_torque", "force_torque", profile, "force-torque sensor", turned=frame == "sensor")


_rgbd_camera = partial(depth_camera, graph="rgbd_camera", images="colour and depth")
"""Converts also the sensor type `depth` of Gazebo classic, because its plugins publish colours too."""
READERS: dict[str, Callable[[Values, Subject], Figures]] = {
    **dict.fromkeys(("ray", "gpu_ray", "lidar", "gpu_lidar"), ray),
    "sonar": sonar,
    "imu": imu,
    "camera": camera,
    "depth_camera": partial(depth_camera, graph="depth_camera", images="depth"),
    **dict.fromkeys(("depth", "rgbd_camera", "rgbd"), _rgbd_camera),
    "contact": contact,
    **dict.fromkeys(("navsat", "gps"), navsat),
    "force_torque": force_torque,
}
"""A dict from sensor types in SDF to the functions that convert them."""
NO_LIKE = GAZEBO_NAMES["no_like"]
"""A dict from sensor types in SDF without an equivalent to texts that complete `there is nothing like ...`."""


@dataclass(frozen=True, slots=True)
class _Arc:
    """The rays of a scan in one plane: angles of the first and the last ray (degrees), and the number of rays."""

    first: float
    last: float
    count: int

    @property
    def width(self) -> float:
        """Angle between the first and the last ray, rad."""
        return math.radians(abs(self.last - self.first))

    @classmethod
    def of(cls, values: Values, sensor: Subject, plane: str, samples: int) -> _Arc:
        """Return the rays in a plane of a scan, `horizontal` or `vertical`; `samples` is the default number of rays.

        Raises:
            UnusableError: the scan has no horizontal plane, or an invalid number of rays.
        """
        path = ("lidar|ray", "scan", plane)
        found = values.find(*path)
        if found is None and plane == "horizontal":
            raise UnusableError("the sensor has no <scan><horizontal>", sensor.span)
        count = values.number(*path, "samples", default=samples) * values.number(*path, "resolution", default=1.0)
        if found is not None and not 0.5 <= count <= 1e9:
            raise UnusableError(f"{count:g} samples: not a valid number of rays", found.span)
        first, last = (round(math.degrees(values.number(*path, end)), 6) for end in ("min_angle", "max_angle"))
        if found is not None and first > last:
            text = f"{plane} min_angle {first:g} degrees is above max_angle {last:g}: "
            sensor.guessed(text + "the beams are listed from the smaller to the larger angle")
        return cls(first, last, max(1, round(count)))


def _given(**figures: float) -> dict[str, float]:
    """Return the values other than zero, which is the default in a profile."""
    return {name: value for name, value in figures.items() if value}


def _plugin(values: Values) -> str:
    """Return the file name of a sensor's plugin in lower case; empty without a plugin."""
    found = values.find("plugin")
    return found.get("filename").lower() if found is not None else ""


def _resolution(values: Values, far: float, sensor: Subject) -> float:
    resolution = values.number("lidar|ray", "range", "resolution")
    if resolution and not 1e-6 <= resolution <= min(_COARSEST, far / 2.0):
        sensor.lost(f"range resolution {resolution:g} m: distances are not rounded, as in Gazebo")
        return 0.0
    return resolution


def _word(values: Values, tag: str, legal: tuple[str, ...]) -> str:
    """Return the text of a tag that has one of the `legal` texts; the first of these if the tag is missing.

    Raises:
        UnusableError: the text is not legal.
    """
    text, found = values.text("force_torque", tag), values.find("force_torque", tag)
    if found is not None and text and text not in legal:
        raise UnusableError(f"{tag} must be one of {', '.join(legal)}, not {printable(text[:40])!r}", found.span)
    return text or legal[0]


def _of_axis(values: Values, triad: _Triad, axis: str, quantity: str) -> float:
    """Return a quantity of the noise of an axis; without this noise, of Gazebo classic's common noise of all axes."""
    path = ("imu", triad.section, axis, "noise")
    found = values.find(*path)
    if found is None:
        return values.number("imu", "noise", triad.classic, quantity)
    kind = found.get("type") or values.text(*path, "type")
    return 0.0 if kind == "none" else values.number(*path, quantity)


def _of_plugin(values: Values, triad: _Triad) -> float:
    """Return the largest standard deviation of the axes' noise in a ROS 1 plugin; 0 without noise."""
    texts = (values.text("plugin", f"{triad.classic}GaussianNoise"), values.text("plugin", "gaussianNoise"))
    given = [numbers(text, len(text.split())) or (0.0,) for text in texts if text]
    return max(given[0]) if given else 0.0


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
        need = "a pinhole camera needs a value between 0 and pi"
        raise UnusableError(f"horizontal_fov {wide:g} rad: {need}", sensor.span)
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


def _resolution_told(profile: dict[str, Any]) -> str:
    width, height = profile["size"]
    return f"camera of {width} x {height} pixels"
