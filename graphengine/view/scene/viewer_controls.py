"""Controls of one viewer of the 3D part: the selected entity, a camera that shows it, and handles that move it."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from viser import _messages

from graphengine.devices.rotation import Vector3
from graphengine.view.layer_data import SceneLayers, SeenCamera, SeenEntity
from graphengine.view.scene.body_dragging import MoveHandles, Pull
from graphengine.view.scene.camera_views import Boxes, Vector, closer, distance_for, stand
from graphengine.view.scene.carried import Carried, Floats, turned
from graphengine.view.scene.viewer_choices import View, ViewerChoices

if TYPE_CHECKING:
    import viser

ORIGIN = np.zeros(3, np.float32)
BEGIN, STIR = 2.0, 2e-4
"""Wall time after a viewer connects in which its browser may set the camera itself, s, and distance by which a camera at rest
moves once per `AGAIN`, m: a browser that still starts loses poses, and viser sends no pose that equals the previous one."""
UNTOUCHED = 0.25
"""Wall time for which the camera does not follow after the viewer last turned it, s; following would undo the turn."""
AGAIN = 1.0
"""Wall time after which a viewer gets the visibility of all layers again, s: a layer may have been drawn again meanwhile."""
SMOOTH = 0.35
"""Part of the way to its new position that a camera behind an entity moves in a frame."""
ONLY = "only"
"""Name of the choice to see only the lidars of the selected robot."""
UP: Vector3 = (0.0, 0.0, 1.0)
USUAL = 0.87
"""Vertical field of view of a camera that is not one of a robot, rad."""


class ViewerControls:
    """The controls of one viewer.

    Args:
        client: the viewer.
        tab: name of the viewer's tab.
        choices: what the viewer chooses in the page.
        command: sends a command to the run.

    Attributes:
        tab: name of the viewer's tab.
        pull: pulls the entity that the viewer drags.
        scene: layer data with the entities that can be selected.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        tab: str,
        choices: ViewerChoices,
        command: Callable[[str, dict[str, Any]], None],
    ) -> None:
        self._client = client
        self.tab = tab
        self.choices = choices
        self._handles = MoveHandles(client.scene, command)
        self.pull = Pull(command)
        self.scene = SceneLayers(read_only=True)
        self._away, self._wish, self._rest = np.zeros(3), np.zeros(3), 0.0
        """Vectors from the camera's focus to the camera, m: where it is and where the viewer wants it; and the wall time from
        which the camera follows again, s."""
        self._begin, self._stir, self._again = time.monotonic(), 0.0, math.inf
        """Wall time at which the viewer connected, s, the part of `STIR` by which the camera is moved, m, and the wall time from
        which its pose is sent again, s."""
        self._placed: tuple[str, View] = ("", "free")
        """The selected entity and the view for which the camera was last placed."""
        self._visible: tuple[frozenset[str], str] | None = None
        """The layers and the selection for which the visibility of layers was sent."""
        self._next = 0.0
        """Wall time from which the visibility of layers is sent again, s."""

    @property
    def selected(self) -> str:
        """Name of the selected entity; empty if no entity is selected."""
        return self.choices.selected

    @property
    def needs_poses(self) -> bool:
        """Whether `update` needs poses, because an entity is selected or pulled."""
        return bool(self.selected) or self.pull.held is not None

    def show_layers(self, layers: Mapping[str, str], owned: Mapping[str, str]) -> None:
        """Show the chosen layers to this viewer, and hide the others.

        Args:
            layers: node of each layer by name.
            owned: robot of each node that is hidden if the viewer wants to see only the lidars of the selected robot.
        """
        now, chosen = time.monotonic(), self.choices.layers
        wanted = (chosen, self.selected)
        if wanted == self._visible and now < self._next:
            return
        self._visible, self._next = wanted, now + AGAIN
        shown = {node: name in chosen for name, node in layers.items()}
        shown |= {node: ONLY not in chosen or robot == self.selected for node, robot in owned.items()}
        for node, visible in shown.items():
            self._client._websock_connection.queue_message(_messages.SetSceneNodeVisibilityMessage(node, visible))

    def update(
        self,
        seconds: float,
        poses: Mapping[str, tuple[Floats, Floats]],
        bodies: Vector,
        walls: Boxes,
        shapes: Mapping[str, Boxes],
    ) -> None:
        """Move the camera and handles to the selected entity, and push the pulled entity.

        Args:
            seconds: simulation time, s.
            poses: poses of the entities by name; empty while no viewer `needs_poses`.
            bodies: poses of all bodies.
            walls: boxes of fixed bodies, which may hide the entity.
            shapes: boxes of the entities by name.
        """
        self.pull.update(seconds, poses)
        name = self.selected
        if name not in poses:
            self._handles.update("", ORIGIN, ORIGIN)
            return
        position, rotation = poses[name]
        self._handles.update(name if self.choices.moves and not self.scene.read_only else "", position, rotation)
        if self._handles.held:
            return
        view, place = self.choices.view, position.astype(float)
        camera = next((one for one in self.scene.cameras if self._is_of(one, name)), None)
        if view == "robot" and camera is not None:
            self._look_through(camera, bodies)
        elif view in ("chase", "top"):
            self._look_at(place, rotation, shapes[name].radius(bodies, place), bodies, walls)
        elif view != "free":
            self._follow(place, shapes[name].radius(bodies, place), bodies, walls)
        self._placed = name, view

    def _is_of(self, camera: SeenCamera, name: str) -> bool:
        owner: SeenEntity | None = next((one for one in self.scene.entities if camera.mount.body in one.bodies), None)
        return owner is not None and owner.mount.name == name

    def _look_through(self, camera: SeenCamera, bodies: Vector) -> None:
        """Put the viewer's camera into a camera of the robot."""
        positions, rotations = Carried.of([(camera.mount.body, camera.mount.pose)]).at(bodies)
        axes = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], np.float32)
        ahead, up = turned(np.repeat(rotations, 2, axis=0), axes)
        self._place(
            positions[0], positions[0] + ahead, (float(up[0]), float(up[1]), float(up[2])), camera.field_of_view
        )

    def _look_at(self, place: Vector, rotation: Floats, radius: float, bodies: Vector, walls: Boxes) -> None:
        """Put the camera behind or above the entity."""
        distance = distance_for(radius)
        ahead = turned(rotation[None], np.array([[1.0, 0.0, 0.0]], np.float32))[0]
        behind = float(np.arctan2(-ahead[1], -ahead[0]))
        if self.choices.view == "top":
            # A camera that looks exactly along the up direction has no defined turn.
            self._place(place + 1.6 * distance * np.array([0.01 * np.cos(behind), 0.01 * np.sin(behind), 1.0]), place)
        else:
            position = stand(walls, bodies, place, behind, distance)
            if self._placed == (self.selected, "chase"):  # without jumps where the way is no longer free
                position = self._client.camera.position + SMOOTH * (position - self._client.camera.position)
            self._place(position, place)

    def _follow(self, place: Vector, radius: float, bodies: Vector, walls: Boxes) -> None:
        """Point the camera at the entity, and keep the direction and distance that the viewer chose."""
        camera = self._client.camera
        away, now = np.array(camera.position - camera.look_at), time.monotonic()
        if self._placed != (self.selected, "follow"):
            azimuth = float(np.arctan2(away[1], away[0]))
            self._again = now + AGAIN
            self._wish, self._rest = stand(walls, bodies, place, azimuth, distance_for(radius)) - place, now
        elif not np.allclose(away, self._away, atol=1e-3) and now > self._begin + BEGIN:
            self._wish, self._away, self._rest = away, away, now + UNTOUCHED
        if now < self._rest:
            return
        position = closer(place, place + self._wish, walls.free(bodies, place, place + self._wish))
        if now >= self._again:
            self._stir, self._again = STIR - self._stir, now + AGAIN
        position = position + np.array([0.0, 0.0, self._stir])
        self._place(position, place)
        self._away = position - place

    def _place(self, position: Vector, focus: Vector, up: Vector3 = UP, field: float = USUAL) -> None:
        camera = self._client.camera
        # A browser may report an invalid camera pose.
        with self._client.atomic(), contextlib.suppress(ValueError):
            if not np.allclose(camera.up_direction, up, atol=1e-3):
                camera.up_direction = up
            if abs(camera.fov - field) > 1e-3:
                camera.fov = field
            camera.position = position
            camera.look_at = focus
