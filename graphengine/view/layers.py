"""Reads from a session what the layers of the 3D part show beside bodies."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.lidar import Lidar
from graphengine.devices.rotation import Pose

if TYPE_CHECKING:
    from graphengine.node.context.session_services import Services

LIDAR = "lidar"


class Layers:
    """What there is to show of a session.

    Args:
        services: of the session.
    """

    def __init__(self, services: Services) -> None:
        self._services = services
        self._lidars: dict[str, Lidar] = {}

    def find(self) -> None:
        """Look again what there is; call it after robots have come or gone."""
        prims = self._services.stage.prims("lidar")
        self._lidars = {prim.path: self._services.world.device(Lidar, prim) for prim in prims}

    def beams(self) -> Mapping[str, NDArray[np.float32]]:
        """Unit vectors of each lidar's beams in its own frame, shape (beams, 3), by prim path."""
        return {path: lidar.directions.astype(np.float32) for path, lidar in self._lidars.items()}

    def scans(self, shown: Collection[str]) -> Mapping[str, tuple[Pose, NDArray[np.float32]]]:
        """Pose and distances, m, of each lidar, if that layer is shown."""
        if LIDAR not in shown:
            return {}
        world, stage = self._services.world, self._services.stage
        return {
            path: (world.frame(stage.find(path)).pose(), lidar.scan().ranges) for path, lidar in self._lidars.items()
        }
