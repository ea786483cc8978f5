"""What a run tells its page about the layers of the 3D part; a layer that is off costs nothing."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import graphengine as ge
from graphengine.api.viewing import make_floor
from graphengine.devices.camera import CameraStub, Picture
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.lidar import LidarStub
from graphengine.devices.rotation import compose, rotate
from graphengine.devices.stage import Stage
from graphengine.format.errors import RenderError, UsageError
from graphengine.messages.endpoints import Network
from graphengine.node.context.render_product import ProductCamera, RenderProduct
from graphengine.node.context.session_services import Services
from graphengine.testing import session
from graphengine.view.layer_data import CAMERAS, CONTACTS, FLOOR, LIDAR, FloorMap
from graphengine.view.layers import Layers
from tests.waiting import eventually

FACTS = {"size": (640, 480), "fov_deg": (90.0, 60.0)}
FLAT = FloorMap(np.zeros((2, 3), np.int8), (0.0, 0.0), 0.5)


@pytest.fixture(scope="module")
def sim() -> Iterator[ge.Session]:
    with session("dd100_warehouse") as made:
        made.run(1.0)
        yield made


def layers_of(services: Services, floor: Any = lambda: FLAT) -> Layers:
    return Layers(SimpleNamespace(services=services, version=0), floor)  # type: ignore[arg-type]  # it reads nothing else


def dry() -> tuple[Services, CameraStub, LidarStub]:
    """A stage with a camera and a lidar."""
    stage = Stage()
    stage.add("/rig/left", "camera", facts=FACTS)
    stage.add("/rig/right", "camera", facts=FACTS)
    stage.add("/lidar", "lidar")
    world = DryWorld(stage)
    camera = world.device(CameraStub, stage.find("/rig/left"), size=(320, 240))
    return Services(world, Network()), camera, world.device(LidarStub, stage.find("/lidar"))


def test_nothing_is_computed_for_layers_that_are_off() -> None:
    services, camera, lidar = dry()

    def no_floor() -> FloorMap:
        raise AssertionError

    layers = layers_of(services, no_floor)
    layers.find([])
    frame = layers.read((), 0.0, 1)
    assert not frame.scans
    assert not frame.pictures
    assert frame.floor is None
    assert camera.previews == lidar.casts == 0


def test_a_lidar_is_cast_while_its_layer_is_shown() -> None:
    services, _, lidar = dry()
    lidar.see(np.full(len(lidar.directions), 2.0), 100.0)
    layers = layers_of(services)
    (seen,) = layers.find([]).lidars
    ranges, intensities = layers.read((LIDAR,), 0.0, 1).scans[seen.mount.name]
    assert ranges.shape == intensities.shape == (len(seen.beams),)
    assert (ranges == 2.0).all()
    assert (intensities == 100.0).all()


def test_in_another_world_of_the_same_scene_its_own_sensors_are_read() -> None:
    (before, _, old), (after, _, new) = dry(), dry()
    old.see(np.full(len(old.directions), 2.0), 100.0)
    new.see(np.full(len(new.directions), 3.0), 100.0)
    running: Any = SimpleNamespace(services=before, version=0)
    layers = Layers(running, lambda: FLAT)
    (seen,) = layers.find([]).lidars
    layers.read((LIDAR, CAMERAS), 0.0, 1)
    running.services = after
    ranges, _ = layers.read((LIDAR, CAMERAS), 1.0, 1).scans[seen.mount.name]
    assert (ranges == 3.0).all()


def test_another_version_of_the_files_has_another_map() -> None:
    services, _, _ = dry()
    running: Any = SimpleNamespace(services=services, version=0)
    maps = [FLAT, FloorMap(np.ones((2, 3), np.int8), (0.0, 0.0), 0.5)]
    layers = Layers(running, lambda: maps[running.version])
    found: list[FloorMap] = []

    def look() -> bool:
        floor = layers.read((FLOOR,), 0.0, 1).floor
        found.extend([floor] if floor is not None else [])
        return len(found) == 1 + int(running.version)

    assert eventually(look)
    running.version = 1
    layers.find([])
    assert eventually(look)
    assert found == maps


def test_one_camera_of_a_rig_is_rendered_in_small_and_not_twice_in_a_tick() -> None:
    services, camera, _ = dry()
    layers = layers_of(services)
    (seen,) = layers.find([]).cameras
    assert seen.mount.name == "/rig/left"
    assert seen.aspect == pytest.approx(4 / 3)
    looks = [(0.0, 1), (0.05, 2), (0.3, 3), (0.35, 4), (0.6, 3), (0.65, 3)]
    found = [layers.read((CAMERAS,), now, tick).pictures for now, tick in looks]
    assert [list(pictures) for pictures in found] == [[], ["/rig/left"], [], ["/rig/left"], [], []]
    assert found[1]["/rig/left"].shape == (240, 320, 3)
    assert camera.previews == 2


def test_a_run_without_opengl_says_so_once_and_renders_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    services, camera, _ = dry()

    def fail(self: Any, timeout: Any = None) -> Picture:
        raise RenderError("there is no OpenGL")

    layers = layers_of(services)
    layers.find([])
    layers.read((CAMERAS,), 0.0, 1)
    monkeypatch.setattr("concurrent.futures.Future.result", fail)
    for tick in range(2, 6):
        frame = layers.read((CAMERAS,), 10.0 * tick, tick)
    assert frame.notes == {CAMERAS: "there is no OpenGL"}
    assert camera.previews == 1


def test_a_map_is_made_once_and_told_once() -> None:
    services, _, _ = dry()
    made = []

    def make() -> FloorMap:
        made.append(1)
        return FLAT

    layers = layers_of(services, make)
    found = []

    def look() -> bool:
        found.append(layers.read((FLOOR,), 0.0, 1).floor)
        return any(found)

    assert eventually(look)
    assert layers.read((FLOOR,), 0.0, 1).floor is None
    assert len(made) == 1


def test_a_scene_without_a_map_says_why() -> None:
    services, _, _ = dry()

    def make() -> FloorMap:
        raise UsageError("there is nothing")

    layers = layers_of(services, make)
    assert eventually(lambda: layers.read((FLOOR,), 0.0, 1).notes == {FLOOR: "there is nothing"})


def test_frames_cameras_and_lidars_are_where_the_world_has_them(sim: ge.Session) -> None:
    services = sim._runner.session.services
    world, poses = services.world, services.world.poses()
    scene = layers_of(services).find(world.bodies().names)
    mounts = [seen.mount for seen in scene.lidars] + [seen.mount for seen in scene.cameras]
    assert len(mounts) == 2
    for mount in mounts:
        body = tuple(poses[mount.body, :3].tolist()), tuple(poses[mount.body, 3:].tolist())
        position, rotation = world.frame(world.stage.find(mount.name)).pose()
        found = compose(body, mount.pose)
        assert found[0] == pytest.approx(position)
        assert found[1] == pytest.approx(rotation)
    names = [frame.name for frame in scene.frames]
    assert {"base_link", "chassis_link", "sim_lidar"} <= set(names)
    assert "Physics" not in names


def test_entities_are_robots_and_what_can_be_moved(sim: ge.Session) -> None:
    world = sim._runner.session.services.world
    names = world.bodies().names
    entities = {entity.mount.name: entity for entity in layers_of(sim._runner.session.services).find(names).entities}
    assert [name for name, entity in entities.items() if entity.robot] == ["dd100"]
    assert "box_01" in entities
    assert "walls" not in entities
    assert {names[row].partition("/")[0] for row in entities["dd100"].bodies} == {"dd100"}
    (contacts, own) = world.contacts(), list(entities["dd100"].bodies)
    lifted = np.isin(contacts.bodies[:, 1], own).astype(float) - np.isin(contacts.bodies[:, 0], own)
    assert lifted @ contacts.forces[:, 2] == pytest.approx(entities["dd100"].mass * 9.81, rel=0.03)


def test_contacts_are_told_while_their_layer_is_shown(sim: ge.Session) -> None:
    layers = layers_of(sim._runner.session.services)
    assert len(layers.read((), 0.0, 1).contacts.points) == 0
    assert len(layers.read((CONTACTS,), 0.0, 1).contacts.points) >= 3


def test_the_map_lies_where_a_lidar_hits_what_stands_still(sim: ge.Session) -> None:
    floor = make_floor(sim._runner.session)
    services = sim._runner.session.services
    layers = layers_of(services)
    (seen,) = layers.find(services.world.bodies().names).lidars
    ranges, _ = layers.read((LIDAR,), 0.0, 1).scans[seen.mount.name]
    position, rotation = services.world.frame(services.stage.find(seen.mount.name)).pose()
    hit, cells = np.isfinite(ranges), np.pad(floor.cells, 20)
    points = np.array(position) + [rotate(rotation, way) for way in (seen.beams[hit] * ranges[hit, None]).tolist()]

    def share(shift: float) -> float:
        """Part of the hits that lie in an occupied cell or beside one."""
        columns, rows = ((points[:, :2] + shift - floor.corner) / floor.cell).astype(int).T + 20
        around = [(row, column) for row in (-1, 0, 1) for column in (-1, 0, 1)]
        near = [cells[rows + row, columns + column] == 100 for row, column in around]
        return float(np.any(near, axis=0).mean())

    assert share(0.0) > 0.8
    assert share(0.4) < 0.6


def test_a_picture_that_a_graph_receives_is_not_rendered_again() -> None:
    services, camera, _ = dry()
    camera.show(np.full((480, 640, 3), 7), time=0.0)
    product = RenderProduct("/rig/right", (640, 480), ProductCamera(camera))
    services.render_products["/product"] = product
    layers = layers_of(services)
    assert [seen.mount.name for seen in layers.find([]).cameras] == ["/rig/right"]
    pictures = layers.read((CAMERAS,), 0.0, 1).pictures
    assert pictures["/rig/right"].shape == (240, 320, 3)
    assert (pictures["/rig/right"] == 7).all()
    assert camera.previews == 0
    assert not layers.read((CAMERAS,), 10.0, 2).pictures
