"""What a run tells its page about the layers of the 3D part: `SceneLayers` with each scene, `FrameLayers` with each frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.contact_points import Contacts
from graphengine.devices.rotation import Pose

LIDAR, CAMERAS, CONTACTS, FLOOR = "lidar", "cameras", "contacts", "map"
"""Layers for which a run computes something while they are shown; the page makes the others from poses alone."""


@dataclass(frozen=True, slots=True)
class Mount:
    """A frame that is fixed to a body.

    Attributes:
        name: prim path, or the frame's name in TF.
        body: row of the body in the poses.
        pose: in the body's frame.
    """

    name: str
    body: int
    pose: Pose


@dataclass(frozen=True, slots=True)
class SeenLidar:
    """A lidar; `beams` are unit vectors in its frame, shape (beams, 3)."""

    mount: Mount
    beams: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SeenCamera:
    """A camera, which looks along the -z axis of its frame, with y up.

    Attributes:
        mount: its frame.
        field_of_view: vertical, rad.
        aspect: width by height of its pictures.
    """

    mount: Mount
    field_of_view: float
    aspect: float


@dataclass(frozen=True, slots=True)
class SeenEntity:
    """A robot or an object that can be moved.

    Attributes:
        mount: its frame, named as commands name the entity.
        robot: whether it is a robot.
        bodies: rows of its bodies in the poses.
        mass: kg.
    """

    mount: Mount
    robot: bool
    bodies: Sequence[int]
    mass: float


@dataclass(frozen=True, slots=True)
class SceneLayers:
    """What changes only when robots come or go.

    Attributes:
        frames: of links, sensors and frames of the robots, by the names that they have in TF.
        lidars: all lidars.
        cameras: one camera of each rig.
        entities: robots and objects that can be moved.
        read_only: whether viewers may only look.
    """

    frames: Sequence[Mount] = ()
    lidars: Sequence[SeenLidar] = ()
    cameras: Sequence[SeenCamera] = ()
    entities: Sequence[SeenEntity] = ()
    read_only: bool = False


@dataclass(frozen=True, slots=True)
class FloorMap:
    """An occupancy map.

    Attributes:
        cells: shape (rows, columns) from south to north and west to east; 100 occupied, 0 free, -1 unknown.
        corner: x and y of its corner in the south-west, m.
        cell: side of a cell, m.
    """

    cells: NDArray[np.int8]
    corner: tuple[float, float]
    cell: float


@dataclass(frozen=True, slots=True)
class FrameLayers:
    """What the layers that are shown need of a frame.

    Attributes:
        scans: ranges, m, inf without a hit, and intensities, 0 to 255, of each lidar by its prim path.
        contacts: points at which bodies touch.
        pictures: new pictures of cameras by prim path, shape (height, width, 3).
        floor: the occupancy map, in one frame only.
        notes: why a layer shows nothing, by the layer's name.
    """

    scans: Mapping[str, tuple[NDArray[np.float32], NDArray[np.float32]]] = field(default_factory=dict)
    contacts: Contacts = field(default_factory=Contacts)
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    floor: FloorMap | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
