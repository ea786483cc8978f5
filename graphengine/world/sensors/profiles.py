"""Sensor profiles: `scenes/sensors/<name>.yaml`, the figures of a sensor, or what a rig of several is made of."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, field_validator, model_validator

from graphengine.diagnostics import Findings
from graphengine.files import Files, NotFoundError, shipped
from graphengine.spec import UPRIGHT, Format, Loaded, Name, NotNegative, Orientation, Positive, Spec, Vector, read
from graphengine.world.robotfile import RobotFile

Pair = Annotated[tuple[float, float], Field(strict=False)]
MAX_BEAMS = 100_000
PixelCount = Annotated[int, Field(ge=1, le=8192)]

OWN_PROFILES = {"realsense_d455": "realsense_d455", "camera": "camera", "imu": "imu", "contact": "contact"}
"""The profile that a type of sensor has when its robot file names none."""


class BeamsSpec(Spec):
    """Beams in the sensor's xy plane, counter-clockwise from its x axis, evenly spaced."""

    first_deg: float = Field(ge=-360, le=360)
    last_deg: float = Field(ge=-360, le=360)
    count: int = Field(ge=2, le=MAX_BEAMS)


class LidarProfile(Spec):
    """A ray-casting range sensor."""

    rate: Positive = Field(le=10_000, description="Sweeps a second.")
    beams: BeamsSpec
    near: NotNegative = Field(description="Nearest distance reported, m.")
    far: Positive = Field(description="Farthest distance reported, m.")


class CameraProfile(Spec):
    """A pinhole camera with square pixels."""

    size: Annotated[tuple[PixelCount, PixelCount], Field(strict=False)] = Field(description="Width and height, pixels.")
    fov_deg: Pair = Field(description="Horizontal and vertical field of view; pictures take the horizontal one.")
    clip: Pair = Field(default=(0.01, 100.0), description="Nearest and farthest distance seen, m.")
    rate: Positive = Field(default=30.0, le=10_000, description="Pictures a second.")
    latency: NotNegative = Field(default=0.1, le=10.0, description="From capture to delivery, s; at least one tick.")
    depth: bool = Field(default=False, description="Whether it is made to measure distance.")
    colour_noise: NotNegative = Field(default=0.0, description="Standard deviation of a colour, 0 to 255.")
    depth_noise: NotNegative = Field(
        default=0.0, description="Standard deviation of a depth at 1 m, m; it grows with the square of the distance."
    )

    @field_validator("fov_deg")
    @classmethod
    def _a_pinhole_sees(cls, degrees: tuple[float, float]) -> tuple[float, float]:
        if not all(0.0 < degree < 180.0 for degree in degrees):
            raise ValueError("a pinhole camera sees more than 0 and less than 180 degrees")
        return degrees

    @field_validator("clip")
    @classmethod
    def _in_front(cls, clip: tuple[float, float]) -> tuple[float, float]:
        if not 0.0 < clip[0] < clip[1]:
            raise ValueError("write [nearest, farthest], both more than 0")
        return clip


class ImuProfile(Spec):
    """An inertial measurement unit. Noise is white, per sample and axis."""

    rate: Positive = Field(default=100.0, le=10_000, description="Samples a second.")
    acceleration_noise: NotNegative = Field(default=0.0, description="Standard deviation, m/s2.")
    angular_velocity_noise: NotNegative = Field(default=0.0, description="Standard deviation, rad/s.")
    acceleration_bias: Vector = Field(default=(0.0, 0.0, 0.0), description="Added to each reading, m/s2.")
    angular_velocity_bias: Vector = Field(default=(0.0, 0.0, 0.0), description="Added to each reading, rad/s.")


class ContactProfile(Spec):
    """A contact sensor on the body that carries it."""

    threshold: NotNegative = Field(default=0.0, description="Force below which nothing is felt, N.")
    limit: Positive = Field(default=100_000.0, description="Greatest force reported, N.")
    radius: NotNegative = Field(
        default=0.0, description="Contacts farther from the sensor are not felt, m; 0: all count."
    )


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

    @model_validator(mode="after")
    def _one_section(self) -> SensorProfile:
        sections = ("lidar", "camera", "imu", "contact", "rig")
        if sum(getattr(self, section) is not None for section in sections) != 1:
            raise ValueError(f"a profile is one of: {', '.join(sections)}")
        return self


def angles(beams: BeamsSpec) -> tuple[float, float, float]:
    """Azimuth of the first and last beam and between two beams, rad."""
    first, last = math.radians(beams.first_deg), math.radians(beams.last_deg)
    return first, last, (last - first) / (beams.count - 1)


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
                findings.add(
                    "S101", f"no sensor profile {profile!r}", span, error.help[0].replace("sensors/", ""), _known()
                )
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
