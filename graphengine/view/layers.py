"""Reads the data for the layers of the 3D view from a session: frames, lidars, cameras, contacts and the occupancy map."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.contact_points import Contacts
from graphengine.devices.lidar import Lidar
from graphengine.devices.stage import Prim
from graphengine.view.camera_pictures import CameraPictures, shrunk
from graphengine.view.floor_map import FloorMaker
from graphengine.view.layer_data import (
    CAMERAS,
    CONTACTS,
    FLOOR,
    LIDAR,
    FloorMap,
    FrameLayers,
    Mount,
    SceneLayers,
    SeenCamera,
    SeenEntity,
    SeenLidar,
)

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

NO_FRAMES = ("scope", "robot", "joint", "material", "graph", "body", "light")
"""Kinds of prims that have no frame in TF."""


class Layers:
    """Collects the layer data of a session.

    Args:
        session: session to show; its world may be replaced by a reload.
        make_floor: makes the occupancy map of the session's scene.
        read_only: whether viewers can watch but not send commands.
    """

    def __init__(self, session: SessionCore, make_floor: Callable[[], FloorMap], *, read_only: bool = False) -> None:
        self._session = session
        self._read_only = read_only
        self._world: object = None
        """The world that contains the lidars in `_lidars`."""
        self._lidars: dict[str, Lidar] = {}
        self._pictures = CameraPictures(session)
        self._make_floor = make_floor
        self._floor = FloorMaker(make_floor)
        self._version = session.version

    def find(self, bodies: Sequence[str]) -> SceneLayers:
        """Return the layer data of the scene; call it again after robots were added or removed.

        Args:
            bodies: names of the bodies in the order of their poses.
        """
        services, rows = self._session.services, {name: row for row, name in enumerate(bodies)}
        if self._session.version != self._version:
            self._version, self._floor = self._session.version, FloorMaker(self._make_floor)
        lidars, cameras = self._find_sensors()
        return SceneLayers(
            [
                mount_of(prim, rows, prim.frame_name)
                for robot in services.stage.prims("robot")
                for prim in robot.descendants()
                if prim.kind not in NO_FRAMES
            ],
            [SeenLidar(mount_of(prim, rows), self._lidars[prim.path].directions.astype(np.float32)) for prim in lidars],
            [_camera(prim, rows) for prim in cameras],
            list(self._entities(rows)),
            self._read_only,
        )

    def _find_sensors(self) -> tuple[Sequence[Prim], Sequence[Prim]]:
        """Return the lidars and cameras of the current world, and store them for `read`."""
        services = self._session.services
        self._world, lidars = services.world, list(services.stage.prims("lidar"))
        self._lidars = {prim.path: services.world.device(Lidar, prim) for prim in lidars}
        cameras = _one_of_each_rig(services.stage.prims("camera"), {p.prim for p in services.render_products.values()})
        self._pictures.find(cameras)
        return lidars, cameras

    def _entities(self, rows: Mapping[str, int]) -> Iterable[SeenEntity]:
        world = self._session.services.world
        for entity in world.entities.all():
            prim = world.stage.find(entity.prim_path)
            parts = [part for part in prim.descendants() if part.body in rows]
            if entity.kind != "static" and parts:
                mass = sum(world.mass(part) for part in parts)
                bodies = [rows[part.body] for part in parts if part.body is not None]
                yield SeenEntity(mount_of(prim, rows, entity.name), entity.kind == "robot", bodies, mass)

    def read(self, shown: Collection[str], now: float, tick: int) -> FrameLayers:
        """Return the data of one frame for the shown layers; hidden layers cost nothing.

        Args:
            shown: names of the shown layers.
            now: current wall time, s.
            tick: number of the current tick.
        """
        if self._session.services.world is not self._world:  # a checkpoint of another world was restored
            self._find_sensors()
        floor = self._floor.take() if FLOOR in shown else None
        notes = {CAMERAS: self._pictures.error, FLOOR: self._floor.error}
        return FrameLayers(
            self._scans() if LIDAR in shown else {},
            self._session.services.world.contacts() if CONTACTS in shown else Contacts(),
            self._small_pictures(now, tick) if CAMERAS in shown else {},
            floor,
            {layer: note for layer, note in notes.items() if note and layer in shown},
        )

    def _small_pictures(self, now: float, tick: int) -> Mapping[str, NDArray[np.uint8]]:
        return {path: shrunk(picture.rgb) for path, picture in self._pictures.take(now, tick).items()}

    def _scans(self) -> Mapping[str, tuple[NDArray[np.float32], NDArray[np.float32]]]:
        samples = {path: lidar.scan() for path, lidar in self._lidars.items()}
        return {path: (sample.ranges, sample.intensities) for path, sample in samples.items()}


def _one_of_each_rig(cameras: Iterable[Prim], read: Collection[str]) -> Sequence[Prim]:
    """Return one camera of each rig: the first camera of which a graph may receive images, otherwise the first camera."""
    chosen: dict[Prim | None, Prim] = {}
    for prim in cameras:
        first = chosen.setdefault(prim.parent, prim)
        if prim.path in read and first.path not in read:
            chosen[prim.parent] = prim
    return list(chosen.values())


def mount_of(prim: Prim, rows: Mapping[str, int], name: str = "") -> Mount:
    """Return the frame of a prim, relative to the body that carries it.

    Args:
        prim: prim to which the frame belongs.
        rows: row of each body in the array of poses, by name.
        name: name of the frame; empty for the prim's path.
    """
    body, pose = prim.carrier()
    return Mount(name or prim.path, rows.get(body or "", 0), pose)


def _camera(prim: Prim, rows: Mapping[str, int]) -> SeenCamera:
    width, height = prim.facts["size"]
    across = math.tan(math.radians(prim.facts["fov_deg"][0]) / 2)
    return SeenCamera(mount_of(prim, rows), 2 * math.atan(across * height / width), width / height)
