"""Sensor profiles: `scenes/sensors/<name>.yaml`, the figures of a lidar or what a camera rig is made of."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from graphengine.diagnostics import Findings
from graphengine.files import Files, NotFoundError, shipped
from graphengine.spec import UPRIGHT, Format, Loaded, Name, NotNegative, Orientation, Positive, Spec, Vector, read
from graphengine.world.robotfile import RobotFile

Pair = Annotated[tuple[float, float], Field(strict=False)]
MAX_BEAMS = 100_000


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


class PartSpec(Spec):
    """A camera or an inertial unit of a rig. A camera looks along its -z axis, +y is up in its picture."""

    kind: Literal["camera", "imu"]
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Orientation = UPRIGHT
    size: Annotated[tuple[int, int], Field(strict=False)] | None = Field(
        default=None, description="Width and height, pixels."
    )
    fov_deg: Pair | None = Field(default=None, description="Horizontal and vertical field of view.")
    clip: Pair | None = Field(default=None, description="Nearest and farthest distance seen, m.")
    depth: bool = Field(default=False, description="Whether it measures distance.")
    rate: Positive = Field(default=30.0, description="Pictures or samples a second.")


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
    rig: RigProfile | None = None


def angles(beams: BeamsSpec) -> tuple[float, float, float]:
    """Azimuth of the first and last beam and between two beams, rad."""
    first, last = math.radians(beams.first_deg), math.radians(beams.last_deg)
    return first, last, (last - first) / (beams.count - 1)


def read_profiles(robot: RobotFile, files: Files, findings: Findings) -> dict[str, SensorProfile]:
    """The profile of each sensor of a robot, by the sensor's name."""
    found: dict[str, SensorProfile] = {}
    loaded: dict[str, Loaded[SensorProfile] | None] = {}
    for name, sensor in robot.spec.sensors.items():
        profile = sensor.profile or ("realsense_d455" if sensor.type == "realsense_d455" else "")
        span = robot.span("sensors", name, "profile")
        if not profile:
            findings.add("G107", f"sensor {name!r}: a lidar needs a profile", robot.key_span("sensors", name), _known())
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
        wanted = entry.spec.lidar if sensor.type == "lidar" else entry.spec.rig
        if wanted is None:
            findings.add("G109", f"profile {profile!r} is not one of a {sensor.type}", span, _known())
        else:
            found[name] = entry.spec
    return found


def _known() -> str:
    return "profiles that ship: " + ", ".join(
        sorted(path.stem for path in (shipped() / "scenes/sensors").glob("*.yaml"))
    )
