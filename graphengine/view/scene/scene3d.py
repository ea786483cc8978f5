"""The 3D part of a page: bodies and layers, and the controls of each viewer."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from graphengine.devices.visible import Bodies
from graphengine.view.layer_data import SceneLayers, SeenEntity
from graphengine.view.scene.camera_frusta import CameraFrusta
from graphengine.view.scene.camera_views import Boxes
from graphengine.view.scene.carried import Carried
from graphengine.view.scene.contact_arrows import ContactArrows
from graphengine.view.scene.drawn_bodies import Batch, DrawnBodies
from graphengine.view.scene.floor_picture import FloorPicture
from graphengine.view.scene.frame_axes import FrameAxes
from graphengine.view.scene.layer import Layer
from graphengine.view.scene.lidar_hits import LidarHits, LidarIntensities
from graphengine.view.scene.robot_trails import RobotTrails
from graphengine.view.scene.viewer_choices import ViewerChoices
from graphengine.view.scene.viewer_controls import ONLY, ViewerControls
from graphengine.view.wire import LiveScene, LiveState

if TYPE_CHECKING:
    import viser

LAYERS: Sequence[type[Layer]] = (
    LidarHits,
    LidarIntensities,
    CameraFrusta,
    FrameAxes,
    ContactArrows,
    RobotTrails,
    FloorPicture,
)
BODIES = {"robots": "Robots", "objects": "Objects", "world": "World"}
"""Names and titles of the groups of bodies: robots, other movable entities, and fixed bodies."""
PULL_KEY: Literal["cmd/ctrl"] = "cmd/ctrl"
"""Key to hold while dragging with the left mouse button to pull a body; without the key, a drag turns the camera."""


class Scene3D:
    """The 3D part of the page.

    Args:
        server: viser server.
        tab_of: returns the name of the tab that a client of viser belongs to, by client id; empty for a client without a page.
        command: sends a command to the run; its arguments are the name of the tab, the name of the command, and the arguments
            of the command.
        picked: called with the name of a tab and of the entity that its viewer clicks; empty if nothing is selected any more.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        tab_of: Callable[[int], str],
        command: Callable[[str, str, dict[str, Any]], None],
        picked: Callable[[str, str], None],
    ) -> None:
        self._server = server
        self._tab_of = tab_of
        self._command = command
        self._picked = picked
        self._bodies = {name: DrawnBodies(server.scene, f"/{name}") for name in BODIES}
        self._layers = [layer(server.scene) for layer in LAYERS]
        self._nodes = {name: f"/{name}" for name in BODIES} | {layer.name: layer.path for layer in self._layers}
        self._scene = SceneLayers()
        self._owners: dict[int, SeenEntity] = {}
        """Entity of each movable body, by row of the body."""
        self._carried = Carried.of([])
        self._owned: Mapping[str, str] = {}
        """Robot of each lidar's node."""
        self._walls, self._shapes = Boxes.of(Bodies(), ()), dict[str, Boxes]()
        self._viewers: dict[int, ViewerControls] = {}
        self._choices: dict[str, ViewerChoices] = {}
        """Choices of the viewers by the name of the tab."""
        # Set before the first viewer connects: viser's default light and shadows take a browser seconds to build.
        server.scene.set_up_direction("+z")
        server.scene.configure_environment_map(None)
        server.scene.configure_default_lights(enabled=False)
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(self._forget)

    @property
    def layers(self) -> Sequence[Mapping[str, str]]:
        """Name, title and tooltip of each layer that viewers can show, as JSON values."""
        bodies = [{"name": name, "title": title, "hint": ""} for name, title in BODIES.items()]
        only = {"name": ONLY, "title": "Lidars of the selection only", "hint": ""}
        return [*bodies, only, *({"name": one.name, "title": one.title, "hint": one.hint} for one in self._layers)]

    @property
    def shown(self) -> Sequence[str]:
        """Names of the data in `FrameLayers` that the shown layers need."""
        return [*dict.fromkeys(layer.needs for layer in self._layers if layer.shown and layer.needs)]

    def choices(self, tab: str) -> ViewerChoices:
        """Return the choices of the viewer in a tab; call `apply` after a change."""
        return self._choices.setdefault(tab, ViewerChoices())

    def apply(self) -> None:
        """Draw the layers that at least one viewer shows."""
        shown = frozenset[str]().union(*(choices.layers for choices in self._choices.values()))
        for layer in self._layers:
            layer.shown = layer.name in shown

    def leave(self, tab: str) -> None:
        """Forget the choices of a viewer whose page is closed."""
        self._choices.pop(tab, None)
        self.apply()

    def show(self, stage: LiveScene) -> None:
        """Draw a new scene in place of the previous one."""
        scene = self._server.scene
        scene.reset()
        scene.add_light_ambient("/lights/ambient", intensity=1.2)
        scene.add_light_directional("/lights/sun", intensity=1.6, position=(4.0, -6.0, 10.0))
        self._scene = stage.layers
        self._owners = {row: entity for entity in stage.layers.entities for row in entity.bodies}
        self._carried = Carried.of([(entity.mount.body, entity.mount.pose) for entity in stage.layers.entities])
        self._shapes = {one.mount.name: Boxes.of(stage.bodies, one.bodies) for one in stage.layers.entities}
        robots = {row for row, entity in self._owners.items() if entity.robot}
        others = self._owners.keys() - robots
        still = set(range(len(stage.bodies.names))) - self._owners.keys()
        self._walls = Boxes.of(stage.bodies, still)
        self._owned = {
            f"{layer.path}{lidar.mount.name}": self._owners[lidar.mount.body].mount.name
            for layer in self._layers
            if isinstance(layer, LidarHits)
            for lidar in stage.layers.lidars
            if lidar.mount.body in self._owners
        }
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
        viewers = list(self._viewers.values())
        placed = (
            zip(*self._carried.at(state.poses), strict=True) if any(viewer.needs_poses for viewer in viewers) else ()
        )
        poses = dict(zip((entity.mount.name for entity in self._scene.entities), placed, strict=False))
        for viewer in viewers:
            viewer.scene = self._scene
            viewer.show_layers(self._nodes, self._owned)
            viewer.update(state.facts["time"], poses, state.poses, self._walls, self._shapes)

    def _welcome(self, client: viser.ClientHandle) -> None:
        tab = self._tab_of(client.client_id)
        command = functools.partial(self._command, tab)
        self._viewers[client.client_id] = ViewerControls(client, tab, self.choices(tab), command)
        self.apply()

    def _forget(self, client: viser.ClientHandle) -> None:
        viewer = self._viewers.pop(client.client_id, None)
        if viewer is not None and not viewer.tab:
            self.leave("")

    def _pick(self, viewer: ViewerControls, name: str) -> None:
        """Select an entity, or deselect it if it is selected; the other parts of the page follow."""
        chosen = "" if viewer.selected == name else name
        viewer.choices.selected = chosen
        self._picked(viewer.tab, chosen)

    def _let_touch(self, batch: Batch) -> None:
        """Let viewers select entities with a click on a shape of the batch, and pull entities with a drag."""

        def click(event: viser.SceneNodePointerEvent[Any]) -> None:
            viewer, entity = self._viewers.get(event.client_id), self._touched(batch, event.instance_index)
            if viewer is not None and entity is not None:
                self._pick(viewer, entity.mount.name)

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
