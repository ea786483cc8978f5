"""The 3D part of a page: bodies and layers, the panel that shows or hides them, and the controls of each viewer."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from graphengine.view.layer_data import SceneLayers, SeenEntity
from graphengine.view.scene.camera_frusta import CameraFrusta
from graphengine.view.scene.carried import Carried
from graphengine.view.scene.contact_arrows import ContactArrows
from graphengine.view.scene.drawn_bodies import Batch, DrawnBodies
from graphengine.view.scene.floor_picture import FloorPicture
from graphengine.view.scene.frame_axes import FrameAxes
from graphengine.view.scene.layer import Layer
from graphengine.view.scene.lidar_hits import LidarHits
from graphengine.view.scene.robot_trails import RobotTrails
from graphengine.view.scene.viewer_controls import ViewerControls
from graphengine.view.wire import LiveScene, LiveState

if TYPE_CHECKING:
    import viser

LAYERS: Sequence[type[Layer]] = (LidarHits, CameraFrusta, FrameAxes, ContactArrows, RobotTrails, FloorPicture)
BODIES = ("Robots", "Objects", "World")
"""Titles of the groups of bodies, in the panel: robots, other movable entities, and fixed bodies."""
PULL_KEY: Literal["cmd/ctrl"] = "cmd/ctrl"
"""Key to hold while dragging with the left mouse button to pull a body; without the key, a drag turns the camera."""


class Scene3D:
    """The 3D part of the page.

    Args:
        server: viser server.
        shown: called when a viewer shows or hides a layer.
        command: sends a command to the run; its arguments are the viewer's client id in viser, the name of the command, and
            the arguments of the command.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        shown: Callable[[], None],
        command: Callable[[int, str, dict[str, Any]], None],
    ) -> None:
        self._server = server
        self._shown = shown
        self._command = command
        self._bodies = {kind: DrawnBodies(server.scene, f"/{kind.lower()}") for kind in BODIES}
        self._layers = [layer(server.scene) for layer in LAYERS]
        self._scene = SceneLayers()
        self._owners: dict[int, SeenEntity] = {}
        """Entity of each movable body, by row of the body."""
        self._carried = Carried.of([])
        self._viewers: dict[int, ViewerControls] = {}
        # Set before the first viewer connects: viser's default light and shadows take a browser seconds to build.
        server.scene.set_up_direction("+z")
        server.scene.configure_environment_map(None)
        server.scene.configure_default_lights(enabled=False)
        self._add_panel()
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(self._forget)

    def _add_panel(self) -> None:
        for title, bodies in self._bodies.items():
            self._add_switch(title, "", bodies)
        for layer in self._layers:
            self._add_switch(layer.title, layer.hint, layer)
            if isinstance(layer, LidarHits):
                self._add_colours(layer)
        self._note = self._server.gui.add_markdown("", visible=False)

    def _add_switch(self, title: str, hint: str, switched: Layer | DrawnBodies) -> None:
        box = self._server.gui.add_checkbox(title, switched.shown, hint=hint or None)

        def switch(_: object) -> None:
            switched.shown = bool(box.value)
            self._shown()

        box.on_update(switch)

    def _add_colours(self, layer: LidarHits) -> None:
        colours: Any = self._server.gui.add_dropdown("Lidar colours", ("range", "intensity"))

        def choose(_: object) -> None:
            layer.colours = colours.value

        colours.on_update(choose)

    @property
    def shown(self) -> Sequence[str]:
        """Names of the shown layers."""
        return [layer.name for layer in self._layers if layer.shown]

    def show(self, stage: LiveScene) -> None:
        """Draw a new scene in place of the previous one."""
        scene = self._server.scene
        scene.reset()
        scene.add_light_ambient("/lights/ambient", intensity=1.2)
        scene.add_light_directional("/lights/sun", intensity=1.6, position=(4.0, -6.0, 10.0))
        self._scene = stage.layers
        self._owners = {row: entity for entity in stage.layers.entities for row in entity.bodies}
        self._carried = Carried.of([(entity.mount.body, entity.mount.pose) for entity in stage.layers.entities])
        robots = {row for row, entity in self._owners.items() if entity.robot}
        others = self._owners.keys() - robots
        still = set(range(len(stage.bodies.names))) - self._owners.keys()
        for bodies, rows in zip(self._bodies.values(), (robots, others, still), strict=True):
            bodies.draw(stage.bodies, rows)
            for batch in bodies.batches if rows is not still else ():
                self._let_touch(batch)
        for layer in self._layers:
            layer.draw(stage.layers)

    def update(self, state: LiveState) -> None:
        """Draw a frame, and update the controls of all viewers."""
        for bodies in self._bodies.values():
            bodies.update(state.poses)
        for layer in self._layers:
            layer.update(state.poses, state.layers)
        note = "\n\n".join(state.layers.notes.values())
        if note != self._note.content:
            self._note.content, self._note.visible = note, bool(note)
        viewers = list(self._viewers.values())
        for viewer in viewers:
            if viewer.scene is not self._scene:
                viewer.offer(self._scene)
        placed = (
            zip(*self._carried.at(state.poses), strict=True) if any(viewer.needs_poses for viewer in viewers) else ()
        )
        poses = dict(zip((entity.mount.name for entity in self._scene.entities), placed, strict=False))
        for viewer in viewers:
            viewer.update(state.facts["time"], poses)

    def select(self, name: str) -> None:
        """Select the entity that a viewer selected in the page's tree; do nothing unless exactly one viewer is connected."""
        viewers = list(self._viewers.values())
        known = any(entity.mount.name == name for entity in self._scene.entities)
        if len(viewers) == 1 and known and viewers[0].selected != name:
            viewers[0].click(name)

    def tell(self, client: int, error: str) -> None:
        """Show a viewer the error of a refused command; `client` is the viewer's client id in viser."""
        if client in self._viewers:
            self._viewers[client].tell(error)

    def _welcome(self, client: viser.ClientHandle) -> None:
        command = functools.partial(self._command, client.client_id)
        self._viewers[client.client_id] = ViewerControls(client, command)

    def _forget(self, client: viser.ClientHandle) -> None:
        self._viewers.pop(client.client_id, None)

    def _let_touch(self, batch: Batch) -> None:
        """Let viewers select entities with a click on a shape of the batch, and pull entities with a drag."""

        def click(event: viser.SceneNodePointerEvent[Any]) -> None:
            viewer, entity = self._viewers.get(event.client_id), self._touched(batch, event.instance_index)
            if viewer is not None and entity is not None:
                viewer.click(entity.mount.name)

        async def drag(event: viser.SceneNodeDragEvent[Any]) -> None:
            viewer, entity = self._viewers.get(event.client_id), self._touched(batch, event.instance_index)
            if viewer is None:
                return
            if event.phase == "end" or entity is None:
                viewer.pull.held = None
            else:
                viewer.pull.held = entity, np.subtract(event.end_position, event.start_position)

        batch.handle.on_click(click)
        if not self._scene.read_only:
            batch.handle.on_drag("left", modifier=PULL_KEY)(drag)

    def _touched(self, batch: Batch, instance: int | None) -> SeenEntity | None:
        rows = batch.shapes.rows
        return self._owners.get(int(rows[instance])) if instance is not None and 0 <= instance < len(rows) else None
