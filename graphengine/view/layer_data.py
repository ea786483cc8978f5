"""Data of the 3D part's layers that a run sends to its page: `SceneLayers` per scene, `FrameLayers` per frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.contact_points import Contacts
from graphengine.devices.rotation import Pose

LIDAR, CAMERAS, CONTACTS, FLOOR = "lidar", "cameras", "contacts", "map"
"""Layers whose data the run computes while they are shown; the page draws the others from poses alone."""


@dataclass(frozen=True, slots=True)
class Mount:
    """A coordinate frame fixed to a body.

    Attributes:
        name: prim path, or the frame's name in TF.
        body: row of the body in the array of poses.
        pose: pose in the body's frame.
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
    """A camera; it looks along the -z axis of its frame, with y up.

    Attributes:
        mount: frame of the camera.
        field_of_view: vertical field of view, rad.
        aspect: width divided by height of its pictures.
    """

    mount: Mount
    field_of_view: float
    aspect: float


@dataclass(frozen=True, slots=True)
class SeenEntity:
    """A robot or an object that can be moved.

    Attributes:
        mount: frame of the entity, with the entity's name in commands.
        robot: whether it is a robot.
        bodies: rows of its bodies in the array of poses.
        mass: total mass, kg.
    """

    mount: Mount
    robot: bool
    bodies: Sequence[int]
    mass: float


@dataclass(frozen=True, slots=True)
class SceneLayers:
    """Layer data that change only when robots are added or removed.

    Attributes:
        frames: frames of the robots' links, sensors and frame prims, named as in TF.
        lidars: all lidars.
        cameras: one camera of each rig.
        entities: robots and objects that can be moved.
        read_only: whether viewers can watch but not send commands.
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
        cells: cells from south to north and west to east, shape (rows, columns); 100 occupied, 0 free, -1 unknown.
        corner: x and y of the south-west corner, m.
        cell: side of a cell, m.
    """

    cells: NDArray[np.int8]
    corner: tuple[float, float]
    cell: float


@dataclass(frozen=True, slots=True)
class FrameLayers:
    """Data of one frame for the shown layers.

    Attributes:
        scans: ranges (m, inf without a hit) and intensities (0 to 255) of each lidar, by prim path.
        contacts: contact points between bodies.
        pictures: new camera pictures by prim path, shape (height, width, 3).
        floor: the occupancy map; sent in one frame only.
        notes: reasons why layers show nothing, by layer name.
    """

    scans: Mapping[str, tuple[NDArray[np.float32], NDArray[np.float32]]] = field(default_factory=dict)
    contacts: Contacts = field(default_factory=Contacts)
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    floor: FloorMap | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
