"""IsaacCreateRenderProduct, IsaacReadCameraInfo and IsaacSetCameraOnRenderProduct: cameras and the paths that lead to them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.camera import Camera, CameraStub
from graphengine.devices.lidar import Lidar, LidarStub
from graphengine.format.errors import ContextError, PrimError
from graphengine.node.context.context import Context
from graphengine.nodes.core.render_product import (
    IsaacCreateRenderProduct,
    IsaacReadCameraInfo,
    IsaacSetCameraOnRenderProduct,
)
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, computed, dd100, ready

LIDAR = "/robot/Geometry/base_link/Lidar"
CAMERA = "/robot/Geometry/base_link/camera"


@pytest.fixture
def context() -> RecordingContext:
    made = RecordingContext()
    made.world.add_robot("/robot")
    made.world.add_device(LidarStub, LIDAR)
    made.world.stage.add(CAMERA, "camera")
    return made


def product(context: RecordingContext, prim: str, **inputs: Any) -> IsaacCreateRenderProduct:
    return ready(IsaacCreateRenderProduct, context, camera_prim=prim, **inputs)


def test_by_default_a_render_product_is_enabled_with_1280_by_720_pixels(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    context.stop(node)
    assert (node.width, node.height, node.enabled, node.render_product_path) == (1280, 720, True, "")


def test_the_path_leads_to_the_lidar(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    assert node.compute() == node.exec_out
    assert context.device(Lidar, node.render_product_path).prim_path == LIDAR


def test_the_path_is_known_before_the_first_tick_and_again_after_a_stop(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    before = node.render_product_path
    assert before
    context.stop(node)
    node.compute()
    assert node.render_product_path == before


def test_every_execution_fires_while_it_is_enabled(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    assert [node.compute() for _ in range(3)] == [node.exec_out] * 3
    node.enabled = False
    assert node.compute() is None
    node.enabled = True
    assert node.compute() == node.exec_out


def test_nodes_with_the_same_camera_and_size_share_a_product(context: RecordingContext) -> None:
    nodes = [product(context, CAMERA), product(context, CAMERA), product(context, CAMERA, width=640)]
    one, same, other, lidar = (node.render_product_path for node in (*nodes, product(context, LIDAR)))
    assert one == same
    assert len({one, other, lidar}) == 3


def test_cameras_whose_paths_differ_only_in_slashes_do_not_share_a_product(context: RecordingContext) -> None:
    cameras = ("/World/arm/left_camera", "/World/arm_left/camera", "/World/arm_left_camera")
    for camera in cameras:
        context.world.add_device(CameraStub, camera)
    paths = [product(context, camera).render_product_path for camera in cameras * 2]
    assert paths[:3] == paths[3:]
    assert tuple(context.device(Camera, path).prim_path for path in paths[:3]) == cameras


def test_a_given_render_product_is_output_unchanged(context: RecordingContext) -> None:
    node = product(context, LIDAR, render_product_prim=("/Render/mine",))
    node.compute()
    assert node.render_product_path == "/Render/mine"


@pytest.mark.parametrize("prim", ["/robot", "/nowhere"])
def test_a_prim_that_is_not_a_sensor_is_refused(context: RecordingContext, prim: str) -> None:
    with pytest.raises(PrimError, match=prim):
        product(context, prim)


@pytest.mark.parametrize("size", [{"width": 0}, {"height": 0}, {"width": 8193}, {"height": 2**32 - 1}])
def test_an_image_size_out_of_range_is_refused(context: RecordingContext, size: dict[str, int]) -> None:
    with pytest.raises(ContextError, match="legal: width and height from 1 to 8192") as caught:
        product(context, CAMERA, **size)
    assert [caught.value.value] == list(size.values())  # by which the place in the file is found


def test_the_image_size_is_ignored_for_a_lidar(context: RecordingContext) -> None:
    assert product(context, LIDAR, width=0).render_product_path == product(context, LIDAR).render_product_path


def test_disabled_in_a_graph_the_helper_behind_it_never_starts(play: Player) -> None:
    world = dd100()
    sensor = "/dd100/Geometry/base_link/chassis_link/sim_lidar/Lidar"
    text = f"""
        nodes:
          Tick: OnPlaybackTick
          Product: {{type: CreateRenderProduct, inputs: {{cameraPrim: {sensor}, enabled: false}}}}
          Helper: RtxLidarHelper
        connections:
          - Tick.tick -> Product.execIn
          - Product.execOut -> Helper.execIn
          - Product.renderProductPath -> Helper.renderProductPath
        """
    playing = play.graph(text, world)
    world.device(LidarStub, world.stage.find(sensor)).see([1.0] * 5)
    playing.tick(3)
    assert playing.topics["Helper"] == "/dd100_0000/sim_lidar/scan"
    assert playing.published("/dd100_0000/sim_lidar/scan") == []
    playing.set("Product", "enabled", True)
    playing.tick()
    assert len(playing.published("/dd100_0000/sim_lidar/scan")) == 1


# IsaacReadCameraInfo


def two_cameras() -> RecordingWorld:
    """A wide one and a narrow one."""
    world = RecordingWorld()
    world.add_robot("/robot")
    for name, degrees in (("wide", 90.0), ("narrow", 60.0)):
        world.add_device(CameraStub, f"/robot/{name}", size=(640, 480), fov_deg=(degrees, 40.0))
    return world


def info(context: RecordingContext, path: str) -> IsaacReadCameraInfo:
    return computed(IsaacReadCameraInfo, context, render_product_path=path)


@pytest.fixture
def cameras() -> RecordingContext:
    made = RecordingContext()
    made.services.world = made.world = two_cameras()
    return made


@pytest.mark.parametrize(("camera", "degrees"), [("wide", 90.0), ("narrow", 60.0)])
def test_focal_length_and_aperture_give_the_field_of_view(
    cameras: RecordingContext, camera: str, degrees: float
) -> None:
    node = info(cameras, f"/robot/{camera}")
    assert 2 * math.atan2(node.horizontal_aperture / 2, node.focal_length) == pytest.approx(math.radians(degrees))
    assert node.vertical_aperture / node.horizontal_aperture == pytest.approx(480 / 640)
    assert (node.horizontal_offset, node.vertical_offset) == (0.0, 0.0)


def test_the_lens_is_one_without_distortion(cameras: RecordingContext) -> None:
    node = info(cameras, "/robot/wide")
    assert (node.projection_type, node.physical_distortion_model) == ("pinhole", "plumb_bob")
    assert node.physical_distortion_coefficients.tolist() == [0.0] * 5
    assert node.physical_distortion_coefficients.dtype == np.float32
    assert node.camera_fisheye_params.tolist() == []


def test_the_size_is_that_of_the_render_product(cameras: RecordingContext) -> None:
    node = info(cameras, cameras.render_product("/robot/wide", 320, 200))
    assert (node.width, node.height) == (320, 200)
    assert node.vertical_aperture == pytest.approx(node.horizontal_aperture * 200 / 320)


def test_a_reader_of_a_render_product_depends_on_the_prim_of_its_camera(cameras: RecordingContext) -> None:
    path = cameras.render_product("/robot/wide", 320, 200)
    info(cameras, path)
    later = Context(cameras.services, cameras.clock, "graph", "/World/graph/later", None, {})
    later.device(Camera, path)
    assert {prim.path for prim in later.asked.values()} == {"/robot/wide"}


# IsaacSetCameraOnRenderProduct


def test_the_render_product_shows_the_other_camera_in_its_own_size(cameras: RecordingContext) -> None:
    path = cameras.render_product("/robot/wide", 320, 240)
    reader = info(cameras, path)
    node = ready(IsaacSetCameraOnRenderProduct, cameras, render_product_path=path, camera_prim="/robot/narrow")
    assert cameras.device(Camera, path).prim_path == "/robot/wide"
    node.compute()
    assert cameras.device(Camera, path).prim_path == "/robot/narrow"
    before = reader.focal_length
    reader.compute()
    assert reader.focal_length > before
    assert (reader.width, reader.height) == (320, 240)


@pytest.mark.parametrize(
    ("inputs", "complaint"),
    [
        ({"render_product_path": "/Render/nothing", "camera_prim": "/robot/wide"}, "/Render/nothing"),
        ({"render_product_path": "/robot/wide", "camera_prim": "/robot/narrow"}, "no render product '/robot/wide'"),
        ({"render_product_path": "", "camera_prim": "/robot"}, "camera"),
    ],
)
def test_a_wrong_render_product_or_camera_is_refused_in_setup(
    cameras: RecordingContext, inputs: dict[str, str], complaint: str
) -> None:
    path = inputs["render_product_path"] or cameras.render_product("/robot/wide", 320, 240)
    with pytest.raises(ContextError, match=complaint):
        ready(IsaacSetCameraOnRenderProduct, cameras, **{**inputs, "render_product_path": path})


def test_in_a_graph_a_reader_gets_the_camera_that_was_set_earlier_in_the_same_pass(play: Player) -> None:
    world = two_cameras()
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Product: {type: CreateRenderProduct, inputs: {cameraPrim: /robot/wide, width: 320, height: 240}}
          Gate: {type: SimulationGate, inputs: {step: 2}}
          Set: {type: SetCameraOnRenderProduct, inputs: {cameraPrim: /robot/narrow}}
          Info: ReadCameraInfo
          Out: PublishCameraInfo
        connections:
          - Tick.tick -> Product.execIn
          - Product.execOut -> Gate.execIn
          - Gate.execOut -> Set.execIn
          - Set.execOut -> Out.execIn
          - Product.execOut -> Out.execIn
          - Product.renderProductPath -> Set.renderProductPath
          - Product.renderProductPath -> Info.renderProductPath
          - Info.focalLength -> Out.timeStamp
        """,
        world,
    )
    seen = playing.each_tick(3, lambda: playing.node("Info").focal_length)
    wide, narrow = (20.955 / 2 / math.tan(math.radians(degrees) / 2) for degrees in (90, 60))
    assert seen == pytest.approx([wide, narrow, narrow])
    playing.session.stop()
    playing.tick()
    assert playing.node("Info").focal_length == pytest.approx(wide)
