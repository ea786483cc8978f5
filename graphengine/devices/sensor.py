"""The Protocols of sensors, and what they hand out.

A sensor has samples: sample n belongs to the first tick at or after n / rate seconds. What a sample holds is shared by all who
read it and never written again. Units are SI; quaternions are (x, y, z, w).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

LARGEST_PICTURE = 8192
"""Greatest width and height of a picture, pixels."""

BOX_3D = np.dtype(
    [
        ("semanticId", "<u4"),
        ("low", "<f4", (3,)),
        ("high", "<f4", (3,)),
        ("transform", "<f4", (4, 4)),
        ("occlusionRatio", "<f4"),
    ]
)
"""One solid box: the number of what is in it, two opposite corners (m); the rows of the matrix are their axes and origin."""


@dataclass(frozen=True, slots=True)
class Scan:
    """One sweep of a lidar; arrays have one entry a beam, ring after ring in order of azimuth, and are never written again."""

    time: float
    """Simulation time of the tick that cast it, s."""
    index: int
    """Number of this sample since play."""
    ranges: NDArray[np.float32]
    """Distance, m; inf where nothing was hit within range."""
    intensities: NDArray[np.float32]
    """0 to 255."""


class Lidar(Protocol):
    """A ray-casting range sensor."""

    @property
    def prim_path(self) -> str:
        """Path of the sensor's prim, where its namespace is collected from."""

    @property
    def rate(self) -> float:
        """Sweeps a second."""

    @property
    def angles(self) -> tuple[float, float, float]:
        """Azimuth of the first beam, of the last beam, and between two beams, rad, counter-clockwise from the sensor's x."""

    @property
    def elevations(self) -> NDArray[np.float64]:
        """Angle of each ring above the sensor's xy plane, rad; one ring at 0 for a planar lidar."""

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors of the beams in the sensor's frame, ring after ring, shape (rings x azimuths, 3)."""

    @property
    def ranges(self) -> tuple[float, float]:
        """Nearest and farthest distance it reports, m."""

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick."""

    @property
    def index(self) -> int:
        """Number of the newest sample since play."""

    def scan(self) -> Scan:
        """The newest sample, cast when first asked for in its tick and shared by all who ask."""


@dataclass(frozen=True, slots=True)
class Picture:
    """What a camera saw at one instant; row 0 is the upper edge."""

    time: float
    """Simulation time of the tick that captured it, s."""
    index: int
    """Number of this sample since play."""
    rgb: NDArray[np.uint8]
    """Shape (height, width, 3)."""
    depth: NDArray[np.float32]
    """Distance along the optical axis, m, shape (height, width); inf where nothing was within the camera's clip range."""
    segmentation: NDArray[np.int32] | None = None
    """Number of the prim seen at each pixel, as in `Camera.labels`; 0 where there is none. None unless somebody asked for it."""
    boxes: NDArray[np.void] | None = None
    """Records of BOX_3D in the optical frame, of all prims that end somewhere, seen or not; they come with a segmentation."""


class Camera(Protocol):
    """A pinhole camera. What it captures in one tick it delivers `latency` ticks later.

    Pixels are square. The optical axis meets the picture at (cx, cy), counted from the upper left corner of the first pixel's
    centre: the middle of a picture of w pixels is at (w - 1) / 2.
    """

    @property
    def prim_path(self) -> str:
        """Path of the camera's prim, where its namespace is collected from."""

    @property
    def rate(self) -> float:
        """Pictures a second."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""

    @property
    def intrinsics(self) -> tuple[float, float, float, float]:
        """Focal lengths fx and fy, and the optical axis cx, cy, in pixels."""

    @property
    def clip(self) -> tuple[float, float]:
        """Nearest and farthest distance along the optical axis that is seen, m."""

    @property
    def latency(self) -> int:
        """Ticks from capture to delivery."""

    @property
    def labels(self) -> Mapping[int, str]:
        """Prim path of each number of a segmentation."""

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick."""

    @property
    def index(self) -> int:
        """Number of the newest sample since play."""

    def request(self, *, segmentation: bool = False) -> None:
        """Capture this tick's sample if one is due; however many ask, it is rendered once."""

    def delivered(self) -> Picture | None:
        """The picture whose turn it is in this tick; the same for all who ask, None in most ticks."""


@dataclass(frozen=True, slots=True)
class ImuSample:
    """What an inertial unit measured, in its own frame."""

    time: float
    """Simulation time, s."""
    index: int
    """Number of this sample since play; -1 before the first, as with a robot that has just come."""
    linear_acceleration: Vector3
    """Rate of change of the velocity, without gravity, m/s2."""
    gravity: Vector3
    """What gravity adds to the reading of an accelerometer: at rest and upright (0, 0, 9.81), m/s2."""
    angular_velocity: Vector3
    """rad/s."""
    orientation: Quaternion
    """Of the sensor in the world frame."""


class Imu(Protocol):
    """An inertial measurement unit."""

    @property
    def prim_path(self) -> str:
        """Path of the sensor's prim."""

    @property
    def rate(self) -> float:
        """Samples a second."""

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick."""

    def sample(self) -> ImuSample:
        """The newest sample, shared by all who ask in its tick."""


@dataclass(frozen=True, slots=True)
class ContactReading:
    """What a contact sensor felt in one tick."""

    time: float
    """Simulation time, s."""
    in_contact: bool
    """Whether the force is above the sensor's threshold."""
    force: float
    """Sum of the contact forces on the sensor, its magnitude in N; at most the sensor's range."""


class ContactSensor(Protocol):
    """A sensor that feels whatever its body touches, or what it touches near the sensor."""

    @property
    def prim_path(self) -> str:
        """Path of the sensor's prim."""

    def reading(self) -> ContactReading:
        """The reading of this tick."""


def beam_directions(angles: tuple[float, float, float], elevations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors of a lidar's beams, ring after ring, shape (rings x azimuths, 3).

    Args:
        angles: azimuth of the first and last beam of a ring and between two, rad.
        elevations: of the rings, rad.
    """
    first, last, increment = angles
    azimuth = first + increment * np.arange(round((last - first) / increment) + 1)
    level = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1)
    if not np.any(elevations):
        return np.tile(level, (len(elevations), 1))
    upwards = np.stack([np.cos(elevations), np.cos(elevations), np.sin(elevations)], axis=1)
    level[:, 2] = 1.0
    directions: NDArray[np.float64] = (upwards[:, None, :] * level).reshape(-1, 3)
    return directions


def pinhole(size: tuple[int, int], horizontal_fov: float) -> tuple[float, float, float, float]:
    """fx, fy, cx, cy (pixels) of a lens in the middle before square pixels, by the horizontal field of view in degrees.

    A field of view reaches from edge to edge, while pixel 0 lies half a pixel inside of it.
    """
    width, height = size
    focal = width / 2 / math.tan(math.radians(horizontal_fov) / 2)
    return focal, focal, (width - 1) / 2, (height - 1) / 2


Friction = tuple[float, float]
"""Static and dynamic friction."""

Light = tuple[float, Vector3]
"""Intensity, in times of what it is at the start, and colour (red, green, blue)."""
