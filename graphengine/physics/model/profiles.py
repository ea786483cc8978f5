"""Sensor profiles: `scenes/sensors/<name>.yaml`, the figures of a sensor, or what a rig of several is made of."""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from graphengine.devices.sensor import LARGEST_PICTURE
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files, NotFoundError, shipped
from graphengine.format.spec import UPRIGHT, Format, Name, NotNegative, Orientation, Positive, Spec, Vector
from graphengine.format.spec_reader import Loaded, read
from graphengine.physics.description.robot_file import RobotFile

Pair = Annotated[tuple[float, float], Field(strict=False)]
Elevation = Annotated[float, Field(ge=-90, le=90)]
MAX_BEAMS = 500_000
PixelCount = Annotated[int, Field(ge=1, le=LARGEST_PICTURE)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Length = Annotated[float, Field(gt=0.0, le=10.0)]
Rate = Annotated[float, Field(ge=0.001, le=10_000.0)]
Deviation = Annotated[float, Field(ge=0.0, le=1000.0)]
Offset = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Offsets = Annotated[tuple[Offset, Offset, Offset], Field(strict=False)]

OWN_PROFILES = {"realsense_d455": "realsense_d455", "camera": "camera", "imu": "imu", "contact": "contact"}
"""The profile that a type of sensor has when its robot file names none."""


class BeamsSpec(Spec):
    """Beams of a ring, counter-clockwise from the sensor's x axis, evenly spaced."""

    first_deg: float = Field(ge=-360, le=360)
    last_deg: float = Field(ge=-360, le=360)
    count: int = Field(ge=2, le=MAX_BEAMS)

    @model_validator(mode="after")
    def _once_around(self) -> BeamsSpec:
        if not 0.0 < self.last_deg - self.first_deg <= 360.0:
            raise ValueError(
                "beams go counter-clockwise and once around: last_deg is more than first_deg, by at most 360"
            )
        return self


class RingsSpec(Spec):
    """Rings of a 3D lidar, from the lowest up: evenly spaced, or one by one."""

    first_deg: Elevation | None = None
    last_deg: Elevation | None = None
    count: int | None = Field(default=None, ge=2, le=1024)
    each_deg: Annotated[tuple[Elevation, ...], Field(strict=False, min_length=1, max_length=1024)] | None = Field(
        default=None, description="Angle of each ring above the sensor's xy plane, in place of first, last and count."
    )

    @model_validator(mode="after")
    def _upwards(self) -> RingsSpec:
        spaced = (self.first_deg, self.last_deg, self.count)
        if (self.each_deg is None) == (spaced == (None, None, None)) or (self.each_deg is None and None in spaced):
            raise ValueError("rings have first_deg, last_deg and count, or each_deg")
        angles = self.each_deg or (self.first_deg, self.last_deg)
        if any(not low < high for low, high in itertools.pairwise(angles)):  # type: ignore[operator]
            raise ValueError("rings go upwards: each is higher than the one before")
        return self

    @property
    def degrees(self) -> tuple[float, ...]:
        """Angle of each ring."""
        if self.first_deg is None or self.last_deg is None or self.count is None:
            return self.each_deg or ()
        step = (self.last_deg - self.first_deg) / (self.count - 1)
        return tuple(self.first_deg + step * ring for ring in range(self.count))


class LidarProfile(Spec):
    """A ray-casting range sensor."""

    rate: Rate = Field(description="Sweeps a second.")
    beams: BeamsSpec
    rings: RingsSpec | None = Field(
        default=None, description="Rings of a 3D lidar; without, one in the sensor's xy plane."
    )
    near: NotNegative = Field(description="Nearest distance reported, m.")
    far: Positive = Field(le=1_000_000, description="Farthest distance reported, m.")
    noise_std: Deviation = Field(default=0.0, description="Standard deviation of a distance, m.")
    resolution: NotNegative = Field(
        default=0.0, description="Distances are multiples of it, m; 0: they are not rounded."
    )

    @model_validator(mode="after")
    def _in_bounds(self) -> LidarProfile:
        if not self.near < self.far:
            raise ValueError(f"near must be less than far, and {self.near:g} is not less than {self.far:g}")
        if self.resolution and not 1e-6 <= self.resolution < self.far:
            raise ValueError("resolution is a micrometre at least and less than far, or 0")
        rings = len(self.elevations)
        if rings * self.beams.count > MAX_BEAMS:
            raise ValueError(
                f"{rings} rings of {self.beams.count} beams are too many: at most {MAX_BEAMS} beams in all"
            )
        return self

    @property
    def angles(self) -> tuple[float, float, float]:
        """Azimuth of the first and last beam of a ring and between two beams, rad."""
        first, last = math.radians(self.beams.first_deg), math.radians(self.beams.last_deg)
        return first, last, (last - first) / (self.beams.count - 1)

    @property
    def elevations(self) -> tuple[float, ...]:
        """Angle of each ring above the sensor's xy plane, rad."""
        return tuple(map(math.radians, self.rings.degrees)) if self.rings is not None else (0.0,)


class CameraProfile(Spec):
    """A pinhole camera with square pixels."""

    size: Annotated[tuple[PixelCount, PixelCount], Field(strict=False)] = Field(description="Width and height, pixels.")
    fov_deg: Pair = Field(description="Horizontal and vertical field of view; pictures take the horizontal one.")
    clip: Pair = Field(default=(0.01, 100.0), description="Nearest and farthest distance seen, m.")
    rate: Rate = Field(default=30.0, description="Pictures a second.")
    latency: NotNegative = Field(default=0.1, le=10.0, description="From capture to delivery, s; at least one tick.")
    depth: bool = Field(default=False, description="Whether it is made to measure distance.")
    colour_noise: NotNegative = Field(default=0.0, le=255, description="Standard deviation of a colour, 0 to 255.")
    depth_noise: Deviation = Field(
        default=0.0, description="Standard deviation of a depth at 1 m, m; it grows with the square of the distance."
    )

    @field_validator("fov_deg")
    @classmethod
    def _a_pinhole_sees(cls, degrees: tuple[float, float]) -> tuple[float, float]:
        if not all(0.1 <= degree <= 179.0 for degree in degrees):
            raise ValueError("a pinhole camera sees from 0.1 to 179 degrees")
        return degrees

    @field_validator("clip")
    @classmethod
    def _in_front(cls, clip: tuple[float, float]) -> tuple[float, float]:
        if not 0.001 <= clip[0] < clip[1] <= 1_000_000.0:
            raise ValueError("write [nearest, farthest], from 0.001 to 1000000 m")
        return clip


class ImuProfile(Spec):
    """An inertial measurement unit. Noise is white, per sample and axis."""

    rate: Rate = Field(default=100.0, description="Samples a second.")
    acceleration_noise: Deviation = Field(default=0.0, description="Standard deviation, m/s2.")
    angular_velocity_noise: Deviation = Field(default=0.0, description="Standard deviation, rad/s.")
    acceleration_bias: Offsets = Field(default=(0.0, 0.0, 0.0), description="Added to each reading, m/s2.")
    angular_velocity_bias: Offsets = Field(default=(0.0, 0.0, 0.0), description="Added to each reading, rad/s.")


class ContactProfile(Spec):
    """A contact sensor on the body that carries it."""

    threshold: NotNegative = Field(default=0.0, description="Force below which nothing is felt, N.")
    limit: Positive = Field(default=100_000.0, description="Greatest force reported, N.")
    radius: NotNegative = Field(
        default=0.0, description="Contacts farther from the sensor are not felt, m; 0: all count."
    )

    @model_validator(mode="after")
    def _feels_something(self) -> ContactProfile:
        if not self.threshold < self.limit:
            raise ValueError(
                f"threshold must be less than limit, and {self.threshold:g} is not less than {self.limit:g}"
            )
        return self


class PartSpec(Spec):
    """A camera or an inertial unit of a rig. A camera looks along its -z axis, +y is up in its picture."""

    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT
    camera: CameraProfile | None = None
    imu: ImuProfile | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> PartSpec:
        if (self.camera is None) == (self.imu is None):
            raise ValueError("a part is a camera or an imu")
        return self


class RigProfile(Spec):
    """Cameras and inertial units in one housing."""

    housing: Name = Field(description="Prim that carries the parts.")
    parts: dict[Name, PartSpec]


class ShapeSpec(Spec):
    """A part of a sensor's body, which cameras and the rays of other robots see; nothing collides with it."""

    shape: Literal["box", "cylinder"]
    size: Annotated[tuple[Length, Length, Length], Field(strict=False)] = Field(
        description="Length, width and height, m; a cylinder stands upright and is round."
    )
    position: Offsets = Field(default=(0.0, 0.0, 0.0), description="Of its middle, in the frame of the sensor's mount.")
    colour: Annotated[tuple[Share, Share, Share], Field(strict=False)] = Field(description="Red, green, blue; 0 to 1.")

    @model_validator(mode="after")
    def _round(self) -> ShapeSpec:
        if self.shape == "cylinder" and self.size[0] != self.size[1]:
            raise ValueError("a cylinder is as wide as it is long")
        return self


class SensorProfile(Spec):
    """A sensor profile file."""

    format: Format = 1
    sensor: Name
    doc: str = ""
    lidar: LidarProfile | None = None
    camera: CameraProfile | None = None
    imu: ImuProfile | None = None
    contact: ContactProfile | None = None
    rig: RigProfile | None = None
    appearance: Annotated[tuple[ShapeSpec, ...], Field(strict=False, max_length=100)] = Field(
        default=(), description="What it looks like to cameras and to the rays of other robots."
    )

    @model_validator(mode="after")
    def _one_section(self) -> SensorProfile:
        sections = ("lidar", "camera", "imu", "contact", "rig")
        if sum(getattr(self, section) is not None for section in sections) != 1:
            raise ValueError(f"a profile is one of: {', '.join(sections)}")
        return self


def read_profiles(robot: RobotFile, files: Files, findings: Findings) -> dict[str, SensorProfile]:
    """The profile of each sensor of a robot, by the sensor's name."""
    found: dict[str, SensorProfile] = {}
    loaded: dict[str, Loaded[SensorProfile] | None] = {}
    for name, sensor in robot.spec.sensors.items():
        profile = sensor.profile or OWN_PROFILES.get(sensor.type, "")
        span = robot.span("sensors", name, "profile")
        if not profile:
            findings.add(
                "G107", f"sensor {name!r}: a {sensor.type} needs a profile", robot.key_span("sensors", name), _known()
            )
            continue
        if profile not in loaded:
            try:
                path = files.find(f"sensors/{profile}.yaml", robot.folder("sensors", name, "profile"))
            except NotFoundError as error:
                near = error.help[0].replace("sensors/", "").replace(".yaml", "")
                findings.add("S101", f"no sensor profile {profile!r}", span, near, _known())
                continue
            loaded[profile] = read(SensorProfile, path, findings)
        entry = loaded[profile]
        if entry is None:
            continue
        kind = "rig" if sensor.type == "realsense_d455" else sensor.type
        if getattr(entry.spec, kind) is None:
            findings.add("G109", f"profile {profile!r} is not one of a {sensor.type}", span, _known())
        else:
            found[name] = entry.spec
    return found


def _known() -> str:
    return "profiles that ship: " + ", ".join(
        sorted(path.stem for path in (shipped() / "scenes/sensors").glob("*.yaml"))
    )
