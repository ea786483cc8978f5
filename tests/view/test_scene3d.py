"""The 3D part of the page: what is drawn of a frame, and what a viewer does with camera and mouse."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

from viser import _messages

from graphengine.devices.contact_points import Contacts
from graphengine.devices.rotation import IDENTITY, NOWHERE, ORIGIN
from graphengine.devices.visible import Bodies, VisibleShape
from graphengine.view.layer_data import (
    FloorMap,
    FrameLayers,
    Mount,
    SceneLayers,
    SeenCamera,
    SeenEntity,
    SeenLidar,
)
from graphengine.view.page_server import PageServer
from graphengine.view.scene import body_dragging, camera_views, robot_trails, scene3d, viewer_controls
from graphengine.view.scene.floor_picture import picture
from graphengine.view.scene.scene3d import Scene3D
from graphengine.view.scene.viewer_controls import ViewerControls
from graphengine.view.wire import LiveScene, LiveState
from tests.view.browser3d import Browser3D
from tests.waiting import eventually

SHAPES = [VisibleShape("box", (0.5, 0.5, 0.1), row, NOWHERE, (0.5, 0.5, 0.5, 1.0)) for row in range(3)]
BODIES = Bodies(["world", "bot/base", "crate"], [False, True, True], SHAPES)
BOT = SeenEntity(Mount("bot", 1, NOWHERE), True, [1], 10.0)
CRATE = SeenEntity(Mount("crate", 2, NOWHERE), False, [2], 2.0)
LAYERS = SceneLayers(
    [Mount("base_link", 1, NOWHERE), Mount("same_place", 1, NOWHERE), Mount("mast", 1, ((0.0, 0.0, 1.0), IDENTITY))],
    [SeenLidar(Mount("/bot/lidar", 1, NOWHERE), np.array([[1, 0, 0], [0, 1, 0]], np.float32))],
    [SeenCamera(Mount("/bot/camera", 1, NOWHERE), 1.0, 1.5)],
    [BOT, CRATE],
)
NODES = [f"/{name}" for name in (*scene3d.BODIES, *(layer.name for layer in scene3d.LAYERS))]
QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


def frame(x: float = 0.0, time: float = 0.0, layers: FrameLayers | None = None, turn: Any = IDENTITY) -> LiveState:
    """A frame with the robot at x, and the crate 2 m beside it."""
    poses = np.array([[*ORIGIN, *IDENTITY], [x, 0, 0, *turn], [0, 2, 0, *IDENTITY]])
    return LiveState({"time": time}, poses, layers or FrameLayers())


class Page(Browser3D):
    """A 3D part with a viewer, of whose browser what it sends is played."""

    def __init__(self, *, read_only: bool = False) -> None:
        self.commands: list[tuple[str, dict[str, Any]]] = []
        self.server = PageServer("127.0.0.1", 0, lambda viewer, message: None, dict)
        self.picked: list[tuple[str, str]] = []
        self.scene = Scene3D(
            self.server.viser,
            self.server.tab_of,
            lambda _, *command: self.commands.append(command),
            lambda *picked: self.picked.append(picked),
        )
        layers = SceneLayers(LAYERS.frames, LAYERS.lidars, LAYERS.cameras, LAYERS.entities, read_only)
        self.stage = LiveScene("test", BODIES, [], {}, layers, ORIGIN)
        self.scene.show(self.stage)
        super().__init__(self.server.url)
        assert eventually(lambda: self.scene._viewers)
        ((number, self.viewer),) = self.scene._viewers.items()
        self.camera = self.server.viser.get_clients()[number].camera

    def node(self, path: str) -> Any:
        return self.server.viser.scene.get_handle_by_name(path)

    def switch(self, title: str) -> None:
        """Switch a layer on."""
        (name,) = [layer["name"] for layer in self.scene.layers if layer["title"] == title]
        self.viewer.choices.layers |= {name}
        self.scene.apply()

    def select(self, name: str) -> None:
        """Select an entity in the tree of the page."""
        self.viewer.choices.selected = name


@pytest.fixture
def page() -> Iterator[Page]:
    made = Page()
    yield made
    made.socket.close()
    made.server.close()


def test_bodies_are_where_the_poses_say(page: Page) -> None:
    page.scene.update(frame(3.0))
    assert page.node("/robots/0").batched_positions.tolist() == [[3, 0, 0]]
    assert page.node("/objects/0").batched_positions.tolist() == [[0, 2, 0]]
    assert page.node("/world/0").batched_positions.tolist() == [[0, 0, 0]]


def test_hits_of_a_lidar_turn_with_it_and_have_the_colours_of_range_or_intensity(page: Page) -> None:
    scan = FrameLayers({"/bot/lidar": (np.array([2, np.inf], np.float32), np.array([255, 0], np.float32))})
    page.scene.update(frame(1.0, layers=scan, turn=QUARTER))
    cloud = page.node("/lidar/bot/lidar/points")
    assert np.asarray(cloud.points) == pytest.approx(np.array([[1, 2, 0]]), abs=2e-3)
    red, _, blue = cloud.colors[0].tolist()
    assert red > blue
    page.switch("Lidar intensity")
    page.scene.update(frame(1.0, layers=scan))
    assert page.node("/intensity/bot/lidar/points").colors[0].tolist() == [253, 231, 37]
    page.scene.update(frame(1.0, layers=FrameLayers({"/bot/lidar": (np.full(2, np.inf, np.float32),) * 2})))
    assert not cloud.visible


def test_a_trail_is_the_way_of_a_robot_and_begins_anew_where_it_is_put(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_trails, "PERIOD", 0.0)
    page.switch("Trails")
    for x in np.arange(0.0, 1.0, 0.02):
        page.scene.update(frame(float(x)))
    line = page.node("/trails/0")
    steps = np.diff(line.points[:, :, 0], axis=1)
    assert len(line.points) == 16
    assert (steps >= 0.05 - 1e-6).all()
    assert line.points[0, 0, 0] == pytest.approx(0.0)
    page.scene.update(frame(5.0))
    assert not line.visible
    for x in (5.1, 5.2):
        page.scene.update(frame(x))
    assert line.points[:, :, 0].min() == pytest.approx(5.0)


def test_arrows_show_the_forces_on_what_can_be_moved(page: Page) -> None:
    page.switch("Contacts")
    bodies, force = np.array([[0, 1], [1, 0]]), np.array([[0, 0, 50.0], [0, 0, -50.0]])
    contacts = Contacts(np.array([[1.0, 0, 0], [2, 0, 0]]), np.array([[0, 0, 1.0], [0, 0, -1]]), force, bodies)
    page.scene.update(frame(layers=FrameLayers(contacts=contacts)))
    arrows = page.node("/contacts/forces")
    assert arrows.points.tolist() == [[[1, 0, 0], [1, 0, 0.5]], [[2, 0, 0], [2, 0, 0.5]]]
    page.scene.update(frame())
    assert not arrows.visible


def test_frames_at_one_place_share_a_name_and_move_with_their_bodies(page: Page) -> None:
    page.switch("Frames")
    page.scene.update(frame(2.0))
    assert page.node("/frames/axes").batched_positions[:, 0].tolist() == [2, 2, 2]
    assert page.node("/frames/names/0").text == "base_link, same_place"
    assert page.node("/frames/names/2").position.tolist() == [2, 0, 1]


def test_a_camera_looks_along_its_axis_and_shows_its_picture(page: Page) -> None:
    page.switch("Cameras")
    pixels = np.full((4, 6, 3), 9, np.uint8)
    page.scene.update(frame(2.0, layers=FrameLayers(pictures={"/bot/camera": pixels})))
    frustum = page.node("/cameras/bot/camera")
    assert frustum.position.tolist() == [2, 0, 0]
    assert np.abs(frustum.wxyz).tolist() == [0, 1, 0, 0]  # viser's look along z, cameras of a stage along -z
    assert frustum.image is pixels


def test_the_map_is_drawn_over_the_area_that_it_covers(page: Page) -> None:
    cells = np.array([[100, 0, -1]], np.int8)
    floor = FloorMap(cells, (-1.0, 4.0), 2.0)
    page.scene.update(frame(layers=FrameLayers(floor=floor)))
    drawn = page.node("/map/cells")
    assert (drawn.render_width, drawn.render_height) == (6.0, 2.0)
    assert drawn.position[:2].tolist() == [2.0, 5.0]
    dark, free, unknown = picture(floor)[0]
    assert dark[:3].sum() < free[:3].sum()
    assert unknown[3] == 0
    page.scene.show(page.stage)
    assert page.node("/map/cells") is not None


RADIUS = math.hypot(0.5, 0.5, 0.1)
"""Radius of the robot, which is a box around its origin, m."""


@pytest.fixture
def settled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer_controls, "UNTOUCHED", 0.0)
    monkeypatch.setattr(viewer_controls, "BEGIN", 0.0)


@pytest.mark.usefixtures("settled")
def test_a_camera_frames_the_selection_and_follows_it_until_a_click_and_again_after_another_one(page: Page) -> None:
    page.select("bot")
    page.scene.update(frame())
    rise, distance = math.radians(camera_views.RISES[0]), camera_views.PER_RADIUS * RADIUS
    away = np.array([0.0, -math.cos(rise), math.sin(rise)]) * distance
    assert page.camera.position == pytest.approx(away, abs=1e-6)
    page.scene.update(frame(1.0))
    assert page.camera.look_at == pytest.approx([1, 0, 0])
    assert page.camera.position == pytest.approx(np.array([1, 0, 0]) + away)
    page.look((1.0, 4.0, 2.0), (1.0, 0.0, 0.0))
    assert eventually(lambda: page.camera.position[1] == 4.0)
    page.scene.update(frame(2.0))
    assert page.camera.position == pytest.approx([2, 4, 2])
    page.click("/robots/0")
    assert eventually(lambda: page.picked == [("tab", "")])
    page.scene.update(frame(3.0))
    assert page.camera.look_at == pytest.approx([2, 0, 0])
    page.click("/robots/0")
    assert eventually(lambda: page.picked[1:] == [("tab", "bot")])
    page.scene.update(frame(3.0))
    assert page.camera.look_at == pytest.approx([3, 0, 0])


@pytest.mark.usefixtures("settled")
def test_a_camera_stands_behind_above_or_in_the_robot(page: Page) -> None:
    page.select("bot")
    page.viewer.choices.choose({"view": "chase"})
    page.scene.update(frame(turn=QUARTER))
    assert page.camera.position[0] == pytest.approx(0.0, abs=1e-6)
    assert page.camera.position[1] < -2.0  # the robot looks along y
    page.viewer.choices.choose({"view": "top"})
    page.scene.update(frame(5.0))
    assert page.camera.position[2] == pytest.approx(1.6 * camera_views.PER_RADIUS * RADIUS)
    assert page.camera.position[:2] == pytest.approx([5.0, 0.0], abs=0.1)
    page.viewer.choices.choose({"view": "robot"})
    page.scene.update(frame(5.0))
    assert page.camera.position == pytest.approx([5, 0, 0])
    assert page.camera.look_at == pytest.approx([5, 0, -1])  # a camera looks along -z of its frame
    assert page.camera.fov == LAYERS.cameras[0].field_of_view
    page.viewer.choices.choose({"view": "no such view"})
    assert page.viewer.choices.view == "robot"


def test_nothing_is_between_a_camera_and_what_it_shows() -> None:
    """A wall of 2 m height stands 1 m beside the point; the camera rises until its line of sight passes over the wall."""
    wall = VisibleShape("box", (0.1, 5.0, 1.0), 0, ((1.0, 0.0, 1.0), IDENTITY), (1.0, 1.0, 1.0, 1.0))
    walls = camera_views.Boxes.of(Bodies(["world"], [False], [wall]), [0])
    poses, focus = np.array([[*ORIGIN, *IDENTITY]]), np.zeros(3)
    place = camera_views.stand(walls, poses, focus, 0.0, 4.0)
    assert np.linalg.norm(place) == pytest.approx(4.0)
    rise = math.degrees(math.asin(place[2] / 4.0))
    over = math.degrees(math.atan2(2.0, 0.9))
    assert rise == pytest.approx(next(one for one in camera_views.RISES if one > over))
    assert camera_views.stand(walls, poses, focus, math.pi, 4.0)[2] == pytest.approx(4 * math.sin(math.radians(25)))
    share = walls.free(poses, focus, np.array([3.0, 0.0, 0.0]))
    assert share == pytest.approx(0.9 / 3.0)
    assert camera_views.closer(focus, np.array([3.0, 0.0, 0.0]), share) == pytest.approx([0.81, 0.0, 0.0])


def test_each_viewer_has_its_own_selection_and_layers(page: Page) -> None:
    other = Browser3D(page.server.url, "other")
    assert eventually(lambda: len(page.scene._viewers) == 2)
    page.click("/robots/0")
    assert eventually(lambda: page.picked == [("tab", "bot")])
    assert page.scene.choices("other").selected == ""
    page.scene.choices("other").choose({"layers": ["robots", "contacts"]})
    page.scene.apply()
    assert set(page.scene.shown) == {"lidar", "contacts"}
    (second,) = [viewer for viewer in page.scene._viewers.values() if viewer.tab == "other"]
    assert visible(second, lambda: second.show_layers(page.scene._nodes, {})) == {"/robots", "/contacts"}
    shown = visible(page.viewer, lambda: page.scene.update(frame()))
    assert shown == {"/robots", "/objects", "/world", "/lidar"}
    page.scene.leave("other")
    assert set(page.scene.shown) == {"lidar"}
    other.socket.close()


def visible(viewer: ViewerControls, update: Callable[[], None]) -> set[str]:
    """The layers that a viewer's browser is told to show in a frame."""
    told: dict[str, bool] = {}
    connection = viewer._client._websock_connection

    def take(message: Any) -> None:
        if isinstance(message, _messages.SetSceneNodeVisibilityMessage) and message.name in NODES:
            told[message.name] = message.visible

    with pytest.MonkeyPatch.context() as patching:
        patching.setattr(connection, "queue_message", take)
        update()
    assert len(told) == len(NODES)
    return {name for name, shown in told.items() if shown}


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (math.nan, 0.0, 0.0)])
@pytest.mark.usefixtures("settled")
def test_a_camera_that_makes_no_sense_ends_nothing(page: Page, place: tuple[float, float, float]) -> None:
    page.select("bot")
    before = page.camera._state
    page.look(place, ORIGIN)
    assert eventually(lambda: page.camera._state is not before)
    page.scene.update(frame(1.0))
    page.look((0.0, -5.0, 3.0), ORIGIN)
    assert eventually(lambda: page.camera.position[1] == -5.0)
    page.scene.update(frame(2.0))
    assert page.camera.look_at == pytest.approx([2, 0, 0])


def test_an_entity_that_is_gone_is_let_go(page: Page) -> None:
    page.select("crate")
    page.viewer.choices.choose({"moves": True})
    page.scene.update(frame())
    assert page.viewer._handles._controls is not None
    page.scene.show(LiveScene("test", BODIES, [], {}, SceneLayers(entities=[BOT]), ORIGIN))
    page.scene.update(frame())
    assert page.viewer._handles._controls is None


def test_a_pull_pushes_at_most_each_tenth_of_a_second_until_it_ends(page: Page) -> None:
    page.scene.update(frame())
    page.drag("start", (0.1, 0.0, 0.0))
    for step in range(20):
        page.drag("update", (0.1 + step / 10, 0.0, 0.0))
    assert eventually(lambda: page.viewer.pull.held is not None and page.viewer.pull.held[1][0] == 2.0)
    for tick in range(10):
        page.scene.update(frame(time=tick / 60))
    ((name, push),) = page.commands
    assert name == "push"
    assert push["entity"] == "bot"
    assert push["force"] == [pytest.approx(body_dragging.STIFFNESS * 10.0 * 2.0), 0.0, 0.0]
    page.drag("end", (2.0, 0.0, 0.0))
    assert eventually(lambda: page.viewer.pull.held is None)
    page.scene.update(frame(time=9.0))
    assert len(page.commands) == 1


def test_a_pull_brings_a_body_to_the_mouse_and_no_farther(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("time.monotonic", iter(np.arange(0.0, 1e6, 0.1)).__next__)
    pushes: list[Any] = []
    pull = body_dragging.Pull(lambda name, arguments: pushes.append(arguments))
    pull.held = BOT, np.array([0.0, 1.5, 0.0])
    place, speed, reached = 0.0, 0.0, []
    for tick in range(600):
        pull.update(tick / 60, {"bot": (np.array([0.0, place, 0.0], np.float32), np.zeros(4, np.float32))})
        speed += pushes[-1]["force"][1] / BOT.mass / 60
        place += speed / 60
        reached.append(place)
    assert max(reached) < 1.8
    assert reached[-1] == pytest.approx(1.5, abs=0.02)


def test_handles_move_an_entity_to_where_they_are_dragged(page: Page) -> None:
    page.scene.update(frame())
    page.select("crate")
    page.viewer.choices.choose({"moves": True})
    page.scene.update(frame())
    controls = page.viewer._handles._controls
    assert controls is not None
    assert controls.position.tolist() == [0, 2, 0]
    owner = page.camera.client.scene._owner_id
    page.send(_messages.TransformControlsDragStartMessage("/move", owner))
    for x in range(10):
        page.send(_messages.TransformControlsUpdateMessage("/move", (1, 0, 0, 0), (float(x), 2.0, 0.5), owner))
    assert eventually(lambda: (page.viewer._handles._waiting or {}).get("position") == [9.0, 2.0, 0.5])
    for _ in range(5):
        page.scene.update(frame())
    ((name, move),) = page.commands
    assert name == "move"
    assert move["entity"] == "crate"
    assert move["orientation"] == {"quaternion_xyzw": [0, 0, 0, 1]}
    assert controls.position.tolist() == [9, 2, 0.5]  # held by the mouse
    page.send(_messages.TransformControlsDragEndMessage("/move", owner))
    assert eventually(lambda: not page.viewer._handles.held)
    page.scene.update(frame())
    assert controls.position.tolist() == [0, 2, 0]


def test_who_may_only_look_has_nothing_to_pull_or_move_by() -> None:
    page = Page(read_only=True)
    page.scene.update(frame())
    page.viewer.choices.choose({"moves": True})
    page.drag("start", (1.0, 0.0, 0.0))
    page.click("/robots/0")
    assert eventually(lambda: page.viewer.selected == "bot")
    page.scene.update(frame())
    assert page.viewer._handles._controls is None
    assert page.commands == []
    page.socket.close()
    page.server.close()
