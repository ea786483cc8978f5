"""Provides the images of the cameras that viewers look at in the pane of images."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from graphengine.devices.camera import Picture
from graphengine.devices.stage import Prim
from graphengine.view.camera_pictures import LARGE, CameraPictures, shrunk
from graphengine.view.wire import CameraImage

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

Wish = tuple[str, bool]
"""Prim path of a camera, and whether its depth is wanted instead of its colours."""


class CameraImages:
    """Collects the images that viewers look at.

    Args:
        session: session with the cameras.
    """

    def __init__(self, session: SessionCore) -> None:
        self._session = session
        self._pictures = CameraPictures(session, LARGE)
        self._cameras: list[Prim] = []
        self._newest: dict[str, Picture] = {}
        """The newest image of each camera, by its prim path."""
        self._sent: dict[int, Wish] = {}
        """What was last sent to each viewer."""
        self._told = ""

    def take(self, wishes: Mapping[int, Wish], now: float, tick: int) -> Iterator[CameraImage]:
        """Yield new images.

        Args:
            wishes: what each viewer looks at, by number of the viewer.
            now: current wall time, s.
            tick: number of the current tick.
        """
        wanted = {camera for camera, _ in wishes.values()}
        cameras = [prim for prim in self._session.services.stage.prims("camera") if prim.path in wanted]
        if cameras != self._cameras:
            self._cameras = cameras
            self._pictures.find(cameras)
            self._newest.clear()
            self._sent.clear()
        if not cameras:
            return
        new = self._pictures.take(now, tick)
        self._newest |= new
        waiting = {wish for viewer, wish in wishes.items() if self._sent.get(viewer) != wish}
        for camera, depth in sorted({*wishes.values()}):
            if camera in new or ((camera, depth) in waiting and camera in self._newest):
                picture = self._newest[camera]
                viewers = [viewer for viewer, wish in wishes.items() if wish == (camera, depth)]
                self._sent |= dict.fromkeys(viewers, (camera, depth))
                yield CameraImage(viewers, camera, shrunk(picture.depth if depth else picture.rgb, LARGE))
        if self._pictures.error != self._told:
            self._told = self._pictures.error
            for viewer, (camera, _) in wishes.items():
                yield CameraImage([viewer], camera, None, self._told)
