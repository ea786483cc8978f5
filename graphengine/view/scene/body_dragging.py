"""Mouse control of entities: a drag of an entity pulls it with forces, and a drag of its handles moves it.

The browser sends an event for each mouse move; the run gets at most one command per `PERIOD`, with the newest position.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graphengine.view.layer_data import SeenEntity
from graphengine.view.scene.carried import Floats

if TYPE_CHECKING:
    import viser

PERIOD = 0.1
"""Minimum time between two commands, s: in wall time, and for pushes in simulation time too."""
STIFFNESS, DAMPING = 15.0, 6.0
"""Coefficients of the pushing force, per kg of the entity: N per m of distance to the mouse, and N per m/s of damping."""
FARTHEST = 2.0
"""Distance to the mouse beyond which the pulling force no longer grows, m."""

Command = Callable[[str, dict[str, Any]], None]
Vector = NDArray[np.float64]


class Pull:
    """Pulls an entity towards the mouse by successive pushes, until the mouse button is released.

    Pushes act on the centre of mass: at the point where the drag started, they would tip light entities over.

    Args:
        command: sends a command to the run.

    Attributes:
        held: the dragged entity, and the vector from the start of the drag to the mouse, m; None while nothing is dragged.
    """

    def __init__(self, command: Command) -> None:
        self._command = command
        self.held: tuple[SeenEntity, Vector] | None = None
        self._seen: tuple[SeenEntity, Vector] | None = None
        self._goal = np.zeros(3)
        self._next = 0.0
        self._last, self._before = -PERIOD, np.zeros(3)
        """Simulation time of the last push, s, and position of the entity then, m."""

    def update(self, seconds: float, poses: Mapping[str, tuple[Floats, Floats]]) -> None:
        """Send a push if it is due.

        Args:
            seconds: simulation time, s.
            poses: poses of the entities by name.
        """
        held, now = self.held, time.monotonic()
        if held is None or held[0].mount.name not in poses:
            return
        entity, way = held
        position = poses[entity.mount.name][0].astype(float)
        if held is not self._seen:
            self._seen, self._goal = held, position + way
        elapsed = seconds - self._last
        if now < self._next or 0.0 <= elapsed < PERIOD:
            return
        velocity = (position - self._before) / elapsed if 0.0 < elapsed < 3 * PERIOD else np.zeros(3)
        self._next, self._last, self._before = now + PERIOD, seconds, position
        ahead = self._goal - position
        ahead *= min(1.0, FARTHEST / max(float(np.linalg.norm(ahead)), FARTHEST))
        force = entity.mass * (STIFFNESS * ahead - DAMPING * velocity)
        self._command("push", {"entity": entity.mount.name, "force": force.tolist(), "duration": PERIOD})


class MoveHandles:
    """Handles around an entity; a viewer drags them to move the entity.

    Args:
        scene: viser scene that only this viewer sees.
        command: sends a command to the run.
    """

    def __init__(self, scene: viser.SceneApi, command: Command) -> None:
        self._scene = scene
        self._command = command
        self._controls: viser.TransformControlsHandle | None = None
        self._name = ""
        self._waiting: dict[str, Any] | None = None
        self._next = 0.0
        self.held = False
        """Whether the viewer drags a handle."""

    def update(self, name: str, position: Floats, rotation: Floats) -> None:
        """Send a command that moves the entity to its handles if one is due; otherwise move the handles to the entity.

        The arguments are the name and pose of the entity; an empty name removes the handles.
        """
        if name != self._name:
            self._show(name)
        waiting, now = self._waiting, time.monotonic()
        if waiting is not None and now >= self._next:
            self._waiting, self._next = None, now + PERIOD
            self._command("move", waiting)
        elif self._controls is not None and waiting is None and not self.held:
            self._controls.position, self._controls.wxyz = position, rotation

    def _show(self, name: str) -> None:
        if self._controls is not None:
            self._controls.remove()
        self._controls, self._name, self.held, self._waiting = None, name, False, None
        if not name:
            return
        controls = self._scene.add_transform_controls("/move", scale=0.7, line_width=3.0, depth_test=False)
        controls.on_update(self._drag)
        self._controls = controls

    async def _drag(self, event: viser.TransformControlsEvent) -> None:  # viser keeps the order of async callbacks
        self.held = event.phase != "end"
        w, x, y, z = event.target.wxyz.tolist()
        orientation = {"quaternion_xyzw": [x, y, z, w]}
        if event.phase == "update" and event.target is self._controls:
            self._waiting = {
                "entity": self._name,
                "position": event.target.position.tolist(),
                "orientation": orientation,
            }
