"""Data that a run sends to its page for the layers of the 3D part: `SceneLayers` per scene, `FrameLayers` per frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.contact_points import Contacts
from graphengine.devices.rotation import Pose

LIDAR, CAMERAS, CONTACTS, FLOOR = "lidar", "cameras", "contacts", "map"
"""Names of layers whose data the run computes while they are shown; the page draws other layers from body poses alone."""


@dataclass(frozen=True, slots=True)
class Mount:
    """A coordinate frame fixed to a body.

    Attributes:
        name: name of the frame: a prim path, a frame name in TF, or the name of an entity.
        body: row of the body in the array of poses.
        pose: pose of the frame relative to the body.
    """

    name: str
    body: int
    pose: Pose


@dataclass(frozen=True, slots=True)
class SeenLidar:
    """A lidar; `beams` are the directions of its beams, unit vectors in the frame `mount`, shape (beams, 3)."""

    mount: Mount
    beams: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SeenCamera:
    """A camera; it looks along the -z axis of its frame, with y up.

    Attributes:
        mount: frame of the camera.
        field_of_view: vertical field of view, rad.
        aspect: width of an image divided by its height.
    """

    mount: Mount
    field_of_view: float
    aspect: float


@dataclass(frozen=True, slots=True)
class SeenEntity:
    """A robot or an object that can be moved.

    Attributes:
        mount: frame of the entity; its name is the name of the entity in commands.
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
        frames: frames of the links, sensors and frame prims of robots, named as in TF.
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
        cells: occupancy of the cells, rows from south to north and columns from west to east; 100 occupied, 0 free, -1
            unknown.
        corner: x and y of the south-west corner, m.
        cell: side length of a cell, m.
    """

    cells: NDArray[np.int8]
    corner: tuple[float, float]
    cell: float


@dataclass(frozen=True, slots=True)
class FrameLayers:
    """Data of one frame for the shown layers.

    Attributes:
        scans: ranges (m, inf if a beam hits nothing) and intensities (0 to 255) of each lidar, by prim path.
        contacts: contact points between bodies.
        pictures: new camera images by prim path of the camera, RGB, shape (height, width, 3).
        floor: the occupancy map in the first frame after it is ready, otherwise None.
        notes: reasons why data of layers are missing, by layer name.
    """

    scans: Mapping[str, tuple[NDArray[np.float32], NDArray[np.float32]]] = field(default_factory=dict)
    contacts: Contacts = field(default_factory=Contacts)
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    floor: FloorMap | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
