"""Controls of one viewer of the 3D part: the selected entity, a camera that follows it, and handles that move it."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.view.layer_data import SceneLayers
from graphengine.view.scene.body_dragging import MoveHandles, Pull
from graphengine.view.scene.carried import Floats

if TYPE_CHECKING:
    import viser

NOTHING = "nothing"
ORIGIN = np.zeros(3, np.float32)
FARTHEST = 8.0
"""Maximum distance of a camera when it starts to follow an entity, m; a camera that is farther away moves closer."""
UNTOUCHED = 0.25
"""Wall time for which the camera does not follow after the viewer last turned it, s; following would undo the turn."""

SHOWN = 5.0
"""Wall time for which an error is shown, s."""


class ViewerControls:
    """The controls of one viewer.

    Args:
        client: the viewer.
        command: sends a command to the run.

    Attributes:
        pull: pulls the entity that the viewer drags.
        scene: layer data with the entities that can be selected.
    """

    def __init__(self, client: viser.ClientHandle, command: Callable[[str, dict[str, Any]], None]) -> None:
        self._client = client
        self._handles = MoveHandles(client.scene, command)
        self.pull = Pull(command)
        self.scene = SceneLayers(read_only=True)
        gui, hint = client.gui, "the selected robot or object; click one to select it, click it again to deselect it"
        self._selected: Any = gui.add_dropdown("Selected", (NOTHING,), order=-3, hint=hint)
        self._follows = gui.add_checkbox("Follow it", True, order=-2, hint="the camera follows the selection")
        hint = "handles move the selected robot or object; a drag with Ctrl or Cmd held pulls any robot or object"
        self._moves = gui.add_checkbox("Move it", False, order=-1, visible=False, hint=hint)
        self._quiet = 0.0
        self._away, self._rest = np.zeros(3), 0.0
        """Vector from the camera's focus to the camera, m, and the wall time from which the camera follows again, s."""

    @property
    def selected(self) -> str:
        """Name of the selected entity; empty if no entity is selected."""
        value = str(self._selected.value)
        return value if value != NOTHING else ""

    @property
    def needs_poses(self) -> bool:
        """Whether `update` needs poses, because an entity is selected or pulled."""
        return bool(self.selected) or self.pull.held is not None

    def offer(self, scene: SceneLayers) -> None:
        """Offer the entities of a new scene; deselect a removed entity; select the only robot if it is new."""
        self.scene = scene
        self._moves.visible = not scene.read_only
        before, names = self._selected.options, [entity.mount.name for entity in scene.entities]
        self._selected.options = (NOTHING, *names)
        robots = [entity.mount.name for entity in scene.entities if entity.robot]
        if len(robots) == 1 and robots[0] not in before:
            self._selected.value = robots[0]

    def click(self, name: str) -> None:
        """Select an entity, or deselect it if it is selected."""
        self._selected.value = NOTHING if name == self.selected else name

    def update(self, seconds: float, poses: Mapping[str, tuple[Floats, Floats]]) -> None:
        """Move the camera and handles to the selected entity, and push the pulled entity.

        Args:
            seconds: simulation time, s.
            poses: poses of the entities by name; empty while no viewer `needs_poses`.
        """
        self.pull.update(seconds, poses)
        name = self.selected
        position, rotation = poses.get(name, (ORIGIN, ORIGIN))
        self._handles.update(name if name in poses and self._moves.value else "", position, rotation)
        if name in poses and self._follows.value and not self._handles.held:
            self._follow(position.astype(float))

    def _follow(self, position: np.ndarray[Any, Any]) -> None:
        """Point the camera at a position, and keep the direction and distance that the viewer chose."""
        camera = self._client.camera
        away, now = camera.position - camera.look_at, time.monotonic()
        if not np.allclose(away, self._away, atol=1e-3):
            self._away, self._rest = away, now + UNTOUCHED
        if now < self._rest:
            return
        distance = float(np.linalg.norm(away))
        if distance > FARTHEST and np.linalg.norm(camera.look_at - position) > 1.0:
            away *= FARTHEST / distance
        # A browser may report an invalid camera pose.
        with self._client.atomic(), contextlib.suppress(ValueError):
            camera.position = position + away
            camera.look_at = position

    def tell(self, error: str) -> None:
        """Show a notification with the error of a refused command; ignore further errors within `SHOWN` s."""
        now = time.monotonic()
        if now < self._quiet:
            return
        self._quiet = now + SHOWN
        self._client.add_notification("Command refused", error, color="red", auto_close_seconds=SHOWN)
